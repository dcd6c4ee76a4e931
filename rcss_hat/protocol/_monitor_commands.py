"""What a monitor may send; one command per datagram (19.0.0, src/monitor.cpp)."""

from __future__ import annotations

from dataclasses import dataclass

from rcss_hat.protocol._command_values import one_of, real, unum, whole
from rcss_hat.protocol._player_commands import Command
from rcss_hat.protocol.errors import LocalProtocolError

SCALE = 16
"""Monitors send positions as integers of 1/16 m."""
LAST_MONITOR_VERSION = 5
CARDS = ("yellow", "red")


def _sixteenths(command: str, what: str, metres: float) -> str:
    real(command, what, metres, -1000.0, 1000.0)
    return str(round(metres * SCALE))


def _side(command: str, side: int, nobody: bool = False) -> str:
    known = {1: "1 (left)", -1: "-1 (right)"} | ({0: "0 (nobody)"} if nobody else {})
    if side not in known:
        raise LocalProtocolError(f"{command}: side must be {' or '.join(known.values())}, not {side!r}")
    return str(int(side))


@dataclass(frozen=True, slots=True)
class DispInit(Command):
    """Join as a monitor; version 1 to 5, or -1 for JSON frames (server 19)."""

    version: float = 1
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        version = whole("dispinit", "version", self.version, -1, LAST_MONITOR_VERSION)
        return "(dispinit)" if self.version == 1 else f"(dispinit version {version})"


@dataclass(frozen=True, slots=True)
class DispStart(Command):
    """Kick off."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(dispstart)"


@dataclass(frozen=True, slots=True)
class DispBye(Command):
    """Leave."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(dispbye)"


@dataclass(frozen=True, slots=True)
class DispFoul(Command):
    """Call a foul at a place (m): free kick for side 1 (left) or -1 (right); 0 drops the ball there."""

    x: float
    y: float
    side: int
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        place = f"{_sixteenths('dispfoul', 'x', self.x)} {_sixteenths('dispfoul', 'y', self.y)}"
        return f"(dispfoul {place} {_side('dispfoul', self.side, nobody=True)})"


@dataclass(frozen=True, slots=True)
class DispPlayer(Command):
    """Place a player of side 1 (left) or -1 (right): metres, and whole degrees of the body."""

    side: int
    unum: int
    x: float
    y: float
    angle: int
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        who = f"{_side('dispplayer', self.side)} {unum('dispplayer', self.unum)}"
        place = f"{_sixteenths('dispplayer', 'x', self.x)} {_sixteenths('dispplayer', 'y', self.y)}"
        return f"(dispplayer {who} {place} {whole('dispplayer', 'angle', self.angle, -180, 180)})"


@dataclass(frozen=True, slots=True)
class DispDiscard(Command):
    """Take a player of side 1 (left) or -1 (right) off the field."""

    side: int
    unum: int
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return f"(dispdiscard {_side('dispdiscard', self.side)} {unum('dispdiscard', self.unum)})"


@dataclass(frozen=True, slots=True)
class DispCard(Command):
    """Show a player of side 1 (left) or -1 (right) a yellow or red card (server 19)."""

    side: int
    unum: int
    card: str
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        who = f"{_side('dispcard', self.side)} {unum('dispcard', self.unum)}"
        return f"(dispcard {who} {one_of('dispcard', 'card', self.card, CARDS)})"
