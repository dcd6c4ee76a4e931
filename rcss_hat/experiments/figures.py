"""The paper's figures: learning curves over simulated hours."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rcss_hat.experiments.metrics import Curves

COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Distinguishable for the colour-blind (Okabe and Ito), black for the first condition."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LINE_STYLES = ("--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))
ERROR_BARS = 15
"""Error bars along a curve, at most."""


def learning_curve_figure(
    curves: Mapping[str, Curves], lines: Mapping[str, float] | None = None, title: str = ""
) -> Figure:
    """Draw learning curves: mean over trials with standard errors, and horizontal lines.

    Parameters
    ----------
    curves : mapping of str to Curves
        By label; the first one is drawn in black, as the baseline.
    lines : mapping of str to float, optional
        Labels and heights in seconds, such as a teacher's mean duration or a threshold.
    title : str

    Returns
    -------
    Figure
        Ready for `save_figure`, a notebook or further changes.

    Raises
    ------
    ValueError
        When there is no curve.
    """
    if not curves:
        raise ValueError("a figure of learning curves needs at least one curve")
    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for k, ((label, curve), colour, marker) in enumerate(
        zip(curves.items(), cycle(COLOURS), cycle(MARKERS), strict=False)
    ):
        axes.plot(curve.hours, curve.mean, color=colour, linewidth=1.4)
        # Error bars of different curves stand at different hours, so that they do not hide each other.
        every = max(1, len(curve.hours) // ERROR_BARS)
        shown = slice((k * every) // len(curves), None, every)
        errors = np.nan_to_num(curve.standard_error[shown])
        axes.errorbar(
            curve.hours[shown],
            curve.mean[shown],
            yerr=errors,
            color=colour,
            marker=marker,
            markersize=4,
            linestyle="none",
            elinewidth=0.9,
            capsize=2,
            label=_with_trials(label, curve),
        )
    for (label, height), style in zip((lines or {}).items(), cycle(LINE_STYLES), strict=False):
        axes.axhline(height, color="#666666", linewidth=1.0, linestyle=style, label=_plain(f"{label} ({height:.1f} s)"))
    axes.set_xlabel("Training time (simulated hours)")
    axes.set_ylabel("Episode duration (s), sliding mean")
    axes.set_xlim(0.0, max(float(curve.hours[-1]) for curve in curves.values()))
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if title:
        axes.set_title(_plain(title))
    handles, labels = axes.get_legend_handles_labels()  # lines first, then curves; wanted the other way round
    n = len(lines or {})
    axes.legend(handles[n:] + handles[:n], labels[n:] + labels[:n], frameon=False, fontsize="small", loc="best")
    return figure


def save_figure(figure: Figure, path: Path | str) -> None:
    """Write a figure; the ending of the name decides the format (``.png``, ``.svg``, ``.pdf``)."""
    figure.savefig(path, dpi=200)


def _with_trials(label: str, curve: Curves) -> str:
    n = len(curve.trials)
    return _plain(f"{label} ({n} trial{'s' if n > 1 else ''})")


def _plain(text: str) -> str:
    """Keep Matplotlib from taking what stands between dollar signs for a formula, and from failing when it is none."""
    return text.replace("$", r"\$")
