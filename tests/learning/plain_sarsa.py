"""Sarsa(lambda) written as the equations read, with dictionaries: slow, and independent of the compiled kernels."""

from __future__ import annotations

import math
from collections import defaultdict

Key = tuple[int, ...]


def cmac_features(state: list[float], widths: list[float], tilings: int) -> dict[Key, float]:
    """Active tiles (variable, tiling, tile), as the players' hashing names them."""
    return {
        (v, j, math.floor((math.floor(tilings * x / width) - j) / tilings)): 1.0
        for v, (x, width) in enumerate(zip(state, widths, strict=True))
        for j in range(tilings)
    }


def rbf_features(
    state: list[float], widths: list[float], tilings: int, sigma: float, cutoff: float, places: int = 2048
) -> dict[Key, float]:
    """Active Gaussians (variable, centre), x rounded to the nearest of ``places`` places within a width."""
    found = {}
    for v, (x, width) in enumerate(zip(state, widths, strict=True)):
        at = math.floor(x * places / width + 0.5) / places
        for c in range(math.floor((at - cutoff) * tilings) - 1, math.ceil((at + cutoff) * tilings) + 2):
            d = abs(at - c / tilings)
            if d < cutoff:
                found[(v, c)] = math.exp(-d * d / (2.0 * sigma * sigma))
    return found


class PlainSarsa:
    def __init__(self, n_actions: int, step: float, gamma: float, lambda_: float) -> None:
        self.n_actions, self.step_size, self.gamma, self.lambda_ = n_actions, step, gamma, lambda_
        self.weights: dict[Key, float] = defaultdict(float)
        self.traces: dict[Key, float] = {}
        self.last_value = 0.0

    def q(self, features: dict[Key, float], action: int) -> float:
        return sum(self.weights[(action, *key)] * value for key, value in features.items())

    def values(self, features: dict[Key, float]) -> list[float]:
        return [self.q(features, a) for a in range(self.n_actions)]

    def start(self, features: dict[Key, float], action: int) -> None:
        self.traces = {}
        self.last_value = self.q(features, action)
        self._mark(features, action)

    def step(self, reward: float, features: dict[Key, float], action: int) -> None:
        self._learn(reward + self.gamma * self.q(features, action) - self.last_value)
        self.last_value = self.q(features, action)
        factor = self.gamma * self.lambda_
        self.traces = {key: e * factor for key, e in self.traces.items() if e * factor >= 0.01}
        self._mark(features, action)

    def end(self, reward: float) -> None:
        self._learn(reward - self.last_value)

    def _mark(self, features: dict[Key, float], action: int) -> None:
        for key, value in features.items():
            for a in range(self.n_actions):
                if a != action:
                    self.traces.pop((a, *key), None)
            self.traces[(action, *key)] = max(self.traces.get((action, *key), 0.0), value)

    def _learn(self, delta: float) -> None:
        for key, e in self.traces.items():
            self.weights[key] += self.step_size * delta * e
