"""The checks that are shipped: they pass for what is ours, and find what is not right."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from quick_servers import QuickServer

from rcss_hat.envs import KeepawayEnv, keepaway_v0, testing

STAGES = pytest.mark.parametrize("stage", ["arena", "fake"])


@STAGES
def test_what_is_ours_passes(quick_servers: list[QuickServer], stage: str) -> None:
    testing.check_returns(lambda: KeepawayEnv(stage=stage, vision=90, max_cycles=60), episodes=4)
    testing.check_same(lambda: KeepawayEnv(stage=stage), KeepawayEnv, steps=40)
    testing.check_agents(lambda: keepaway_v0.env(stage=stage, per="decision"), episodes=2)
    testing.check_agents(lambda: keepaway_v0.parallel_env(stage=stage), episodes=1)


def test_takers_pass_too() -> None:
    testing.check_agents(lambda: keepaway_v0.env(taker_agents=True, per="decision"))
    testing.check_agents(lambda: keepaway_v0.parallel_env(taker_agents=True), episodes=1)


class Late(gymnasium.Wrapper):  # type: ignore[type-arg]
    """Forgets what an episode's first steps were worth."""

    def step(self, action: Any) -> Any:
        seen, reward, *rest, info = self.env.step(action)
        return seen, 0.0 if info["dt"] == info["elapsed"] else reward, *rest, info


class Wide(gymnasium.Wrapper):  # type: ignore[type-arg]
    def step(self, action: Any) -> Any:
        seen, *rest = self.env.step(action)
        return seen + np.float32(200.0), *rest


class Counting(gymnasium.Wrapper):  # type: ignore[type-arg]
    def step(self, action: Any) -> Any:
        *rest, info = self.env.step(action)
        return *rest, info | {"episode": 1}


@pytest.mark.parametrize(("wrapper", "said"), [(Late, "the return is"), (Wide, "not within"), (Counting, "belongs to")])
def test_what_does_not_hold_is_found(wrapper: Any, said: str) -> None:
    with pytest.raises(AssertionError, match=said):
        testing.check_returns(lambda: wrapper(KeepawayEnv()))


def test_a_difference_is_found() -> None:
    with pytest.raises(AssertionError, match="entry 0 of the trajectory of seed 0"):
        testing.check_same(KeepawayEnv, lambda: KeepawayEnv(profile="11.1"))
