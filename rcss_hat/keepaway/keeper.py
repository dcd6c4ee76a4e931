"""A keeper's cycle: search the ball, hold or pass it, run for it, or get open."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.getting_open import get_open
from rcss_hat.keepaway.holding import KEEPER_HOLD, hold_ball, pass_ball
from rcss_hat.keepaway.state import state_variables
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.fastest import current_fastest_teammate
from rcss_hat.player.interception import intercept
from rcss_hat.player.motion import ball_after
from rcss_hat.player.moving import search_ball, turn_neck_to
from rcss_hat.player.objects import ball_distance, ball_is_known
from rcss_hat.player.records import NEVER

Record = NDArray[np.void]

NO_DECISION, UNKNOWN, FOLLOW_THROUGH, FIRST, STEP, HOLDING = range(6)
"""What `decide` may find; see there."""
NO_ACTION = -1


class DecisionPoint(NamedTuple):
    """What a keeper's policy has to be asked and told in a cycle.

    Attributes
    ----------
    status : int
    reward : float
        With STEP, cycles since this keeper's last decision.
    ended : bool
        The previous episode ended since the last cycle; the learner takes that before anything else.
    acted : bool
        This keeper decided in that episode.
    final_reward : float
        Reward of its last decision there, cycles.
    """

    status: int
    reward: float
    ended: bool
    acted: bool
    final_reward: float


class Plan(NamedTuple):
    """The commands of a cycle, not yet truncated."""

    kind: int  # of the body command
    a: float
    b: float
    turns_neck: bool
    neck: float


@kernel
def decide(agent: Record, state_out: NDArray[np.float64]) -> DecisionPoint:
    """Find out whether a keeper's policy has to be asked, and whether it has to be told of an episode's end.

    Parameters
    ----------
    agent : record
    state_out : ndarray of float64, shape (n_state_variables,)
        Gets the state when it is defined.

    Returns
    -------
    DecisionPoint
        Its status is NO_DECISION (not at the ball), UNKNOWN (at the ball but the state is undefined: Hold, without the
        policy), FOLLOW_THROUGH (a pass needs another kick; without the policy), HOLDING (a Hold lasts; likewise), FIRST
        (first decision of the episode) or STEP (with the reward of the previous decision).
    """
    now = agent["now"][0]
    ended, acted, final_reward = False, False, 0.0
    if agent["new_episode"][0]:
        ended = True
        acted = agent["last_action_time"][0] != NEVER
        if acted:
            final_reward = float(now - agent["last_action_time"][0])
        agent["new_episode"][0] = 0
        agent["last_action"][0] = NO_ACTION
        agent["last_action_time"][0] = NEVER
    status, reward = NO_DECISION, 0.0
    if ball_is_known(agent) and ball_distance(agent) < agent["kick_dist"][0]:
        status = _with_ball(agent, state_out, now)
        if status == STEP:
            reward = float(now - agent["last_action_time"][0])
    return DecisionPoint(status, reward, ended, acted, final_reward)


@kernel
def _with_ball(agent: Record, state: NDArray[np.float64], now: int) -> int:
    if not state_variables(agent, state):
        return UNKNOWN
    last = agent["last_action_time"][0]
    if last == NEVER:
        return FIRST
    # A pass may take several kicks. Repeating it counts as acting (`_play_ball`): each repeat costs its reward a cycle.
    if last == now - 1 and agent["last_action"][0] > 0:
        return FOLLOW_THROUGH
    if agent["last_action"][0] == 0 and now - last < agent["hold_cycles"][0]:
        return HOLDING
    return STEP


@kernel
def keeper_acts(agent: Record, params: Record, status: int, choice: int) -> Plan:
    """Plan a keeper's commands: what `decide` found, and what the policy answered if it was asked."""
    if status != NO_DECISION:
        return _play_ball(agent, params, status, choice)
    if not ball_is_known(agent):
        return search(agent, params)
    # Nobody receives a pass as such: whoever is first of the keepers runs for the ball, whatever the takers do.
    fastest = current_fastest_teammate(agent, params)
    if fastest == agent["me"][0]:
        kind, a = intercept(agent, params)
        x, y = ball_after(agent, params, 1)
    else:
        kind, a = get_open(agent, params, fastest)
        x, y = 0.0, 0.0  # to face: the centre of the region
    return Plan(kind, a, 0.0, True, turn_neck_to(agent, params, x, y, kind, a))


@kernel
def _play_ball(agent: Record, params: Record, status: int, choice: int) -> Plan:
    """Hold or pass; in a state that is not defined, and while a Hold lasts, hold without having decided."""
    action = 0
    if status != UNKNOWN and status != HOLDING:
        action = agent["last_action"][0] if status == FOLLOW_THROUGH else choice
        agent["last_action"][0] = action
        agent["last_action_time"][0] = agent["now"][0]
    if action == 0:
        kind, a, b = hold_ball(agent, params, KEEPER_HOLD)
    else:
        kind, a, b = pass_ball(agent, params, action)
    return Plan(kind, a, b, False, 0.0)


@kernel
def search(agent: Record, params: Record) -> Plan:
    """Search the ball with the neck in line with the body."""
    kind, a = search_ball(agent, params)
    return Plan(kind, a, 0.0, True, -agent["head"][0])
