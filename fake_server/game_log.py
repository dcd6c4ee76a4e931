"""The forms of a game log: text (versions 4 to 6) and JSON (version -1).

Each turns what happens into the bytes to append to the file. Source: 19.0.0, src/initsenderlogger.cpp and
src/dispsender.cpp.
"""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fake_server.show import json_show, team_of, write_show
from rcss_hat.protocol import messages
from rcss_hat.protocol.digits import ascii_bytes
from rcss_hat.protocol.json_text import json_text
from rcss_hat.protocol.messages.show import MAX_SHOW
from rcss_hat.protocol.messages.show_json import json_message, json_team, json_time
from rcss_hat.protocol.play_modes import PLAY_MODES

JSON_LOG = -1
"""Version of the game log that is JSON."""
OLDEST_TEXT_LOG, NEWEST_TEXT_LOG = 4, 6
"""Versions of the text form; for older, binary ones the oldest of these is written."""

_NO_HEAD = ascii_bytes("")


def _line(text: str) -> bytes:
    return text.encode("latin-1", "replace") + b"\n"


class TextForm:
    """A line for everything.

    Parameters
    ----------
    version : int
        4 to 6.
    """

    def __init__(self, version: int) -> None:
        self._version = version
        self._buffer = np.zeros(MAX_SHOW, dtype=np.uint8)

    def begin(self, head: Iterable[str], start: float) -> bytes:
        """Return the header and the parameter messages; ``start`` is when the server began."""
        return b"".join(map(_line, (f"ULG{self._version}", *head)))

    def play_mode(self, match: NDArray[np.void]) -> bytes:
        """Return the play mode."""
        mode = PLAY_MODES[int(match["mode"][0])]
        return _line(messages.PlayMode(time=int(match["time"][0]), mode=mode).to_text())

    def team(self, match: NDArray[np.void], teams: tuple[str, str]) -> bytes:
        """Return names and score."""
        left, right = match["score"][0].tolist()
        return _line(team_of(teams, (left, right), int(match["time"][0])).to_text())

    def message(self, match: NDArray[np.void], board: int, text: str) -> bytes:
        """Return a message."""
        return _line(messages.Msg(time=int(match["time"][0]), board=board, text=text.replace("\n", " ")).to_text())

    def show(self, match: NDArray[np.void], params: NDArray[np.void]) -> bytes:
        """Return a frame."""
        size = write_show(match, params, self._version - 1, _NO_HEAD, self._buffer)
        return self._buffer[:size].tobytes() + b"\n"

    def end(self) -> bytes:
        """Return what closes the log."""
        return b""


class JsonForm:
    """An array with an object for everything.

    Parameters
    ----------
    version : str
        Of the server, such as 19.0.
    """

    def __init__(self, version: str) -> None:
        self._version = version

    def begin(self, head: Iterable[str], start: float) -> bytes:
        """Return the header and the parameter messages; ``start`` is when the server began."""
        stamp = time.strftime("%Y-%m-%dT%H:%M:%S%z", time.localtime(start))
        members = (json_text({"version": f"{self._version}.0"}), json_text({"timestamp": stamp}), *head)
        return ("[\n" + ",\n".join(members)).encode("ascii")

    def _member(self, name: str, value: object) -> bytes:
        return b",\n" + json_text({name: value}).encode("ascii")

    def play_mode(self, match: NDArray[np.void]) -> bytes:
        """Return the play mode."""
        return self._member("playmode", json_time(match) | {"mode": PLAY_MODES[int(match["mode"][0])]})

    def team(self, match: NDArray[np.void], teams: tuple[str, str]) -> bytes:
        """Return names and score."""
        return self._member("team", json_time(match) | json_team(match, teams))

    def message(self, match: NDArray[np.void], board: int, text: str) -> bytes:
        """Return a message."""
        return b",\n" + json_message(match, board, text).encode("ascii")

    def show(self, match: NDArray[np.void], params: NDArray[np.void]) -> bytes:
        """Return a frame."""
        return b",\n" + json_show(match, params).encode("ascii")

    def end(self) -> bytes:
        """Return what closes the log; without it, the file is the beginning of an array."""
        return b"\n]\n"


Form = TextForm | JsonForm


def form_of(version: int, profile: str) -> Form:
    """Return the form of a version of the game log."""
    if version == JSON_LOG:
        return JsonForm(profile)
    return TextForm(min(max(version, OLDEST_TEXT_LOG), NEWEST_TEXT_LOG))
