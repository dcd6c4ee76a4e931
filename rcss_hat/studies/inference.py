"""Statistics in which participants are drawn at random from people: what is said holds for others, too.

The unit is the participant, never the game or the trial: of each there is one number, the mean of his games or trials.
Differences between groups of participants have bootstrap intervals over participants and Welch's test; differences
within participants are those of each participant, tested against zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from rcss_hat.experiments.statistics import Comparison, compare, compare_with_number

RESAMPLES = 10_000


@dataclass(frozen=True, slots=True)
class Components:
    """Where the variance of games comes from: a random-effects model with one random effect, the participant.

    Attributes
    ----------
    between, within : float
        Standard deviations: of participants' true means, and of a participant's games.
    icc : float
        Share of the variance that lies between participants.
    games : float
        Games per participant, as they count in unequal numbers.
    participants : int
    """

    between: float
    within: float
    icc: float
    games: float
    participants: int


def components(groups: Sequence[Sequence[ArrayLike]]) -> Components:
    """Estimate the components of variance by the method of moments (analysis of variance).

    Parameters
    ----------
    groups : sequence of sequence of array_like
        Games of every participant of every condition; conditions may have different means.

    Raises
    ------
    ValueError
        When no condition has two participants, or nobody has two games.
    """
    squares_between = squares_within = 0.0
    free_between = free_within = 0
    weight = 0.0
    for group in groups:
        games = [np.asarray(g, dtype=np.float64) for g in group]
        sizes = np.array([len(g) for g in games], dtype=np.float64)
        total = sizes.sum()
        if len(games) < 2:
            continue
        mean = sum(float(g.sum()) for g in games) / total
        squares_between += float(sum(len(g) * (g.mean() - mean) ** 2 for g in games))
        squares_within += float(sum(((g - g.mean()) ** 2).sum() for g in games))
        free_between += len(games) - 1
        free_within += int(total) - len(games)
        weight += total - float((sizes**2).sum()) / total
    if not free_between or not free_within:
        raise ValueError("components of variance need two participants of a condition with two games each")
    n = weight / free_between
    within = squares_within / free_within
    between = max(squares_between / free_between - within, 0.0) / n
    everything = between + within
    icc = between / everything if everything else math.nan
    participants = sum(len(group) for group in groups)
    return Components(math.sqrt(between), math.sqrt(within), icc, n, participants)


def between(values: Mapping[str, Sequence[float]], seed: int = 0) -> dict[tuple[str, str], Comparison]:
    """Compare every group of participants with every one after it; groups of one are left out."""
    names = [name for name, sample in values.items() if len(sample) > 1]
    return {(a, b): compare(values[a], values[b], seed) for k, a in enumerate(names) for b in names[k + 1 :]}


def within(values: Mapping[str, Mapping[str, float]], seed: int = 0) -> dict[tuple[str, str], Comparison]:
    """Compare conditions that the same participants met: values by condition and participant."""
    names, found = list(values), {}
    for k, a in enumerate(names):
        for b in names[k + 1 :]:
            both = [p for p in values[a] if p in values[b]]
            if len(both) > 1:
                found[a, b] = compare_with_number([values[a][p] - values[b][p] for p in both], 0.0, seed)
    return found


@dataclass(frozen=True, slots=True)
class Gain:
    """What learners gained by participants, over a baseline.

    Attributes
    ----------
    estimate, low, high : float
        Mean over participants minus the baseline's mean, with its 95 % interval.
    p : float
        That it is not zero: Welch's test of the participants' means against the baseline's trials.
    participants : int
    """

    estimate: float
    low: float
    high: float
    p: float
    participants: int


def gain(participants: Sequence[ArrayLike], baseline: ArrayLike, seed: int = 0) -> Gain:
    """Compare learners that were taught by participants with those that were not.

    The bootstrap draws participants, then trials of each, and trials of the baseline: participants are random, and so
    is what learning adds.

    Parameters
    ----------
    participants : sequence of array_like
        Trials of every participant.
    baseline : array_like
        Trials without a teacher.

    Raises
    ------
    ValueError
        For fewer than two participants or trials of the baseline.
    """
    trials = [np.asarray(t, dtype=np.float64) for t in participants]
    without = np.asarray(baseline, dtype=np.float64)
    if len(trials) < 2 or len(without) < 2:
        raise ValueError("a gain needs two participants and two trials of the baseline")
    means = np.array([t.mean() for t in trials])
    rng = np.random.default_rng(seed)
    drawn = np.empty(RESAMPLES)
    for k in range(RESAMPLES):
        chosen = rng.integers(len(trials), size=len(trials))
        mine = np.mean([trials[i][rng.integers(len(trials[i]), size=len(trials[i]))].mean() for i in chosen])
        drawn[k] = mine - without[rng.integers(len(without), size=len(without))].mean()
    low, high = np.quantile(drawn, [0.025, 0.975])
    test = stats.ttest_ind(means, without, equal_var=False)
    estimate = float(means.mean() - without.mean())
    return Gain(estimate, float(low), float(high), float(test.pvalue), len(trials))


def rank_correlation(x: ArrayLike, y: ArrayLike, seed: int = 0) -> tuple[float, float, float]:
    """Return Spearman's correlation over participants with its bootstrap 95 % interval.

    Raises
    ------
    ValueError
        For fewer than four participants.
    """
    a, b = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if len(a) < 4:
        raise ValueError("a correlation needs four participants")
    r = _spearman(a, b)
    if math.isnan(r):
        return r, r, r
    rng = np.random.default_rng(seed)
    drawn = [_spearman(a[rows], b[rows]) for rows in (rng.integers(len(a), size=len(a)) for _ in range(RESAMPLES // 5))]
    low, high = np.nanquantile(drawn, [0.025, 0.975])
    return r, float(low), float(high)


def _spearman(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    if np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return math.nan
    return float(np.corrcoef(stats.rankdata(a), stats.rankdata(b))[0, 1])
