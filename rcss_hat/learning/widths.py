"""How wide a tile is for each state variable of Keepaway, and how far the variable reaches.

The variables come in the players' order (blocks of ``4 (n - 1) + 2 m + 1`` numbers for n keepers and m takers):
dist(K1, C); dist(K1, Ki); dist(K1, Tj); dist(Ki, C); dist(Tj, C); min dist(Ki, T); min angle(Ki, K1, T).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WIDTH_RULES = ("players", "article")
"""``players``: the widths that the UT Austin players 0.6 compute; ``article``: 3 m and 10 degrees throughout, as the
article of 2005 prints them (Stone, Sutton and Kuhlmann, Adaptive Behavior 13(3))."""

ANGLE_MAX = 180.0
"""Degrees."""


def n_state_variables(n_keepers: int, n_takers: int) -> int:
    """Count the state variables of n v m Keepaway: ``4 (n - 1) + 2 m + 1``."""
    return 4 * (n_keepers - 1) + 2 * n_takers + 1


def tile_widths(n_keepers: int, n_takers: int, rule: str = "players") -> NDArray[np.float64]:
    """Tile width of every state variable.

    Parameters
    ----------
    n_keepers : int
        At least 3.
    n_takers : int
        At least 2.
    rule : {"players", "article"}
        See `WIDTH_RULES`.

    Returns
    -------
    ndarray of float64, shape (4 (n - 1) + 2 m + 1,)
        Metres, for the last n - 1 variables degrees.

    Raises
    ------
    ValueError
        For fewer players (the players' formula divides by n - 2 and m - 1) or an unknown rule.

    Notes
    -----
    Source: UT Austin players 0.6, WorldModelKeepaway.cc. Its integer division truncates toward zero.
    """
    _check_size(n_keepers, n_takers)
    if rule not in WIDTH_RULES:
        raise ValueError(f"tile widths must be one of {', '.join(WIDTH_RULES)}, not {rule!r}")
    if rule == "article":
        distances = 3 * (n_keepers - 1) + 2 * n_takers + 1
        return np.array([3.0] * distances + [10.0] * (n_keepers - 1))
    others = [2.0 + int((i - 1) / (n_keepers - 2)) for i in range(1, n_keepers)]
    to_takers = [3.0 + int((i - 1) / (n_takers - 1)) for i in range(n_takers)]
    return np.array(
        [2.0]
        + others  # dist(K1, Ki)
        + to_takers  # dist(K1, Tj)
        + others  # dist(Ki, C)
        + [3.0] * n_takers  # dist(Tj, C)
        + [4.0] * (n_keepers - 1)  # min dist(Ki, T)
        + [10.0] * (n_keepers - 1)  # min angle(Ki, K1, T)
    )


def variable_maxima(n_keepers: int, n_takers: int, distance_max: float) -> NDArray[np.float64]:
    """Upper end of every state variable's range; larger values are treated as this one.

    Parameters
    ----------
    n_keepers, n_takers : int
    distance_max : float
        Metres, for all distances. Angles end at 180 degrees. All ranges begin at 0.

    Returns
    -------
    ndarray of float64, shape (4 (n - 1) + 2 m + 1,)
    """
    _check_size(n_keepers, n_takers)
    maxima = np.full(n_state_variables(n_keepers, n_takers), distance_max, dtype=np.float64)
    maxima[-(n_keepers - 1) :] = ANGLE_MAX
    return maxima


def _check_size(n_keepers: int, n_takers: int) -> None:
    if not (3 <= n_keepers <= 11 and 2 <= n_takers <= 11):
        raise ValueError(f"the learner is defined for 3 to 11 keepers and 2 to 11 takers, not {n_keepers}v{n_takers}")
