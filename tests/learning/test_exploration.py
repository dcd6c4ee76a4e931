from __future__ import annotations

import numpy as np
import pytest

from rcss_hat.learning.exploration import NO_ACTION, epsilon_greedy, greedy
from rcss_hat.numeric.rng import stream


def shares(q: list[float], n: int, epsilon: float = 0.0, favoured: int = NO_ACTION, bonus: float = 0.0) -> np.ndarray:
    rng, values = stream(3, 1), np.array(q)
    chosen = [epsilon_greedy(rng, values, n, epsilon, favoured, bonus) for _ in range(12_000)]
    return np.bincount(chosen, minlength=len(q)) / len(chosen)


def test_the_best_action_is_chosen_without_a_draw() -> None:
    rng = stream(3, 1)
    before = rng.copy()
    assert greedy(rng, np.array([1.0, 3.0, 2.0, 9.0]), 3, NO_ACTION, 0.0) == 1
    assert (rng == before).all()


def test_ties_are_broken_uniformly_also_after_an_improvement() -> None:
    # The players' tie counter is not reset by a better action, which would favour the earlier of two later ties.
    assert shares([0.0, 0.0, 5.0, 5.0, 5.0], 5) == pytest.approx([0, 0, 1 / 3, 1 / 3, 1 / 3], abs=0.02)


def test_zero_values_make_the_random_policy() -> None:
    assert shares([0.0, 0.0, 0.0], 3) == pytest.approx([1 / 3] * 3, abs=0.02)


def test_exploration_is_uniform_over_all_actions() -> None:
    assert shares([0.0, 1.0, 0.0], 3, epsilon=0.3) == pytest.approx([0.1, 0.8, 0.1], abs=0.02)


def test_the_favoured_action_counts_for_more() -> None:
    assert shares([0.0, 5.0, 4.0], 3, favoured=0, bonus=10.0).tolist() == [1.0, 0.0, 0.0]
    assert shares([0.0, 5.0, 4.0], 3, favoured=0, bonus=4.0).tolist() == [0.0, 1.0, 0.0]
    assert shares([0.0, 5.0, 4.0], 3, favoured=0, bonus=5.0) == pytest.approx([0.5, 0.5, 0.0], abs=0.02)
