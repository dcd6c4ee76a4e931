"""How long a player takes to a point, and who is first at the ball (WorldModelPredict.cc of the UT Austin players)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.player.motion import (
    TURN_AROUND_DISTANCE,
    after_dash,
    after_turn,
    ball_after,
    dash_acceleration,
    needs_turn,
    planned_rotation,
    strongest_dash,
    to_body,
)
from rcss_hat.player.objects import is_known
from rcss_hat.player.records import N_AHEAD, NOBODY, NOT_COMPUTED, OPPONENTS

Record = NDArray[np.void]

HORIZON = 30
"""Cycles looked ahead for an interception."""
NOT_IN_TIME = 100
"""Cycles of a player who cannot make it."""
FRESH = 3
"""Cycles after which a seen velocity and body angle count as forgotten."""
_ASSUMED_SPEED = 0.3
"""Speed of players whose motion is forgotten, towards wherever they go (m/cycle)."""
_COS_20 = math.cos(20.0 * DEG)
_MOST_MOVES = 60


@kernel
def cycles_for_distance(agent: Record, params: Record, distance: float, speed: float) -> int:
    """Cycles to run straight until a point is within kicking reach.

    Parameters
    ----------
    agent, params : record
    distance : float
        To the point (m).
    speed : float
        Along the way, after decay (m/cycle).
    """
    left, decay, top = distance - agent["kick_dist"][0], params["player_decay"][0], params["player_speed_max"][0]
    if left <= 0.0:
        return 0
    push = params["maxpower"][0] * params["dash_power_rate"][0]
    stride = push / (1.0 - decay)
    if stride > top or speed + push > top:
        return _capped_cycles(left, speed, push, decay, top)
    # Rolling on from the first speed plus a sprint from rest: about a stride per cycle, less what the start costs.
    sprint, roll = agent["sprint"], agent["roll"]
    cycles = int(left / stride)
    cycles = max(1, min(cycles, N_AHEAD - 2))
    while cycles > 1 and sprint[0, cycles - 1] + speed * roll[0, cycles - 1] >= left:
        cycles -= 1
    while cycles < N_AHEAD - 1 and sprint[0, cycles] + speed * roll[0, cycles] < left:
        cycles += 1
    return cycles


@kernel
def _capped_cycles(left: float, speed: float, push: float, decay: float, top: float) -> int:
    """Cycles to run a distance when full dashes reach the speed limit."""
    cycles = 0
    while left > 0.0 and cycles < NOT_IN_TIME:
        speed = min(speed + push, top)
        left -= speed
        speed *= decay
        cycles += 1
    return cycles


@kernel
def head_start(agent: Record, slot: int) -> int:
    """Cycles (0 or negative) since the information on another player's motion, which it has used to run."""
    now = agent["now"][0]
    change = agent["player_change"][0, slot]
    start = change - now
    if start < -FRESH:
        start = -2 if slot >= OPPONENTS else 0  # caution: forgotten opponents have been running, team mates have not
    if agent["player_see_time"][0, slot] > change:
        start = max(start, agent["player_see_time"][0, slot] - now)
    return start


@kernel
def cycles_to_point(agent: Record, params: Record, slot: int, x: float, y: float) -> int:
    """Cycles until a player can kick a ball that lies at a point.

    Others start from where they were last seen, and have been running since. The player itself plans every cycle.
    """
    dx, dy = x - agent["player_see_pos"][0, slot, 0], y - agent["player_see_pos"][0, slot, 1]
    distance2 = dx * dx + dy * dy
    reach = agent["kick_dist"][0]
    if distance2 < reach * reach:
        return 0
    distance = math.sqrt(distance2)
    if slot == agent["me"][0]:
        return _own_cycles(agent, params, x, y, dx / distance, dy / distance)
    cycles = head_start(agent, slot)
    if agent["player_change"][0, slot] - agent["now"][0] < -FRESH:
        return cycles + cycles_for_distance(agent, params, distance, _ASSUMED_SPEED)
    body = agent["player_see_body"][0, slot] * DEG
    c, s = math.cos(body), math.sin(body)
    forward, side = dx * c + dy * s, dy * c - dx * s
    vx, vy = agent["player_see_vel"][0, slot, 0], agent["player_see_vel"][0, slot, 1]
    turns, forward, side, v_forward, _ = _turn_to(
        agent, params, forward, side, vx * c + vy * s, vy * c - vx * s, forward / distance, side / distance
    )
    cycles += turns
    distance2 = forward * forward + side * side
    if turns > 0 and distance2 < reach * reach:
        return cycles
    return cycles + cycles_for_distance(agent, params, math.sqrt(distance2), v_forward)


@kernel
def _turn_to(
    agent: Record,
    params: Record,
    forward: float,
    side: float,
    v_forward: float,
    v_side: float,
    goal_forward: float,
    goal_side: float,
) -> tuple[int, float, float, float, float]:
    """Turn (or brake while facing away) until a run can begin, or the point is within reach.

    Returns
    -------
    tuple
        Cycles taken; target and velocity in the new body frame.
    """
    reach2 = agent["kick_dist"][0] ** 2
    strongest = strongest_dash(agent, params)
    cycles = 0
    while cycles < _MOST_MOVES:
        if needs_turn(agent, forward, side, v_forward, v_side, 1, TURN_AROUND_DISTANCE):
            c, s = planned_rotation(agent, params, forward, side, v_forward, v_side, 1)
            goal_forward, goal_side = goal_forward * c + goal_side * s, goal_side * c - goal_forward * s
            forward, side, v_forward, v_side = after_turn(params, c, s, forward, side, v_forward, v_side)
        else:
            acceleration = dash_acceleration(agent, params, forward, v_forward, 1, strongest)
            if acceleration >= 0.0 or goal_forward >= _COS_20:
                break
            forward, side, v_forward, v_side = after_dash(params, acceleration, forward, side, v_forward, v_side)
        cycles += 1
        if forward * forward + side * side < reach2:
            break
    return cycles, forward, side, v_forward, v_side


@kernel
def _own_cycles(agent: Record, params: Record, x: float, y: float, goal_x: float, goal_y: float) -> int:
    forward, side = to_body(agent, x - agent["pos"][0, 0], y - agent["pos"][0, 1])
    v_forward, v_side = to_body(agent, agent["vel"][0, 0], agent["vel"][0, 1])
    goal_forward, goal_side = to_body(agent, goal_x, goal_y)
    cycles, forward, side, v_forward, v_side = _turn_to(
        agent, params, forward, side, v_forward, v_side, goal_forward, goal_side
    )
    reach2 = agent["kick_dist"][0] ** 2
    strongest = strongest_dash(agent, params)
    while forward * forward + side * side > reach2 and cycles < NOT_IN_TIME:
        if needs_turn(agent, forward, side, v_forward, v_side, 1, TURN_AROUND_DISTANCE):
            c, s = planned_rotation(agent, params, forward, side, v_forward, v_side, 1)
            forward, side, v_forward, v_side = after_turn(params, c, s, forward, side, v_forward, v_side)
        else:
            acceleration = dash_acceleration(agent, params, forward, v_forward, 1, strongest)
            forward, side, v_forward, v_side = after_dash(params, acceleration, forward, side, v_forward, v_side)
        cycles += 1
    return cycles


@kernel
def _measure_reach(agent: Record, params: Record, first: int, end: int) -> None:
    """Note how far some players could have come at most, so that few need a prediction.

    ``agent["distance"]`` gets the distance beyond a sprint from rest (m; negative: unknown player), ``agent["order"]``
    the cycles they have been running already.
    """
    decay, reach = params["player_decay"][0], agent["kick_dist"][0]
    me = agent["me"][0]
    for o in range(first, end):
        if not is_known(agent, o):
            agent["distance"][0, o] = -1.0
            continue
        if o == me:
            vx, vy = agent["vel"][0, 0], agent["vel"][0, 1]
            # Being near where it was last seen counts as being there.
            extra = 2.0 * reach
            agent["order"][0, o] = 0
        else:
            vx, vy = agent["player_see_vel"][0, o, 0], agent["player_see_vel"][0, o, 1]
            extra = reach
            agent["order"][0, o] = -head_start(agent, o)
        speed = max(math.sqrt(vx * vx + vy * vy), _ASSUMED_SPEED)
        agent["distance"][0, o] = extra + speed / (1.0 - decay)


@inlined
def _may_reach(agent: Record, slot: int, x: float, y: float, cycles: int) -> bool:
    """Tell whether a player could possibly be at a point in some cycles, after `_measure_reach`."""
    run = cycles + agent["order"][0, slot]
    if run < 0:
        run = 0
    most = agent["distance"][0, slot] + agent["sprint"][0, min(run, N_AHEAD - 1)]
    if slot == agent["me"][0]:
        dx, dy = x - agent["pos"][0, 0], y - agent["pos"][0, 1]
    else:
        dx, dy = x - agent["player_see_pos"][0, slot, 0], y - agent["player_see_pos"][0, slot, 1]
    return dx * dx + dy * dy <= most * most


@kernel
def _fewest_cycles(
    agent: Record, params: Record, first: int, end: int, x: float, y: float, cycles: int
) -> tuple[int, int]:
    """Who of some slots is first at a point, if anybody within some cycles: slot or NOBODY, and cycles."""
    best, fewest = NOBODY, NOT_IN_TIME
    most = params["player_speed_max"][0] * (cycles + 1)
    for o in range(end - 1, first - 1, -1):
        if agent["distance"][0, o] < 0.0 or not _may_reach(agent, o, x, y, cycles):
            continue
        dx, dy = agent["player_pos"][0, o, 0] - x, agent["player_pos"][0, o, 1] - y
        if dx * dx + dy * dy < most * most:
            n = cycles_to_point(agent, params, o, x, y)
            if n < fewest:
                best, fewest = o, n
    return best, fewest


@kernel
def _first_at(agent: Record, params: Record, first: int, end: int, x: float, y: float) -> int:
    """Who of some slots is first at a point where the ball lies: slot or NOBODY."""
    best, fewest = NOBODY, NOT_IN_TIME
    for o in range(end - 1, first - 1, -1):
        if is_known(agent, o):
            dx, dy = agent["player_pos"][0, o, 0] - x, agent["player_pos"][0, o, 1] - y
            if math.sqrt(dx * dx + dy * dy) < fewest * params["player_speed_max"][0]:
                n = cycles_to_point(agent, params, o, x, y)
                if n < fewest:
                    best, fewest = o, n
    return best


@kernel
def fastest_teammate(agent: Record, params: Record) -> int:
    """Player of the own team, oneself included, who is first at the ball: slot or NOBODY.

    When an opponent is first, it is the one who is first at the point where that opponent gets the ball.
    """
    own, other = agent["top_own"][0], agent["top_other"][0]
    _measure_reach(agent, params, 0, own)
    _measure_reach(agent, params, OPPONENTS, other)
    for cycles in range(HORIZON + 1):
        x, y = ball_after(agent, params, cycles)
        best, fewest = _fewest_cycles(agent, params, 0, own, x, y, cycles)
        if fewest <= cycles:
            return best
        if cycles == HORIZON:
            break
        _, fewest = _fewest_cycles(agent, params, OPPONENTS, other, x, y, cycles)
        if fewest <= cycles:
            return _first_at(agent, params, 0, own, x, y)
    x, y = ball_after(agent, params, HORIZON)
    return _in_the_end(agent, params, 0, own, x, y)


@kernel
def fastest_opponent(agent: Record, params: Record) -> int:
    """Opponent who is first at the ball: slot or NOBODY."""
    end = agent["top_other"][0]
    _measure_reach(agent, params, OPPONENTS, end)
    for cycles in range(HORIZON + 1):
        x, y = ball_after(agent, params, cycles)
        best, fewest = _fewest_cycles(agent, params, OPPONENTS, end, x, y, cycles)
        if fewest <= cycles:
            return best
    x, y = ball_after(agent, params, HORIZON)
    return _in_the_end(agent, params, OPPONENTS, end, x, y)


@kernel
def _in_the_end(agent: Record, params: Record, first: int, end: int, x: float, y: float) -> int:
    """Who takes fewest cycles to the end of the horizon, though nobody makes it in time: slot or NOBODY."""
    best, fewest = NOBODY, NOT_IN_TIME
    most = params["player_speed_max"][0] * (HORIZON + 1)
    for o in range(end - 1, first - 1, -1):
        if not is_known(agent, o):
            continue
        dx, dy = agent["player_pos"][0, o, 0] - x, agent["player_pos"][0, o, 1] - y
        if dx * dx + dy * dy < most * most:
            n = cycles_to_point(agent, params, o, x, y)
            if n < fewest:
                best, fewest = o, n
    return best


@kernel
def current_fastest_teammate(agent: Record, params: Record) -> int:
    """Return `fastest_teammate`, computed once per news: slot or NOBODY."""
    _renew(agent)
    if agent["fast_own"][0] == NOT_COMPUTED:
        agent["fast_own"][0] = fastest_teammate(agent, params)
    return agent["fast_own"][0]


@kernel
def current_fastest_opponent(agent: Record, params: Record) -> int:
    """Return `fastest_opponent`, computed once per news: slot or NOBODY."""
    _renew(agent)
    if agent["fast_other"][0] == NOT_COMPUTED:
        agent["fast_other"][0] = fastest_opponent(agent, params)
    return agent["fast_other"][0]


@kernel
def fastest_is_current(agent: Record) -> bool:
    """Tell whether nothing new was seen or heard since `fastest_teammate` was last asked for."""
    return agent["fast_see"][0] == agent["see_time"][0] and agent["fast_hear"][0] == agent["hear_time"][0]


@kernel
def _renew(agent: Record) -> None:
    if not fastest_is_current(agent):
        agent["fast_see"][0] = agent["see_time"][0]
        agent["fast_hear"][0] = agent["hear_time"][0]
        agent["fast_own"][0] = NOT_COMPUTED
        agent["fast_other"][0] = NOT_COMPUTED


@kernel
def cycles_to_ball(agent: Record, params: Record, slot: int) -> int:
    """Cycles until another player has the ball, wherever it rolls; 101 for NOBODY."""
    if slot < 0:
        return NOT_IN_TIME + 1
    bx, by = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    dx, dy = agent["player_pos"][0, slot, 0], agent["player_pos"][0, slot, 1]
    if (bx - dx) ** 2 + (by - dy) ** 2 > 40.0 * 40.0:
        return NOT_IN_TIME + 1
    vx, vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
    if vx * vx + vy * vy < 0.01 * 0.01:
        return cycles_to_point(agent, params, slot, bx, by)
    _measure_reach(agent, params, slot, slot + 1)
    cycles, needed = 0, NOT_IN_TIME
    # Out of reach in fewer cycles means that the search goes on, whatever the exact number is: "open" until asked for.
    is_open, open_x, open_y = False, 0.0, 0.0
    x, y = 0.0, 0.0
    before_x, before_y = -1000.0, -1000.0
    while cycles <= needed and cycles < HORIZON and (x - before_x) ** 2 + (y - before_y) ** 2 > 1e-8:
        cycles += 1
        before_x, before_y = x, y
        x, y = ball_after(agent, params, cycles)
        dx, dy = agent["player_pos"][0, slot, 0] - x, agent["player_pos"][0, slot, 1] - y
        if math.sqrt(dx * dx + dy * dy) < params["player_speed_max"][0] * (cycles + 1):
            is_open, open_x, open_y = not _may_reach(agent, slot, x, y, cycles - 1), x, y
            needed = cycles if is_open else cycles_to_point(agent, params, slot, x, y)
        elif is_open:
            is_open, needed = False, cycles_to_point(agent, params, slot, open_x, open_y)
    return cycles_to_point(agent, params, slot, open_x, open_y) if is_open else needed
