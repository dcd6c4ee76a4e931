"""What in a demonstration set predicts how much it helps: the first question of the HAT paper's section 6.

Many sets of different teachers and sizes are summarised and evaluated (a study with ``[sampling]``). Each set has
figures, known before any learning; the outcome is the jumpstart of its decision list, or the total reward of learning
with it. Ranks are correlated, figure by figure, and models that are tested on sets they have not seen say how much can
be predicted from all figures together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import stats
from sklearn.ensemble import RandomForestRegressor
from sklearn.linear_model import RidgeCV
from sklearn.model_selection import KFold, cross_val_predict
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from rcss_hat.experiments.figures import COLOURS
from rcss_hat.experiments.results import Results

FIGURES = {
    "episodes": "episodes",
    "decisions": "decisions",
    "seconds": "seconds demonstrated",
    "mean_s": "mean duration of its episodes (s)",
    "sd_s": "standard deviation of the durations (s)",
    "shortest_s": "shortest episode (s)",
    "longest_s": "longest episode (s)",
    "pass_share": "share of passes among decisions",
    "near_pass_share": "share of passes to the nearer mate",
    "far_pass_share": "share of passes to the farther mate",
    "passes_per_s": "passes per second",
    "taker_at_pass_m": "distance of the nearest taker at a pass (m)",
    "share_out": "share of episodes that end with the ball out",
    "coverage": "share of the state variables' ranges covered",
    "majority_share": "share of the most frequent action",
    "rules": "rules in D",
    "conditions": "conditions in D",
    "accuracy": "accuracy of D, cross-validated",
    "episode_accuracy": "accuracy of D, episodes left out",
    "training_accuracy": "accuracy of D on the set itself",
    "advised_pass_share": "share of demonstrated states in which D passes",
}
"""Figures of a set (see `rcss_hat.experiments.sets.set_figures` and `rcss_hat.hat.summarize.Summary`), in words."""
RESAMPLES = 2000
FOLDS = 10


@dataclass(frozen=True, slots=True)
class Prediction:
    """How well sets' figures predict an outcome.

    Attributes
    ----------
    outcome : str
    frame : DataFrame
        One row per set: figures and outcome.
    correlations : DataFrame
        Index: figures, strongest first. Columns ``rho`` (Spearman), ``low``, ``high`` (bootstrap 95 %) and ``p``.
    r2_linear, r2_forest : float
        Share of the outcome's variance that a ridge regression and a random forest explain on sets left out.
    """

    outcome: str
    frame: pd.DataFrame
    correlations: pd.DataFrame
    r2_linear: float
    r2_forest: float


def sampled_frame(results: Results, outcome: str = "jumpstart") -> pd.DataFrame:
    """Return one row per sampled set: pool, figures, and the outcome (relative to the baseline for the jumpstart)."""
    study, rows = results.study, []
    for name in results.trials:
        spec = study.sets.get(name)
        if study.sampling is None or spec is None or spec.of not in [(pool,) for pool in study.sampling.pools]:
            continue
        figures = results.experiment.sets.prepare(name).figures
        value = float(results.sample(name, outcome).mean())
        if outcome == "jumpstart" and results.baseline is not None:
            value -= float(results.sample(results.baseline, outcome).mean())
        rows.append({"set": name, "pool": spec.of[0], **{k: figures.get(k) for k in FIGURES}, outcome: value})
    return pd.DataFrame(rows)


def predict(frame: pd.DataFrame, outcome: str, seed: int) -> Prediction:
    """Correlate every figure with the outcome, and test models of all figures.

    Parameters
    ----------
    frame : DataFrame
        See `sampled_frame`.
    outcome : str
        A column of it.
    seed : int
        Of resampling and folds.

    Raises
    ------
    ValueError
        With fewer than ten sets.
    """
    if len(frame) < FOLDS:
        raise ValueError(f"what predicts {outcome} cannot be said from {len(frame)} sets; at least {FOLDS} are needed")
    known = frame.assign(**{k: pd.to_numeric(frame[k]).fillna(0.0) for k in FIGURES})
    y = known[outcome].to_numpy(dtype=np.float64)
    varied = [k for k in FIGURES if known[k].nunique() > 1]
    rng = np.random.default_rng(seed)
    rows = {k: _correlation(known[k].to_numpy(dtype=np.float64), y, rng) for k in varied}
    table = pd.DataFrame.from_dict(rows, orient="index", columns=["rho", "low", "high", "p"])
    table = table.reindex(table["rho"].abs().sort_values(ascending=False, kind="stable").index)
    X = known[varied].to_numpy(dtype=np.float64)
    folds = KFold(FOLDS, shuffle=True, random_state=seed)
    linear = make_pipeline(StandardScaler(), RidgeCV(alphas=np.logspace(-2, 4, 13)))
    forest = RandomForestRegressor(300, min_samples_leaf=3, random_state=seed)
    r2 = [_r2(y, cross_val_predict(model, X, y, cv=folds)) for model in (linear, forest)]
    return Prediction(outcome, known, table, r2[0], r2[1])


def predictor_figure(prediction: Prediction, unit: str = "s", panels: int = 3) -> Figure:
    """Draw the outcome against the figures that correlate with it most, one point per set, a colour per pool."""
    names = list(prediction.correlations.index[:panels])
    figure = Figure(figsize=(3.6 * len(names), 3.6), layout="constrained")
    axes = np.atleast_1d(np.asarray(figure.subplots(1, len(names), sharey=True)))
    pools = sorted(prediction.frame["pool"].unique())
    for panel, name in zip(axes, names, strict=True):
        for k, pool in enumerate(pools):
            rows = prediction.frame[prediction.frame["pool"] == pool]
            colour = COLOURS[(k + 1) % len(COLOURS)]
            panel.scatter(rows[name], rows[prediction.outcome], s=14, color=colour, label=pool, alpha=0.8, linewidths=0)
        panel.set_xlabel(f"{FIGURES[name]}\nrank correlation {prediction.correlations.loc[name, 'rho']:+.2f}")
        panel.axhline(0.0, color="#999999", linewidth=0.8)
        panel.grid(color="#dddddd", linewidth=0.6)
        panel.set_axisbelow(True)
        for side in ("top", "right"):
            panel.spines[side].set_visible(False)
    axes[0].set_ylabel(f"{prediction.outcome.capitalize()} ({unit})")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize="small", title="Teacher", loc="outside right upper")
    return figure


def _correlation(
    x: NDArray[np.float64], y: NDArray[np.float64], rng: np.random.Generator
) -> tuple[float, float, float, float]:
    found = stats.spearmanr(x, y)
    rows = rng.integers(0, len(x), (RESAMPLES, len(x)))
    ranks = [stats.rankdata(values[rows], axis=1) for values in (x, y)]
    first, second = (r - r.mean(axis=1, keepdims=True) for r in ranks)
    scale = np.sqrt((first**2).sum(axis=1) * (second**2).sum(axis=1))
    drawn = (first * second).sum(axis=1)[scale > 0.0] / scale[scale > 0.0]
    low, high = np.quantile(drawn, [0.025, 0.975]) if len(drawn) else (np.nan, np.nan)
    return float(found.statistic), float(low), float(high), float(found.pvalue)


def _r2(y: NDArray[np.float64], predicted: NDArray[np.float64]) -> float:
    return 1.0 - float(((y - predicted) ** 2).sum() / ((y - y.mean()) ** 2).sum())
