"""What a trainer (offline coach) may send; one command per datagram (19.0.0, src/coach.cpp)."""

from __future__ import annotations

from dataclasses import dataclass

from rcss_hat.protocol._command_values import message, on_off, one_of, real, team_name, unum, whole
from rcss_hat.protocol._player_commands import LAST_VERSION, Command
from rcss_hat.protocol.errors import LocalProtocolError
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS

SAY_COACH_MSG_SIZE = 128
"""Longest message of a trainer with the server's default ``say_coach_msg_size``."""
MAX_TYPE = 255


@dataclass(frozen=True, slots=True)
class TrainerInit(Command):
    """Join as the trainer."""

    version: float = 11
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return f"(init (version {real('init', 'version', self.version, 1, LAST_VERSION)}))"


@dataclass(frozen=True, slots=True)
class Start(Command):
    """Kick off."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(start)"


@dataclass(frozen=True, slots=True)
class ChangeMode(Command):
    """Change the play mode; names in `rcss_hat.protocol.play_modes`."""

    mode: str
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return f"(change_mode {one_of('change_mode', 'play mode', self.mode, PLAY_MODE_IDS)})"


@dataclass(frozen=True, slots=True)
class MoveBall(Command):
    """Place the ball, metres; with a velocity in metres per cycle, else at rest."""

    x: float
    y: float
    velocity: tuple[float, float] | None = None
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        numbers = [real("move", "x", self.x), real("move", "y", self.y)]
        if self.velocity is not None:
            numbers += ["0", *(real("move", "velocity", component) for component in self.velocity)]
        return f"(move (ball) {' '.join(numbers)})"


@dataclass(frozen=True, slots=True)
class MovePlayer(Command):
    """Place a player: metres, body angle in degrees, velocity in metres per cycle; what is None stays as it is."""

    team: str
    unum: int
    x: float
    y: float
    angle: float | None = None
    velocity: tuple[float, float] | None = None
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        numbers = [real("move", "x", self.x), real("move", "y", self.y)]
        if self.angle is not None:
            numbers.append(real("move", "angle", self.angle, -180.0, 180.0))
        elif self.velocity is not None:
            raise LocalProtocolError("move: a player's velocity needs an angle before it")
        if self.velocity is not None:
            numbers += [real("move", "velocity", component) for component in self.velocity]
        name = f"{team_name('move', self.team)} {unum('move', self.unum)}"
        return f"(move (player {name}) {' '.join(numbers)})"


@dataclass(frozen=True, slots=True)
class Look(Command):
    """Ask where everything is."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(look)"


@dataclass(frozen=True, slots=True)
class Eye(Command):
    """Switch see_global messages on or off."""

    on: bool
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return f"(eye {on_off(self.on)})"


@dataclass(frozen=True, slots=True)
class TrainerEar(Command):
    """Switch hear messages on or off."""

    on: bool
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return f"(ear {on_off(self.on)})"


@dataclass(frozen=True, slots=True)
class CheckBall(Command):
    """Ask in which part of the field the ball is."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(check_ball)"


@dataclass(frozen=True, slots=True)
class Recover(Command):
    """Give all players their full stamina, effort and recovery."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(recover)"


@dataclass(frozen=True, slots=True)
class TeamNames(Command):
    """Ask for the names of the teams."""

    alone = True

    def text(self) -> str:
        """Return the command as text."""
        return "(team_names)"


@dataclass(frozen=True, slots=True)
class TrainerSay(Command):
    """Say something to all players."""

    message: str
    alone = True

    def text(self, size: int = SAY_COACH_MSG_SIZE) -> str:
        """Return the command as text; `size` is the server's say_coach_msg_size."""
        return f"(say {message('say', self.message, size)})"


@dataclass(frozen=True, slots=True)
class ChangePlayerType(Command):
    """Give a player another type."""

    team: str
    unum: int
    player_type: int
    alone = True

    def text(self) -> str:
        """Return the command as text."""
        command = "change_player_type"
        player_type = whole(command, "player type", self.player_type, 0, MAX_TYPE)
        return f"({command} {team_name(command, self.team)} {unum(command, self.unum)} {player_type})"
