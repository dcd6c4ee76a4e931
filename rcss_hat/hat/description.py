"""Figures of a demonstration, for people and for tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._demonstration_file import DemonstrationInfo
from rcss_hat.keepaway.decision import action_name

COVERAGE_BINS = 10


@dataclass(frozen=True, slots=True, eq=False)
class Description:
    """Figures of a demonstration.

    Attributes
    ----------
    info : DemonstrationInfo
    durations : ndarray, shape (n_episodes,)
        Seconds.
    share_out : float
        Share of the episodes that ended with the ball out, of those whose end is known; nan without any.
    action_counts : ndarray of int, shape (n_actions,)
    ranges : ndarray, shape (3, n_variables)
        Minimum, mean and maximum of each state variable.
    coverage : ndarray, shape (n_variables,)
        Share of ten equal parts of each variable's possible range in the region that hold a decision.
    idle : int
        Episodes in which a person pressed no key.
    by_learner, corrected : int
        Decisions that a learner took, where a person took turns with it; decisions of which somebody said afterwards
        that another would have been right.
    """

    info: DemonstrationInfo
    durations: NDArray[np.float64]
    share_out: float
    action_counts: NDArray[np.int64]
    ranges: NDArray[np.float64]
    coverage: NDArray[np.float64]
    idle: int = 0
    by_learner: int = 0
    corrected: int = 0

    @property
    def action_shares(self) -> NDArray[np.float64]:
        """Share of each action; nan without decisions."""
        total = self.action_counts.sum()
        return self.action_counts / total if total else np.full(len(self.action_counts), np.nan)

    def to_text(self) -> str:
        """Return the figures for people."""
        task = self.info.task
        where = f"{self.info.stage}: {task.size}, {task.field} m, vision {task.vision}"
        lines = [f"Demonstration of {self.info.teacher} on {where}"]
        if not len(self.durations):
            return "\n".join([*lines, "  no episode was finished"])
        d = self.durations
        lines.append(
            f"  {len(d)} episodes, mean {d.mean():.2f} s (sd {d.std():.2f}, shortest {d.min():.1f}, "
            f"median {np.median(d):.1f}, longest {d.max():.1f})"
            + ("" if np.isnan(self.share_out) else f"; {100 * self.share_out:.0f} % ended with the ball out")
        )
        if self.idle:
            lines.append(f"  {self.idle} of them without a single key (idle in the header): was anybody there?")
        shares = zip(range(len(self.action_counts)), self.action_counts, self.action_shares, strict=True)
        actions = ", ".join(f"{action_name(k)} {n} ({100 * share:.1f} %)" for k, n, share in shares)
        lines.append(f"  {self.action_counts.sum()} decisions: {actions}")
        if self.by_learner or self.corrected:
            lines.append(f"  {self.by_learner} of them taken by the learner, {self.corrected} corrected afterwards")
        width = max(map(len, self.info.variable_names))
        lines.append(f"  {'variable':<{width + 11}}{'min':>8}{'mean':>8}{'max':>8}{'covered':>9}")
        for k, name in enumerate(self.info.variable_names):
            low, mean, high = self.ranges[:, k]
            label = f"state_{k} {name}"
            covered = f"{100 * self.coverage[k]:.0f} %"
            lines.append(f"  {label:<{width + 11}}{low:8.2f}{mean:8.2f}{high:8.2f}{covered:>9}")
        return "\n".join(lines)


def coverage(rows: NDArray[np.float64], info: DemonstrationInfo) -> NDArray[np.float64]:
    """Return `Description.coverage` of these states."""
    bins = np.clip((COVERAGE_BINS * rows / _state_ranges(info)).astype(np.int64), 0, COVERAGE_BINS - 1)
    return np.array([len(np.unique(column)) for column in bins.T]) / COVERAGE_BINS


def _state_ranges(info: DemonstrationInfo) -> NDArray[np.float64]:
    """Largest value each variable can take inside the region: half the diagonal, the diagonal, or 180 degrees."""
    task = info.task
    diagonal = float(np.hypot(task.length, task.width))
    mates, players = task.keepers - 1, task.keepers - 1 + task.takers
    return np.array(
        [diagonal / 2] + [diagonal] * players + [diagonal / 2] * players + [diagonal] * mates + [180.0] * mates
    )
