"""How people demonstrate, in numbers: one row per participant and step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import GroupKFold, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.hat.ripper import RipperClassifier
from rcss_hat.hat.summarize import Summary, summarize
from rcss_hat.keepaway.decision import LEARNER
from rcss_hat.studies.folder import Kept
from rcss_hat.studies.tables import demonstrations_of, latencies

SUMMARY_SEED = 1
"""Of RIPPER's splits and the folds of cross-validation, as in experiments."""
MEASURES = {
    "mean_s": ("Mean game", "s", 2),
    "sd_s": ("Standard deviation", "s", 2),
    "pass_share": ("Decisions that pass", "", 3),
    "keys_per_s": ("Keys per second", "1/s", 2),
    "lapsed_share": ("Keys that came too late", "", 3),
    "latency_ms": ("Latency of keys", "ms", 0),
    "consistency": ("Consistency", "", 2),
    "accuracy": ("Accuracy of the rules", "", 3),
    "idle_share": ("Games without a key", "", 3),
    "own_share": ("Decisions by the participant", "", 3),
    "corrected_share": ("Decisions corrected", "", 3),
}
"""Measures of a demonstration: words, unit, decimals. Latency: median time from getting the ball to the key that was
played. Consistency: see `consistency`. Where somebody else plays along, passes, consistency and rules are those of what
the participant decided or called right."""
USUAL = {"own_share": 1.0, "corrected_share": 0.0}
"""What measures are where nobody plays along and nothing is corrected; they are shown where one is not."""
NEIGHBOURS, FOLDS = 25, 10
FEWEST: int = RipperClassifier().folds
"""Decisions that rules can be learned from."""


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What a participant demonstrated in a step.

    Attributes
    ----------
    participant, step : str
    condition : str
        Empty where the step has none.
    demonstration : DemonstrationSet
    summary : Summary
    figures : dict
        `MEASURES`; None where there is none.
    """

    participant: str
    step: str
    condition: str
    demonstration: DemonstrationSet
    summary: Summary
    figures: dict[str, float | None]

    @property
    def rules(self) -> DecisionList:
        """RIPPER's summary."""
        return self.summary.printed


def shown_by(kept: Kept) -> list[Shown]:
    """Return what a participant demonstrated, summarised and measured, step by step; see also `too_little`.

    Raises
    ------
    FileFormatError
    """
    found = []
    for name, demonstration in demonstrations_of(kept).items():
        if demonstration.lessons.n_decisions < FEWEST:
            continue
        planned = next(p for p in kept.plan if p.name == name)
        summary = summarize(demonstration, SUMMARY_SEED)
        games = kept.progress.played[name].games
        figures = _figures(demonstration, summary)
        waits = latencies(kept, planned)
        pressed = sum(game["keys"] or 0 for game in games)
        figures |= {
            "keys_per_s": pressed / float(demonstration.durations.sum()),
            "lapsed_share": _lapsed(kept, name),
            "latency_ms": float(np.median(waits)) if len(waits) else None,
        }
        found.append(Shown(kept.name, name, planned.condition or "", demonstration, summary, figures))
    return found


def too_little(kept: Kept) -> list[str]:
    """Name the steps in which a participant decided so little that there is nothing to learn from, in words."""
    return [
        f"{kept.name} in {name}: {demonstration.lessons.n_decisions} decisions of his own"
        for name, demonstration in demonstrations_of(kept).items()
        if demonstration.lessons.n_decisions < FEWEST
    ]


def _figures(demonstration: DemonstrationSet, summary: Summary) -> dict[str, float | None]:
    durations, decisions = demonstration.durations, [d for game in demonstration for d in game.decisions]
    return {
        "mean_s": float(durations.mean()),
        "sd_s": float(durations.std(ddof=1)) if len(durations) > 1 else None,
        "pass_share": float((demonstration.lessons.y > 0).mean()),
        "consistency": consistency(demonstration.lessons),
        "accuracy": None if np.isnan(summary.accuracy) else float(summary.accuracy),
        "idle_share": float(np.mean([d.idle for d in demonstration])),
        "own_share": float(np.mean([d.by != LEARNER for d in decisions])),
        "corrected_share": float(np.mean([d.right is not None for d in decisions])),
    }


def measured(shown: Sequence[Shown]) -> list[str]:
    """Return the measures that say something of some demonstrations."""
    return [m for m in MEASURES if any(s.figures[m] != USUAL.get(m) for s in shown)]


def consistency(demonstration: DemonstrationSet) -> float | None:
    """Return how well passes can be told from decisions in other games: the area under the ROC curve.

    Every decision is judged by the share of passes among the most similar ones of other games (state variables
    standardised). None with fewer than two games with a pass, or with a Hold.
    """
    passed, games = demonstration.y > 0, demonstration.groups
    if min(len(np.unique(games[passed])), len(np.unique(games[~passed]))) < 2:
        return None
    sizes = np.unique(games, return_counts=True)[1]
    folds, least = min(FOLDS, len(sizes)), len(passed) - max(sizes)
    judge = make_pipeline(StandardScaler(), KNeighborsClassifier(max(1, min(NEIGHBOURS, len(passed) // 3, least))))
    judged = cross_val_predict(
        judge, demonstration.X, passed, groups=games, cv=GroupKFold(folds), method="predict_proba"
    )
    return float(roc_auc_score(passed, judged[:, 1]))


def _lapsed(kept: Kept, step: str) -> float | None:
    from rcss_hat.studies.game_files import read_rows, table_path

    path = table_path(kept.folder, step, "keys")
    fates = [row["fate"] for row in read_rows(path)] if path.exists() else []
    meant = [fate for fate in fates if fate in ("played", "lapsed")]
    return fates.count("lapsed") / len(meant) if meant else None
