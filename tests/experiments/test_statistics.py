from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from scipy import stats

from rcss_hat.experiments import statistics as st

A, B = [1.0, 2.0, 3.0, 6.0], [4.0, 5.0, 9.0]


def test_student_t_by_hand() -> None:
    # Means 3 and 6; sums of squares 14 and 14; pooled variance 28 / 5.
    result = st.student_t(A, B)
    assert result.df == 5
    assert result.statistic == pytest.approx(-3.0 / math.sqrt(28 / 5 * (1 / 4 + 1 / 3)))
    # With 2 degrees of freedom the distribution has a closed form: p = 1 - |t| / sqrt(2 + t^2).
    two = st.student_t([0.0, 2.0], [3.0, 7.0])
    assert two.statistic == pytest.approx(-4.0 / math.sqrt(5.0))
    assert two.p == pytest.approx(1.0 - 4.0 / math.sqrt(5.0) / math.sqrt(2.0 + 16.0 / 5.0))


def test_welch_t_by_hand() -> None:
    result = st.welch_t(A, B)
    va, vb = 14 / 3 / 4, 14 / 2 / 3
    assert result.statistic == pytest.approx(-3.0 / math.sqrt(va + vb))
    assert result.df == pytest.approx((va + vb) ** 2 / (va**2 / 3 + vb**2 / 2))
    assert 0.1 < result.p < 0.3


def test_t_tests_without_variance() -> None:
    assert st.student_t([1.0, 1.0], [1.0, 1.0]).p == 1.0
    assert st.welch_t([1.0, 1.0], [2.0, 2.0, 2.0]).p == 0.0
    assert st.welch_t([1.0, 1.0], [2.0, 2.0]).statistic == -math.inf


def test_false_alarms_are_as_frequent_as_they_should_be() -> None:
    random = np.random.default_rng(2)
    samples = random.normal(14.0, 0.5, (600, 2, 10))
    for test in (st.student_t, st.welch_t):
        assert np.mean([test(a, b).p < 0.05 for a, b in samples]) == pytest.approx(0.05, abs=0.025)


def test_holm_by_hand() -> None:
    assert st.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert st.holm([0.6, 0.7]).tolist() == [1.0, 1.0]
    assert st.holm([0.02]).tolist() == [0.02]
    assert st.holm([]).shape == (0,)


def test_standard_error_and_interval_of_a_mean() -> None:
    assert st.standard_error([1.0, 3.0]) == 1.0
    assert math.isnan(st.standard_error([1.0]))
    interval = st.mean_interval([1.0, 3.0])
    # One degree of freedom is the Cauchy distribution: its 97.5 % point is tan(0.475 pi).
    assert interval.estimate == 2.0
    assert interval.high - 2.0 == 2.0 - interval.low == pytest.approx(math.tan(0.475 * math.pi))
    assert st.ci95([1.0, 3.0]) == pytest.approx(math.tan(0.475 * math.pi))
    assert math.isnan(st.ci95([5.0]))
    assert st.ci95(np.random.default_rng(0).normal(size=4000)) == pytest.approx(1.96 / math.sqrt(4000), rel=0.05)


@pytest.mark.parametrize("method", ["bca", "percentile"])
def test_bootstrap_interval(method: str) -> None:
    random = np.random.default_rng(1)
    a, b = random.normal(15.0, 0.5, 40), random.normal(14.0, 0.5, 40)
    found = st.bootstrap_difference(a, b, seed=3, method=method)
    assert found.estimate == pytest.approx(a.mean() - b.mean())
    half = 1.96 * math.sqrt(a.var(ddof=1) / 40 + b.var(ddof=1) / 40)
    assert (found.low, found.high) == pytest.approx((found.estimate - half, found.estimate + half), abs=0.03)
    assert found == st.bootstrap_difference(a, b, seed=3, method=method)
    assert found != st.bootstrap_difference(a, b, seed=4, method=method)


def test_bootstrap_intervals_hold_the_true_difference_about_as_often_as_they_say() -> None:
    random = np.random.default_rng(5)
    hits = 0
    for trial in range(200):
        a, b = random.normal(1.0, 1.0, 20), random.normal(0.0, 1.0, 20)
        found = st.bootstrap_difference(a, b, seed=trial, resamples=600)
        hits += found.low <= 1.0 <= found.high
    assert 0.88 <= hits / 200 <= 0.99


def test_what_rounding_leaves_is_no_variance() -> None:
    third = [0.1 + 0.2, 0.3, 0.3]
    assert st.student_t(third, [0.3, 0.3]).p == st.welch_t(third, [0.3, 0.3]).p == 1.0
    assert st.compare_with_number(third, 0.3).p_welch == 1.0
    assert st.welch_t(third, [0.4, 0.4]).p == 0.0


def test_a_constant_sample_is_compared_with_one_that_varies_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = st.welch_t([0.81] * 4, [0.8, 0.83, 0.79, 0.9])
    wanted = stats.ttest_1samp([0.8, 0.83, 0.79, 0.9], 0.81)
    assert found.p == pytest.approx(wanted.pvalue)


def test_bootstrap_without_variance() -> None:
    found = st.bootstrap_difference([2.0, 2.0], [1.0, 1.0])
    assert (found.estimate, found.low, found.high) == (1.0, 1.0, 1.0)
    one_sided = st.bootstrap_difference([2.0, 2.0, 2.0], [1.0, 1.5, 2.0])
    assert 0.0 <= one_sided.low < 0.5 < one_sided.high <= 1.0


def test_cliffs_delta_and_probability_of_improvement() -> None:
    assert st.cliffs_delta([1.0, 2.0], [3.0, 4.0]) == -1.0
    assert st.cliffs_delta([1.0, 4.0], [2.0, 3.0]) == 0.0
    assert st.cliffs_delta([3.0, 4.0], [3.0, 0.0]) == pytest.approx(3 / 4)
    assert st.probability_of_improvement([3.0, 4.0], [3.0, 0.0]) == pytest.approx((3 + 0.5) / 4)


def test_hedges_g_by_hand() -> None:
    # variances 1 and 1, so that the difference of 2 is two standard deviations; 4 degrees of freedom
    assert st.hedges_g([3.0, 4.0, 5.0], [1.0, 2.0, 3.0]) == pytest.approx(2.0 * (1.0 - 3.0 / 15.0))
    assert st.hedges_g([1.0, 1.0], [1.0, 1.0]) == 0.0
    assert st.hedges_g([1.0, 1.0], [2.0, 2.0]) == -math.inf


def test_a_number_known_without_error() -> None:
    found = st.compare_with_number([11.0, 12.0, 13.0], 10.0, seed=1)
    assert found.difference == pytest.approx(2.0) and found.n_baseline == 1
    # t = 2 / (1 / sqrt 3) with 2 degrees of freedom, of which the distribution is known: p = 1 - t / sqrt(2 + t^2)
    t = 2.0 * math.sqrt(3.0)
    assert found.p_student == pytest.approx(1.0 - t / math.sqrt(2.0 + t * t))
    assert 1.0 <= found.low < 2.0 < found.high <= 3.0
    assert found.hedges_g == pytest.approx(2.0 * (1.0 - 3.0 / 7.0))
    assert found.p_improvement == 1.0
    same = st.compare_with_number([10.0, 10.0], 10.0)
    assert (same.p_student, same.difference, same.hedges_g) == (1.0, 0.0, 0.0)
    assert st.compare_with_number([11.0, 11.0], 10.0).p_student == 0.0


def test_a_table_of_comparisons() -> None:
    random = np.random.default_rng(8)
    samples = {
        "no-prior": random.normal(380.0, 6.0, 10),
        "ppr": random.normal(411.0, 6.0, 10),
        "same": random.normal(380.0, 6.0, 10),
    }
    table = st.comparison_table(samples, "no-prior", seed=1)
    assert list(table.index) == ["ppr", "same"]
    assert table.loc["ppr", "difference"] == pytest.approx(samples["ppr"].mean() - samples["no-prior"].mean())
    assert table.loc["ppr", "p_holm"] == pytest.approx(2 * table.loc["ppr", "p_welch"])
    assert table.loc["same", "p_holm"] == pytest.approx(table.loc["same", "p_welch"])
    assert table.loc["ppr", "p_holm"] < 0.001 < 0.05 < table.loc["same", "p_holm"]
    assert table.loc["ppr", "low"] > 20.0 and table.loc["ppr", "high"] < 42.0
    assert table.loc["same", "low"] < 0.0 < table.loc["same", "high"]
    assert (table["n"] == 10).all()
    assert table.equals(st.comparison_table(samples, "no-prior", seed=1))
    assert st.comparison_table({"a": [1.0, 2.0]}, "a").empty


def test_mistakes_are_named() -> None:
    with pytest.raises(ValueError, match="at least 2 finite numbers, not"):
        st.student_t([1.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="at least 1 finite numbers"):
        st.cliffs_delta([], [1.0])
    with pytest.raises(ValueError, match="finite"):
        st.standard_error([math.nan, 1.0])
    with pytest.raises(ValueError, match="one of bca, percentile, not 'basic'"):
        st.bootstrap_difference(A, B, method="basic")
    with pytest.raises(ValueError, match="no condition 'x' to compare with; there are a"):
        st.comparison_table({"a": A}, "x")
