"""The command line: ``server::name=value`` and ``player::name=value`` as rcssserver reads them, and own options.

Values: booleans are 0, 1, true, false, on, off, yes or no, in any case; texts may stand in quotes. ``--`` in front of a
parameter is allowed. Configuration files are not read.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from fake_server.player_param import BY_NAME as PLAYER_BY_NAME
from fake_server.player_param import PlayerParams
from rcss_hat.protocol.params import BY_NAME as SERVER_BY_NAME
from rcss_hat.protocol.params import KIND_NAMES, PROFILES, Parameter, ServerParams, Value, checked
from rcss_hat.protocol.records import SAY_SIZE

PROGRAM = "fake-rcssserver"
PATIENCE = 1.25
"""Seconds that rcssserver waits for a client in synch mode."""
USAGE = f"""\
Usage: {PROGRAM} [OPTIONS] [server::NAME=VALUE] [player::NAME=VALUE] ...
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
_TAKES_VALUE = ("--seed", "--profile", "--bind", "--episodes", "--patience")
_FLAGS = ("--quiet", "--help")


_LIMITS: dict[str, tuple[int, int, str]] = {
    "port": (0, 65535, "a port"),
    "coach_port": (0, 65535, "a port"),
    "olcoach_port": (0, 65535, "a port"),
    "say_msg_size": (0, SAY_SIZE, "a number of characters"),
    "game_log_version": (1, 6, "a version"),
    "game_log_compression": (0, 9, "a level"),
    "text_log_compression": (0, 9, "a level"),
    "simulator_step": (10, 10000, "milliseconds"),
    "send_step": (10, 10000, "milliseconds"),
    "sense_body_step": (10, 10000, "milliseconds"),
    "player_types": (1, 255, "a number"),
}
"""Parameters whose values are bounded here: lowest, highest, what they are."""

_WITHOUT_EFFECT = frozenset({
    "back_passes", "ball_weight", "clang_advice_win", "clang_define_win", "clang_del_win",
    "clang_info_win", "clang_mess_delay", "clang_mess_per_cycle", "clang_meta_win", "clang_rule_win",
    "clang_win_size", "coach_msg_file", "control_radius", "foul_cycles", "foul_detect_probability",
    "free_kick_faults", "freeform_send_period", "freeform_wait_period", "illegal_defense_dist_x",
    "illegal_defense_duration", "illegal_defense_number", "illegal_defense_width", "kick_rand_factor_l",
    "kick_rand_factor_r", "landmark_file", "log_times", "max_goal_kicks", "offside_active_area_size",
    "offside_kick_margin", "old_coach_hear", "pen_allow_mult_kicks", "pen_before_setup_wait",
    "pen_coach_moves_players", "pen_dist_x", "pen_max_extra_kicks", "pen_max_goalie_dist_x", "pen_nr_kicks",
    "pen_random_winner", "pen_ready_wait", "pen_setup_wait", "pen_taken_wait", "penalty_shoot_outs",
    "player_weight", "prand_factor_l", "prand_factor_r", "profile", "proper_goal_kicks", "recv_step",
    "red_card_probability", "say_coach_cnt_max", "send_vi_step", "sense_body_step", "stopped_ball_vel",
    "synch_micro_sleep", "team_actuator_noise", "team_l_start", "team_r_start", "verbose", "wind_ang",
    "wind_dir", "wind_force", "wind_none", "wind_rand", "wind_random",
    "subs_max",
})  # fmt: skip
"""Parameters that are accepted and told to clients, but change nothing."""


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
    """

    params: ServerParams = field(default_factory=ServerParams)
    player_params: PlayerParams = field(default_factory=PlayerParams)
    seed: int | None = None
    bind: str = "127.0.0.1"
    episodes: int | None = None
    patience: float = PATIENCE
    quiet: bool = False


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
    own, assignments = _split(arguments)
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
    for assignment in assignments:
        _assign(options, assignment)
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
        if name in _WITHOUT_EFFECT and chosen[name] != default[name]
    ]
    return sorted(changed)


def _split(arguments: Iterable[str]) -> tuple[dict[str, str], list[str]]:
    """Separate own options from parameters."""
    own: dict[str, str] = {}
    assignments = []
    rest = iter(arguments)
    for argument in rest:
        name, _, value = argument.partition("=")
        if argument.lstrip("-").lower() in ("help", "h"):
            raise HelpRequested
        if "::" in name:
            assignments.append(argument)
        elif name in _FLAGS:
            own[name] = ""
        elif name in _TAKES_VALUE:
            own[name] = value if "=" in argument else _next(rest, name)
        else:
            known = (*_TAKES_VALUE, *_FLAGS, "replay")
            raise UsageError(f"unknown option {argument!r}{_suggestion(name, known)}; see {PROGRAM} --help")
    return own, assignments


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


def _assign(options: ServerOptions, assignment: str) -> None:
    """Carry out ``space::name=value``."""
    path, equals, text = assignment.lstrip("-").partition("=")
    space, _, name = path.partition("::")
    if space == "server":
        table, target = SERVER_BY_NAME, options.params.set
    elif space == "player":
        table, target = PLAYER_BY_NAME, options.player_params.set
    else:
        raise UsageError(f"unknown name space in {assignment!r}; parameters begin with server:: or player::")
    if name not in table:
        hint = "; the seed of the simulation is --seed N" if name == "random_seed" else _suggestion(name, table, space)
        raise UsageError(f"unknown parameter {space}::{name}{hint}")
    if not equals:
        raise UsageError(f"{space}::{name} needs a value: {space}::{name}={_example(table[name])}")
    try:
        value = parse_value(table[name], text)
    except TypeError as error:
        raise UsageError(f"{space}::{error}") from None
    if name in _LIMITS and not isinstance(value, str):
        low, high, meaning = _LIMITS[name]
        if not low <= value <= high:
            bound = f"at least {low}" if value < low else f"at most {high}"
            raise UsageError(f"{space}::{name} takes {meaning}, {low} to {high}: {bound}, not {text}")
    target(name, value)


def parse_value(parameter: Parameter, text: str) -> Value:
    """Read the value of a parameter.

    Raises
    ------
    TypeError
        When the text does not fit the parameter's kind.
    """
    if parameter.kind is str:
        quoted = len(text) >= 2 and text[0] == text[-1] and text[0] in "'\""
        return text[1:-1] if quoted else text
    if parameter.kind is bool:
        value: Value = _BOOLEANS.get(text.lower(), text)
    else:
        value = _number(text)
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
    close = [f"{space}::{word}" if space else word for word in difflib.get_close_matches(name, list(known), n=2)]
    return f"; did you mean {' or '.join(close)}?" if close else ""
