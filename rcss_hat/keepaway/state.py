"""The state variables of Keepaway: distances and angles around the keeper with the ball (K1).

Order of the UT Austin players (WorldModelKeepaway.cc): blocks, zero-based; K2 .. Kn and T1 .. Tm are sorted by distance
to K1; C is the centre of the region. Metres and degrees.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.objects import closest_teammate, sort_by_distance
from rcss_hat.player.records import NOBODY, OPPONENTS

Record = NDArray[np.void]

MAX_RANGE = math.hypot(25.0, 25.0)
"""Range of distances between players (m), whatever the region is."""


def n_state_variables(n_keepers: int, n_takers: int) -> int:
    """Number of state variables: 13 in 3v2."""
    return 4 * (n_keepers - 1) + 2 * n_takers + 1


def state_names(n_keepers: int, n_takers: int) -> list[str]:
    """Names of the state variables, such as ``dist(K1,C)`` and ``min_ang(K2,K1,T)``, in order."""
    keepers = [f"K{i}" for i in range(2, n_keepers + 1)]
    takers = [f"T{j}" for j in range(1, n_takers + 1)]
    return [
        "dist(K1,C)",
        *(f"dist(K1,{k})" for k in keepers),
        *(f"dist(K1,{t})" for t in takers),
        *(f"dist({k},C)" for k in keepers),
        *(f"dist({t},C)" for t in takers),
        *(f"min_dist({k},T)" for k in keepers),
        *(f"min_ang({k},K1,T)" for k in keepers),
    ]


def state_ranges(n_keepers: int, n_takers: int) -> NDArray[np.float64]:
    """Largest value of each state variable, for scaling (the smallest is 0); shape (variables,)."""
    half = 0.5 * MAX_RANGE
    others = n_keepers - 1
    return np.array(
        [half, *[MAX_RANGE] * (others + n_takers), *[half] * (others + n_takers), *[half] * others, *[180.0] * others]
    )


@kernel
def angle_at(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Angle (degrees) at (x, y) between the directions to two points."""
    ux, uy, wx, wy = ax - x, ay - y, bx - x, by - y
    return math.atan2(abs(ux * wy - uy * wx), ux * wx + uy * wy) * RAD


@kernel
def state_variables(agent: Record, state: NDArray[np.float64]) -> bool:
    """Compute the state variables as a keeper believes them to be.

    Parameters
    ----------
    agent : record
    state : ndarray of float64, shape (n_state_variables,)
        Filled in.

    Returns
    -------
    bool
        False when somebody is unknown; the state is then undefined.
    """
    n, m = agent["n_keepers"][0], agent["n_takers"][0]
    holder, _ = closest_teammate(agent, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1])
    if holder == NOBODY:
        return False
    pos = agent["player_pos"]
    x, y = pos[0, holder, 0], pos[0, holder, 1]
    order, distance = agent["order"][0], agent["distance"][0]
    keepers, takers = order[:n], order[n : n + m]
    if not sort_by_distance(agent, 0, n, x, y, keepers, distance[:n]):
        return False
    if not sort_by_distance(agent, OPPONENTS, m, x, y, takers, distance[n : n + m]):
        return False
    state[0] = math.sqrt(x * x + y * y)
    for i in range(1, n + m):
        state[i] = distance[i]
        px, py = pos[0, order[i], 0], pos[0, order[i], 1]
        state[n + m - 1 + i] = math.sqrt(px * px + py * py)
    base = 2 * (n + m) - 2
    for i in range(1, n):
        kx, ky = pos[0, keepers[i], 0], pos[0, keepers[i], 1]
        nearest2, narrowest = 1e12, 180.0
        for j in range(m):
            tx, ty = pos[0, takers[j], 0], pos[0, takers[j], 1]
            nearest2 = min(nearest2, (tx - kx) ** 2 + (ty - ky) ** 2)
            narrowest = min(narrowest, angle_at(x, y, kx, ky, tx, ty))
        state[base + i] = math.sqrt(nearest2)
        state[base + n - 1 + i] = narrowest
    return True
