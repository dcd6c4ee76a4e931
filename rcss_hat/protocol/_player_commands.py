"""What a player may send (19.0.0, src/player_command_parser; 11.1.2 knows fewer forms)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from rcss_hat.protocol._command_values import message, on_off, one_of, real, team_name, unum, whole
from rcss_hat.protocol.errors import LocalProtocolError
from rcss_hat.protocol.records import SAY_SIZE

WIDTHS = ("narrow", "normal", "wide")
QUALITIES = ("low", "high")
EAR_MODES = ("partial", "complete")
LAST_VERSION = 19
INT_MAX = 2**31 - 1


class Command(ABC):
    """Something a client may send."""

    __slots__ = ()
    alone = False
    """Whether the command needs a datagram of its own."""

    @abstractmethod
    def text(self) -> str:
        """Return the command as text, without NUL.

        Raises
        ------
        LocalProtocolError
            When an argument is illegal.
        """

    def to_bytes(self) -> bytes:
        """Return the command as bytes, without NUL; see `text`."""
        return self.text().encode("ascii")


@dataclass(frozen=True, slots=True)
class Dash(Command):
    """Run: power in -100 .. 100, direction in degrees relative to the body (server 13 and later)."""

    power: float
    direction: float | None = None

    def text(self) -> str:
        """Return the command as text."""
        power = real("dash", "power", self.power, -100.0, 100.0)
        if self.direction is None:
            return f"(dash {power})"
        return f"(dash {power} {real('dash', 'direction', self.direction, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class DashLegs(Command):
    """Run with each leg on its own, (power, direction) or None (server 19)."""

    left: tuple[float, float] | None = None
    right: tuple[float, float] | None = None

    def text(self) -> str:
        """Return the command as text."""
        legs = []
        for name, leg in (("l", self.left), ("r", self.right)):
            if leg is not None:
                power = real("dash", f"power of leg {name}", leg[0], -100.0, 100.0)
                legs.append(f"({name} {power} {real('dash', f'direction of leg {name}', leg[1], -180.0, 180.0)})")
        if not legs:
            raise LocalProtocolError("dash: give at least one of the legs left and right")
        return f"(dash {' '.join(legs)})"


@dataclass(frozen=True, slots=True)
class Turn(Command):
    """Turn the body: moment in degrees, less when moving."""

    moment: float

    def text(self) -> str:
        """Return the command as text."""
        return f"(turn {real('turn', 'moment', self.moment, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class TurnNeck(Command):
    """Turn the neck by degrees relative to the body."""

    moment: float

    def text(self) -> str:
        """Return the command as text."""
        return f"(turn_neck {real('turn_neck', 'moment', self.moment, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class Kick(Command):
    """Kick: power in -100 .. 100, direction in degrees relative to the body."""

    power: float
    direction: float

    def text(self) -> str:
        """Return the command as text."""
        power = real("kick", "power", self.power, -100.0, 100.0)
        return f"(kick {power} {real('kick', 'direction', self.direction, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class LongKick(Command):
    """A kick that servers read and ignore."""

    power: float
    direction: float

    def text(self) -> str:
        """Return the command as text."""
        power = real("long_kick", "power", self.power, -100.0, 100.0)
        return f"(long_kick {power} {real('long_kick', 'direction', self.direction, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class Tackle(Command):
    """Tackle: the number is a power for clients below version 12, a direction in degrees from 12 on."""

    number: float
    foul: bool | None = None

    def text(self) -> str:
        """Return the command as text."""
        number = real("tackle", "power or direction", self.number, -180.0, 180.0)
        return f"(tackle {number})" if self.foul is None else f"(tackle {number} {on_off(self.foul)})"


@dataclass(frozen=True, slots=True)
class Catch(Command):
    """Catch the ball (goalie): direction in degrees relative to the body."""

    direction: float

    def text(self) -> str:
        """Return the command as text."""
        return f"(catch {real('catch', 'direction', self.direction, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class Move(Command):
    """Place oneself before kick-off, metres; the own half has negative x for both sides."""

    x: float
    y: float

    def text(self) -> str:
        """Return the command as text."""
        return f"(move {real('move', 'x', self.x)} {real('move', 'y', self.y)})"


@dataclass(frozen=True, slots=True)
class Say(Command):
    """Say a message; always sent in quotes, because an unquoted one swallows the commands behind it."""

    message: str

    def text(self, size: int = SAY_SIZE) -> str:
        """Return the command as text; `size` is the server's say_msg_size."""
        return f'(say "{message("say", self.message, size)}")'


@dataclass(frozen=True, slots=True)
class ChangeView(Command):
    """Choose the view: width narrow, normal or wide; quality low or high (server 12 and later: may be left out)."""

    width: str
    quality: str | None = None

    def text(self) -> str:
        """Return the command as text."""
        width = one_of("change_view", "width", self.width, WIDTHS)
        if self.quality is None:
            return f"(change_view {width})"
        return f"(change_view {width} {one_of('change_view', 'quality', self.quality, QUALITIES)})"


@dataclass(frozen=True, slots=True)
class AttentionTo(Command):
    """Listen to one player: team our, opp, l, r or a name; without arguments, to nobody."""

    team: str | None = None
    unum: int = 0

    def text(self) -> str:
        """Return the command as text."""
        if self.team is None:
            return "(attentionto off)"
        return f"(attentionto {team_name('attentionto', self.team)} {unum('attentionto', self.unum)})"


@dataclass(frozen=True, slots=True)
class PointTo(Command):
    """Point somewhere: metres and degrees relative to the face; without arguments, stop pointing."""

    distance: float | None = None
    direction: float = 0.0

    def text(self) -> str:
        """Return the command as text."""
        if self.distance is None:
            return "(pointto off)"
        distance = real("pointto", "distance", self.distance)
        return f"(pointto {distance} {real('pointto', 'direction', self.direction, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class Ear(Command):
    """Switch hearing on or off: of one team (our, opp, l, r, a name) or both, of one kind or both."""

    on: bool
    team: str | None = None
    mode: str | None = None

    def text(self) -> str:
        """Return the command as text."""
        words = [on_off(self.on)]
        if self.team is not None:
            words.append(team_name("ear", self.team))
        if self.mode is not None:
            words.append(one_of("ear", "mode", self.mode, EAR_MODES))
        return f"(ear ({' '.join(words)}))"


@dataclass(frozen=True, slots=True)
class Clang(Command):
    """Say which versions of the coach language one understands."""

    minimum: int
    maximum: int

    def text(self) -> str:
        """Return the command as text."""
        minimum = whole("clang", "lowest version", self.minimum, 0, INT_MAX)
        return f"(clang (ver {minimum} {whole('clang', 'highest version', self.maximum, 0, INT_MAX)}))"


@dataclass(frozen=True, slots=True)
class Compression(Command):
    """Compress messages: level 0 .. 9; -1 switches off."""

    level: int

    def text(self) -> str:
        """Return the command as text."""
        return f"(compression {whole('compression', 'level', self.level, -1, 9)})"


@dataclass(frozen=True, slots=True)
class ChangeFocus(Command):
    """Move the point of focus: metres and degrees (server 18 and later)."""

    distance: float
    direction: float

    def text(self) -> str:
        """Return the command as text."""
        distance = real("change_focus", "distance", self.distance)
        return f"(change_focus {distance} {real('change_focus', 'direction', self.direction, -180.0, 180.0)})"


@dataclass(frozen=True, slots=True)
class SenseBody(Command):
    """Ask for a sense_body message."""

    def text(self) -> str:
        """Return the command as text."""
        return "(sense_body)"


@dataclass(frozen=True, slots=True)
class Score(Command):
    """Ask for the score."""

    def text(self) -> str:
        """Return the command as text."""
        return "(score)"


@dataclass(frozen=True, slots=True)
class Done(Command):
    """Answer ``(think)`` in synch mode."""

    def text(self) -> str:
        """Return the command as text."""
        return "(done)"


@dataclass(frozen=True, slots=True)
class Bye(Command):
    """Leave."""

    def text(self) -> str:
        """Return the command as text."""
        return "(bye)"


@dataclass(frozen=True, slots=True)
class SynchSee(Command):
    """See in step with sense_body (server 12 and later)."""

    def text(self) -> str:
        """Return the command as text."""
        return "(synch_see)"


@dataclass(frozen=True, slots=True)
class GaussianSee(Command):
    """See with Gaussian noise (server 19)."""

    def text(self) -> str:
        """Return the command as text."""
        return "(gaussian_see)"


@dataclass(frozen=True, slots=True)
class Init(Command):
    """Join a team."""

    team: str
    version: float = 11
    goalie: bool = False
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        version = real("init", "version", self.version, 1, LAST_VERSION)
        goalie = " (goalie)" if self.goalie else ""
        return f"(init {team_name('init', self.team)} (version {version}){goalie})"


@dataclass(frozen=True, slots=True)
class Reconnect(Command):
    """Take a place again that one had."""

    team: str
    unum: int
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return f"(reconnect {team_name('reconnect', self.team)} {unum('reconnect', self.unum)})"
