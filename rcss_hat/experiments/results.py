"""What the trials of an experiment say: one number per trial and measure, comparisons, and verdicts on claims."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rcss_hat.experiments import metrics
from rcss_hat.experiments.experiment import Experiment
from rcss_hat.experiments.statistics import Comparison, compare, compare_with_number, comparison_table
from rcss_hat.experiments.study_parts import Claim, ClaimTest
from rcss_hat.experiments.trial_records import TrialRecord

MEASURES = {
    "jumpstart": "Jumpstart",
    "final": "Final",
    "total": "Total Reward",
    "greedy": "Without exploration",
    "early": "First 1,000 episodes",
}
"""Measures by name, with the words of the paper where it has them; seconds, total reward seconds summed over hours."""
SIGNIFICANT = 0.05
CURVE_STEP = 0.25
"""Simulated hours between the points of a drawn learning curve."""
BELOW_BASELINE = 0.3
"""The threshold of the time-to-threshold measure lies so much (s) below the baseline's final reward, as the paper's."""
REPRODUCED, NOT_REPRODUCED, DIFFERENT, UNTESTED = "reproduced", "not reproduced", "different", "not tested"


@dataclass(frozen=True, slots=True)
class Evidence:
    """One comparison behind a claim.

    Attributes
    ----------
    test : ClaimTest
    condition, than : str
        Conditions; ``than`` is a demonstration set where the test names teachers.
    comparison : Comparison or None
        None with fewer than two trials of either.
    holds : bool or None
    """

    test: ClaimTest
    condition: str
    than: str
    comparison: Comparison | None
    holds: bool | None


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a claim: reproduced (all comparisons hold), not reproduced (none does), different (some do)."""

    claim: Claim
    verdict: str
    evidence: tuple[Evidence, ...]


class Results:
    """The finished trials of an experiment.

    Parameters
    ----------
    experiment : Experiment

    Attributes
    ----------
    trials : dict of str to list of TrialRecord
        By condition; conditions without a finished trial are left out.
    left_out : dict of str to list of TrialRecord
        Trials that are not pooled with the others, because of what happened on their servers.
    """

    def __init__(self, experiment: Experiment) -> None:
        self.experiment, self.study = experiment, experiment.study
        self.trials: dict[str, list[TrialRecord]] = {}
        self.left_out: dict[str, list[TrialRecord]] = {}
        for name in self.study.conditions:
            for record in experiment.trials(name):
                sound = pooled(record, self.study.missed_at_most)
                (self.trials if sound else self.left_out).setdefault(name, []).append(record)
        self._samples: dict[tuple[str, str], NDArray[np.float64]] = {}

    @property
    def baseline(self) -> str | None:
        """The condition the others are compared with, when it has trials."""
        return self.study.baseline if self.study.baseline in self.trials else None

    def baseline_of(self, condition: str) -> str | None:
        """Return the condition that another one is compared with, when it has trials."""
        baseline = self.study.baseline_of(condition)
        return baseline if baseline in self.trials else None

    def label(self, condition: str) -> str:
        """What people call a condition."""
        return self.study.conditions[condition].label

    def seeds(self, condition: str) -> list[int]:
        """Seeds of the finished trials of a condition."""
        return [record.result["seed"] for record in self.trials[condition]]

    # -- measures ----------------------------------------------------------------------------------------------------
    def sample(self, condition: str, measure: str) -> NDArray[np.float64]:
        """Return one number per trial, in seconds; nan where the condition has no such measure.

        Parameters
        ----------
        condition : str
        measure : str
            A key of `MEASURES`, or ``hours``: when the trial reaches `threshold_of`, or, where it never does, the hours
            that it had. For ``jumpstart`` it is the mean duration of the initial policy, from which
            `difference` makes the jumpstart.
        """
        key = condition, measure
        if key not in self._samples:
            records = self.trials[condition]
            threshold = self.threshold_of(condition) if measure == "hours" else None
            values = [_hours(r, threshold) if measure == "hours" else _measure(r, measure) for r in records]
            self._samples[key] = np.array(values, dtype=np.float64)
        return self._samples[key]

    def value(self, condition: str, measure: str) -> tuple[float, float]:
        """Return a measure's mean over trials and its standard error; the jumpstart is relative to the baseline.

        ``initial`` is the duration of the initial policy itself.
        """
        sample = self.sample(condition, "jumpstart" if measure == "initial" else measure)
        mean = float(sample.mean())
        error = float(sample.std(ddof=1) / math.sqrt(len(sample))) if len(sample) > 1 else math.nan
        if measure != "jumpstart":
            return mean, error
        baseline = self.baseline_of(condition)
        if baseline is None or condition == baseline:
            return math.nan, math.nan
        return mean - float(self.sample(baseline, measure).mean()), error

    def frame(self) -> pd.DataFrame:
        """Return all measures of all trials: columns condition, trial, seed, episodes, initial and the measures."""
        rows = []
        for name, records in self.trials.items():
            for k, record in enumerate(records):
                row: dict[str, Any] = {
                    "condition": name,
                    **{x: record.result[x] for x in ("trial", "seed", "episodes")},
                }
                row["initial"] = self.sample(name, "jumpstart")[k]
                row |= {measure: self.sample(name, measure)[k] for measure in MEASURES if measure != "jumpstart"}
                rows.append(row)
        return pd.DataFrame(rows)

    # -- comparisons -------------------------------------------------------------------------------------------------
    def comparisons(self, conditions: Sequence[str], measure: str) -> pd.DataFrame:
        """Compare conditions with the baseline; empty when there is none, or there are fewer than two trials.

        Returns
        -------
        DataFrame
            See `rcss_hat.experiments.statistics.comparison_table`.
        """
        known = [c for c in conditions if c in self.trials]
        baseline = self.baseline_of(known[0]) if known else None
        if baseline is None:
            return pd.DataFrame()
        names = [baseline, *(c for c in known if c != baseline)]
        samples = {name: self.sample(name, measure) for name in names}
        samples = {name: s for name, s in samples.items() if len(s) > 1 and np.isfinite(s).all()}
        if baseline not in samples or len(samples) < 2:
            return pd.DataFrame()
        return comparison_table(samples, baseline, self.study.seed)

    def verdicts(self) -> list[Verdict]:
        """Judge the study's claims."""
        return [self._verdict(claim) for claim in self.study.claims]

    def _verdict(self, claim: Claim) -> Verdict:
        evidence = tuple(
            self._evidence(test, condition, than)
            for test in claim.tests
            for condition in test.conditions
            for than in (*test.than, *test.teachers)
        )
        held = [e.holds for e in evidence]
        if None in held:
            return Verdict(claim, UNTESTED, evidence)
        verdict = REPRODUCED if all(held) else DIFFERENT if any(held) else NOT_REPRODUCED
        return Verdict(claim, verdict, evidence)

    def _evidence(self, test: ClaimTest, condition: str, than: str) -> Evidence:
        comparison = None
        if test.teachers:
            mean = self.experiment.sets.prepare(than).figures.get("mean_s")
            if condition in self.trials and mean is not None:
                comparison = _against_number(self.sample(condition, test.metric), mean, self.study.seed)
        elif condition in self.trials and than in self.trials:
            others = self.sample(than, test.than_metric or test.metric)
            comparison = _against_sample(self.sample(condition, test.metric), others, self.study.seed)
        holds = None if comparison is None else claim_holds(test.test, comparison)
        return Evidence(test, condition, than, comparison, holds)

    # -- curves ------------------------------------------------------------------------------------------------------
    def curves(self, condition: str) -> metrics.Curves | None:
        """Return the learning curves of a condition; None when it does not learn."""
        logs = [record.log for record in self.trials[condition] if record.log is not None]
        if not logs:
            return None
        hours = self.study.conditions[condition].hours
        return metrics.learning_curves(logs, _curve_hours(hours))

    def threshold_of(self, condition: str) -> float | None:
        """Return the seconds that `hours_to_threshold` measures the way to; None without a baseline that learned."""
        baseline = self.baseline_of(condition)
        if baseline is None:
            return None
        final = self.value(baseline, "final")[0]
        return None if math.isnan(final) else round(final - BELOW_BASELINE, 1)

    @cached_property
    def threshold(self) -> float | None:
        """The threshold of the study's baseline."""
        return None if self.baseline is None else self.threshold_of(self.baseline)

    def hours_to_threshold(self, condition: str) -> float:
        """Return when the mean learning curve, of full windows only, reaches the threshold; nan: never."""
        curves, threshold = self.curves(condition), self.threshold_of(condition)
        if curves is None or threshold is None:
            return math.nan
        full = max(_full_window(record.log) for record in self.trials[condition] if record.log is not None)
        reached = (curves.mean >= threshold) & (curves.hours >= full)
        return float(curves.hours[reached.argmax()]) if reached.any() else math.nan


def pooled(record: TrialRecord, missed_at_most: float) -> bool:
    """Whether a trial may be pooled with others: its players heard every end of an episode, and missed few cycles."""
    servers = record.result.get("servers")
    return servers is None or (servers["unheard"] == 0 and servers["missed_share"] <= missed_at_most)


def claim_holds(test: str, comparison: Comparison) -> bool:
    """Decide a comparison by the paper's test: two-sided Student t, p < 0.05."""
    significant = comparison.p_student < SIGNIFICANT
    higher, lower = significant and comparison.difference > 0, significant and comparison.difference < 0
    return {
        "higher": higher,
        "lower": lower,
        "similar": not significant,
        "not lower": not lower,
        "not higher": not higher,
    }[test]


def _usable(sample: NDArray[np.float64]) -> bool:
    return len(sample) > 1 and bool(np.isfinite(sample).all())


def _against_sample(a: NDArray[np.float64], b: NDArray[np.float64], seed: int) -> Comparison | None:
    return compare(a, b, seed) if _usable(a) and _usable(b) else None


def _against_number(a: NDArray[np.float64], number: float, seed: int) -> Comparison | None:
    return compare_with_number(a, number, seed) if _usable(a) else None


def _hours(record: TrialRecord, threshold: float | None) -> float:
    if record.log is None or threshold is None:
        return math.nan
    reached = metrics.time_to_threshold(record.log, threshold)
    return float(record.result["hours"]) if math.isnan(reached) else reached


def _measure(record: TrialRecord, measure: str) -> float:
    if measure in ("jumpstart", "greedy"):
        evaluation = record.result["initial" if measure == "jumpstart" else "greedy"]
        return math.nan if evaluation is None else float(evaluation["mean_s"])
    log, hours = record.log, float(record.result["hours"])
    if log is None or log.empty:
        return math.nan
    if measure == "early":
        return metrics.early_reward(log)
    if measure == "final":
        return metrics.final_reward(log, hours)
    return metrics.total_reward(log, math.floor(hours)) if hours >= 1.0 else math.nan


def _curve_hours(hours: float) -> NDArray[np.float64]:
    steps = max(4, round(hours / CURVE_STEP))
    return np.linspace(hours / steps, hours, steps)


def _full_window(log: pd.DataFrame | None) -> float:
    if log is None or len(log) < metrics.WINDOW:
        return math.inf
    return float(metrics.end_hours(log)[metrics.WINDOW - 1])
