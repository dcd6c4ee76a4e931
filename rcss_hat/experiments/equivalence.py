"""Testing that two stages are the same game: two one-sided tests, and the difference of learning curves with a band.

That a difference is not significant does not show that there is none. Equivalence is shown when the data rule out, at
the level of significance, that the difference is as large as a margin that was stated beforehand (Schuirmann 1987).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from rcss_hat.experiments.metrics import Curves

LEVEL = 0.05


@dataclass(frozen=True, slots=True)
class Equivalence:
    """Two one-sided tests (TOST).

    Attributes
    ----------
    difference : float
    low, high : float
        90 % interval of the difference: equivalent at the level of 5 % when it lies within the margin.
    margin : float
    p : float
        The greater of the two tests' p-values.
    """

    difference: float
    low: float
    high: float
    margin: float
    p: float

    @property
    def holds(self) -> bool:
        """Whether the difference is shown to be smaller than the margin."""
        return self.p < LEVEL


@dataclass(frozen=True, slots=True)
class Band:
    """The difference of two mean learning curves, with its pointwise 95 % interval; arrays of shape (k,)."""

    hours: NDArray[np.float64]
    difference: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def equivalence(terms: Sequence[tuple[float, ArrayLike]], margin: float) -> Equivalence:
    """Test whether a sum of weighted means is equivalent to 0.

    Variances may differ (Welch's test, degrees of freedom after Satterthwaite).

    Parameters
    ----------
    terms : sequence of (float, array_like)
        Weights and independent samples: ``[(1, a), (-1, b)]`` for the difference of two means.
    margin : float
        Greatest absolute value that counts as no difference.

    Raises
    ------
    ValueError
        For fewer than two finite numbers in a sample, or a margin that is not more than 0.

    Examples
    --------
    >>> equivalence([(1, [10.1, 9.9, 10.0]), (-1, [10.0, 10.1, 9.9, 10.0])], margin=0.5).holds
    True
    >>> equivalence([(1, [10.0, 12.0]), (-1, [9.0, 11.0])], margin=0.5).holds
    False
    """
    if not margin > 0.0:
        raise ValueError(f"a margin is more than 0, not {margin!r}")
    estimate, variances, degrees = 0.0, [], []
    for weight, values in terms:
        sample = np.asarray(values, dtype=np.float64)
        if len(sample) < 2 or not np.isfinite(sample).all():
            raise ValueError("a test of equivalence needs at least two finite numbers in every sample")
        estimate += weight * float(sample.mean())
        variances.append(weight**2 * float(sample.var(ddof=1)) / len(sample))
        degrees.append(len(sample) - 1)
    error, df = _welch(variances, degrees)
    if error == 0.0:
        return Equivalence(estimate, estimate, estimate, margin, 0.0 if abs(estimate) < margin else 1.0)
    p = max(float(stats.t.sf((estimate + margin) / error, df)), float(stats.t.cdf((estimate - margin) / error, df)))
    half = float(stats.t.ppf(1.0 - LEVEL, df)) * error
    return Equivalence(estimate, estimate - half, estimate + half, margin, p)


def difference_band(a: Curves, b: Curves) -> Band:
    """Return the difference of two conditions' mean curves (Welch's interval at every hour).

    Raises
    ------
    ValueError
        When they are not over the same hours, or either has a single trial.
    """
    if not np.array_equal(a.hours, b.hours):
        raise ValueError("curves over different hours have no difference")
    if min(len(a.trials), len(b.trials)) < 2:
        raise ValueError("a band needs at least two trials of either")
    difference = a.mean - b.mean
    half = np.empty_like(difference)
    degrees = [len(a.trials) - 1, len(b.trials) - 1]
    for k, (x, y) in enumerate(zip(a.trials.T, b.trials.T, strict=True)):
        error, df = _welch([float(x.var(ddof=1)) / len(x), float(y.var(ddof=1)) / len(y)], degrees)
        half[k] = float(stats.t.ppf(1.0 - LEVEL / 2.0, df)) * error if error > 0.0 else 0.0
    return Band(a.hours, difference, difference - half, difference + half)


def _welch(variances: Sequence[float], degrees: Sequence[int]) -> tuple[float, float]:
    """Return the standard error of a sum of means, and Satterthwaite's degrees of freedom."""
    total = math.fsum(variances)
    shares = math.fsum(v**2 / n for v, n in zip(variances, degrees, strict=True))
    return math.sqrt(total), total**2 / shares if shares > 0.0 else math.inf
