"""How players, monitors and trainers join, and how servers read it (19.0.0, src/stadium.cpp and coach.cpp)."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from rcss_hat.protocol.commands.scanf import Scanf
from rcss_hat.protocol.commands.table import JOINING, Command, c_text, command
from rcss_hat.protocol.commands.trainer import NAME
from rcss_hat.protocol.commands.values import ILLEGAL_FORM, UNKNOWN_COMMAND, Refusal, Team, Unum, mark, real, whole
from rcss_hat.protocol.params import PROFILES

__all__ = ["DispInit", "Init", "Reconnect", "TrainerInit", "parse_init", "parse_trainer_init"]

Version = Annotated[float, real(1, 19)]


@command(JOINING, "(init {team} (version {version}))", "(init {team} (version {version}) {goalie})")
class Init(Command):
    """Join a team."""

    team: Team
    version: Version = 11
    goalie: Annotated[bool, mark("(goalie)")] = False


@command(JOINING, "(reconnect {team} {unum})")
class Reconnect(Command):
    """Take a place again that one had."""

    team: Team
    unum: Unum


@command(JOINING, "(init (version {version}))")
class TrainerInit(Command):
    """Join as the trainer."""

    version: Version = 11


@command(JOINING, "(dispinit version {version})", "(dispinit)")
class DispInit(Command):
    """Join as a monitor; version 1 to 5, or -1 for JSON frames (server 19)."""

    version: Annotated[float, replace(whole(-1, 5), conversion="%lf", read=float, absent=1)] = 1


# --- how servers read them -----------------------------------------------------------------------------------------
_SPACES = " \t\n\v\f\r"
_DEFAULT_VERSION = 3.0
_TEAM = {"19.0": Scanf(" ( init %15[+-_a-zA-Z0-9] %n "), "11.1": Scanf(" ( init %15[-_a-zA-Z0-9] %n ")}
_VERSION = Scanf(" ( version %lf ) %n ")
_read_reconnect, _read_dispinit = (JOINING.of(record)[0].reader() for record in (Reconnect, DispInit))
_TRAINER_INIT = JOINING.of(TrainerInit)[0].scanf


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
    text = c_text(data.removesuffix(b"\n"))
    dispinit: DispInit | Refusal = _read_dispinit(text)
    if isinstance(dispinit, DispInit):
        return dispinit
    if text.startswith("(dispinit)"):
        return DispInit(1.0)
    if text.startswith("(init "):
        return _player_init(text, profile)
    if text.startswith("(reconnect "):
        reconnect: Reconnect | Refusal = _read_reconnect(text)
        return reconnect
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


def parse_trainer_init(data: bytes) -> TrainerInit | Refusal | None:
    """Read the first datagram of a trainer.

    Returns
    -------
    TrainerInit, Refusal or None
        None when it is no init: the server then kicks off and takes it as a command (`parse_trainer_command`).
    """
    text = c_text(data.removesuffix(b"\n"))
    name = NAME.scan(text).values
    if not name:
        return ILLEGAL_FORM
    if name[0] != "init":
        return None
    found = _TRAINER_INIT.scan(text)
    version = float(found.values[0]) if found.values else _DEFAULT_VERSION
    return ILLEGAL_FORM if found.exhausted or version < 1.0 else TrainerInit(version)
