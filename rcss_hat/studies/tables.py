"""Everything that is kept in a study's folder as tables, one row per step, game, key, answer and participant.

Participants are named, steps and conditions stand beside every row, and keys are assigned to the games they belong to;
so each table can be used by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.studies.folder import Kept
from rcss_hat.studies.game_files import read_rows, table_path
from rcss_hat.studies.journal import Event
from rcss_hat.studies.plan import Planned

COLUMNS: dict[str, dict[str, str]] = {
    "participants": {
        "participant": "Name of the place.",
        "rehearsal": "1: a scripted participant.",
        "conditions": "Assigned, in order, with + between them.",
        "state": "`finished`, `stopped` by the experimenter, or `under way`.",
        "minutes": "From his first to his last event.",
        "games": "Games of demonstrations that count.",
    },
    "steps": {
        "participant": "Name of the place.", "step": "Step.", "kind": "As in the study's file.",
        "condition": "For which it was gone through; empty: for none.",
        "begun_ms": "When he saw it first; empty: not yet.", "done_ms": "When it was behind him; empty: not yet.",
        "seconds": "Between the two.",
        "hidden_s": "Of these, seconds in which its page was open and not in sight.",
    },
    "games": {
        "participant": "Name of the place.", "step": "Step.", "kind": "`practice` or `demonstration`.",
        "condition": "Of the step.", "order": "Which of his conditions this is, from 1.", "game": "Number in the step.",
        "match": "Match of the step.", "cycles": "Length.", "seconds": "Length in the game's seconds.",
        "reason": "`o` out, `t` taken.", "idle": "1: no key pressed.", "keys": "Keys pressed.",
        "stood": "How often the game stood still in it.",
    },
    "keys": {
        "participant": "Name of the place.", "step": "Step.", "condition": "Of the step.",
        "game": "Game it belongs to; empty: to one that did not count.",
        "match": "See `STEP.keys.csv`, as for all that follow.", "cycle": "", "ms": "", "page_ms": "", "action": "",
        "mate": "", "holder": "", "held_ms": "", "fate": "", "fate_cycle": "",
    },
    "answers": {
        "participant": "Name of the place.", "step": "Step.", "condition": "Of the step.",
        "question": "Its name.", "answer": "As in the journal; several options with + between them; empty: none.",
    },
}  # fmt: skip
"""The tables that a report writes as CSV, and their columns."""


def tables_of(people: list[Kept]) -> dict[str, pd.DataFrame]:
    """Make all tables.

    Raises
    ------
    FileFormatError
        When a file is damaged.
    """
    makers = {"participants": _participant, "steps": _steps, "games": games_of, "keys": _keys, "answers": _answers}
    return {
        name: pd.DataFrame([row for kept in people for row in make(kept)], columns=list(COLUMNS[name]))
        for name, make in makers.items()
    }


def demonstrations_of(kept: Kept) -> dict[str, DemonstrationSet]:
    """Return what a participant demonstrated, by step; steps without a game are left out.

    Raises
    ------
    FileFormatError
    """
    found = {}
    for planned in kept.plan:
        path = kept.folder / f"{planned.name}.csv"
        if planned.step_kind == "demonstration" and path.exists():
            demonstration = DemonstrationSet.load(path)
            if len(demonstration):
                found[planned.name] = demonstration
    return found


def _participant(kept: Kept) -> Iterator[Mapping[str, Any]]:
    progress = kept.progress
    shown = [p for p in kept.plan if p.step_kind == "demonstration"]
    yield {
        "participant": kept.name,
        "rehearsal": int(kept.about["rehearsal"]),
        "conditions": "+".join(kept.about["conditions"]),
        "state": "stopped" if progress.stopped else "finished" if progress.finished else "under way",
        "minutes": round(kept.events[-1]["ms"] / 60_000, 2) if kept.events else 0.0,
        "games": sum(len(progress.played[p.name].games) for p in shown),
    }


def _steps(kept: Kept) -> Iterator[Mapping[str, Any]]:
    for planned in kept.plan:
        mine = [e for e in kept.events if e.get("step") == planned.name]
        begun, done = (next((e["ms"] for e in mine if e["event"] == kind), None) for kind in ("begun", "done"))
        seconds = None if begun is None or done is None else (done - begun) / 1000.0
        row = {
            "participant": kept.name,
            "step": planned.name,
            "kind": planned.step_kind,
            "condition": planned.condition,
        }
        yield row | {"begun_ms": begun, "done_ms": done, "seconds": seconds, "hidden_s": _hidden(mine, done)}


def _hidden(events: list[Event], done: int | None) -> float:
    """Seconds in which a page of a step was open and not in sight."""
    total, hidden_since = 0, None
    for event in events:
        hides = event["event"] == "look" and not event["value"]
        ends = (event["event"] == "look" and event["value"]) or (
            event["event"] == "page" and event["state"] != "opened"
        )
        if hides and hidden_since is None:
            hidden_since = event["ms"]
        elif ends and hidden_since is not None:
            total += event["ms"] - hidden_since
            hidden_since = None
    if hidden_since is not None and done is not None:
        total += max(done - hidden_since, 0)
    return total / 1000.0


def games_of(kept: Kept) -> Iterator[dict[str, Any]]:
    """Yield the rows of a participant's games."""
    conditions = kept.about["conditions"]
    for planned in kept.plan:
        if planned.game is None:
            continue
        stood = [e for e in kept.events if e["event"] == "stood" and e["step"] == planned.name]
        for game in kept.progress.played[planned.name].games:
            cycles = game["end"] - game["start"]
            yield {
                "participant": kept.name,
                "step": planned.name,
                "kind": planned.step_kind,
                "condition": planned.condition,
                "order": conditions.index(planned.condition) + 1 if planned.condition in conditions else None,
                "game": game["game"],
                "match": game["match"],
                "cycles": cycles,
                "seconds": cycles / 10.0,
                "reason": game["reason"],
                "idle": int(game["idle"]),
                "keys": game["keys"],
                "stood": sum(_within(game, e["match"], e["cycle"]) for e in stood),
            }


def _within(game: Event, match: int, cycle: int) -> bool:
    return bool(game["match"] == match and game["start"] < cycle < game["end"])


def _keys(kept: Kept) -> Iterator[Mapping[str, Any]]:
    for planned in kept.plan:
        path = table_path(kept.folder, planned.name, "keys")
        if planned.kept and path.exists():
            games = kept.progress.played[planned.name].games
            for row in read_rows(path):
                yield {
                    "participant": kept.name,
                    "step": planned.name,
                    "condition": planned.condition,
                    "game": _game(games, int(row["match"]), int(row["cycle"])),
                    **row,
                }


def _game(games: list[Event], match: int, cycle: int) -> int | None:
    return next((g["game"] for g in games if g["match"] == match and g["start"] <= cycle < g["end"]), None)


def _answers(kept: Kept) -> Iterator[Mapping[str, Any]]:
    condition = {planned.name: planned.condition for planned in kept.plan}
    for step, answers in kept.progress.answers.items():
        for question, answer in answers.items():
            text = "+".join(answer) if isinstance(answer, list) else answer
            row = {"participant": kept.name, "step": step, "condition": condition.get(step)}
            yield row | {"question": question, "answer": text}


def latencies(kept: Kept, planned: Planned) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Milliseconds of real time from getting the ball to the first key that was played in that possession."""
    path = table_path(kept.folder, planned.name, "keys")
    if not path.exists():
        return np.empty(0)
    return np.array([float(r["held_ms"]) for r in read_rows(path) if r["fate"] == "played" and r["held_ms"]])
