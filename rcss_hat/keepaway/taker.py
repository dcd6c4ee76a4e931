"""A taker's cycle: the hand-coded takers of the UT Austin players, and macro-actions for takers that learn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.holding import TAKER_HOLD, hold_ball
from rcss_hat.keepaway.keeper import Plan, search
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
from rcss_hat.player.records import NOBODY, OPPONENTS
from rcss_hat.protocol.records import TURN

Record = NDArray[np.void]

HAND_CODED, GO_TO_BALL = range(2)
"""Macro-actions of a taker. The hand-coded one is the default; those from 2 on block the keepers K2, K3, ...: the
taker stands between that keeper and the ball."""


def n_macro_actions(n_keepers: int) -> int:
    """Number of a taker's macro-actions: 4 against three keepers."""
    return n_keepers + 1


@kernel
def taker_acts(agent: Record, params: Record, order: int) -> Plan:
    """Plan a taker's commands.

    Parameters
    ----------
    agent, params : record
    order : int
        HAND_CODED, GO_TO_BALL or whom to block. A taker that has the ball keeps it, one that has lost it searches it,
        and one that does not know where everybody is goes by its own mind, whatever the order.
    """
    if not ball_is_known(agent):
        return search(agent, params)
    me = agent["me"][0]
    bx, by = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    teammate, own_distance = closest_teammate(agent, bx, by)
    if ball_distance(agent) < agent["kick_dist"][0] and teammate == me:
        # Never passed or kicked away: the referee has to see it with the takers for some cycles.
        kind, a, b = hold_ball(agent, params, TAKER_HOLD)
        return Plan(kind, a, b, False, 0.0)
    next_x, next_y = ball_after(agent, params, 1)
    blocked = NOBODY if order <= GO_TO_BALL else _keeper(agent, order)
    if blocked != NOBODY:
        kind, a = mark(agent, params, blocked)
    elif order != GO_TO_BALL and agent["n_takers"][0] > 2 and not _chases(agent, bx, by):
        kind, a = mark(agent, params, most_open_opponent(agent, current_fastest_opponent(agent, params)))
    else:
        _, other_distance = closest_opponent(agent, bx, by)
        # At equal distance the opponent counts: it comes first in the players' list.
        has_it = teammate >= 0 and own_distance < min(agent["kick_dist"][0], other_distance)
        if order != GO_TO_BALL and teammate != me and has_it:
            return Plan(TURN, turn_body_moment(agent, params, next_x, next_y, 1), 0.0, True, -agent["head"][0])
        kind, a = intercept(agent, params)
    return Plan(kind, a, 0.0, True, turn_neck_to(agent, params, next_x, next_y, kind, a))


@kernel
def _chases(agent: Record, bx: float, by: float) -> bool:
    """Tell whether this taker is first or second at the ball.

    When ball or a taker are unknown the order stays by number.
    """
    m = agent["n_takers"][0]
    order, distance = agent["order"][0], agent["distance"][0]
    sort_by_distance(agent, 0, m, bx, by, order[:m], distance[:m])
    return order[0] == agent["me"][0] or order[1] == agent["me"][0]


@kernel
def _keeper(agent: Record, order: int) -> int:
    """Slot of the keeper that an order says to block; NOBODY when there is none, or some keeper is unknown."""
    n = agent["n_keepers"][0]
    holder, _ = closest_opponent(agent, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1])
    if order > n or holder == NOBODY:
        return NOBODY
    x, y = agent["player_pos"][0, holder, 0], agent["player_pos"][0, holder, 1]
    slots, distance = agent["order"][0], agent["distance"][0]
    if not sort_by_distance(agent, OPPONENTS, n, x, y, slots[:n], distance[:n]):
        return NOBODY
    return slots[order - 1]
