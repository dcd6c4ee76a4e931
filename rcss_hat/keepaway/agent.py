"""A Keepaway player as three kernels: `perceive`, `decide`, `act`, called in this order once per cycle.

The same kernels run behind UDP and in the arena. They draw no random numbers and keep everything in one record.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.getting_open import open_grid
from rcss_hat.keepaway.keeper import (
    FIRST,
    FOLLOW_THROUGH,
    HOLDING,
    NO_ACTION,
    NO_DECISION,
    STEP,
    UNKNOWN,
    DecisionPoint,
    Plan,
    decide,
    keeper_acts,
)
from rcss_hat.keepaway.taker import taker_acts
from rcss_hat.numeric import rng
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.bodily import feel
from rcss_hat.player.fastest import current_fastest_opponent, fastest_is_current
from rcss_hat.player.hearing import listen, speak
from rcss_hat.player.localisation import landmarks_wanted
from rcss_hat.player.motion import ball_after
from rcss_hat.player.records import AGENT, N_AHEAD, N_SLOTS, NEVER, NOT_COMPUTED, OPPONENTS
from rcss_hat.player.sight import shows_everyone, watch
from rcss_hat.protocol.records import LEFT, MAX_PLAYERS, NO_COMMAND, RIGHT

Record = NDArray[np.void]

__all__ = [
    "FIRST",
    "FOLLOW_THROUGH",
    "HOLDING",
    "NO_DECISION",
    "STEP",
    "UNKNOWN",
    "DecisionPoint",
    "act",
    "decide",
    "landmarks_wanted",
    "new_agent",
    "perceive",
]

_TIMES = ("now", "see_time", "hear_time", "collision_time", "sent_time", "ball_seen", "ball_change", "ball_see_time",
          "player_seen", "player_time", "player_change", "player_angles", "player_see_time", "fast_see", "fast_hear",
          "aim_time", "search_time", "say_time", "last_action_time")  # fmt: skip


def new_agent(
    side: int, unum: int, n_keepers: int, n_takers: int, params: Record, seed: int, hold_cycles: int = 1
) -> Record:
    """Make the record of a player who knows nothing yet.

    Parameters
    ----------
    side : int
        ``records.LEFT``: keeper, ``records.RIGHT``: taker.
    unum : int
        Uniform number, 1 .. 11.
    n_keepers, n_takers : int
    params : record
        Server parameters (dtype PARAMS).
    seed : int
        Of the match; the player's own stream follows from it, side and number.
    hold_cycles : int
        Cycles from a keeper's Hold to his next decision; 1: he decides in every cycle.

    Returns
    -------
    record
        dtype AGENT, shape (1,).

    Raises
    ------
    ValueError
        For a side, number or team size that cannot be.
    """
    if side not in (LEFT, RIGHT):
        raise ValueError(f"side must be {LEFT} (keeper) or {RIGHT} (taker), not {side}")
    if not 1 <= unum <= MAX_PLAYERS:
        raise ValueError(f"uniform number must be 1 .. {MAX_PLAYERS}, not {unum}")
    if hold_cycles < 1:
        raise ValueError(f"hold_cycles must be 1 or more, not {hold_cycles}")
    if not (1 <= n_keepers <= MAX_PLAYERS and 1 <= n_takers <= MAX_PLAYERS):
        raise ValueError(f"1 .. {MAX_PLAYERS} keepers and takers can play, not {n_keepers} and {n_takers}")
    agent = np.zeros(1, dtype=AGENT)
    for name in _TIMES:
        agent[name] = NEVER
    agent["side"], agent["unum"], agent["me"] = side, unum, unum - 1
    agent["n_keepers"], agent["n_takers"] = n_keepers, n_takers
    agent["n_own"], agent["n_other"] = (n_keepers, n_takers) if side == LEFT else (n_takers, n_keepers)
    agent["axis"] = 1.0 if side == LEFT else -1.0
    agent["wanted"] = landmarks_wanted(params)
    agent["rng"] = rng.stream(seed, rng.PLAYER, side, unum)
    _tabulate(agent, params)
    agent["effort"] = agent["neck_cos"] = agent["body_cos"] = agent["search_sign"] = 1.0
    agent["player_known"] = 1
    agent["fast_own"] = agent["fast_other"] = NOT_COMPUTED
    agent["last_action"] = NO_ACTION
    agent["hold_cycles"] = hold_cycles
    agent["taken_guess"] = 1
    _forget(agent)
    return agent


def _tabulate(agent: Record, params: Record) -> None:
    cycles = np.arange(N_AHEAD)
    player, ball = float(params["player_decay"][0]), float(params["ball_decay"][0])
    agent["kick_dist"] = params["player_size"] + params["ball_size"] + params["kickable_margin"]
    agent["roll"] = (1.0 - player**cycles) / (1.0 - player)
    agent["first_share"][0, 1:] = (1.0 - player) / (1.0 - player ** cycles[1:])
    agent["ball_roll"] = (1.0 - ball**cycles) / (1.0 - ball)
    push = float(params["maxpower"][0] * params["dash_power_rate"][0])
    agent["sprint"] = push * np.cumsum((1.0 - player**cycles) / (1.0 - player))
    agent["grid"] = open_grid(float(params["keepaway_length"][0]), float(params["keepaway_width"][0]))


@kernel
def _forget(agent: Record) -> None:
    """Forget where everybody is: they have been moved."""
    agent["ball_seen"][0] = NEVER
    agent["guessed"][0] = 0
    for o in range(N_SLOTS):
        if o != agent["me"][0]:
            agent["player_seen"][0, o] = NEVER
    agent["top_own"][0] = max(agent["n_own"][0], agent["me"][0] + 1)
    agent["top_other"][0] = OPPONENTS + agent["n_other"][0]


@kernel
def perceive(
    agent: Record, params: Record, sense: Record, see: Record, has_see: bool, heard: Record, episode_started: bool
) -> None:
    """Take in what the server told since the last cycle's commands.

    Parameters
    ----------
    agent, params : record
    sense : record
        The sense_body message of this cycle.
    see : record
        The newest see message; one that carries the number of an earlier cycle came after that cycle's commands.
    has_see : bool
        False when no see came since the last call.
    heard : record
        The last message of a team mate in this cycle; ``time`` is -1 for none.
    episode_started : bool
        The referee said that a new episode begins, since the last call.
    """
    if episode_started:
        _forget(agent)
        if agent["episodes"][0] > 0:
            agent["new_episode"][0] = 1
        agent["episodes"][0] += 1
    time = sense["time"][0]
    late = has_see and see["time"][0] < time
    others = late or not has_see or not shows_everyone(agent, see)
    if others and fastest_is_current(agent):
        current_fastest_opponent(agent, params)
    if late:
        agent["now"][0] = time
        watch(agent, params, see)
    feel(agent, params, sense, others)
    if has_see and not late:
        watch(agent, params, see)
    if heard["time"][0] >= 0:
        listen(agent, params, heard)
    _guess_ending(agent, params)


@kernel
def _guess_ending(agent: Record, params: Record) -> None:
    """Guess how an episode that ends with the next step would end."""
    x, y = ball_after(agent, params, 1)
    inside = abs(x) < 0.5 * params["keepaway_length"][0] and abs(y) < 0.5 * params["keepaway_width"][0]
    agent["taken_guess"][0] = inside


@kernel
def act(agent: Record, params: Record, status: int, choice: int, action_out: Record) -> None:
    """Choose and remember the commands of this cycle.

    Parameters
    ----------
    agent, params : record
    status : int
        A keeper's, from `decide`; ignored for takers.
    choice : int
        A keeper's action with the status FIRST or STEP: 0 hold, i pass to the i-th nearest; else ignored. A taker's
        macro-action, see `rcss_hat.keepaway.taker`; 0 is the hand-coded taker.
    action_out : record
        Gets the commands (dtype ACTION), all numbers whole.
    """
    if agent["side"][0] == LEFT:
        plan = keeper_acts(agent, params, status, choice)
    else:
        plan = taker_acts(agent, params, choice)
    speak(agent, params, plan.kind, plan.a, plan.b, action_out)
    if agent["withheld"][0]:  # the last command may be on its way still: two in a cycle would confuse the counters
        plan = Plan(NO_COMMAND, 0.0, 0.0, False, 0.0)
        action_out["say_n"][0] = 0
    neck = np.trunc(plan.neck) if plan.turns_neck else 0.0
    action_out["kind"][0] = plan.kind  # cut to whole numbers, which is part of the noise that the players play with
    action_out["a"][0] = np.trunc(plan.a)
    action_out["b"][0] = np.trunc(plan.b)
    action_out["turns_neck"][0] = plan.turns_neck
    action_out["neck"][0] = neck
    agent["sent_time"][0] = agent["now"][0]
    agent["sent_kind"][0] = plan.kind
    agent["sent_a"][0] = np.trunc(plan.a)
    agent["sent_b"][0] = np.trunc(plan.b)
    agent["sent_neck"][0] = neck
