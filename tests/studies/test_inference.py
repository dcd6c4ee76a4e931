"""Statistics over participants: what they find in data whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from rcss_hat.studies.inference import Components, between, components, gain, rank_correlation, within
from rcss_hat.studies.power import power_of


def test_components_of_variance_are_found_again() -> None:
    rng = np.random.default_rng(1)
    groups = [
        [mean + 2.0 * rng.standard_normal() + 3.0 * rng.standard_normal(20) for _ in range(200)] for mean in (8, 11)
    ]
    found = components(groups)
    assert found.between == pytest.approx(2.0, abs=0.2) and found.within == pytest.approx(3.0, abs=0.1)
    assert found.icc == pytest.approx(4 / 13, abs=0.05)
    assert found.games == pytest.approx(20) and found.participants == 400


def test_components_take_unequal_numbers_and_refuse_too_few() -> None:
    found = components([[[1.0, 3.0], [5.0, 7.0, 6.0]], [[2.0]]])
    assert found.games == pytest.approx(2.4)
    with pytest.raises(ValueError, match="two participants"):
        components([[[1.0, 2.0]], [[3.0]]])
    with pytest.raises(ValueError, match="two games"):
        components([[[1.0], [2.0]]])


def test_many_games_of_few_participants_are_no_evidence() -> None:
    """Two participants per group who differ as people do: a test over games would call it certain."""
    found = between({"a": [9.0, 12.0], "b": [7.5, 10.0]})
    assert found["a", "b"].p_welch > 0.3


def test_within_participants_the_differences_count() -> None:
    values = {"a": {"p1": 5.0, "p2": 15.0, "p3": 25.0}, "b": {"p1": 4.0, "p2": 13.9, "p3": 24.1, "p4": 0.0}}
    found = within(values)["a", "b"]
    assert found.n == 3 and found.difference == pytest.approx(1.0) and found.p_welch < 0.01


def test_gains_over_a_baseline_hold_for_other_participants() -> None:
    rng = np.random.default_rng(2)
    taught = [12.0 + rng.standard_normal() + 0.2 * rng.standard_normal(3) for _ in range(10)]
    found = gain(taught, 10.0 + 0.2 * rng.standard_normal(10), seed=3)
    means = [t.mean() for t in taught]
    assert found.low < found.estimate < found.high
    assert found.high - found.low == pytest.approx(3.92 * np.std(means, ddof=1) / np.sqrt(10), rel=0.25)
    assert found.p < 0.01 and found.participants == 10
    with pytest.raises(ValueError):
        gain(taught[:1], [1.0, 2.0])


def test_rank_correlation_is_spearmans() -> None:
    x = np.arange(12.0)
    r, low, high = rank_correlation(x, x**3)
    assert [r, low, high] == pytest.approx([1.0, 1.0, 1.0])
    assert np.isnan(rank_correlation(x, np.ones(12))[0])
    with pytest.raises(ValueError):
        rank_correlation([1, 2, 3], [1, 2, 3])


@pytest.mark.parametrize("design", ["between", "within"])
def test_power_is_the_level_without_a_difference_and_grows_with_participants(design: str) -> None:
    variance = Components(1.0, 4.0, 0.06, 16.0, 12)
    nothing = power_of({"a": 8.0, "b": 8.0}, variance, [10], 16, design)
    assert nothing[0].power == pytest.approx(0.05, abs=0.02)
    found = [p.power for p in power_of({"a": 9.0, "b": 8.0}, variance, [5, 20, 80], 16, design)]
    assert found == sorted(found) and found[-1] > 0.9


def test_power_agrees_with_the_textbook() -> None:
    """Two samples of 17 with a difference of one standard deviation have a power of 0.8."""
    variance = Components(1.0, 0.0, 1.0, 10.0, 12)
    assert power_of({"a": 1.0, "b": 0.0}, variance, [17], 10)[0].power == pytest.approx(0.8, abs=0.03)
