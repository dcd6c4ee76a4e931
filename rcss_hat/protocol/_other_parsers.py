"""Init, trainer and monitor messages as the server reads them (19.0.0, src/stadium.cpp, coach.cpp, monitor.cpp).

A text that the server would refuse gives a `Refusal`, which holds the answer the server sends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rcss_hat.protocol._monitor_commands import (
    CARDS,
    SCALE,
    DispBye,
    DispCard,
    DispDiscard,
    DispFoul,
    DispInit,
    DispPlayer,
    DispStart,
)
from rcss_hat.protocol._player_commands import Command, Compression, Done, Init, Reconnect
from rcss_hat.protocol._scanf import Scanf
from rcss_hat.protocol._trainer_commands import (
    SAY_COACH_MSG_SIZE,
    ChangeMode,
    ChangePlayerType,
    CheckBall,
    Eye,
    Look,
    MoveBall,
    MovePlayer,
    Recover,
    Start,
    TeamNames,
    TrainerEar,
    TrainerInit,
    TrainerSay,
)
from rcss_hat.protocol.params import PROFILES
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.protocol.records import MAX_PLAYERS

_SPACES = " \t\n\v\f\r"


@dataclass(frozen=True, slots=True)
class Refusal:
    """What the server answers to a message it does not accept, for example ``(error illegal_command_form)``."""

    text: str


ILLEGAL_FORM = Refusal("(error illegal_command_form)")
ILLEGAL_OBJECT = Refusal("(error illegal_object_form)")
ILLEGAL_MODE = Refusal("(error illegal_mode)")
UNKNOWN_COMMAND = Refusal("(error unknown_command)")
_DEFAULT_VERSION = 3.0


def _to_text(data: bytes) -> str:
    """Return what C sees of a message: up to the first NUL, one character per byte."""
    return data.split(b"\0", 1)[0].decode("latin-1")


# --- init ----------------------------------------------------------------------------------------------------------
_TEAM = {"19.0": Scanf(" ( init %15[+-_a-zA-Z0-9] %n "), "11.1": Scanf(" ( init %15[-_a-zA-Z0-9] %n ")}
_VERSION = Scanf(" ( version %lf ) %n ")
_RECONNECT = Scanf(" ( reconnect %127s %d ) ")
_DISPINIT = Scanf(" ( dispinit version %lf ) ")


def parse_init(data: bytes, profile: str = "19.0") -> Init | Reconnect | DispInit | Refusal:
    """Read the first datagram of a player or monitor.

    Parameters
    ----------
    data : bytes
        The datagram, with or without NUL or newline at its end.
    profile : {"19.0", "11.1"}
        Which server reads: 19.0 allows more characters in team names.

    Returns
    -------
    Init, Reconnect, DispInit or Refusal
        The version may be any real number, even nan, and the uniform number any integer: whether there is such a
        version or player is for the server to find.
    """
    if profile not in PROFILES:
        raise ValueError(f"unknown profile {profile!r}; known are {', '.join(PROFILES)}")
    text = _to_text(data.removesuffix(b"\n"))
    dispinit = _DISPINIT.scan(text).values
    if text.startswith("(dispinit)") or dispinit:
        return DispInit(float(dispinit[0]) if dispinit else 1.0)
    if text.startswith("(init "):
        return _player_init(text, profile)
    if text.startswith("(reconnect "):
        values = _RECONNECT.scan(text).values
        return Reconnect(str(values[0]), int(values[1])) if len(values) == 2 else ILLEGAL_FORM
    return UNKNOWN_COMMAND


def _player_init(text: str, profile: str) -> Init | Refusal:
    values, i, _ = _TEAM[profile].scan(text)
    if not values or i == 0:
        return Refusal("(error illegal_teamname)")
    if not _continues(text, i):
        return Refusal("(error illegal_teamname_or_too_long_teamname)")
    version, goalie = _DEFAULT_VERSION, False
    i = text.find("(", i)
    while 0 <= i < len(text) and text[i] != ")":
        rest = text[i:]
        if rest.startswith("(version "):
            versions, read, _ = _VERSION.scan(rest)
            if not versions or read == 0:
                return ILLEGAL_FORM
            version = float(versions[0])
            i += read
        elif rest.startswith("(goalie)"):
            goalie = True
            i += len("(goalie)")
        else:
            return ILLEGAL_FORM
        if not _continues(text, i):
            return ILLEGAL_FORM
        while text[i : i + 1] in tuple(_SPACES):
            i += 1
    return Init(str(values[0]), version, goalie)


def _continues(text: str, i: int) -> bool:
    return i < len(text) and text[i] in "()" + _SPACES


# --- trainer -------------------------------------------------------------------------------------------------------
_COMMAND_NAME = Scanf(" ( %127[-0-9a-zA-Z.+*/?<>_] ")
_TRAINER_INIT = Scanf(" ( init ( version %lf ) ) ")
_CHANGE_MODE = Scanf(" ( change_mode %127[-0-9a-zA-Z.+*/?<>_] ) %n ")
_MOVE = Scanf(" ( move ( %127[^)] ) %lf %lf %lf %lf %lf ) %n ")
_PLAYER = Scanf("(player %s %d)")
_SAY = Scanf(" ( %s %[-0-9a-zA-Z ().+*/?<>_]")
_EAR = Scanf(" ( ear %15[^ ()] ) ")
_EYE = Scanf(" ( eye %15[^ ()] ) ")
_CHANGE_PLAYER_TYPE = Scanf(" ( change_player_type %127s %d %d ) ")
_COMPRESSION = Scanf(" ( compression %d ) ")


def parse_trainer_init(data: bytes) -> TrainerInit | Refusal | None:
    """Read the first datagram of a trainer.

    Returns
    -------
    TrainerInit, Refusal or None
        None when it is no init: the server then kicks off and takes it as a command (`parse_trainer_command`).
    """
    text = _to_text(data.removesuffix(b"\n"))
    name = _COMMAND_NAME.scan(text).values
    if not name:
        return ILLEGAL_FORM
    if name[0] != "init":
        return None
    found = _TRAINER_INIT.scan(text)
    version = float(found.values[0]) if found.values else _DEFAULT_VERSION
    if found.exhausted or version < 1.0:
        return ILLEGAL_FORM
    return TrainerInit(version)


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
    text = _to_text(data)
    name = _COMMAND_NAME.scan(text).values
    if not name:
        return ILLEGAL_FORM
    if name[0] == "say":
        values = _SAY.scan(text).values
        return TrainerSay(_chopped(str(values[1]), say_coach_msg_size)) if len(values) == 2 else ILLEGAL_FORM
    if name[0] in _SIMPLE:
        return _SIMPLE[name[0]]()
    parse = _TRAINER.get(str(name[0]))
    return parse(text) if parse else UNKNOWN_COMMAND


def _chopped(message: str, size: int) -> str:
    """Cut the command's closing parenthesis off, or what is too long."""
    return message[:size] if len(message) > size else message.removesuffix(")")


def _change_mode(text: str) -> Command | Refusal:
    values = _CHANGE_MODE.scan(text).values
    if not values:
        return ILLEGAL_FORM
    return ChangeMode(str(values[0])) if values[0] in PLAY_MODE_IDS else ILLEGAL_MODE


def _move(text: str) -> Command | Refusal:
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


def _ear(text: str) -> Command | Refusal:
    mode = _EAR.scan(text).values
    return TrainerEar(mode == ["on"]) if mode in (["on"], ["off"]) else ILLEGAL_FORM


def _eye(text: str) -> Command | Refusal:
    mode = _EYE.scan(text).values
    return Eye(mode == ["on"]) if mode in (["on"], ["off"]) else ILLEGAL_FORM


def _change_player_type(text: str) -> Command | Refusal:
    values = _CHANGE_PLAYER_TYPE.scan(text).values
    return ChangePlayerType(str(values[0]), int(values[1]), int(values[2])) if len(values) == 3 else ILLEGAL_FORM


def _compression(text: str) -> Command | Refusal:
    level = _COMPRESSION.scan(text).values
    return Compression(int(level[0])) if level and int(level[0]) <= 9 else ILLEGAL_FORM


_SIMPLE: dict[object, Callable[[], Command]] = {
    "start": Start, "look": Look, "team_names": TeamNames, "recover": Recover, "check_ball": CheckBall, "done": Done,
}  # fmt: skip
_TRAINER: dict[str, Callable[[str], Command | Refusal]] = {
    "change_mode": _change_mode, "move": _move, "ear": _ear, "eye": _eye, "change_player_type": _change_player_type,
    "compression": _compression,
}  # fmt: skip

# --- monitor -------------------------------------------------------------------------------------------------------
_DISPFOUL = Scanf(" ( dispfoul %d %d %d ) ")
_DISPPLAYER = Scanf(" ( dispplayer %d %d %d %d %d ) ")
_DISPDISCARD = Scanf(" ( dispdiscard %d %d ) ")
_DISPCARD = Scanf(" ( dispcard %d %d %7[^)] ) ")


def parse_monitor_command(data: bytes, coach_mode: bool = False) -> Command | Refusal:
    """Read a monitor's command.

    Parameters
    ----------
    data : bytes
        One datagram.
    coach_mode : bool
        Whether the server allows a trainer; only then monitors may kick off with ``(start)`` and move objects.

    Returns
    -------
    Command or Refusal
        The server sends a refusal as ``(msg TIME 1 "...")``.
    """
    text = _to_text(data)
    if text == "(dispbye)":
        return DispBye()
    if text == "(dispstart)":
        return DispStart()
    for start, parse in _MONITOR:
        if text.startswith(start):
            return parse(text)
    if coach_mode:
        for start, parse in _MONITOR_AS_COACH:
            if text.startswith(start):
                return parse(text)
    return ILLEGAL_FORM


def _ints(form: Scanf, count: int, text: str) -> list[int] | None:
    values = form.scan(text).values
    return [int(value) for value in values] if len(values) == count else None


def _dispplayer(text: str) -> Command | Refusal:
    values = _ints(_DISPPLAYER, 5, text)
    if values is None:
        return ILLEGAL_FORM
    side, unum, x, y, angle = values
    return DispPlayer(side, unum, x / SCALE, y / SCALE, angle)


def _dispdiscard(text: str) -> Command | Refusal:
    values = _ints(_DISPDISCARD, 2, text)
    return ILLEGAL_FORM if values is None else DispDiscard(*values)


def _dispfoul(text: str) -> Command | Refusal:
    values = _ints(_DISPFOUL, 3, text)
    return ILLEGAL_FORM if values is None else DispFoul(values[0] / SCALE, values[1] / SCALE, values[2])


def _dispcard(text: str) -> Command | Refusal:
    values = _DISPCARD.scan(text).values
    if len(values) != 3 or values[2] not in CARDS:
        return ILLEGAL_FORM
    return DispCard(int(values[0]), int(values[1]), str(values[2]))


_Parser = Callable[[str], Command | Refusal]
_MONITOR: tuple[tuple[str, _Parser], ...] = (
    ("(dispplayer", _dispplayer),
    ("(dispdiscard", _dispdiscard),
    ("(compression", _compression),
    ("(dispfoul", _dispfoul),
    ("(dispcard", _dispcard),
)
_MONITOR_AS_COACH: tuple[tuple[str, _Parser], ...] = (
    ("(start)", lambda text: Start()),
    ("(change_mode", _change_mode),
    ("(move", _move),
    ("(recover", lambda text: Recover()),
    ("(check_ball", lambda text: CheckBall()),
)
