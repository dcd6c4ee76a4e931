r"""The server's logs: Keepaway episodes (.kwy), the game (.rcg) and what clients sent (.rcl).

While a match runs, a log is called ``incomplete.SUFFIX``; at the end it gets its name from date, teams and score. With
``*_log_fixed`` it has its fixed name from the start (19.0.0, src/logger.cpp).
"""

from __future__ import annotations

import gzip
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import IO, cast

import numpy as np
from numpy.typing import NDArray

from fake_server.game_log import form_of
from fake_server.show import LOG_BOARD, MESSAGE_BOARD
from rcss_hat.protocol.keepaway_log import log_head, log_line
from rcss_hat.protocol.params import ServerParams
from rcss_hat.simulation.state import BEFORE_KICK_OFF, TIME_OVER


class LogError(OSError):
    """A log cannot be written; the message names the file and the reason."""


class _Log:
    """One log file.

    Parameters
    ----------
    params : ServerParams
    kind : {"keepaway", "game", "text"}
        Prefix of its parameters ``*_log_dir``, ``*_log_fixed``, ``*_log_fixed_name``, ``*_log_dated``.
    suffix : str
    """

    def __init__(self, params: ServerParams, kind: str, suffix: str) -> None:
        self._dated = bool(params[f"{kind}_log_dated"])
        self._fixed = bool(params[f"{kind}_log_fixed"])
        level = int(params.number(f"{kind}_log_compression")) if f"{kind}_log_compression" in params else 0
        self._suffix = suffix + (".gz" if level > 0 else "")
        self._folder = Path(str(params[f"{kind}_log_dir"])).expanduser()
        stem = str(params[f"{kind}_log_fixed_name"]) if self._fixed else "incomplete"
        self.path = self._folder / (stem + self._suffix)
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            file = gzip.GzipFile(self.path, "wb", level) if level > 0 else self.path.open("wb")
        except OSError as error:
            raise LogError(f"cannot write the {kind} log {self.path}: {error.strerror or error}") from None
        self._file = cast("IO[bytes]", file)

    def write(self, data: bytes | memoryview) -> None:
        self._file.write(data)

    def line(self, text: str) -> None:
        self._file.write(text.encode("latin-1", "replace") + b"\n")

    def flush(self) -> None:
        self._file.flush()

    def close(self, date: str, result: str) -> None:
        """Close the file and give it its name."""
        self._file.close()
        if self._fixed:
            return
        name = f"{date if self._dated else ''}{result}{self._suffix}".replace("/", "_")
        target = self._folder / name
        try:
            self.path = self.path.rename(target)
        except OSError as error:
            print(f"error renaming {self.path} to {target}: {error.strerror or error}", file=sys.stderr)


class Logs:
    """All logs of a server.

    Parameters
    ----------
    params : ServerParams
    head : iterable of str
        The parameter messages, with which a game log begins: in JSON when the log is.
    start : float
        When the server started, seconds since the epoch.

    Raises
    ------
    LogError
        When a file cannot be written.
    """

    def __init__(self, params: ServerParams, head: Iterable[str], start: float) -> None:
        self._date_format = str(params["log_date_format"])
        self._start = time.localtime(start)
        self._record_messages = bool(params["record_messages"])
        self._size = (float(params.number("keepaway_length")), float(params.number("keepaway_width")))
        self._form = form_of(int(params.number("game_log_version")), params.profile)
        self._mode = 0
        self._teams: tuple[str, str, int, int] | None = None
        self._game = _Log(params, "game", ".rcg") if params["game_logging"] else None
        self._text = _Log(params, "text", ".rcl") if params["text_logging"] else None
        wanted = params["keepaway"] and params["keepaway_logging"]
        self._keepaway = _Log(params, "keepaway", ".kwy") if wanted else None
        if self._game:
            self._game.write(self._form.begin(head, start))
            self._game.flush()

    @property
    def wants_messages(self) -> bool:
        """Whether anything is written of what clients send."""
        return self._text is not None or (self._game is not None and self._record_messages)

    @property
    def paths(self) -> list[Path]:
        """Files that are being written, or were."""
        return [log.path for log in (self._keepaway, self._game, self._text) if log]

    # --- Keepaway -------------------------------------------------------------------------------------------------
    def keepaway_header(self, keepers: int, takers: int) -> None:
        """Write what stands above the episodes."""
        if not self._keepaway:
            return
        self._keepaway.write(log_head(keepers, takers, *self._size).encode())
        self._keepaway.flush()

    def episode(self, number: int, start: int, end: int, taken: bool) -> None:
        """Write a finished episode."""
        if self._keepaway:
            self._keepaway.write(log_line(number, start, end, "t" if taken else "o").encode())
            self._keepaway.flush()

    # --- text -----------------------------------------------------------------------------------------------------
    def received(self, match: NDArray[np.void], who: str, text: str) -> None:
        """Write a client's datagram; ``who`` is for example ``keepers_1`` or ``Coach``."""
        self._both(match, f"Recv {who}: {text}")

    def substitution(self, match: NDArray[np.void], text: str) -> None:
        """Write a change of a player's type (in the game log only)."""
        self._record(match, LOG_BOARD, text)

    def referee(self, match: NDArray[np.void], text: str) -> None:
        """Write a message of the referee."""
        if self._text:
            self._text.line(f"{_stamp(match)}\t(referee {text})")
        self._record(match, MESSAGE_BOARD, f"(referee {text})", playing=True)

    def speech(self, match: NDArray[np.void], who: str, text: str) -> None:
        """Write what a player or trainer said (in the game log only)."""
        self._record(match, MESSAGE_BOARD, f"({who} {text})", playing=True)

    def _both(self, match: NDArray[np.void], text: str) -> None:
        if self._text:
            self._text.line(f"{_stamp(match)}\t{text}")
        self._record(match, LOG_BOARD, text)

    def _record(self, match: NDArray[np.void], board: int, text: str, playing: bool = False) -> None:
        """Write a message into the game log; ``playing``: not before kick-off."""
        mode = match["mode"][0]
        if not (self._game and self._record_messages) or mode == TIME_OVER or (playing and mode == BEFORE_KICK_OFF):
            return
        self._game.write(self._form.message(match, board, text))

    # --- game -----------------------------------------------------------------------------------------------------
    def show(self, match: NDArray[np.void], params: NDArray[np.void], teams: tuple[str, str]) -> None:
        """Write the frame of a step; nothing before kick-off, one frame when the time is over."""
        if self._text:
            self._text.flush()
        mode = int(match["mode"][0])
        if not self._game or mode == BEFORE_KICK_OFF or (mode == TIME_OVER and self._mode == TIME_OVER):
            return
        if mode != self._mode:
            self._mode = mode
            self._game.write(self._form.play_mode(match))
        result = (*teams, int(match["score"][0, 0]), int(match["score"][0, 1]))
        if result != self._teams and result != ("", "", 0, 0):
            self._teams = result
            self._game.write(self._form.team(match, teams))
        self._game.write(self._form.show(match, params))
        self._game.flush()

    def close(self, match: NDArray[np.void], teams: tuple[str, str]) -> None:
        """Write the result, close the files and give them their names."""
        score = match["score"][0]
        named = [f"{team}_{score[k]}" if team else "null" for k, team in enumerate(teams)]
        result = "-vs-".join(named)
        if self._game:
            stamp = time.strftime("%Y%m%d%H%M", self._start)
            self._game.write(self._form.message(match, MESSAGE_BOARD, f"(result {stamp} {result})"))
            self._game.write(self._form.team(match, teams) + self._form.end())
        date = time.strftime(self._date_format, self._start)
        for log in (self._text, self._game, self._keepaway):
            if log:
                log.close(date, result)


def _stamp(match: NDArray[np.void]) -> str:
    return f"{match['time'][0]},{match['stopped'][0]}"
