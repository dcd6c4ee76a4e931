"""Player commands: what is accepted, clamped and counted.

Source: 19.0.0, src/player.cpp; the rules that differ in 11.1 are those of 11.1.2, src/player.C. Every kernel returns
whether the command was accepted. At most one body command (dash, turn, kick, tackle, catch, move) is accepted in a
cycle, and one turn_neck; the server never tells a client what it ignored.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation.catch import try_catch
from fake_server.simulation.clock import view_angle
from fake_server.simulation.collision import resolve_collisions
from fake_server.simulation.dash import clamp, dash_at_once
from fake_server.simulation.hearing import keep_message
from fake_server.simulation.kick import ball_kickable, kick_acceleration
from fake_server.simulation.referee import kick_forbidden
from fake_server.simulation.state import (
    BEFORE_KICK_OFF,
    C_ATTENTIONTO,
    C_CATCH,
    C_CHANGE_FOCUS,
    C_CHANGE_VIEW,
    C_KICK,
    C_MOVE,
    C_POINTTO,
    C_SAY,
    C_TACKLE,
    C_TURN,
    C_TURN_NECK,
    CATCH_FAULT_LEFT,
    CATCH_FAULT_RIGHT,
    F_CATCH,
    F_CATCH_FAULT,
    F_KICK,
    F_KICK_FAULT,
    F_TACKLE,
    F_TACKLE_FAULT,
    FREE_KICK_LEFT,
    FREE_KICK_RIGHT,
    GOAL_LEFT,
    GOAL_RIGHT,
    LEG_BUSY,
    LEG_DASH,
    LEG_FREE,
    PLAY_ON,
    side_of,
    unum_of,
)
from fake_server.simulation.tackle import (
    ball_in_body_frame,
    opponent_at_ball,
    tackle_acceleration,
    tackle_failure,
)
from rcss_hat.numeric.angles import DEG, normalize_radians
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import bernoulli, uniform
from rcss_hat.protocol.records import (
    CATCH,
    DASH,
    HIGH,
    KICK,
    LEFT,
    MAX_PLAYERS,
    MOVE,
    NO_SIDE,
    SAY_SIZE,
    TACKLE,
    TURN,
    WIDE,
)

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
def dash(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    power: float,
    direction: float,
) -> bool:
    """Dash with a power, in a direction (degrees from the body; 11.1 knows none).

    The dash acts at the start of the next step, in 11.1 at once.
    """
    if match["command_done"][0, i]:
        return False
    if params["version_11"][0]:
        dash_at_once(match, params, types, i, power)
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
def _occupy_legs(match: NDArray[np.void], i: int) -> None:
    for leg in range(2):
        if match["leg"][0, i, leg] == LEG_FREE:
            match["leg"][0, i, leg] = LEG_BUSY


@inlined
def turn(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    moment: float,
    rng: NDArray[np.uint64],
) -> bool:
    """Turn the body by a moment (degrees).

    ``body' = body + (1 + U(-player_rand, player_rand)) moment / (1 + inertia_moment |v|)``, in the next step.
    """
    if match["command_done"][0, i]:
        return False
    _occupy_legs(match, i)
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
def kick(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    power: float,
    direction: float,
    rng: NDArray[np.uint64],
) -> bool:
    """Kick with a power, in a direction (degrees from the body).

    A kick that fails uses up the cycle's body command in 19, not in 11.1.
    """
    if match["command_done"][0, i]:
        return False
    fails = kick_forbidden(match["mode"][0]) or not ball_kickable(match, params, types, i)
    match["flags_next"][0, i] |= F_KICK | F_KICK_FAULT if fails else F_KICK
    match["kick_cycles"][0, i] = 2
    if fails:
        match["command_done"][0, i] = not params["version_11"][0]
        return False
    match["command_done"][0, i] = 1
    power = clamp(power, params["minpower"][0], params["maxpower"][0])
    angle = clamp(direction, params["minmoment"][0], params["maxmoment"][0]) * DEG
    x, y = kick_acceleration(match, params, types, i, power, angle, rng)
    match["ball_acc"][0, 0] += x
    match["ball_acc"][0, 1] += y
    match["catcher"][0] = -1
    match["counts"][0, i, C_KICK] += 1
    return True


@kernel
def tackle(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    power_or_angle: float,
    foul: bool,
    rng: NDArray[np.uint64],
) -> bool:
    """Tackle; the player is immobile for ``tackle_cycles``, whatever happens.

    Clients of version 12 and later give a direction (degrees), older ones a power. With ``foul`` (19) and an opponent
    at the ball the area has another shape and a success leaves the player mobile; no foul is ever called.
    """
    if match["command_done"][0, i]:
        return False
    _occupy_legs(match, i)
    match["command_done"][0, i] = 1
    match["tackle_cycles"][0, i] = int(params["tackle_cycles"][0])
    match["counts"][0, i, C_TACKLE] += 1
    x, y = ball_in_body_frame(match, i)
    foul = foul and opponent_at_ball(match, params, types, i)
    exponent = params["foul_exponent"][0] if foul else params["tackle_exponent"][0]
    failure = tackle_failure(params, x, y, exponent)
    if failure >= 1.0:
        match["flags_next"][0, i] |= F_TACKLE_FAULT
        return True
    if not bernoulli(rng, 1.0 - failure):
        match["flags_next"][0, i] |= F_TACKLE | F_TACKLE_FAULT
        return True
    match["flags_next"][0, i] |= F_TACKLE
    mode = match["mode"][0]
    if kick_forbidden(mode) and mode != CATCH_FAULT_LEFT and mode != CATCH_FAULT_RIGHT:
        return True
    if foul:
        match["tackle_cycles"][0, i] = 0
    ax, ay = tackle_acceleration(match, params, types, i, power_or_angle, failure, x, y, rng)
    match["ball_acc"][0, 0] += ax
    match["ball_acc"][0, 1] += ay
    match["catcher"][0] = -1
    return True


@kernel
def catch_ball(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    direction: float,
    rng: NDArray[np.uint64],
) -> bool:
    """Catch in a direction (degrees from the body); only a goalie can, in play_on, every ``catch_ban_cycle`` cycles."""
    if match["command_done"][0, i]:
        return False
    match["command_done"][0, i] = 1
    match["flags_next"][0, i] |= F_CATCH
    if not match["goalie"][0, i] or match["catch_ban"][0, i] > 0 or match["mode"][0] != PLAY_ON:
        match["flags_next"][0, i] |= F_CATCH_FAULT
        return False
    if not params["version_11"][0]:
        match["catch_ban"][0, i] = int(params["catch_ban_cycle"][0])
    direction = clamp(direction, params["min_catch_angle"][0], params["max_catch_angle"][0])
    reached, caught = try_catch(match, params, types, i, match["body"][0, i] + direction * DEG, rng)
    if not caught:
        match["flags_next"][0, i] |= F_CATCH_FAULT
    elif params["version_11"][0]:
        match["catch_ban"][0, i] = int(params["catch_ban_cycle"][0])
    if not reached:
        return False
    match["counts"][0, i, C_CATCH] += 1
    match["moves_since_catch"][0, i] = 0
    return True


@kernel
def move(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    x: float,
    y: float,
    rng: NDArray[np.uint64],
) -> bool:
    """Move to a place (m, in the player's own view: negative x is his half), before a kick-off or with a caught ball.

    False also when a goalie has moved ``goalie_max_moves`` times since his catch; the server then warns him, see
    :func:`too_many_moves`.
    """
    if match["command_done"][0, i]:
        return False
    sign = 1.0 if side_of(i) == LEFT else -1.0
    mode = match["mode"][0]
    if mode in (BEFORE_KICK_OFF, GOAL_LEFT, GOAL_RIGHT):
        match["pos"][0, i, 0] = x * sign
        match["pos"][0, i, 1] = y * sign
        resolve_collisions(match, params, rng)
    elif mode in (FREE_KICK_LEFT, FREE_KICK_RIGHT) and match["catcher"][0] == i:
        if not too_many_moves(match, params, i):
            match["pos"][0, i, 0] = x * sign
            match["pos"][0, i, 1] = y * sign
            match["moves_since_catch"][0, i] += 1
    else:
        return False
    _occupy_legs(match, i)
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
def act(
    match: NDArray[np.void],
    params: NDArray[np.void],
    types: NDArray[np.void],
    i: int,
    action: NDArray[np.void],
    rng: NDArray[np.uint64],
) -> bool:
    """Do what an ACTION record says, as if its text had been parsed: body command, turn_neck, say.

    Parameters
    ----------
    match, params, types : records
    i : int
        Index of the player.
    action : ndarray of ACTION, shape (1,)
    rng : ndarray of uint64, shape (4,)
        The PHYSICS stream.

    Returns
    -------
    bool
        Whether the body command was accepted.
    """
    kind = action["kind"][0]
    a, b = action["a"][0], action["b"][0]
    accepted = False
    if kind == DASH:
        accepted = dash(match, params, types, i, a, b)
    elif kind == TURN:
        accepted = turn(match, params, types, i, a, rng)
    elif kind == KICK:
        accepted = kick(match, params, types, i, a, b, rng)
    elif kind == TACKLE:
        accepted = tackle(match, params, types, i, a, False, rng)
    elif kind == CATCH:
        accepted = catch_ball(match, params, types, i, a, rng)
    elif kind == MOVE:
        accepted = move(match, params, types, i, a, b, rng)
    if action["turns_neck"][0]:
        turn_neck(match, params, i, action["neck"][0])
    if action["say_n"][0] > 0:
        say(match, params, i, action["say"][0], action["say_n"][0])
    return accepted
