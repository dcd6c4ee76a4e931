"""A keeper's cycle: search the ball, hold or pass it, run for it, or get open."""

from __future__ import annotations

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
"""What `decide` may find; see `rcss_hat.keepaway.agent.decide`."""
NO_ACTION = -1


@kernel
def keeper_decides(agent: Record, state: NDArray[np.float64]) -> int:
    """Find out whether the policy has to be asked, and end the episode before if there is one to end."""
    now = agent["now"][0]
    agent["ended"][0] = 0
    agent["reward"][0] = 0.0
    if agent["new_episode"][0]:
        agent["ended"][0] = 1
        acted = agent["last_action_time"][0] != NEVER
        agent["ended_acted"][0] = acted
        agent["final_reward"][0] = now - agent["last_action_time"][0] if acted else 0.0
        agent["new_episode"][0] = 0
        agent["last_action"][0] = NO_ACTION
        agent["last_action_time"][0] = NEVER
    status = NO_DECISION
    if ball_is_known(agent) and ball_distance(agent) < agent["kick_dist"][0]:
        status = _with_ball(agent, state, now)
    agent["status"][0] = status
    return status


@kernel
def _with_ball(agent: Record, state: NDArray[np.float64], now: int) -> int:
    if not state_variables(agent, state):
        return UNKNOWN
    last = agent["last_action_time"][0]
    if last == NEVER:
        return FIRST
    if last == now - 1 and agent["last_action"][0] > 0:
        return FOLLOW_THROUGH
    if agent["last_action"][0] == 0 and now - last < agent["hold_cycles"][0]:
        return HOLDING
    agent["reward"][0] = now - last
    return STEP


@kernel
def keeper_acts(agent: Record, params: Record, choice: int) -> None:
    """Plan a keeper's commands."""
    status = agent["status"][0]
    agent["plan_turns_neck"][0] = 0
    if status != NO_DECISION:
        action = 0
        if status != UNKNOWN and status != HOLDING:
            action = agent["last_action"][0] if status == FOLLOW_THROUGH else choice
            agent["last_action"][0] = action
            agent["last_action_time"][0] = agent["now"][0]
        if action == 0:
            kind, a, b = hold_ball(agent, params, KEEPER_HOLD)
        else:
            kind, a, b = pass_ball(agent, params, action)
        plan(agent, kind, a, b)
        return
    agent["plan_turns_neck"][0] = 1
    if not ball_is_known(agent):
        plan_search(agent, params)
        return
    fastest = current_fastest_teammate(agent, params)
    if fastest == agent["me"][0]:
        kind, a = intercept(agent, params)
        x, y = ball_after(agent, params, 1)
    else:
        kind, a = get_open(agent, params, fastest)
        x, y = 0.0, 0.0
    plan(agent, kind, a, 0.0)
    agent["plan_neck"][0] = turn_neck_to(agent, params, x, y, kind, a)


@kernel
def plan(agent: Record, kind: int, a: float, b: float) -> None:
    """Note the body command of this cycle, not yet truncated."""
    agent["plan_kind"][0] = kind
    agent["plan_a"][0] = a
    agent["plan_b"][0] = b


@kernel
def plan_search(agent: Record, params: Record) -> None:
    """Search the ball with the neck in line with the body."""
    kind, a = search_ball(agent, params)
    plan(agent, kind, a, 0.0)
    agent["plan_turns_neck"][0] = 1
    agent["plan_neck"][0] = -agent["head"][0]
