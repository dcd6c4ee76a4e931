"""Short messages: how one joins, answers to commands, what changes now and then."""

from __future__ import annotations

import re
from typing import Annotated

from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.messages.event import (
    BY_BYTES,
    SIDES,
    Event,
    Kind,
    Rest,
    Side,
    Unum,
    Whole,
    Word,
    event,
    optional,
    reads,
    record,
)
from rcss_hat.protocol.messages.groups import Group
from rcss_hat.protocol.messages.parts import counted

__all__ = [
    "ChangePlayerType", "Error", "Init", "InitOk", "Msg", "Ok", "OkCheckBall", "OkClang", "OkCompression",
    "OkTeamNames", "PlayMode", "Reconnect", "Score", "Team", "Think", "Unknown", "Warning",
]  # fmt: skip


# --- joining ---------------------------------------------------------------------------------------------------------
@event("init")
class Init(Event):
    """A player was accepted: ``(init SIDE UNUM MODE)``."""

    side: Side
    unum: Unum
    mode: Word


@event("init ok")
class InitOk(Event):
    """A trainer was accepted: ``(init ok)``."""


@event("reconnect")
class Reconnect(Event):
    """A player is back: ``(reconnect SIDE MODE)``."""

    side: Side
    mode: Word


# --- answers ---------------------------------------------------------------------------------------------------------
@event("ok")
class Ok(Event):
    """A command was accepted: its name, and what else the answer says, for example ``eye`` and ``on``."""

    command: Word
    text: Rest = ""


@record
class OkClang(Event):
    """Versions of the coach language."""

    minimum: int
    maximum: int

    def to_text(self) -> str:
        """Return ``(ok clang (ver MINIMUM MAXIMUM))``."""
        return f"(ok clang (ver {self.minimum} {self.maximum}))"


@reads("ok clang")
def _ok_clang(group: Group) -> Event:
    versions = group.group("ver")
    return OkClang(minimum=versions.integer(), maximum=versions.integer())


@event("ok compression")
class OkCompression(Event):
    """From now on messages are compressed; a negative level: no longer."""

    level: Whole


@event("ok check_ball")
class OkCheckBall(Event):
    """Where the ball is: ``in_field``, ``goal_l``, ``goal_r`` or ``out_of_field``."""

    time: Whole
    where: Word


@record
class OkTeamNames(Event):
    """Names of the teams; None where there is none yet."""

    left: str | None
    right: str | None

    def to_text(self) -> str:
        """Return ``(ok team_names (team l LEFT) (team r RIGHT))``."""
        teams = [f" (team {side} {name})" for side, name in zip(SIDES, (self.left, self.right), strict=True) if name]
        return f"(ok team_names{''.join(teams)})"


@reads("ok team_names")
def _ok_team_names(group: Group) -> Event:
    names: dict[str, str] = {}
    while group.more:
        team = group.group("team")
        side = team.word(*SIDES)
        names[side] = team.text()
    return OkTeamNames(left=names.get("l"), right=names.get("r"))


@event("error")
class Error(Event):
    """A message was refused; the text is without ``(error`` and ``)``."""

    text: Rest


@event("warning")
class Warning(Event):
    """A message was accepted with a warning."""

    text: Rest


@event("score")
class Score(Event):
    """Goals of the own and the other team."""

    time: Whole
    ours: Whole
    theirs: Whole


# --- what changes ----------------------------------------------------------------------------------------------------
@event("think")
class Think(Event):
    """Synch mode: the server waits for commands and ``(done)``."""


_SideIfAny = Annotated[str | None, Kind(lambda group: group.word() if group.peek() in SIDES else None, optional)]
_TypeIfAny = Annotated[int | None, Kind(lambda group: group.integer(0) if group.more else None, optional)]


@event("change_player_type")
class ChangePlayerType(Event):
    """A player has another type now; None: an opponent, whose type stays unknown. Monitors and coaches get the side."""

    side: _SideIfAny = None
    unum: Unum
    player_type: _TypeIfAny = None


@event("playmode")
class PlayMode(Event):
    """A line of a game log: the play mode changed."""

    time: Whole
    mode: Word


@record
class Team(Event):
    """Names and scores: in a monitor's frame, and as a line of a game log (then with a time).

    Attributes
    ----------
    left, right : str
        ``null`` while there is no such team.
    penalties : tuple of int
        Scored and missed by the left, scored and missed by the right team; empty before penalty kicks.
    """

    left: str
    right: str
    left_score: int
    right_score: int
    penalties: tuple[int, ...] = ()
    time: int | None = None

    def to_text(self) -> str:
        """Return ``(team TIME LEFT RIGHT SCORES)``, the line of a log, or ``(tm ...)``, the part of a frame."""
        words = ["tm" if self.time is None else f"team {self.time}", self.left, self.right]
        return f"({' '.join([*words, *map(str, (self.left_score, self.right_score, *self.penalties))])})"


@reads("team")
def _team(group: Group) -> Event:
    time, left, right = group.integer(), group.text(), group.text()
    ours, theirs, *penalties = (int(score) for score in counted(group, 2, 6))
    return Team(time=time, left=left, right=right, left_score=ours, right_score=theirs, penalties=tuple(penalties))


@record
class Msg(Event):
    """What a monitor is told: board 1 is for people (referee, players, replies), board 2 for the log."""

    time: int
    board: int
    text: str

    def to_text(self) -> str:
        """Return ``(msg TIME BOARD "TEXT")``."""
        return f'(msg {self.time} {self.board} "{self.text}")'


_MSG = re.compile(rb'\(msg (-?[0-9]{1,9}) ([0-9]{1,3}) "([^\0]*)"\)[ \t\r\n]*(?:\0|$)')


def _msg(data: bytes, team: str) -> Event:
    match = _MSG.match(data)
    if match is None:
        raise RemoteProtocolError('bad msg message: expected (msg TIME BOARD "TEXT")', data, len(b"(msg "))
    return Msg(time=int(match[1]), board=int(match[2]), text=match[3].decode("latin-1"))


BY_BYTES[b"msg"] = _msg


@record
class Unknown(Event):
    """A well-formed message of a kind this package does not know."""

    data: bytes
