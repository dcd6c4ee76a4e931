"""A taker's cycle: the hand-coded takers of the UT Austin players."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.holding import TAKER_HOLD, hold_ball
from rcss_hat.keepaway.keeper import plan, plan_search
from rcss_hat.keepaway.marking import mark, most_open_opponent
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.fastest import current_fastest_opponent
from rcss_hat.player.interception import intercept
from rcss_hat.player.motion import ball_after, turn_body_moment
from rcss_hat.player.moving import turn_neck_to
from rcss_hat.player.objects import (
    ball_distance,
    ball_is_known,
    closest_opponent,
    closest_teammate,
    sort_by_distance,
)
from rcss_hat.protocol.records import TURN

Record = NDArray[np.void]


@kernel
def taker_acts(agent: Record, params: Record) -> None:
    """Plan a taker's commands."""
    agent["plan_turns_neck"][0] = 1
    if not ball_is_known(agent):
        plan_search(agent, params)
        return
    me = agent["me"][0]
    bx, by = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    teammate, own_distance = closest_teammate(agent, bx, by)
    if ball_distance(agent) < agent["kick_dist"][0] and teammate == me:
        agent["plan_turns_neck"][0] = 0
        kind, a, b = hold_ball(agent, params, TAKER_HOLD)
        plan(agent, kind, a, b)
        return
    next_x, next_y = ball_after(agent, params, 1)
    if agent["n_takers"][0] > 2 and not _chases(agent, bx, by):
        kind, a = mark(agent, params, most_open_opponent(agent, current_fastest_opponent(agent, params)))
    else:
        _, other_distance = closest_opponent(agent, bx, by)
        # At equal distance the opponent counts: it comes first in the players' list.
        if teammate != me and teammate >= 0 and own_distance < min(agent["kick_dist"][0], other_distance):
            plan(agent, TURN, turn_body_moment(agent, params, next_x, next_y, 1), 0.0)
            agent["plan_neck"][0] = -agent["head"][0]
            return
        kind, a = intercept(agent, params)
    plan(agent, kind, a, 0.0)
    agent["plan_neck"][0] = turn_neck_to(agent, params, next_x, next_y, kind, a)


@kernel
def _chases(agent: Record, bx: float, by: float) -> bool:
    """Tell whether this taker is first or second at the ball.

    When ball or a taker are unknown the order stays by number.
    """
    m = agent["n_takers"][0]
    order, distance = agent["order"][0], agent["distance"][0]
    sort_by_distance(agent, 0, m, bx, by, order[:m], distance[:m])
    return order[0] == agent["me"][0] or order[1] == agent["me"][0]
