"""Who is on a server and what is going on there, as a monitor's frame tells it; what can be made of it. No sockets.

A server keeps for as long as it lives what the first match brought: the names of both teams, a body for every uniform
number that was ever given (a player who left is disabled, and so not placed, seen or waited for), the clock, the play
mode, and in Keepaway the number of keepers counted at the first kick-off, which decides where they are placed. A new
``(init ...)`` never gives a number again; ``(reconnect TEAM UNUM)`` does, but not during ``play_on`` (rcssserver 19,
src/stadium.cpp, parsePlayerInit; src/player.cpp, disable; src/referee.cpp, KeepawayRef). So a second match calls a
foul, which any monitor may, takes up the bodies of the first one, and goes on with the ball outside of the region:
the server's referee then ends the episode at once and places everybody as at the start of any other.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import one_line
from rcss_hat.protocol.play_modes import PLAY_MODES

KEEPERS, TAKERS = "keepers", "takers"
BEFORE_KICK_OFF, PLAY_ON, TIME_OVER = "before_kick_off", "play_on", "time_over"
Numbers = frozenset[int]
NOBODY: Numbers = frozenset()

_HEAD = re.compile(rb"\(show (\d{1,9}) \(pm (\d{1,2})\)(?: \(tm ([^ ()]+) ([^ ()]+) )?")
_PLAYER = re.compile(rb"\(\(([lr]) (\d{1,2})\) \d+ (0x[0-9a-f]+|0) .*?\(c ([0-9 ]+)\)\)")
_NO_TEAM = b"null"
_LONGEST_NAME = 15
_OLD_SHOW, _OLD_SIZE = b"\0\1", 2052
_OLD_MODE, _OLD_NAMES, _OLD_NAME_SIZE, _OLD_FIRST, _OLD_TIME = 2, (4, 22), 16, 52, 316
_OLD_PLAYERS = struct.Struct(">" + "3h6x" * 22)
"""Offsets (bytes) in a frame of version 1; state, side and number come first in each of the 22 entries."""


class WrongServer(RuntimeError):
    """A server on which this task cannot be played; the message says, in one printable line, what would be right."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


@dataclass(frozen=True, slots=True)
class Look:
    """What one frame shows.

    Attributes
    ----------
    cycle : int
    mode : str
        Play mode.
    names : (str, str)
        Of the left and the right team; empty where there is none.
    present : (set of int, set of int)
        Uniform numbers of the connected players of the left and the right side.
    bodies : (set of int, set of int)
        Numbers of all who are or were there, as far as the frame shows: those who left without ever having given a
        command, and all who left a server older than 14, are not known.
    """

    cycle: int
    mode: str
    names: tuple[str, str]
    present: tuple[Numbers, Numbers]
    bodies: tuple[Numbers, Numbers]

    @property
    def counts(self) -> tuple[int, int]:
        """Connected players of the left and the right side."""
        return len(self.present[0]), len(self.present[1])

    def complete(self, task: Task) -> bool:
        """Tell whether the players of the task are there, and nobody else."""
        return self.present == (_first(task.keepers), _first(task.takers))


def _first(n: int) -> Numbers:
    return frozenset(range(1, n + 1))


def look_at(frame: bytes) -> Look | None:
    """Read a monitor's frame of version 1, or 3 to 5; None for other messages, and for frames that make no sense."""
    if frame.startswith(b"(show"):
        return _look_at_text(frame)
    if frame.startswith(_OLD_SHOW) and len(frame) >= _OLD_SIZE:
        return _look_at_binary(frame)
    return None


def _look_at_text(frame: bytes) -> Look | None:
    head = _HEAD.match(frame)
    if head is None or int(head[2]) not in PLAY_MODES:
        return None
    present: dict[bytes, set[int]] = {b"l": set(), b"r": set()}
    bodies: dict[bytes, set[int]] = {b"l": set(), b"r": set()}
    for side, number, state, counts in _PLAYER.findall(frame):
        if state != b"0":
            present[side].add(int(number))
        if state != b"0" or any(count != b"0" for count in counts.split()):
            bodies[side].add(int(number))
    left, right = (b"" if name in (None, _NO_TEAM) else name for name in head.group(3, 4))
    return Look(
        int(head[1]),
        PLAY_MODES[int(head[2])],
        (left.decode("latin-1"), right.decode("latin-1")),
        (frozenset(present[b"l"]), frozenset(present[b"r"])),
        (frozenset(bodies[b"l"]), frozenset(bodies[b"r"])),
    )


def _look_at_binary(frame: bytes) -> Look | None:
    mode = PLAY_MODES.get(frame[_OLD_MODE])
    if mode is None:
        return None
    words = _OLD_PLAYERS.unpack_from(frame, _OLD_FIRST)
    entries = list(zip(words[::3], words[1::3], words[2::3], strict=True))
    left, right = (
        frozenset(number for state, where, number in entries if state != 0 and where == side) for side in (1, -1)
    )
    names = [frame[at : at + _OLD_NAME_SIZE].split(b"\0")[0].decode("latin-1") for at in _OLD_NAMES]
    cycle = int.from_bytes(frame[_OLD_TIME : _OLD_TIME + 2], "big")
    return Look(cycle, mode, (names[0], names[1]), (left, right), (left, right))


def refuse_unfit(look: Look, task: Task, ours: tuple[bool, bool], where: str) -> None:
    """Raise WrongServer when our players cannot play here.

    Parameters
    ----------
    look : Look
    task : Task
    ours : (bool, bool)
        Whether we bring the keepers and the takers; who is not ours may be there already.
    where : str
        The server, for the message.
    """
    left, right = look.names
    if left not in ("", KEEPERS) or right not in ("", TAKERS):
        raise WrongServer(
            f"the teams at {where} are called {_name(left)} and {_name(right)}, not {KEEPERS} and {TAKERS}, and a "
            "server keeps its teams (no_more_team): restart it"
        )
    if look.mode == TIME_OVER:
        raise WrongServer(f"the match at {where} is over (cycle {look.cycle}): restart the server")
    _refuse_crowd(look, task, ours, where)
    counted = max(look.bodies[0], default=0)
    if look.cycle > 0 and counted not in (0, task.keepers):
        raise WrongServer(
            f"the server at {where} was kicked off with {counted} keepers and places as many for ever, not "
            f"{task.keepers}: restart it, or give the size it has"
        )


def _refuse_crowd(look: Look, task: Task, ours: tuple[bool, bool], where: str) -> None:
    keepers, takers = look.counts
    there = f"{keepers} keepers and {takers} takers are at {where} (cycle {look.cycle})"
    if (ours[0] and keepers) or (ours[1] and takers):
        running = keepers and takers and look.mode != BEFORE_KICK_OFF
        state = f"a match is running: {there}" if running else f"{there} already"
        raise WrongServer(f"{state}; wait until they leave, or play on another server")
    if keepers > task.keepers or takers > task.takers:
        raise WrongServer(f"{there}: that is not {task.size}; give the size they play, or use another server")


def _name(name: str) -> str:
    return repr(name[:_LONGEST_NAME]) if name else "(none)"


def seat_is_known(look: Look, side: int, number: int) -> bool:
    """Tell whether a uniform number (side 0 left, 1 right) was given before, so that it is taken up by reconnecting."""
    return any(body >= number for body in look.bodies[side])


def is_untouched(look: Look) -> bool:
    """Tell whether nothing was ever kicked off: the kick-off then starts the first episode."""
    return look.mode == BEFORE_KICK_OFF and look.cycle == 0
