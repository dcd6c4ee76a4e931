"""What a player senses of himself.

Source: 19.0.0, src/bodysender.cpp and src/arm.h.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD, cut_degrees, normalize_radians
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.wire import six_digits
from rcss_hat.protocol.records import N_COUNTS
from rcss_hat.simulation.state import (
    C_ATTENTIONTO,
    C_CATCH,
    C_CHANGE_VIEW,
    C_DASH,
    C_KICK,
    C_MOVE,
    C_POINTTO,
    C_SAY,
    C_TACKLE,
    C_TURN,
    C_TURN_NECK,
)
from rcss_hat.simulation.world import World

_COUNTERS = np.array([C_KICK, C_DASH, C_TURN, C_SAY, C_TURN_NECK, C_CATCH, C_MOVE, C_CHANGE_VIEW])
"""Counter of the match for each of the message's counts."""


@inlined
def _sense_arm(match: NDArray[np.void], i: int, out: NDArray[np.void]) -> None:
    """Arm: target relative to the face, distance in 0.1 m, direction cut to whole degrees; 0 0 while it is down."""
    out["arm_movable"][0] = match["arm_movable"][0, i]
    out["arm_expires"][0] = match["arm_expires"][0, i]
    out["arm_distance"][0] = 0.0
    out["arm_direction"][0] = 0.0
    if match["arm_expires"][0, i] > 0:
        dx = match["arm_pos"][0, i, 0] - match["pos"][0, i, 0]
        dy = match["arm_pos"][0, i, 1] - match["pos"][0, i, 1]
        angle = normalize_radians(math.atan2(dy, dx) - (match["body"][0, i] + match["neck"][0, i]))
        out["arm_distance"][0] = six_digits(np.rint(math.sqrt(dx * dx + dy * dy) * 10.0) * 0.1)
        out["arm_direction"][0] = float(int(np.rint(angle * RAD * 10.0) * 0.1))


@kernel
def sense_body(world: World, i: int, out: NDArray[np.void]) -> None:
    """Write the sense_body message of a player as a client would read it.

    Parameters
    ----------
    world : World
    i : int
        Index of the player.
    out : ndarray of SENSE_BODY, shape (1,)
        Every field is set; what the client's version does not have is -1 (capacity) or 0 (collision).
    """
    match = world.match
    version = match["version"][0, i]
    out["time"][0] = match["time"][0]
    out["quality"][0] = match["quality"][0, i]
    out["width"][0] = match["width"][0, i]
    out["stamina"][0] = six_digits(match["stamina"][0, i])
    out["effort"][0] = six_digits(match["effort"][0, i])
    out["capacity"][0] = six_digits(match["capacity"][0, i]) if version >= 13 else -1.0
    vx, vy = match["vel"][0, i, 0], match["vel"][0, i, 1]
    out["speed"][0] = np.rint(math.sqrt(vx * vx + vy * vy) / 0.01) / 100.0
    out["speed_direction"][0] = float(cut_degrees(vx, vy, match["body"][0, i], match["neck"][0, i]))
    out["head_angle"][0] = float(int(match["neck"][0, i] * RAD))
    for k in range(N_COUNTS):
        out["counts"][0, k] = match["counts"][0, i, _COUNTERS[k]]
    _sense_arm(match, i, out)
    out["arm_count"][0] = match["counts"][0, i, C_POINTTO]
    out["focus_side"][0] = match["focus_side"][0, i]
    out["focus_unum"][0] = match["focus_unum"][0, i]
    out["focus_count"][0] = match["counts"][0, i, C_ATTENTIONTO]
    out["tackle_expires"][0] = match["tackle_cycles"][0, i]
    out["tackle_count"][0] = match["counts"][0, i, C_TACKLE]
    out["has_collision"][0] = version >= 12
    out["collision"][0] = match["collided"][0, i] if version >= 12 else 0
