"""How people demonstrate, in numbers: one row per participant and step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import GroupKFold, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.hat.summarize import Summary, summarize
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
}
"""Measures of a demonstration: words, unit, decimals. Latency: median time from getting the ball to the key that was
played. Consistency: see `consistency`."""
NEIGHBOURS, FOLDS = 25, 10


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
    """Return what a participant demonstrated, summarised and measured, step by step.

    Raises
    ------
    FileFormatError
    """
    found = []
    for name, demonstration in demonstrations_of(kept).items():
        if not demonstration.n_decisions:
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


def _figures(demonstration: DemonstrationSet, summary: Summary) -> dict[str, float | None]:
    durations = demonstration.durations
    return {
        "mean_s": float(durations.mean()),
        "sd_s": float(durations.std(ddof=1)) if len(durations) > 1 else None,
        "pass_share": float((demonstration.y > 0).mean()),
        "consistency": consistency(demonstration),
        "accuracy": None if np.isnan(summary.accuracy) else float(summary.accuracy),
        "idle_share": float(np.mean([d.idle for d in demonstration])),
    }


def consistency(demonstration: DemonstrationSet) -> float | None:
    """Return how well passes can be told from decisions in other games: the area under the ROC curve.

    Every decision is judged by the share of passes among the most similar ones of other games (state variables
    standardised). None with fewer than two games in which there was both a pass and a Hold.
    """
    passed, games = demonstration.y > 0, demonstration.groups
    folds = min(FOLDS, len(demonstration))
    if len(np.unique(games[passed])) < 2 or passed.all():
        return None
    judge = make_pipeline(StandardScaler(), KNeighborsClassifier(min(NEIGHBOURS, len(passed) // 3)))
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
