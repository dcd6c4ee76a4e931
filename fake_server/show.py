"""What monitors and game logs are told of the match's record, in every form (`rcss_hat.protocol.messages`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol import messages
from rcss_hat.protocol.digits import Buffer
from rcss_hat.protocol.messages import binary, show, show_json
from rcss_hat.simulation.clock import view_angle
from rcss_hat.simulation.state import F_GOALIE, F_RED_CARD, F_STAND, F_YELLOW_CARD, N_PLAYERS

MESSAGE_BOARD, LOG_BOARD = 1, 2


@inlined
def state_flags(match: NDArray[np.void], i: int) -> int:
    """Return a player's state word of the monitor protocol; off the field only cards are left of it."""
    flags = match["flags"][0, i]
    if not match["enabled"][0, i]:
        return flags & (F_YELLOW_CARD | F_RED_CARD)
    return flags | F_STAND | (F_GOALIE if match["goalie"][0, i] else 0)


@kernel
def _look(
    match: NDArray[np.void], params: NDArray[np.void], flags: NDArray[np.int64], view_angles: NDArray[np.float64]
) -> None:
    for i in range(N_PLAYERS):
        flags[i] = state_flags(match, i)
        view_angles[i] = view_angle(match, params, i)


def _seen(match: NDArray[np.void], params: NDArray[np.void]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return every player's state word and view angle (degrees)."""
    flags, view_angles = np.empty(N_PLAYERS, dtype=np.int64), np.empty(N_PLAYERS)
    _look(match, params, flags, view_angles)
    return flags, view_angles


def write_show(match: NDArray[np.void], params: NDArray[np.void], version: int, head: Buffer, buffer: Buffer) -> int:
    """Write a frame of monitor version 3 to 5; returns its length. See `rcss_hat.protocol.messages.show.write_show`."""
    return show.write_show(match, *_seen(match, params), version, head, buffer)


def show_1(match: NDArray[np.void], params: NDArray[np.void], teams: tuple[str, str]) -> bytes:
    """Return a frame of monitor version 1; ``teams`` are the names, empty where there is none."""
    return binary.show_1(match, _seen(match, params)[0], teams)


def show_2(match: NDArray[np.void], params: NDArray[np.void], teams: tuple[str, str]) -> bytes:
    """Return a frame of monitor version 2; ``teams`` are the names, empty where there is none."""
    return binary.show_2(match, *_seen(match, params), teams)


def json_show(
    match: NDArray[np.void], params: NDArray[np.void], mode: str | None = None, teams: tuple[str, str] = ("", "")
) -> str:
    """Return a frame as JSON, for monitors with play mode and teams."""
    return show_json.json_show(match, *_seen(match, params), mode, teams)


def monitor_head(mode: int, teams: tuple[str, str], score: tuple[int, int]) -> str:
    """Return play mode and teams as in frames for monitors."""
    return f" (pm {mode}) {team_of(teams, score).to_text()}"


def team_of(teams: tuple[str, str], score: tuple[int, int], time: int | None = None) -> messages.Team:
    """Return names, ``null`` where there is none, and score; with a time, as a line of a log."""
    left, right = (name or "null" for name in teams)
    return messages.Team(left=left, right=right, left_score=score[0], right_score=score[1], time=time)
