"""Player commands: what is accepted, clamped and counted.

Source: 19.0.0, src/player.cpp; the rules that differ in 11.1 are those of 11.1.2, src/player.C. Every kernel returns
whether the command was accepted. At most one body command (dash, turn, kick, tackle, catch, move) is accepted in a
cycle, and one turn_neck; the server never tells a client what it ignored.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_radians
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import uniform
from rcss_hat.protocol.records import (
    DASH,
    HIGH,
    KICK,
    LEFT,
    MAX_PLAYERS,
    NO_SIDE,
    SAY_SIZE,
    TURN,
    WIDE,
)
from rcss_hat.simulation.clock import view_angle
from rcss_hat.simulation.collision import resolve_collisions
from rcss_hat.simulation.dash import clamp, dash_at_once
from rcss_hat.simulation.hearing import keep_message
from rcss_hat.simulation.kick import ball_kickable, kick_acceleration
from rcss_hat.simulation.referee import kick_forbidden
from rcss_hat.simulation.state import (
    BEFORE_KICK_OFF,
    C_ATTENTIONTO,
    C_CHANGE_FOCUS,
    C_CHANGE_VIEW,
    C_KICK,
    C_MOVE,
    C_POINTTO,
    C_SAY,
    C_TURN,
    C_TURN_NECK,
    F_KICK,
    F_KICK_FAULT,
    FREE_KICK_LEFT,
    FREE_KICK_RIGHT,
    GOAL_LEFT,
    GOAL_RIGHT,
    LEG_BUSY,
    LEG_DASH,
    LEG_FREE,
    PHYSICS,
    side_of,
    unum_of,
)
from rcss_hat.simulation.world import World

BOTH_LEGS, LEFT_LEG, RIGHT_LEG = range(3)
_MAX_FOCUS_DIST = 40.0


@inlined
def _dash_leg(
    match: NDArray[np.void], params: NDArray[np.void], i: int, leg: int, power: float, direction: float
) -> bool:
    """Store what one leg is to do; a leg does one thing per cycle."""
    if match["leg"][0, i, leg] != LEG_FREE:
        return False
    direction = clamp(direction, params["min_dash_angle"][0], params["max_dash_angle"][0])
    step = params["dash_angle_step"][0]
    if step >= 1e-10:
        direction = step * np.rint(direction / step)
    match["leg"][0, i, leg] = LEG_DASH
    match["leg_power"][0, i, leg] = clamp(power, params["min_dash_power"][0], params["max_dash_power"][0])
    match["leg_dir"][0, i, leg] = direction
    match["command_done"][0, i] = 1
    return True


@inlined
def dash(world: World, i: int, power: float, direction: float) -> bool:
    """Dash with a power, in a direction (degrees from the body; 11.1 knows none).

    The dash acts at the start of the next step, in 11.1 at once.
    """
    match, params = world.match, world.params
    if match["command_done"][0, i]:
        return False
    if params["version_11"][0]:
        dash_at_once(world, i, power)
        match["command_done"][0, i] = 1
        return True
    left = _dash_leg(match, params, i, 0, power, direction)
    right = _dash_leg(match, params, i, 1, power, direction)
    return left or right


@kernel
def dash_legs(
    match: NDArray[np.void], params: NDArray[np.void], i: int, leg: int, power: float, direction: float
) -> bool:
    """Dash with one leg, LEFT_LEG or RIGHT_LEG, or with BOTH_LEGS alike (19).

    As in the server this asks only whether the leg is free, not whether another body command was accepted: it works
    after a kick or catch in the same cycle, and while the player is immobile after a tackle.
    """
    accepted = False
    if leg != RIGHT_LEG:
        accepted = _dash_leg(match, params, i, 0, power, direction)
    if leg != LEFT_LEG:
        accepted = _dash_leg(match, params, i, 1, power, direction) or accepted
    return accepted


@inlined
def occupy_legs(match: NDArray[np.void], i: int) -> None:
    """Let the legs that are free do nothing else in this cycle."""
    for leg in range(2):
        if match["leg"][0, i, leg] == LEG_FREE:
            match["leg"][0, i, leg] = LEG_BUSY


@inlined
def turn(world: World, i: int, moment: float) -> bool:
    """Turn the body by a moment (degrees).

    ``body' = body + (1 + U(-player_rand, player_rand)) moment / (1 + inertia_moment |v|)``, in the next step.
    """
    match, params, types, rng = world.match, world.params, world.types, world.streams[PHYSICS]
    if match["command_done"][0, i]:
        return False
    occupy_legs(match, i)
    rand = params["player_rand"][0]
    moment = clamp(moment, params["minmoment"][0], params["maxmoment"][0]) * DEG
    vx, vy = match["vel"][0, i, 0], match["vel"][0, i, 1]
    inertia = types["inertia_moment"][match["type"][0, i]]
    turned = (1.0 + uniform(rng, -rand, rand)) * moment / (1.0 + inertia * math.sqrt(vx * vx + vy * vy))
    match["body_pending"][0, i] = normalize_radians(match["body"][0, i] + turned)
    match["counts"][0, i, C_TURN] += 1
    match["command_done"][0, i] = 1
    return True


@inlined
def kick(world: World, i: int, power: float, direction: float) -> bool:
    """Kick with a power, in a direction (degrees from the body).

    A kick that fails uses up the cycle's body command in 19, not in 11.1.
    """
    match, params = world.match, world.params
    if match["command_done"][0, i]:
        return False
    fails = kick_forbidden(match["mode"][0]) or not ball_kickable(world, i)
    match["flags_next"][0, i] |= F_KICK | F_KICK_FAULT if fails else F_KICK
    match["kick_cycles"][0, i] = 2
    if fails:
        match["command_done"][0, i] = not params["version_11"][0]
        return False
    match["command_done"][0, i] = 1
    power = clamp(power, params["minpower"][0], params["maxpower"][0])
    angle = clamp(direction, params["minmoment"][0], params["maxmoment"][0]) * DEG
    x, y = kick_acceleration(world, i, power, angle)
    match["ball_acc"][0, 0] += x
    match["ball_acc"][0, 1] += y
    match["catcher"][0] = -1
    match["counts"][0, i, C_KICK] += 1
    return True


@kernel
def move(world: World, i: int, x: float, y: float) -> bool:
    """Move to a place (m, in the player's own view: negative x is his half), before a kick-off or with a caught ball.

    False also when a goalie has moved ``goalie_max_moves`` times since his catch; the server then warns him, see
    :func:`too_many_moves`.
    """
    match, params = world.match, world.params
    if match["command_done"][0, i]:
        return False
    sign = 1.0 if side_of(i) == LEFT else -1.0
    mode = match["mode"][0]
    if mode in (BEFORE_KICK_OFF, GOAL_LEFT, GOAL_RIGHT):
        match["pos"][0, i, 0] = x * sign
        match["pos"][0, i, 1] = y * sign
        resolve_collisions(world)
    elif mode in (FREE_KICK_LEFT, FREE_KICK_RIGHT) and match["catcher"][0] == i:
        if not too_many_moves(match, params, i):
            match["pos"][0, i, 0] = x * sign
            match["pos"][0, i, 1] = y * sign
            match["moves_since_catch"][0, i] += 1
    else:
        return False
    occupy_legs(match, i)
    match["command_done"][0, i] = 1
    match["counts"][0, i, C_MOVE] += 1
    return True


@kernel
def too_many_moves(match: NDArray[np.void], params: NDArray[np.void], i: int) -> bool:
    """Tell whether a goalie may not move again with the ball he caught."""
    most = params["goalie_max_moves"][0]
    return bool(most >= 0.0 and match["moves_since_catch"][0, i] >= most)


@inlined
def turn_neck(match: NDArray[np.void], params: NDArray[np.void], i: int, moment: float) -> bool:
    """Turn the neck by a moment (degrees); exact, and clamped to [minneckang, maxneckang] relative to the body."""
    if match["neck_done"][0, i]:
        return False
    moment = clamp(moment, params["minneckmoment"][0], params["maxneckmoment"][0]) * DEG
    match["neck_pending"][0, i] = clamp(
        match["neck"][0, i] + moment, params["minneckang"][0] * DEG, params["maxneckang"][0] * DEG
    )
    match["counts"][0, i, C_TURN_NECK] += 1
    match["neck_done"][0, i] = 1
    return True


@kernel
def say(match: NDArray[np.void], params: NDArray[np.void], i: int, text: NDArray[np.uint8], n: int) -> bool:
    """Say the first n characters of a text; longer ones than ``say_msg_size``, at most SAY_SIZE, are dropped."""
    if n > SAY_SIZE or n > params["say_msg_size"][0]:
        return False
    match["counts"][0, i, C_SAY] += 1
    return keep_message(match, params, i, text, n)


@kernel
def change_view(match: NDArray[np.void], i: int, width: int, quality: int) -> bool:
    """Set width and quality of the view; no low quality with synch_see."""
    if width > WIDE or (match["synch_see"][0, i] and quality != HIGH):
        return False
    match["width"][0, i] = width
    match["quality"][0, i] = quality
    match["counts"][0, i, C_CHANGE_VIEW] += 1
    return True


@kernel
def synch_see(match: NDArray[np.void], i: int) -> bool:
    """Let a player see in step with the simulation, for good (19)."""
    match["synch_see"][0, i] = 1
    match["quality"][0, i] = HIGH
    return True


@kernel
def gaussian_see(match: NDArray[np.void], i: int) -> bool:
    """Let a player see distances with Gaussian noise instead of in steps, for good (19)."""
    match["gaussian_see"][0, i] = 1
    return True


@kernel
def change_focus(match: NDArray[np.void], params: NDArray[np.void], i: int, dist: float, direction: float) -> bool:
    """Move the focus point by a distance (m) and a direction (degrees) (19; seen with by clients of version 18 on)."""
    half = 0.5 * view_angle(match, params, i) * DEG
    match["focus_dist"][0, i] = clamp(match["focus_dist"][0, i] + dist, 0.0, _MAX_FOCUS_DIST)
    match["focus_dir"][0, i] = clamp(normalize_radians(match["focus_dir"][0, i] + direction * DEG), -half, half)
    match["counts"][0, i, C_CHANGE_FOCUS] += 1
    return True


@kernel
def point_to(match: NDArray[np.void], params: NDArray[np.void], i: int, distance: float, direction: float) -> bool:
    """Point at a place, distance (m) and direction (degrees) from the face, for ``point_to_duration`` cycles."""
    if match["arm_movable"][0, i] > 0:
        return False
    angle = direction * DEG + match["body"][0, i] + match["neck"][0, i]
    match["arm_pos"][0, i, 0] = match["pos"][0, i, 0] + distance * math.cos(angle)
    match["arm_pos"][0, i, 1] = match["pos"][0, i, 1] + distance * math.sin(angle)
    match["arm_movable"][0, i] = int(params["point_to_ban"][0])
    match["arm_expires"][0, i] = int(params["point_to_duration"][0])
    match["counts"][0, i, C_POINTTO] += 1
    return True


@kernel
def point_to_off(match: NDArray[np.void], params: NDArray[np.void], i: int) -> bool:
    """Take the arm down."""
    if match["arm_movable"][0, i] > 0:
        return False
    match["arm_pos"][0, i, 0] = match["arm_pos"][0, i, 1] = 0.0
    match["arm_movable"][0, i] = max(0, int(params["point_to_ban"][0] - params["point_to_duration"][0]))
    match["arm_expires"][0, i] = 0
    match["counts"][0, i, C_POINTTO] += 1
    return True


@kernel
def attention_to(match: NDArray[np.void], i: int, side: int, unum: int) -> bool:
    """Attend to a player, connected or not, of a side that has a team; not to oneself."""
    if not 1 <= unum <= MAX_PLAYERS or (side == side_of(i) and unum == unum_of(i)):
        return False
    match["focus_side"][0, i] = side
    match["focus_unum"][0, i] = unum
    match["counts"][0, i, C_ATTENTIONTO] += 1
    return True


@kernel
def attention_off(match: NDArray[np.void], i: int) -> bool:
    """Attend to nobody in particular."""
    match["focus_side"][0, i] = NO_SIDE
    match["focus_unum"][0, i] = 0
    match["counts"][0, i, C_ATTENTIONTO] += 1
    return True


@kernel
def act(world: World, i: int, action: NDArray[np.void]) -> bool:
    """Do what an ACTION record of Keepaway says, as if its text had been parsed: dash, turn or kick, turn_neck, say.

    Keepaway's players neither tackle nor catch nor move.

    Parameters
    ----------
    world : World
    i : int
        Index of the player.
    action : ndarray of ACTION, shape (1,)

    Returns
    -------
    bool
        Whether the body command was accepted.
    """
    match, params = world.match, world.params
    kind = action["kind"][0]
    a, b = action["a"][0], action["b"][0]
    accepted = False
    if kind == DASH:
        accepted = dash(world, i, a, b)
    elif kind == TURN:
        accepted = turn(world, i, a)
    elif kind == KICK:
        accepted = kick(world, i, a, b)
    if action["turns_neck"][0]:
        turn_neck(match, params, i, action["neck"][0])
    if action["say_n"][0] > 0:
        say(match, params, i, action["say"][0], action["say_n"][0])
    return accepted
