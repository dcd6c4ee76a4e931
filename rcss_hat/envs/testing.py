"""Checks of what environments of Keepaway promise, beyond those of Gymnasium and PettingZoo.

For wrappers, servers and changes of one's own: every check takes a function that makes the environment, plays it with
random actions and raises an AssertionError that says what does not hold.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import Env
from pettingzoo import AECEnv, ParallelEnv

Make = Callable[[], Any]
TOLD = ("dt", "cycle", "keeper", "status", "number", "elapsed", "missed", "skipped")
"""What ``info`` holds at every step of the single environment."""
REASONS = ("out", "taken", "?", "max_cycles", "server")


def check_returns(make: Make, episodes: int = 5, seed: int = 0) -> None:
    """Check that rewards sum up to the duration of every episode in cycles, and what ``info`` tells of it."""
    env, draw = make(), random.Random(seed)
    try:
        for episode in range(episodes):
            seen, info = env.reset(seed=seed if episode == 0 else None)
            _check_step(env, seen, info)
            total, over = 0.0, False
            while not over:
                seen, reward, terminated, truncated, info = env.step(draw.randrange(int(env.action_space.n)))
                _check_step(env, seen, info)
                total, over = total + reward, terminated or truncated
            assert total == info["duration"], f"the return is {total}, the duration {info['duration']} cycles"
            assert info["reason"] in REASONS, f"an episode ends by {', '.join(REASONS)}, not {info['reason']!r}"
            assert terminated != truncated, "an episode is terminated or truncated, not both"
    finally:
        env.close()


def _check_step(env: Env[Any, Any], seen: Any, info: dict[str, Any]) -> None:
    assert env.observation_space.contains(seen), f"{seen} is not within {env.observation_space}"
    missing = [name for name in TOLD if name not in info]
    assert not missing, f"info lacks {', '.join(missing)}"
    assert "episode" not in info, "info['episode'] belongs to Gymnasium's and others' statistics"


def trajectory(make: Make, steps: int = 60, seed: int = 0) -> list[tuple[Any, ...]]:
    """Return what a single environment tells while it is stepped at random, ends and resets included."""
    env, draw = make(), random.Random(seed)
    try:
        seen, info = env.reset(seed=seed)
        told: list[tuple[Any, ...]] = [(seen.tolist(), _plain(info))]
        for _ in range(steps):
            seen, reward, terminated, truncated, info = env.step(draw.randrange(int(env.action_space.n)))
            told.append((seen.tolist(), reward, terminated, truncated, _plain(info)))
            if terminated or truncated:
                seen, info = env.reset()
                told.append((seen.tolist(), _plain(info)))
        return told
    finally:
        env.close()


def _plain(info: dict[str, Any]) -> dict[str, Any]:
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in info.items()}


def check_same(make: Make, other: Make, steps: int = 60, seed: int = 0) -> None:
    """Check that two single environments tell the same, number for number: the same place twice, or two places."""
    for k, (mine, theirs) in enumerate(zip(trajectory(make, steps, seed), trajectory(other, steps, seed), strict=True)):
        assert mine == theirs, f"entry {k} of the trajectory of seed {seed} is {mine} and {theirs}"


def check_agents(make: Make, episodes: int = 3, seed: int = 0) -> None:
    """Check that in PettingZoo every keeper gets the duration of every episode, and every taker the negative.

    For ``reward="team"``.
    """
    env, draw = make(), random.Random(seed)
    try:
        for episode in range(episodes):
            first = seed if episode == 0 else None
            total, info = (_turns if isinstance(env, AECEnv) else _together)(env, draw, first)
            for agent, sum_ in total.items():
                due = info["duration"] if agent.startswith("keeper") else -info["duration"]
                assert sum_ == due, f"{agent} got {sum_} of {due} cycles"
    finally:
        env.close()


def _turns(
    env: AECEnv[str, Any, int], draw: random.Random, seed: int | None
) -> tuple[dict[str, float], dict[str, Any]]:
    env.reset(seed=seed)
    total, info = dict.fromkeys(env.possible_agents, 0.0), dict[str, Any]()
    for agent in env.agent_iter():
        seen, reward, terminated, truncated, info = env.last()
        assert env.observation_space(agent).contains(seen), f"{agent} observes {seen}"
        total[agent] += reward
        env.step(None if terminated or truncated else draw.randrange(int(info["action_mask"].sum())))
    return total, info


def _together(
    env: ParallelEnv[str, Any, int], draw: random.Random, seed: int | None
) -> tuple[dict[str, float], dict[str, Any]]:
    _, infos = env.reset(seed=seed)
    total = dict.fromkeys(env.possible_agents, 0.0)
    while env.agents:
        actions = {agent: draw.randrange(int(infos[agent]["action_mask"].sum())) for agent in env.agents}
        seen, rewards, _, _, infos = env.step(actions)
        for agent, reward in rewards.items():
            assert env.observation_space(agent).contains(seen[agent]), f"{agent} observes {seen[agent]}"
            total[agent] += reward
    return total, infos[env.possible_agents[0]]
