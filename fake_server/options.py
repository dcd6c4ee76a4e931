"""The command line: ``server::name = value`` and ``player::name = value`` as rcssserver reads them, and own options.

Values: booleans are 0, 1, true, false, on, off, yes or no, in any case; texts may stand in quotes. A value that the
original would cast, such as 1.5 for an integer, is refused. Of configuration files, only those named by ``include`` are
read.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from fake_server.effects import NO_EFFECT, NOT_DONE_HERE, SAVERS
from fake_server.player_param import BY_NAME as PLAYER_BY_NAME
from fake_server.player_param import PlayerParams
from fake_server.server_line import Assignment, HelpWanted, IncludeError, LineError, read_arguments, unquoted
from rcss_hat.protocol.params import BY_NAME as SERVER_BY_NAME
from rcss_hat.protocol.params import KIND_NAMES, PROFILES, Parameter, ServerParams, Value, checked
from rcss_hat.protocol.records import SAY_SIZE

PROGRAM = "fake-rcssserver"
PATIENCE = 1.25
"""Seconds that rcssserver waits for a client in synch mode."""
USAGE = f"""\
Usage: {PROGRAM} [OPTIONS] [server::NAME=VALUE] [player::NAME=VALUE] [include=FILE] ...
       {PROGRAM} replay FILE [--port P] [--bind ADDRESS]

A stand-in for rcssserver. Parameters are written as for rcssserver; port 0 is any free port.

Options:
  --seed N           play reproducibly (in synch mode): the same seed and clients give the same match
  --profile VERSION  defaults and rules of server {" or ".join(PROFILES)} (default {PROFILES[0]})
  --bind ADDRESS     address to listen on (default 127.0.0.1; 0.0.0.0 is every network)
  --episodes N       stop after N Keepaway episodes
  --patience SECONDS how long synch mode waits for a client (default 1.25, as the original)
  --quiet            print nothing but warnings
  --help             show this text

Commands:
  replay FILE        play a recorded transcript (.jsonl or .jsonl.gz) to real clients; --port P (default 6000)

Example: Keepaway 3 vs 2 at full speed, starting 5 seconds after the first step
  {PROGRAM} --seed 1 server::keepaway=1 server::keepaway_start=5 server::synch_mode=1 \\
    server::synch_offset=80 server::visible_angle=360 server::half_time=-1 server::use_offside=0 \\
    server::forbid_kick_off_offside=0 server::stamina_inc_max=3500
"""

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_BOOLEANS = {"0": False, "1": True, "false": False, "true": True, "off": False, "on": True, "no": False, "yes": True}
_TABLES: dict[str, Mapping[str, Parameter]] = {"server": SERVER_BY_NAME, "player": PLAYER_BY_NAME}
_VERSION = "version"
"""Stands in every configuration file that rcssserver writes; says nothing about the match."""
_TEAM_NAME = re.compile(r"[-+_a-zA-Z0-9]{1,15}")
_TAKES_VALUE = ("--seed", "--profile", "--bind", "--episodes", "--patience")
_FLAGS = ("--quiet",)


_LIMITS: dict[str, tuple[int, int, str]] = {
    "port": (0, 65535, "a port"),
    "coach_port": (0, 65535, "a port"),
    "olcoach_port": (0, 65535, "a port"),
    "say_msg_size": (0, SAY_SIZE, "a number of characters"),
    "game_log_version": (-1, 6, "a version"),
    "game_log_compression": (0, 9, "a level"),
    "text_log_compression": (0, 9, "a level"),
    "simulator_step": (10, 10000, "milliseconds"),
    "send_step": (10, 10000, "milliseconds"),
    "sense_body_step": (10, 10000, "milliseconds"),
    "player_types": (1, 255, "a number"),
}
"""Parameters whose values are bounded here: lowest, highest, what they are."""
_LEAST: dict[str, int] = {"slow_down_factor": 1, "nr_normal_halfs": 0, "nr_extra_halfs": 0, "extra_half_time": 0}
_BETWEEN_0_AND_1 = ("foul_detect_probability", "red_card_probability")
"""Parameters whose values are raised or lowered to what they may be, without a word, as the original does."""


class UsageError(Exception):
    """The command line is wrong; the message says where and what would be right."""


class HelpRequested(Exception):
    """``--help`` or ``help`` was given."""


@dataclass
class ServerOptions:
    """Everything that decides how a server behaves.

    Attributes
    ----------
    params : ServerParams
    player_params : PlayerParams
    seed : int or None
        None: taken from the clock.
    bind : str
        Address to listen on.
    episodes : int or None
        Stop after so many Keepaway episodes.
    patience : float
        Seconds that synch mode waits for a client's ``(done)``.
    quiet : bool
        Print nothing on standard output.
    ignored : list of str
        Parameters of name spaces that have no effect here, as ``space::name``.
    """

    params: ServerParams = field(default_factory=ServerParams)
    player_params: PlayerParams = field(default_factory=PlayerParams)
    seed: int | None = None
    bind: str = "127.0.0.1"
    episodes: int | None = None
    patience: float = PATIENCE
    quiet: bool = False
    ignored: list[str] = field(default_factory=list)


def parse_options(arguments: Iterable[str]) -> ServerOptions:
    """Read a command line.

    Parameters
    ----------
    arguments : iterable of str
        Without the program's name.

    Raises
    ------
    UsageError
        For an unknown option or a value that does not fit.
    HelpRequested
        When the help text is wanted.
    """
    own, line = _split(arguments)
    profile = own.get("--profile", PROFILES[0])
    if profile not in PROFILES:
        raise UsageError(f"--profile takes {' or '.join(PROFILES)}, not {profile!r}")
    options = ServerOptions(
        params=ServerParams(profile),
        player_params=PlayerParams(profile),
        seed=_natural(own, "--seed", 0),
        bind=own.get("--bind", "127.0.0.1"),
        episodes=_natural(own, "--episodes", 1),
        patience=_seconds(own, "--patience", PATIENCE),
        quiet="--quiet" in own,
    )
    try:
        for assignment in read_arguments(line):
            _assign(options, assignment)
    except HelpWanted:
        raise HelpRequested from None
    except IncludeError as error:
        raise UsageError(str(error)) from None
    except LineError as error:
        raise UsageError(_complaint(error)) from None
    _check_log_version(options.params)
    _check_team_names(options.params)
    return options


def without_effect(options: ServerOptions) -> list[str]:
    """Return the parameters that were changed and change nothing, as ``space::name``."""
    profile = options.params.profile
    changed = [
        f"{space}::{name}"
        for space, chosen, default in (
            ("server", options.params, ServerParams(profile)),
            ("player", options.player_params, PlayerParams(profile)),
        )
        for name in chosen
        if name in NO_EFFECT[space] and chosen[name] not in (default[name], NOT_DONE_HERE.get(name))
    ]
    return sorted({*changed, *options.ignored})


def _split(arguments: Iterable[str]) -> tuple[dict[str, str], list[str]]:
    """Separate own options from the line of parameters."""
    own: dict[str, str] = {}
    line = []
    rest = iter(arguments)
    for argument in rest:
        name, _, value = argument.partition("=")
        if argument.lower() in ("-h", "--h", "h"):
            raise HelpRequested
        if name in _FLAGS:
            own[name] = ""
        elif name in _TAKES_VALUE:
            own[name] = value if "=" in argument else _next(rest, name)
        else:
            line.append(argument)
    return own, line


def _next(rest: Iterator[str], name: str) -> str:
    value = next(rest, None)
    if value is None:
        raise UsageError(f"{name} needs a value")
    return value


def _natural(own: dict[str, str], name: str, least: int) -> int | None:
    text = own.get(name)
    if text is None:
        return None
    if not (text.isascii() and text.isdigit()) or int(text) < least:
        raise UsageError(f"{name} takes an integer of at least {least}, not {text!r}")
    return int(text)


def _seconds(own: dict[str, str], name: str, otherwise: float) -> float:
    text = own.get(name)
    if text is None:
        return otherwise
    if not _NUMBER.fullmatch(text) or not 0.0 < float(text) <= 3600.0:
        raise UsageError(f"{name} takes seconds, more than 0 and at most 3600, not {text!r}")
    return float(text)


def _check_log_version(params: ServerParams) -> None:
    """Refuse versions of the game log that the server does not have."""
    version = params["game_log_version"]
    if version == 0 or (version == -1 and params.profile == "11.1"):
        json_too = "" if params.profile == "11.1" else ", or -1 for JSON"
        raise UsageError(f"server::game_log_version takes a version, 1 to 6{json_too}, not {version}")


def _check_team_names(params: ServerParams) -> None:
    """Refuse fixed team names of which the original makes others (it cuts them, or takes none)."""
    names = {name: str(params[name]) for name in ("fixed_teamname_l", "fixed_teamname_r")}
    for name, value in names.items():
        if value and not _TEAM_NAME.fullmatch(value):
            raise UsageError(f"server::{name} takes up to 15 of letters, digits, +, - and _, not {value!r}")
    left, right = names.values()
    if left and left == right:
        raise UsageError(f"server::fixed_teamname_l and server::fixed_teamname_r are both {left!r}; they must differ")


def _complaint(error: LineError) -> str:
    """Say in one line what is wrong with a line of parameters."""
    if error.missing == "value":
        space, _, name = error.path.rpartition("::")
        table = _TABLES.get(space, {})
        example = f": {error.path}={_example(table[name])}" if name in table else ""
        if error.found:
            return f"cannot read {error.found!r}: {error.path} needs '=' and a value{example}"
        return f"{error.path} needs a value{example}"
    name = error.found.partition("=")[0]
    spaces = [f"{space}::{name}" for space, table in _TABLES.items() if name in table]
    own = (*_TAKES_VALUE, *_FLAGS, "--help", "replay")
    hint = f"; did you mean {' or '.join(spaces)}?" if spaces else _suggestion(name, own)
    return f"unknown option {error.found!r}{hint}; see {PROGRAM} --help"


def _assign(options: ServerOptions, assignment: Assignment) -> None:
    """Carry out ``space::name = value``."""
    try:
        if assignment.space in SAVERS:
            _ignore(options, assignment)
        elif assignment.space not in _TABLES:
            spaces = (*_TABLES, *SAVERS)
            path = f"{assignment.space}::{assignment.name}={assignment.value}"
            hint = _suggestion(assignment.space, spaces) or f"; there are {', '.join(spaces)}"
            raise UsageError(f"unknown name space in {path!r}{hint}")
        elif assignment.name != _VERSION:
            params = options.params if assignment.space == "server" else options.player_params
            params.set(assignment.name, _checked(assignment, _TABLES[assignment.space]))
    except UsageError as error:
        raise UsageError(f"{assignment.source}{error}") from None


def _ignore(options: ServerOptions, assignment: Assignment) -> None:
    """Note a parameter of a name space without effect, unless that is what it asks for."""
    defaults = SAVERS[assignment.space]
    name, path = assignment.name, f"{assignment.space}::{assignment.name}"
    if name == _VERSION:
        return
    if defaults and name not in defaults:
        raise UsageError(f"unknown parameter {path}{_suggestion(name, defaults, assignment.space)}")
    if unquoted(assignment.value).lower() not in defaults.get(name, ()):
        options.ignored.append(path)


def _checked(assignment: Assignment, table: Mapping[str, Parameter]) -> Value:
    """Return the value of an assignment, which its parameter may have."""
    space, name, text = assignment.space, assignment.name, assignment.value
    if name not in table:
        hint = "; the seed of the simulation is --seed N" if name == "random_seed" else _suggestion(name, table, space)
        raise UsageError(f"unknown parameter {space}::{name}{hint}")
    try:
        value = parse_value(table[name], text)
    except TypeError as error:
        raise UsageError(f"{space}::{error}") from None
    if name in _LIMITS and not isinstance(value, str):
        low, high, meaning = _LIMITS[name]
        if not low <= value <= high:
            bound = f"at least {low}" if value < low else f"at most {high}"
            raise UsageError(f"{space}::{name} takes {meaning}, {low} to {high}: {bound}, not {text}")
    return _clamped(name, value)


def _clamped(name: str, value: Value) -> Value:
    """Return a value as the original takes it."""
    if isinstance(value, str):
        return value
    if name in _BETWEEN_0_AND_1:
        return min(max(float(value), 0.0), 1.0)
    return max(value, _LEAST.get(name, value))


def parse_value(parameter: Parameter, text: str) -> Value:
    """Read the value of a parameter.

    Raises
    ------
    TypeError
        When the text does not fit the parameter's kind.
    """
    if parameter.kind is str:
        return unquoted(text)
    if parameter.kind is bool:
        number = _number(text)
        whole = str(int(number)) if isinstance(number, float) and number.is_integer() else text  # 1.0 is 1
        value: Value = _BOOLEANS.get(whole.lower(), text)
    else:
        value = _number(text)
    if parameter.kind is not float and isinstance(value, int) and not -(2**31) <= value < 2**31:
        value = text
    try:
        return checked(parameter, value)
    except TypeError:
        raise TypeError(f"{parameter.name} takes {KIND_NAMES[parameter.kind]}, not {text!r}") from None


def _number(text: str) -> float | int | str:
    if not _NUMBER.fullmatch(text):
        return text
    value = float(text) if not text.lstrip("+-").isdigit() else int(text)
    return value if math.isfinite(value) else text


def _example(parameter: Parameter) -> Value:
    return 1 if parameter.kind is bool else parameter.default


def _suggestion(name: str, known: Iterable[str], space: str = "") -> str:
    lower = {word.lower(): word for word in known}
    words = [lower[word] for word in difflib.get_close_matches(name.lower(), list(lower), n=2)]
    close = [f"{space}::{word}" if space else word for word in words]
    return f"; did you mean {' or '.join(close)}?" if close else ""
