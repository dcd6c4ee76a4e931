"""What a step is worth: the cycles it took, plain or discounted as in a semi-Markov decision process.

The first step of an episode is counted from the episode's start, before which nobody could decide. So the rewards of
an episode sum up to its duration exactly; discounted, ``r0 + d0 (r1 + d1 (r2 + ...))`` with the discounts of the steps
is ``(1 - g**T) / (1 - g)`` for an episode of T cycles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

CYCLES, SECONDS = "cycles", "seconds"
_UNITS = {CYCLES: 1.0, SECONDS: 0.1}


@dataclass(frozen=True, slots=True)
class Rewards:
    """How cycles become rewards.

    Attributes
    ----------
    unit : {"cycles", "seconds"}
        Of the reward; a cycle is 0.1 s.
    gamma : float
        Discount per cycle; 1: none.

    Raises
    ------
    ValueError
        For another unit, or a discount that is not in (0, 1].
    """

    unit: str = CYCLES
    gamma: float = 1.0

    def __post_init__(self) -> None:
        if self.unit not in _UNITS:
            raise ValueError(f"reward is {' or '.join(map(repr, _UNITS))}, not {self.unit!r}")
        if not 0.0 < self.gamma <= 1.0:
            raise ValueError(f"discount is above 0 and at most 1 (per cycle), not {self.gamma!r}")

    def reward(self, dt: int | NDArray[Any]) -> Any:
        """Return the reward of a step of ``dt`` cycles: the sum of ``gamma**i`` for i < dt; arrays likewise."""
        unit = _UNITS[self.unit]
        if self.gamma == 1.0:
            return dt * unit
        return (1.0 - self.gamma**dt) / (1.0 - self.gamma) * unit

    def discount(self, dt: int | NDArray[Any]) -> Any:
        """Return what the value after a step of ``dt`` cycles counts, ``gamma**dt``; arrays likewise."""
        return self.gamma**dt
