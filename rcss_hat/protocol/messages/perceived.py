"""What a player perceives: see, sense_body, hear."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol import records
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.messages.event import BY_BYTES, Event, record
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body

__all__ = ["Hear", "See", "SenseBody"]


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class See(Event):
    """What a player sees: a SEE record, shape (1,)."""

    record: NDArray[np.void]


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SenseBody(Event):
    """What a player feels: a SENSE_BODY record, shape (1,)."""

    record: NDArray[np.void]


def _see(data: bytes, team: str) -> Event:
    record = records.empty(records.SEE)
    parse_see(data, team.encode("latin-1", "replace"), record)
    return See(record=record)


def _sense_body(data: bytes, team: str) -> Event:
    record = records.empty(records.SENSE_BODY)
    parse_sense_body(data, record)
    return SenseBody(record=record)


@record
class Hear(Event):
    """Something said.

    Attributes
    ----------
    time : int
    source : str
        ``referee``, ``coach`` (the trainer), ``online_coach_left``, ``online_coach_right``, ``self``, ``our``, ``opp``,
        or ``player``: to trainers, and to players of version 7, who are not told which side spoke.
    text : str or None
        Without quotes; None when only the fact of speaking was heard.
    direction : float or None
        Relative to the body.
    unum : int or None
        Of a team mate; to trainers, of any player.
    team : str or None
        To trainers only: the speaker's team.
    goalie : bool
        To trainers only.
    """

    time: int
    source: str
    text: str | None = None
    direction: float | None = None
    unum: int | None = None
    team: str | None = None
    goalie: bool = False

    def to_text(self) -> str:
        """Return the message; only to trainers, servers write ``referee`` before the time."""
        if self.team is not None:
            return f'(hear {self.time} (p "{self.team}" {self.unum}{" goalie" * self.goalie}) "{self.text}")'
        if self.source == "referee":
            return f"(hear {self.time} referee {self.text})"
        direction = "" if self.direction is None else f" {self.direction:g}"
        source = "" if self.source == "player" else f" {self.source}"
        unum = "" if self.unum is None else f" {self.unum}"
        text = "" if self.text is None else f' "{self.text}"'
        return f"(hear {self.time}{direction}{source}{unum}{text})"


_SPOKEN = re.compile(rb"\(hear (?:referee )?(-?[0-9]{1,9}) ([^\0]+)\)[ \t\r\n]*(?:\0|$)")
_WITH_NAME = re.compile(r"(referee|self|coach|online_coach_left|online_coach_right) (.*)", re.DOTALL)
_BY_SIDE = re.compile(r'(?:(-?[0-9]{1,3}) )?(our|opp)(?: ([0-9]{1,2}))?(?: "([^"]*)")?')
_BY_DIRECTION = re.compile(r'(-?[0-9]{1,3}) "([^"]*)"')
_BY_PLAYER = re.compile(r'\(p "([^"]*)" ([0-9]{1,2})( goalie)?\) "([^"]*)"')


def _hear(data: bytes, team: str) -> Event:
    match = _SPOKEN.match(data)
    if match is None:
        raise RemoteProtocolError("bad hear message: expected (hear TIME SOURCE TEXT)", data, len(b"(hear "))
    time, said = int(match.group(1)), match.group(2).decode("latin-1")
    if data.startswith(b"(hear referee "):  # to trainers, who get the name before the time
        return Hear(time=time, source="referee", text=said)
    named = _WITH_NAME.fullmatch(said)
    if named:
        return Hear(time=time, source=named[1], text=_without_quotes(named[2]))
    by_side = _BY_SIDE.fullmatch(said)
    if by_side and (by_side[1] is None) == (by_side[4] is None):
        direction, unum = by_side[1], by_side[3]
        if (unum is not None and 1 <= int(unum) <= MAX_PLAYERS) == (by_side[2] == "our"):
            return Hear(
                time=time,
                source=by_side[2],
                text=by_side[4],
                direction=None if direction is None else float(direction),
                unum=None if unum is None else int(unum),
            )
    by_direction = _BY_DIRECTION.fullmatch(said)
    if by_direction:
        return Hear(time=time, source="player", text=by_direction[2], direction=float(by_direction[1]))
    by_player = _BY_PLAYER.fullmatch(said)
    if by_player and 1 <= int(by_player[2]) <= MAX_PLAYERS:
        speaker, unum, goalie, text = by_player.groups()
        return Hear(time=time, source="player", text=text, unum=int(unum), team=speaker, goalie=goalie is not None)
    raise RemoteProtocolError("bad hear message: unknown source", data, match.start(2))


def _without_quotes(text: str) -> str:
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


BY_BYTES |= {b"see": _see, b"sense_body": _sense_body, b"hear": _hear}
