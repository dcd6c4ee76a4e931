"""The same seed plays the same game over UDP and in the arena, number for number."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from serving import serving

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.policy import TeamPolicy, load_policy
from rcss_hat.keepaway.decision import Decide, EpisodeEnd
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.match import Match

SEED = 7
Decisions = list[tuple[int, int, float, int, tuple[float, ...]]]


class Recorded:
    """A policy that writes down what it decides."""

    def __init__(self, policy: TeamPolicy) -> None:
        self.policy = policy
        self.decisions: Decisions = []

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        decide, ended = self.policy(number)

        def recorded(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            action = decide(cycle, status, reward, state)
            self.decisions.append((cycle, number + 1, reward, action, tuple(state)))
            return action

        return recorded, ended


async def over_udp(task: Task, policy: TeamPolicy, episodes: int) -> tuple[list[Episode], Decisions]:
    policy.warm_up()
    recorded = Recorded(policy)
    with serving(task, SEED) as server:
        match = Match(task, (server.host, server.port), SEED, recorded, True, episodes)
        await match.connect()
        await match.play(kick_off=True)
        assert match.missed == 0
        played = server.episodes()[:episodes]
    return played, sorted(d for d in recorded.decisions if d[0] < played[-1].end)


def in_arena(task: Task, policy: TeamPolicy, episodes: int) -> tuple[list[Episode], Decisions]:
    match = ArenaMatch(task, SEED, policy, log_decisions=True)
    played: list[Episode] = []
    decisions: Decisions = []
    for finished in match.advance(episodes=episodes):
        played += finished
        decisions += [
            (int(d["cycle"]), int(d["keeper"]), float(d["reward"]), int(d["action"]), tuple(d["state"]))
            for d in match.take_decisions()
        ]
    return played, sorted(d for d in decisions if d[0] < played[-1].end)


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("size", "vision", "policy", "episodes"),
    [
        ("3v2", 360, "hand", 6),
        ("3v2", 360, "random", 6),
        ("3v2", 90, "hand", 6),
        ("3v2", 360, "rules", 6),
        ("4v3", 360, "hand", 4),
    ],
)
def test_same_seed_same_game(size: str, vision: int, policy: str, episodes: int, tmp_path: Path) -> None:
    task = Task.parse(size, vision=vision)
    spec = policy
    if policy == "rules":
        spec = str(tmp_path / "rules.json")
        PAPER_RULES.save(spec)

    def fresh() -> TeamPolicy:
        return load_policy(spec, task.keepers, task.takers, SEED)

    udp_episodes, udp_decisions = asyncio.run(over_udp(task, fresh(), episodes))
    arena_episodes, arena_decisions = in_arena(task, fresh(), episodes)
    assert udp_episodes == arena_episodes
    assert len(arena_decisions) > 10
    assert udp_decisions == arena_decisions
