"""Collisions of ball and players.

Source: 19.0.0, src/stadium.cpp (collisions, calcBallCollisionPos, calcCollisionPos). In each of at most ten rounds
every overlapping pair proposes new places on both sides of its middle, an object takes the average of its proposals,
and at the end whatever collided gets its velocity times -0.1, once.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import uniform
from rcss_hat.protocol.records import COLLIDED_BALL, COLLIDED_PLAYER
from rcss_hat.simulation.state import F_BALL_COLLIDE, F_BALL_TO_PLAYER, F_PLAYER_COLLIDE, N_PLAYERS, PHYSICS, PLAY_ON
from rcss_hat.simulation.world import World

_MAX_ROUNDS = 10
_MAX_STRETCHES = 10
_EPS = 1e-10
_BALL = N_PLAYERS
# Columns of the proposals of one object.
_X, _Y, _N, _EVER = range(4)


@inlined
def _any_overlap(match: NDArray[np.void], ball_size: float) -> bool:
    """Tell whether any two objects overlap; the common case is that none do."""
    pos, size, players = match["pos"][0], match["size"][0], match["players"][0]
    bx, by = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    n = match["n_players"][0]
    for a in range(n):
        i = players[a]
        x, y = pos[i, 0], pos[i, 1]
        dx, dy = bx - x, by - y
        reach = ball_size + size[i]
        if dx * dx + dy * dy < reach * reach and i != match["catcher"][0]:
            return True
        for b in range(a + 1, n):
            j = players[b]
            dx, dy = x - pos[j, 0], y - pos[j, 1]
            reach = size[i] + size[j]
            if dx * dx + dy * dy < reach * reach:
                return True
    return False


@kernel
def _apart(
    ax: float, ay: float, bx: float, by: float, reach: float, rng: NDArray[np.uint64]
) -> tuple[float, float, float, float]:
    """New places of two overlapping objects: just reach apart, on both sides of their middle."""
    mid_x, mid_y = 0.5 * (ax + bx), 0.5 * (ay + by)
    dx, dy = ax - mid_x, ay - mid_y
    half = 0.5 * reach + _EPS
    far = math.sqrt(dx * dx + dy * dy)
    if far < _EPS:
        angle = uniform(rng, -math.pi, math.pi)
        dx, dy = half * math.cos(angle), half * math.sin(angle)
    else:
        dx, dy = dx * (half / far), dy * (half / far)
    for _ in range(_MAX_STRETCHES):
        gap_x, gap_y = (mid_x + dx) - (mid_x - dx), (mid_y + dy) - (mid_y - dy)
        if gap_x * gap_x + gap_y * gap_y >= reach * reach:
            break
        dx, dy = dx * 1.0001, dy * 1.0001
    return mid_x + dx, mid_y + dy, mid_x - dx, mid_y - dy


@inlined
def _propose(proposals: NDArray[np.float64], k: int, x: float, y: float) -> None:
    proposals[k, _X] += x
    proposals[k, _Y] += y
    proposals[k, _N] += 1.0
    proposals[k, _EVER] = 1.0


@kernel
def _ball_round(
    match: NDArray[np.void], ball_size: float, proposals: NDArray[np.float64], rng: NDArray[np.uint64]
) -> bool:
    """Let ball and players that overlap propose new places."""
    pos, size = match["pos"][0], match["size"][0]
    bx, by = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    found = False
    for a in range(match["n_players"][0]):
        i = match["players"][0, a]
        x, y = pos[i, 0], pos[i, 1]
        dx, dy = bx - x, by - y
        reach = ball_size + size[i]
        if dx * dx + dy * dy >= reach * reach or i == match["catcher"][0]:
            continue
        found = True
        match["collided"][0, i] |= COLLIDED_BALL
        match["flags_next"][0, i] |= F_BALL_TO_PLAYER | F_BALL_COLLIDE
        if match["mode"][0] == PLAY_ON:
            new_bx, new_by, new_x, new_y = _apart(bx, by, x, y, reach, rng)
        else:
            # A ball that waits for a kick stays where it is.
            new_bx, new_by = bx, by
            far = math.sqrt(dx * dx + dy * dy)
            if far == 0.0:
                angle = uniform(rng, -math.pi, math.pi)
                new_x, new_y = bx + (reach + _EPS) * math.cos(angle), by + (reach + _EPS) * math.sin(angle)
            else:
                scale = (reach + _EPS) / max(far, _EPS)
                new_x, new_y = bx - dx * scale, by - dy * scale
        _propose(proposals, _BALL, new_bx, new_by)
        _propose(proposals, i, new_x, new_y)
    return found


@kernel
def _player_round(match: NDArray[np.void], proposals: NDArray[np.float64], rng: NDArray[np.uint64]) -> bool:
    """Let pairs of players that overlap propose new places."""
    pos, size, players = match["pos"][0], match["size"][0], match["players"][0]
    found = False
    n = match["n_players"][0]
    for a in range(n):
        i = players[a]
        for b in range(a + 1, n):
            j = players[b]
            dx, dy = pos[i, 0] - pos[j, 0], pos[i, 1] - pos[j, 1]
            reach = size[i] + size[j]
            if dx * dx + dy * dy >= reach * reach:
                continue
            found = True
            for one in (i, j):
                match["collided"][0, one] |= COLLIDED_PLAYER
                match["flags_next"][0, one] |= F_PLAYER_COLLIDE
            ix, iy, jx, jy = _apart(pos[i, 0], pos[i, 1], pos[j, 0], pos[j, 1], reach, rng)
            _propose(proposals, i, ix, iy)
            _propose(proposals, j, jx, jy)
    return found


@inlined
def _take_average(place: NDArray[np.float64], proposal: NDArray[np.float64]) -> None:
    """Move an object to the average of its proposals and forget them."""
    if proposal[_N] > 0.0:
        place[0] = proposal[_X] / proposal[_N]
        place[1] = proposal[_Y] / proposal[_N]
        proposal[_X] = proposal[_Y] = proposal[_N] = 0.0


@kernel
def resolve_collisions(world: World) -> None:
    """Move overlapping objects apart and turn their velocities round.

    Parameters
    ----------
    world : World
        Of its streams PHYSICS is drawn from, when two centres coincide.
    """
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    ball_size = params["ball_size"][0]
    if not _any_overlap(match, ball_size):
        return
    proposals = match["proposals"][0]
    proposals[:] = 0.0
    for _ in range(_MAX_ROUNDS):
        found = _ball_round(match, ball_size, proposals, rng)
        found = _player_round(match, proposals, rng) or found
        if not found:
            break
        _take_average(match["ball_pos"][0], proposals[_BALL])
        for a in range(match["n_players"][0]):
            i = match["players"][0, a]
            _take_average(match["pos"][0, i], proposals[i])
    if proposals[_BALL, _EVER] > 0.0:
        match["ball_vel"][0, 0] *= -0.1
        match["ball_vel"][0, 1] *= -0.1
    for a in range(match["n_players"][0]):
        i = match["players"][0, a]
        if proposals[i, _EVER] > 0.0:
            match["vel"][0, i, 0] *= -0.1
            match["vel"][0, i, 1] *= -0.1
