"""What a trainer (offline coach) may send, one command a datagram, and how servers read it (19.0.0, src/coach.cpp)."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from rcss_hat.protocol.commands.player import Compression, Done
from rcss_hat.protocol.commands.scanf import Scanf
from rcss_hat.protocol.commands.table import PLAYER, TRAINER, Command, c_text, command
from rcss_hat.protocol.commands.values import (
    ILLEGAL_FORM,
    ILLEGAL_MODE,
    ILLEGAL_OBJECT,
    UNKNOWN_COMMAND,
    Degrees,
    Metres,
    Refusal,
    Switch,
    Team,
    Unum,
    Velocity,
    message,
    whole,
    word,
)
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.protocol.records import MAX_PLAYERS

__all__ = [
    "ChangeMode", "ChangePlayerType", "CheckBall", "Eye", "Look", "MoveBall", "MovePlayer", "Recover", "Start",
    "TeamNames", "TrainerEar", "TrainerSay", "parse_trainer_command",
]  # fmt: skip

SAY_COACH_MSG_SIZE = 128
"""Longest message of a trainer with the server's default ``say_coach_msg_size``."""
_WORD = "%127[-0-9a-zA-Z.+*/?<>_]"
_MODE = replace(word(PLAY_MODE_IDS, "play mode", conversion=_WORD), refusal=ILLEGAL_MODE)


@command(TRAINER, "(start)")
class Start(Command):
    """Kick off."""


@command(TRAINER, "(change_mode {mode})")
class ChangeMode(Command):
    """Change the play mode; names in `rcss_hat.protocol.play_modes`."""

    mode: Annotated[str, _MODE]


@command(TRAINER, "(move (ball) {x} {y})", "(move (ball) {x} {y} 0 {velocity})")
class MoveBall(Command):
    """Place the ball, metres; with a velocity in metres per cycle, else at rest."""

    x: Metres
    y: Metres
    velocity: Velocity | None = None


@command(
    TRAINER,
    "(move (player {team} {unum}) {x} {y})",
    "(move (player {team} {unum}) {x} {y} {angle})",
    "(move (player {team} {unum}) {x} {y} {angle} {velocity})",
    otherwise="a player's velocity needs an angle before it",
)
class MovePlayer(Command):
    """Place a player: metres, body angle in degrees, velocity in metres per cycle; what is None stays as it is."""

    team: Team
    unum: Unum
    x: Metres
    y: Metres
    angle: Degrees | None = None
    velocity: Velocity | None = None


@command(TRAINER, "(look)")
class Look(Command):
    """Ask where everything is."""


@command(TRAINER, "(eye {on})")
class Eye(Command):
    """Switch see_global messages on or off."""

    on: Switch


@command(TRAINER, "(ear {on})")
class TrainerEar(Command):
    """Switch hear messages on or off."""

    on: Switch


@command(TRAINER, "(check_ball)")
class CheckBall(Command):
    """Ask in which part of the field the ball is."""


@command(TRAINER, "(recover)")
class Recover(Command):
    """Give all players their full stamina, effort and recovery."""


@command(TRAINER, "(team_names)")
class TeamNames(Command):
    """Ask for the names of the teams."""


@command(TRAINER, "(say {message})")
class TrainerSay(Command):
    """Say something to all players."""

    message: Annotated[str, message(SAY_COACH_MSG_SIZE)]


@command(TRAINER, "(change_player_type {team} {unum} {player_type})")
class ChangePlayerType(Command):
    """Give a player another type."""

    team: Team
    unum: Unum
    player_type: Annotated[int, whole(0, 255, "player type")]


TRAINER.add(*PLAYER.of(Compression, Done))

# --- how servers read them -----------------------------------------------------------------------------------------
NAME = Scanf(f" ( {_WORD} ")
_MOVE = Scanf(" ( move ( %127[^)] ) %lf %lf %lf %lf %lf ) %n ")
_PLAYER = Scanf("(player %s %d)")
_SAY = Scanf(" ( %s %[-0-9a-zA-Z ().+*/?<>_]")


def parse_trainer_command(data: bytes, say_coach_msg_size: int = SAY_COACH_MSG_SIZE) -> Command | Refusal:
    """Read a trainer's command.

    Parameters
    ----------
    data : bytes
        One datagram; a second command in it is ignored, as by the server.
    say_coach_msg_size : int
        Where longer messages are cut.

    Returns
    -------
    Command or Refusal
    """
    text = c_text(data)
    name = NAME.scan(text).values
    if not name:
        return ILLEGAL_FORM
    if name[0] == "say":
        values = _SAY.scan(text).values
        return TrainerSay(_chopped(str(values[1]), say_coach_msg_size)) if len(values) == 2 else ILLEGAL_FORM
    read = _READERS.get(str(name[0]))
    return read(text) if read else UNKNOWN_COMMAND


def _chopped(message: str, size: int) -> str:
    """Cut the command's closing parenthesis off, or what is too long."""
    return message[:size] if len(message) > size else message.removesuffix(")")


def parse_move(text: str) -> Command | Refusal:
    """Read where an object shall be, the ball or a player."""
    values = _MOVE.scan(text).values
    numbers = [float(value) for value in values[1:]]
    if len(numbers) < 2 or any(number != number for number in numbers):
        return ILLEGAL_OBJECT
    x, y, *rest = numbers
    velocity = (rest[1], rest[2]) if len(rest) == 3 else None
    name = f"({values[0]})"
    if name == "(ball)":
        return ILLEGAL_FORM if len(rest) == 2 else MoveBall(x, y, velocity)
    player = _PLAYER.scan(name).values
    if len(player) < 2 or not 1 <= int(player[1]) <= MAX_PLAYERS:
        return ILLEGAL_OBJECT
    if len(rest) == 2:
        return ILLEGAL_FORM
    return MovePlayer(str(player[0]), int(player[1]), x, y, rest[0] if rest else None, velocity)


_READERS = {name: forms[0].reader() for name, forms in TRAINER.forms.items() if name != "say"} | {"move": parse_move}
