"""Independent learners in PettingZoo, and takers that learn: ``python examples/in_turns.py keepers|takers``.

``keepers``: three keepers learn, each for itself, from what it perceives; the takers are hand-coded. ``takers``: two
takers learn which macro-action to take; the keepers are hand-coded. All learn by Q-learning, linear in indicators of
every variable's range, with the cycles to their own next decision as rewards (takers: the negative).
"""

from __future__ import annotations

import argparse

import curves
import numpy as np

from rcss_hat.envs import keepaway_v0
from rcss_hat.keepaway.policies import hand

BINS = 8
REACH = 20.0
"""Metres beyond which all distances are one."""


class Learner:
    """One agent's values, linear in indicators."""

    def __init__(self, high: np.ndarray, actions: int, rng: np.random.Generator, optimism: float) -> None:
        self.width = np.where(high == 180.0, 180.0, REACH) / BINS
        self.first = np.arange(len(high)) * BINS
        self.weights = np.full((actions, len(high) * BINS), optimism / len(high))
        self.rng, self.rate = rng, 0.1 / len(high)
        self.before: tuple[np.ndarray, int] | None = None

    def turn(self, seen: np.ndarray, reward: float, over: bool, epsilon: float) -> int | None:
        """Learn from what came of the last decision, and decide; None at the end of an episode."""
        active = self.first + np.minimum(seen / self.width, BINS - 1).astype(int)
        values = self.weights[:, active].sum(axis=1)
        if self.before is not None:
            then, action = self.before
            target = reward + (0.0 if over else values.max())
            self.weights[action, then] += self.rate * (target - self.weights[action, then].sum())
        self.before = None
        if over:
            return None
        chosen = int(self.rng.integers(len(values))) if self.rng.random() < epsilon else int(values.argmax())
        self.before = active, chosen
        return chosen


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("who", choices=["keepers", "takers"])
    parser.add_argument("--episodes", type=int, default=1_200)
    parser.add_argument("--window", type=int, default=150)
    parser.add_argument("--seed", type=int, default=1)
    o = parser.parse_args()
    team = o.who.removesuffix("s")
    env = keepaway_v0.env(reward="own", taker_agents=o.who == "takers", per="decision")
    rng = np.random.default_rng(o.seed)
    learners = {
        name: Learner(env.observation_space(name).high, int(env.action_space(name).n), rng, 20.0 * (team == "keeper"))
        for name in env.possible_agents
        if name.startswith(team)
    }
    durations, rows = [], []
    for episode in range(o.episodes):
        env.reset(seed=o.seed if episode == 0 else None)
        epsilon, duration = 0.1 * (1.0 - episode / o.episodes), 0
        for name in env.agent_iter():
            seen, reward, terminated, truncated, info = env.last()
            over = terminated or truncated
            duration = info.get("duration", duration)
            if name in learners:
                env.step(learners[name].turn(seen, reward, over, epsilon))
            else:
                env.step(None if over else hand(seen.astype(np.float64), 3, 2))
        durations.append(duration / 10.0)
        if len(durations) == o.window:
            rows.append((episode + 1, float(np.mean(durations))))
            durations = []
    note = f"{o.who} that learn in turns, mean of the last {o.window} episodes, seed {o.seed}"
    curves.write_curve(f"in-turns-{o.who}", rows, note, "episodes")


if __name__ == "__main__":
    main()
