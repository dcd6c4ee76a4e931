"""Games whose every decision was written down once: digests of episodes, decisions and weights.

They hold the promise that a change of the code's shape changes no decision of any player. Where a change is meant to
change the game, write the digests again, in a commit that says why: ``python tests/stage/recorded_games.py``. With
``--udp`` all of them are played on the fake server, too, and those that differ are named.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from serving import serving

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.mapping import map_rules
from rcss_hat.hat.policy import TeamPolicy, learners_policy, load_policy, rules_policy
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.hat.transfer.making import make_method
from rcss_hat.keepaway.decision import Decide, EpisodeEnd
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import load_config
from rcss_hat.stage.match import Match

DIGESTS = Path(__file__).parents[1] / "data" / "stage" / "recorded-games.json"
SEED, EPISODES, FIRST = 20110502, 20, 3
"""Seed of all games; episodes in the arena; those of them that are played over UDP, too."""
POLICIES = ("hold", "random", "hand", "rules", "no-prior", "ppr", "value-bonus", "extra-action", "chat")
"""Fixed policies, the paper's decision list, and learners (preset best) by transfer method, learning as they play."""
Decision = tuple[int, int, float, int, tuple[float, ...]]
"""Cycle, keeper, reward, action, state variables."""


@dataclass(frozen=True)
class Game:
    """What is played."""

    size: str
    vision: int
    profile: str
    policy: str

    @property
    def name(self) -> str:
        return f"{self.size} {self.vision} {self.profile} {self.policy}"

    @property
    def task(self) -> Task:
        return Task.parse(self.size, vision=self.vision, profile=self.profile)

    def team(self) -> TeamPolicy:
        """Return the policy, fresh."""
        task = self.task
        if self.policy in ("hold", "random", "hand"):
            return load_policy(self.policy, task.keepers, task.takers, SEED)
        rules = map_rules(PAPER_RULES, task.keepers, task.takers) if task.keepers > 3 else PAPER_RULES
        if self.policy == "rules":
            return rules_policy(rules, SEED)
        method = make_method(self.policy)
        learners = Learners.create(load_config("best"), method, task.keepers, task.takers, SEED)
        return learners_policy(learners, rules if method.needs_advice else None)


GAMES = [
    Game(size, vision, profile, policy)
    for size in ("3v2", "4v3")
    for vision in (360, 90)
    for profile in ("19.0", "11.1")
    for policy in POLICIES
]


def digest(episodes: Iterable[Episode], decisions: Iterable[Decision]) -> str:
    """Return a hash of everything that happened, to the last bit."""
    found = hashlib.sha256()
    for episode in episodes:
        found.update(f"{episode.number} {episode.start} {episode.end} {episode.reason}\n".encode())
    for cycle, keeper, reward, action, state in decisions:
        found.update(f"{cycle} {keeper} {reward.hex()} {action} {' '.join(x.hex() for x in state)}\n".encode())
    return found.hexdigest()[:16]


def in_arena(game: Game) -> dict[str, str]:
    """Play in the arena; digests of the first episodes, of all, and of what was learned."""
    policy = game.team()
    match = ArenaMatch(game.task, SEED, policy, log_decisions=True)
    episodes: list[Episode] = []
    decisions: list[Decision] = []
    for finished in match.advance(episodes=EPISODES):
        episodes += finished
        decisions += [
            (int(d["cycle"]), int(d["keeper"]), float(d["reward"]), int(d["action"]), tuple(map(float, d["state"])))
            for d in match.take_decisions()
        ]
    end = episodes[FIRST - 1].end
    learners = policy.learners
    weights = np.zeros(game.task.keepers) if learners is None else learners.weights
    return {
        "first": digest(episodes[:FIRST], sorted(d for d in decisions if d[0] < end)),
        "all": digest(episodes, sorted(decisions)),
        "weights": hashlib.sha256(np.ascontiguousarray(weights).tobytes()).hexdigest()[:16],
    }


class Recorded:
    """A policy that writes down what it decides."""

    def __init__(self, policy: TeamPolicy) -> None:
        self.policy = policy
        self.hold_cycles = policy.hold_cycles
        self.decisions: list[Decision] = []

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        decide, ended = self.policy(number)

        def recorded(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            action = decide(cycle, status, reward, state)
            self.decisions.append((cycle, number + 1, float(reward), int(action), tuple(map(float, state))))
            return action

        return recorded, ended


async def _over_udp(game: Game) -> str:
    policy = game.team()
    policy.warm_up()
    recorded = Recorded(policy)
    with serving(game.task, SEED) as server:
        match = Match(game.task, (server.host, server.port), SEED, recorded, True, FIRST)
        await match.connect()
        await match.play(kick_off=True)
        episodes = server.episodes()[:FIRST]
    return digest(episodes, sorted(d for d in recorded.decisions if d[0] < episodes[-1].end))


def over_udp(game: Game) -> str:
    """Play the first episodes on the fake server and return their digest."""
    return asyncio.run(_over_udp(game))


def recorded() -> dict[str, dict[str, str]]:
    """Return the digests that were written down, by name of the game."""
    found: dict[str, dict[str, str]] = json.loads(DIGESTS.read_text())
    return found


def _lines() -> Iterator[str]:
    for game in GAMES:
        yield f"{json.dumps(game.name)}: {json.dumps(in_arena(game))}"


if __name__ == "__main__":
    if "--udp" in sys.argv:
        differing = [game.name for game in GAMES if over_udp(game) != recorded()[game.name]["first"]]
        sys.exit(f"different over UDP: {', '.join(differing)}" if differing else 0)
    DIGESTS.write_text("{\n" + ",\n".join(_lines()) + "\n}\n")
