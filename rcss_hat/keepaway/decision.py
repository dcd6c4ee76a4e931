"""How a keeper asks its policy, outside of the compiled loop."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Decide = Callable[[int, int, float, NDArray[np.float64]], int]
"""Policy of a keeper: (cycle, status, reward, state) -> action; see `rcss_hat.keepaway.agent.decide`."""
EpisodeEnd = Callable[[int, bool, float], None]
"""Told of an episode's end: (cycle, this keeper acted in it, cycles since its last decision)."""
KeeperPolicy = Callable[[int], tuple[Decide, EpisodeEnd | None]]
"""Policy of a team: keeper number from 0 -> (decide, episode_ended) of that keeper."""


def hold_cycles_of(policy: KeeperPolicy) -> int:
    """Cycles a Hold of this policy lasts: its attribute ``hold_cycles``, 1 when it has none."""
    return int(getattr(policy, "hold_cycles", 1))
