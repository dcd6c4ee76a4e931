"""Motion of ball and players in one step.

Source: 19.0.0, src/object.cpp (MPObject::_inc)::

    if a != 0: |a| <= accel_max; v += a; |v| <= speed_max
    v += polar(U(0, rand |v|), U(-pi, pi))        11.1: (U(-rand |v|, rand |v|), the same)
    p += v                                        bouncing from goal posts
    v *= decay; a = 0

Wind is not simulated (none by default). The server shuffles the order of the objects; as motion of one object does not
depend on the others, a fixed order gives the same distribution.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol.records import COLLIDED_POST
from rcss_hat.simulation.dash import slowness
from rcss_hat.simulation.noise import polar_noise, square_noise
from rcss_hat.simulation.posts import move_past_posts, near_posts
from rcss_hat.simulation.state import F_POST_COLLIDE, PHYSICS
from rcss_hat.simulation.world import World


@inlined
def accelerate(vx: float, vy: float, ax: float, ay: float, accel_max: float, speed_max: float) -> tuple[float, float]:
    """Add an acceleration to a velocity, both cut to their maximum."""
    if ax == 0.0 and ay == 0.0:
        return vx, vy
    size = math.sqrt(ax * ax + ay * ay)
    if size > accel_max:
        ax *= accel_max / size
        ay *= accel_max / size
    vx += ax
    vy += ay
    size = math.sqrt(vx * vx + vy * vy)
    if size > speed_max:
        vx *= speed_max / size
        vy *= speed_max / size
    return vx, vy


@inlined
def motion_noise(
    params: NDArray[np.void], vx: float, vy: float, rand: float, rng: NDArray[np.uint64]
) -> tuple[float, float]:
    """Draw the noise of a velocity."""
    if vx == 0.0 and vy == 0.0:
        return 0.0, 0.0
    limit = rand * math.sqrt(vx * vx + vy * vy)
    if params["version_11"][0]:
        return square_noise(rng, limit)
    return polar_noise(rng, limit)


@inlined
def move_ball(world: World) -> None:
    """Advance the ball by one step."""
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    pos, vel, acc = match["ball_pos"][0], match["ball_vel"][0], match["ball_acc"][0]
    vx, vy = accelerate(vel[0], vel[1], acc[0], acc[1], params["ball_accel_max"][0], params["ball_speed_max"][0])
    noise_x, noise_y = motion_noise(params, vx, vy, params["ball_rand"][0], rng)
    vx, vy = vx + noise_x, vy + noise_y
    goal_width, size = params["goal_width"][0], params["ball_size"][0]
    if near_posts(goal_width, pos[0], pos[1], vx, vy, size):
        pos[0], pos[1], vx, vy, _ = move_past_posts(goal_width, pos[0], pos[1], vx, vy, size, rng)
    else:
        pos[0] += vx
        pos[1] += vy
    decay = params["ball_decay"][0]
    vel[0], vel[1] = vx * decay, vy * decay
    acc[0], acc[1] = 0.0, 0.0


@inlined
def move_player(world: World, i: int) -> None:
    """Advance a player by one step and commit his angles."""
    match, params, types, rng = world.match, world.params, world.types, world.streams[PHYSICS]
    pos, vel, acc = match["pos"][0, i], match["vel"][0, i], match["acc"][0, i]
    k = match["type"][0, i]
    factor = slowness(match, params, i)
    vx, vy = accelerate(
        vel[0],
        vel[1],
        acc[0],
        acc[1],
        params["player_accel_max"][0] * factor,
        types["player_speed_max"][k] * factor,
    )
    commit_angles(match, i)
    noise_x, noise_y = motion_noise(params, vx, vy, params["player_rand"][0], rng)
    vx, vy = vx + noise_x, vy + noise_y
    goal_width, size = params["goal_width"][0], match["size"][0, i]
    if near_posts(goal_width, pos[0], pos[1], vx, vy, size):
        pos[0], pos[1], vx, vy, touched = move_past_posts(goal_width, pos[0], pos[1], vx, vy, size, rng)
        if touched:
            match["collided"][0, i] |= COLLIDED_POST
            match["flags_next"][0, i] |= F_POST_COLLIDE
    else:
        pos[0] += vx
        pos[1] += vy
    decay = types["player_decay"][k]
    vel[0], vel[1] = vx * decay, vy * decay
    acc[0], acc[1] = 0.0, 0.0


@inlined
def commit_angles(match: NDArray[np.void], i: int) -> None:
    """Make the angles that turn and turn_neck asked for those of body and neck."""
    match["body"][0, i] = match["body_pending"][0, i]
    match["neck"][0, i] = match["neck_pending"][0, i]


@kernel
def stand_still(match: NDArray[np.void], i: int) -> None:
    """Let a player only turn: the step of before_kick_off."""
    commit_angles(match, i)
    for axis in range(2):
        match["vel"][0, i, axis] = 0.0
        match["acc"][0, i, axis] = 0.0
