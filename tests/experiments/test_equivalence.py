"""Two one-sided tests and bands of differences, against textbook values and simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rcss_hat.experiments.equivalence import difference_band, equivalence
from rcss_hat.experiments.metrics import Curves


def test_two_samples_are_tested_as_by_two_welch_tests() -> None:
    rng = np.random.default_rng(4)
    a, b, margin = rng.normal(10.0, 1.0, 3), rng.normal(10.2, 0.4, 10), 1.5
    found = equivalence([(1, a), (-1, b)], margin)
    above = stats.ttest_ind(a + margin, b, equal_var=False, alternative="greater")
    below = stats.ttest_ind(a - margin, b, equal_var=False, alternative="less")
    assert found.p == pytest.approx(max(above.pvalue, below.pvalue))
    interval = stats.ttest_ind(a, b, equal_var=False).confidence_interval(0.90)
    assert (found.low, found.high) == pytest.approx((interval.low, interval.high))
    assert found.difference == pytest.approx(a.mean() - b.mean())


@pytest.mark.parametrize("margin", [0.2, 0.8, 1.6, 3.0])
def test_it_holds_when_the_interval_lies_within_the_margin(margin: float) -> None:
    rng = np.random.default_rng(7)
    for _ in range(200):
        a, b = rng.normal(0.3, 1.0, 5), rng.normal(0.0, 0.7, 8)
        found = equivalence([(1, a), (-1, b)], margin)
        assert found.holds == (-margin < found.low and found.high < margin)


def test_stages_that_differ_by_the_margin_are_called_equivalent_as_often_as_the_level_says() -> None:
    rng, margin, n = np.random.default_rng(1), 1.0, 4000
    held = sum(
        equivalence([(1, rng.normal(margin, 0.5, 4)), (-1, rng.normal(0.0, 0.5, 10))], margin).holds for _ in range(n)
    )
    assert 0.035 < held / n < 0.065


def test_a_difference_of_differences_has_the_variance_of_all_four() -> None:
    rng = np.random.default_rng(2)
    a, b, c, d = (rng.normal(m, 1.0, n) for m, n in ((9, 3), (5, 4), (9, 10), (5, 12)))
    found = equivalence([(1, a), (-1, b), (-1, c), (1, d)], 2.0)
    error = np.sqrt(sum(x.var(ddof=1) / len(x) for x in (a, b, c, d)))
    assert found.difference == pytest.approx(a.mean() - b.mean() - c.mean() + d.mean())
    assert 2 * error * 1.6 < found.high - found.low < 2 * error * 2.4


def test_samples_without_variance_and_impossible_ones() -> None:
    assert equivalence([(1, [5.0, 5.0]), (-1, [5.0, 5.0, 5.0])], 0.1).holds
    assert not equivalence([(1, [5.0, 5.0]), (-1, [6.0, 6.0])], 1.0).holds
    for terms, margin in (([(1, [1.0])], 1.0), ([(1, [1.0, np.nan])], 1.0), ([(1, [1.0, 2.0])], 0.0)):
        with pytest.raises(ValueError, match=r"at least two finite|a margin is more than 0"):
            equivalence(terms, margin)


def test_a_band_is_welchs_interval_at_every_hour() -> None:
    rng, hours = np.random.default_rng(3), np.array([1.0, 2.0, 3.0])
    a, b = Curves(hours, rng.normal(8.0, 1.0, (3, 3))), Curves(hours, rng.normal(7.0, 0.5, (10, 3)))
    band = difference_band(a, b)
    for k in range(3):
        interval = stats.ttest_ind(a.trials[:, k], b.trials[:, k], equal_var=False).confidence_interval(0.95)
        assert (band.low[k], band.high[k]) == pytest.approx((interval.low, interval.high))
    with pytest.raises(ValueError, match="different hours"):
        difference_band(a, Curves(hours + 1.0, b.trials))
    with pytest.raises(ValueError, match="two trials"):
        difference_band(Curves(hours, a.trials[:1]), b)
