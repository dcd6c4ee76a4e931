"""The table of a demonstration: its decisions, as CSV; see `rcss_hat.hat._demonstration_file` for the header."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from rcss_hat.hat._demonstration_file import DemonstrationInfo, Entry, check_decision, columns
from rcss_hat.inputs import MIB, FileFormatError, excerpt, read_text
from rcss_hat.keepaway.decision import Decision

MAX_TABLE = 256 * MIB
"""Bytes: a million decisions."""
_WHOLE = re.compile(r" *[-+]?[0-9]{1,18} *")


def table_head(info: DemonstrationInfo) -> str:
    """Write the first line of the table."""
    return ",".join(columns(info)) + "\n"


def table_rows(info: DemonstrationInfo, number: int, decisions: Iterable[Decision]) -> str:
    """Write the decisions of an episode; numbers exact to the last bit."""

    def marks(d: Decision) -> str:
        return f",{d.by},{'' if d.right is None else d.right}" if info.marked else ""

    return "".join(
        f"{number},{d.cycle},{d.keeper},{','.join(map(repr, d.state))},{d.action}{marks(d)}\n" for d in decisions
    )


def read_table(path: Path, info: DemonstrationInfo, entries: Sequence[Entry]) -> list[list[Decision]]:
    """Read the decisions of the listed episodes.

    Raises
    ------
    FileFormatError
        Naming file, line, and what would be right.
    """
    rows = _rows(path, read_text(path, "table of a demonstration", MAX_TABLE))
    expected = columns(info)
    _, found = next(rows, (1, []))
    if found != expected:
        line = ",".join(found)
        raise FileFormatError(
            f"{path}, line 1: the columns of {info.task.size} are {','.join(expected)}; found "
            f"{line if line.isprintable() and len(line) < 200 else excerpt(line, 200)}"
        )
    episodes = []
    for entry in entries:
        decisions = []
        for number in range(1, entry.decisions + 1):
            row = next(rows, None)
            if row is None:
                raise FileFormatError(
                    f"{path}: ends within episode {entry.episode.number}, before decision {number} of the "
                    f"{entry.decisions} that its header lists; restore the file, or correct the header"
                )
            try:
                decisions.append(_decision_from(row[1], info, entry))
            except ValueError as error:
                raise FileFormatError(f"{path}, line {row[0]}: {error}") from error
        episodes.append(decisions)
    return episodes


def _rows(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows with the numbers of their lines; a quote that opens must close within its line."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    while True:
        line = reader.line_num + 1
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise FileFormatError(f"{path}, line {line}: {error}; is there a quote too many?") from error
        if reader.line_num > line:
            raise FileFormatError(f"{path}, line {line}: a quote opens that does not close in this line")
        yield line, cells


def _decision_from(cells: list[str], info: DemonstrationInfo, entry: Entry) -> Decision:
    names = columns(info)
    if len(cells) != len(names):
        raise ValueError(f"expected {len(names)} cells, found {len(cells)}")
    numbers = dict(zip(names, cells, strict=True))
    found = _whole(numbers, "episode")
    if found != entry.episode.number:
        raise ValueError(f"expected a decision of episode {entry.episode.number}, found episode {found}")
    state = tuple(_real(numbers, f"s{k}") for k in range(info.n_variables))
    right = _whole(numbers, "right") if numbers.get("right") else None
    cycle, keeper, action = (_whole(numbers, name) for name in ("cycle", "keeper", "action"))
    decision = Decision(cycle, keeper, state, action, numbers.get("by", ""), right)
    check_decision(info, decision)
    return decision


def _whole(cells: dict[str, str], name: str) -> int:
    if not _WHOLE.fullmatch(cells[name]):
        raise ValueError(f"{name} must be a whole number, not {excerpt(cells[name])}")
    return int(cells[name])


def _real(cells: dict[str, str], name: str) -> float:
    try:
        return float(cells[name])
    except ValueError:
        raise ValueError(f"{name} must be a number, not {excerpt(cells[name])}") from None
