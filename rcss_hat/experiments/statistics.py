"""Comparing conditions: the paper's t-test, and what reviewers ask for today.

A sample is one number per trial. The paper compares every condition with No Prior by a two-sided Student t-test. Beside
it stand Welch's test with Holm's correction over all comparisons of a table, a bootstrap interval of the difference of
means, and Cliff's delta. Trials that share one set of demonstrations speak about that set only.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy import stats

BOOTSTRAPS = ("bca", "percentile")


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate and its confidence interval."""

    estimate: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class TTest:
    """A two-sided test: statistic, degrees of freedom, p-value."""

    statistic: float
    df: float
    p: float


def standard_error(values: ArrayLike) -> float:
    """Standard error of a mean; nan for fewer than two values."""
    sample = _sample(values, 1)
    return float(sample.std(ddof=1) / math.sqrt(sample.size)) if sample.size > 1 else math.nan


def mean_interval(values: ArrayLike, confidence: float = 0.95) -> Interval:
    """Mean and its confidence interval by Student's t; the interval is nan for a single value."""
    sample = _sample(values, 1)
    mean = float(sample.mean())
    if sample.size == 1:
        return Interval(mean, math.nan, math.nan)
    half = float(stats.t.ppf(0.5 + confidence / 2.0, sample.size - 1)) * standard_error(sample)
    return Interval(mean, mean - half, mean + half)


def ci95(values: ArrayLike) -> float:
    """Half width of the 95 % interval of a mean by Student's t; nan for a single value."""
    interval = mean_interval(values)
    return interval.high - interval.estimate


def student_t(a: ArrayLike, b: ArrayLike) -> TTest:
    """Test whether two independent samples have the same mean, assuming equal variances.

    Raises
    ------
    ValueError
        For fewer than two values in a sample.
    """
    return _t_test(a, b, equal_variances=True)


def welch_t(a: ArrayLike, b: ArrayLike) -> TTest:
    """Test whether two independent samples have the same mean, whatever their variances; see `student_t`."""
    return _t_test(a, b, equal_variances=False)


def holm(p_values: ArrayLike) -> NDArray[np.float64]:
    """Adjust p-values for multiple comparisons by Holm's step-down method.

    Parameters
    ----------
    p_values : array_like, shape (k,)

    Returns
    -------
    ndarray of float64, shape (k,)
        In the same order; compare them with the level of significance.
    """
    p = np.asarray(p_values, dtype=np.float64)
    order = np.argsort(p, kind="stable")
    stepped = p[order] * (p.size - np.arange(p.size))
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(stepped))
    return adjusted


def bootstrap_difference(
    a: ArrayLike,
    b: ArrayLike,
    seed: int = 0,
    confidence: float = 0.95,
    resamples: int = 10_000,
    method: str = "bca",
) -> Interval:
    """Difference of means ``mean(a) - mean(b)`` with its bootstrap confidence interval.

    Parameters
    ----------
    a, b : array_like
        Independent samples, resampled each for itself.
    seed : int
        Decides the resampling.
    confidence : float
    resamples : int
    method : {"bca", "percentile"}
        Bias-corrected and accelerated, or plain percentiles.

    Raises
    ------
    ValueError
        For fewer than two values in a sample, or an unknown method.
    """
    if method not in BOOTSTRAPS:
        raise ValueError(f"bootstrap method must be one of {', '.join(BOOTSTRAPS)}, not {method!r}")
    first, second = _sample(a, 2), _sample(b, 2)
    difference = float(first.mean() - second.mean())
    if _is_constant(first) and _is_constant(second):
        return Interval(difference, difference, difference)
    found = stats.bootstrap(
        (first, second),
        lambda x, y, axis: x.mean(axis=axis) - y.mean(axis=axis),
        n_resamples=resamples,
        confidence_level=confidence,
        method={"bca": "BCa", "percentile": "percentile"}[method],
        rng=np.random.default_rng(seed),
        vectorized=True,
    ).confidence_interval
    return Interval(difference, float(found.low), float(found.high))


def cliffs_delta(a: ArrayLike, b: ArrayLike) -> float:
    """Share of pairs in which a is greater, minus the share in which it is smaller: from -1 to 1."""
    first, second = _sample(a, 1), _sample(b, 1)
    return float(np.sign(first[:, None] - second[None, :]).mean())


def hedges_g(a: ArrayLike, b: ArrayLike) -> float:
    """Difference of means in pooled standard deviations, corrected for small samples (Hedges 1981).

    Infinite for different samples without variance, 0 for equal ones.
    """
    first, second = _sample(a, 2), _sample(b, 2)
    difference, degrees = float(first.mean() - second.mean()), first.size + second.size - 2
    squares = float(((first - first.mean()) ** 2).sum() + ((second - second.mean()) ** 2).sum())
    if _is_constant(first) and _is_constant(second):
        return _standardised(float(first[0] - second[0]), 0.0, degrees)
    return _standardised(difference, math.sqrt(squares / degrees), degrees)


def probability_of_improvement(a: ArrayLike, b: ArrayLike) -> float:
    """Probability that a random value of a exceeds one of b, ties counting half."""
    return (cliffs_delta(a, b) + 1.0) / 2.0


@dataclass(frozen=True, slots=True)
class Comparison:
    """A condition against the baseline.

    Attributes
    ----------
    n, n_baseline : int
        Trials.
    mean, standard_error : float
        Of the condition.
    difference, low, high : float
        Of means, with its 95 % bootstrap interval.
    p_student, p_welch : float
        Two-sided, not corrected for the number of comparisons.
    hedges_g, cliffs_delta, p_improvement : float
        Sizes of the effect, see the functions of those names.
    """

    n: int
    n_baseline: int
    mean: float
    standard_error: float
    difference: float
    low: float
    high: float
    p_student: float
    p_welch: float
    hedges_g: float
    cliffs_delta: float
    p_improvement: float


def compare(values: ArrayLike, baseline: ArrayLike, seed: int = 0, method: str = "bca") -> Comparison:
    """Compare a condition with the baseline; ``seed`` and ``method`` are those of `bootstrap_difference`.

    Raises
    ------
    ValueError
        For fewer than two trials of either.
    """
    interval = bootstrap_difference(values, baseline, seed, method=method)
    sample = _sample(values, 2)
    return Comparison(
        n=sample.size,
        n_baseline=_sample(baseline, 2).size,
        mean=float(sample.mean()),
        standard_error=standard_error(sample),
        difference=interval.estimate,
        low=interval.low,
        high=interval.high,
        p_student=student_t(values, baseline).p,
        p_welch=welch_t(values, baseline).p,
        hedges_g=hedges_g(values, baseline),
        cliffs_delta=cliffs_delta(values, baseline),
        p_improvement=probability_of_improvement(values, baseline),
    )


def compare_with_number(values: ArrayLike, number: float, seed: int = 0) -> Comparison:
    """Compare a condition with a number that is known without error, such as the mean of a teacher's demonstrations.

    The t-test is that for one sample, in place of both Student's and Welch's; ``n_baseline`` is 1.

    Raises
    ------
    ValueError
        For fewer than two trials.
    """
    sample = _sample(values, 2)
    difference, deviation = float(sample.mean()) - number, float(sample.std(ddof=1))
    if _is_constant(sample):
        same = _is_constant(np.append(sample, number))
        p, low, high, deviation = (1.0 if same else 0.0), difference, difference, 0.0
    else:
        p = float(stats.ttest_1samp(sample, number).pvalue)
        rng = np.random.default_rng(seed)
        found = stats.bootstrap((sample,), np.mean, n_resamples=10_000, method="BCa", rng=rng).confidence_interval
        low, high = float(found.low) - number, float(found.high) - number
    return Comparison(
        n=sample.size,
        n_baseline=1,
        mean=float(sample.mean()),
        standard_error=standard_error(sample),
        difference=difference,
        low=low,
        high=high,
        p_student=p,
        p_welch=p,
        hedges_g=_standardised(difference, deviation, sample.size - 1),
        cliffs_delta=cliffs_delta(sample, [number]),
        p_improvement=probability_of_improvement(sample, [number]),
    )


def comparison_table(samples: Mapping[str, ArrayLike], baseline: str, seed: int = 0) -> pd.DataFrame:
    """Compare every condition of a table with one of them.

    Parameters
    ----------
    samples : mapping of str to array_like
        One number per trial, by condition.
    baseline : str
        A key of ``samples``.
    seed : int

    Returns
    -------
    DataFrame
        Index: the other conditions, in order. Columns: the attributes of `Comparison`, and ``p_holm``, Welch's p-value
        corrected for all comparisons of the table.

    Raises
    ------
    ValueError
        When the baseline is not among the conditions, or a condition has fewer than two trials.
    """
    if baseline not in samples:
        raise ValueError(f"no condition {baseline!r} to compare with; there are {', '.join(samples)}")
    rows: dict[str, dict[str, Any]] = {}
    for name, values in samples.items():
        if name != baseline:
            rows[name] = asdict(compare(values, samples[baseline], seed))
    columns = list(Comparison.__dataclass_fields__)
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    table["p_holm"] = holm(table["p_welch"].to_numpy(dtype=np.float64))
    return table


def _standardised(difference: float, deviation: float, degrees: int) -> float:
    """Return a difference in standard deviations, corrected for small samples; infinite without deviation."""
    if deviation == 0.0:
        return math.copysign(math.inf, difference) if difference != 0.0 else 0.0
    return difference / deviation * (1.0 - 3.0 / (4.0 * degrees - 1.0))


def _t_test(a: ArrayLike, b: ArrayLike, equal_variances: bool) -> TTest:
    first, second = _sample(a, 2), _sample(b, 2)
    if _is_constant(first) and _is_constant(second):  # no variance at all: the test has no answer, the eye has
        same = _is_constant(np.concatenate([first, second]))
        statistic = 0.0 if same else math.copysign(math.inf, first[0] - second[0])
        return TTest(statistic, float(first.size + second.size - 2), 1.0 if same else 0.0)
    with warnings.catch_warnings():  # one may be constant: its variance is nothing then, which is right
        warnings.filterwarnings("ignore", "Precision loss", RuntimeWarning)
        result = stats.ttest_ind(first, second, equal_var=equal_variances)
    return TTest(float(result.statistic), float(result.df), float(result.pvalue))


def _sample(values: ArrayLike, at_least: int) -> NDArray[np.float64]:
    sample = np.asarray(values, dtype=np.float64).ravel()
    if sample.size < at_least or not np.isfinite(sample).all():
        raise ValueError(f"a sample needs at least {at_least} finite numbers, not {sample.tolist()}")
    return sample


def _is_constant(sample: NDArray[np.float64]) -> bool:
    return bool(np.ptp(sample) <= 1e-12 * np.abs(sample).max())  # what rounding leaves is no variance
