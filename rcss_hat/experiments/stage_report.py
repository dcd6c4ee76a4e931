"""The part of a report that compares stages, and that says what became of the servers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from rcss_hat.experiments.document import FigureBlock, Heading, Paragraph, TableBlock
from rcss_hat.experiments.equivalence import Band, Equivalence, difference_band, equivalence
from rcss_hat.experiments.figures import COLOURS
from rcss_hat.experiments.report_tables import NOTHING, number, p_text
from rcss_hat.experiments.results import Results
from rcss_hat.experiments.study_parts import StageComparison

WORDS = {"initial": "Initial policy", "jumpstart": "Jumpstart", "final": "Final", "total": "Total Reward"}
EXPLAINED = """Two one-sided tests: two stages are equivalent in a measure when the 90 % interval of the difference lies
within the margin (p < 0.05). A row that says no does not say that they differ: there may be too few trials to tell."""


def comparisons(results: Results) -> list[Heading | Paragraph | TableBlock | FigureBlock]:
    """Return what compares stages; nothing where the study compares none."""
    blocks: list[Heading | Paragraph | TableBlock | FigureBlock] = []
    for comparison in results.study.comparisons:
        table = equivalence_table(results, comparison)
        if table.empty:
            continue
        blocks += [Heading(comparison.title, 3), TableBlock(table, name=comparison.name)]
        bands = _bands(results, comparison)
        if bands:
            caption = f"{comparison.title}: difference of mean learning curves, with its pointwise 95 % interval."
            blocks.append(FigureBlock(_band_figure(bands), f"{comparison.name}-difference", caption))
    return [Heading("Stages compared"), Paragraph(" ".join(EXPLAINED.split())), *blocks] if blocks else []


def equivalence_table(results: Results, comparison: StageComparison) -> pd.DataFrame:
    """Return a comparison's tests, one row per pair and measure; those that cannot be made yet are left out."""
    rows = []
    for pair in comparison.pairs:
        if not all(name in results.trials for name in pair):
            continue
        for measure, margin in comparison.margins.items():
            found = _equivalence(results, pair, measure, margin)
            if found is None:
                continue
            first, second = (results.value(name, measure)[0] for name in pair)
            counts = " / ".join(str(len(results.trials[name])) for name in pair)
            rows.append(
                {
                    "Condition": results.label(pair[0]),
                    "against": results.label(pair[1]),
                    "Measure": WORDS[measure],
                    "First": number(first, measure),
                    "Second": number(second, measure),
                    "Difference": number(found.difference, measure, sign=True),
                    "90 % interval": f"{number(found.low, measure, True)} to {number(found.high, measure, True)}",
                    "Margin": f"± {margin:g}",
                    "p": p_text(found.p),
                    "Equivalent": "yes" if found.holds else "no",
                    "n": counts,
                }
            )
    return pd.DataFrame(rows)


def _equivalence(results: Results, pair: tuple[str, str], measure: str, margin: float) -> Equivalence | None:
    terms: list[tuple[float, Any]] = []
    for sign, name in zip((1.0, -1.0), pair, strict=True):
        terms.append((sign, results.sample(name, "jumpstart" if measure == "initial" else measure)))
        if measure == "jumpstart":
            baseline = results.baseline_of(name)
            if baseline is None or baseline == name:
                return None
            terms.append((-sign, results.sample(baseline, measure)))
    try:
        return equivalence(terms, margin)
    except ValueError:  # too few trials yet, or a condition without this measure
        return None


def _bands(results: Results, comparison: StageComparison) -> dict[str, Band]:
    bands = {}
    for pair in comparison.pairs:
        if not all(name in results.trials for name in pair):
            continue
        curves = [results.curves(name) for name in pair]
        if curves[0] is not None and curves[1] is not None:
            try:
                bands[f"{results.label(pair[0])} - {results.label(pair[1])}"] = difference_band(curves[0], curves[1])
            except ValueError:  # too few trials yet
                continue
    return bands


def _band_figure(bands: dict[str, Band]) -> Figure:
    """Draw differences of curves, one panel each, all to the same scale."""
    columns = min(2, len(bands))
    rows = math.ceil(len(bands) / columns)
    figure = Figure(figsize=(4.2 * columns, 2.6 * rows + 0.4), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in panels.flat[len(bands) :]:
        axes.set_visible(False)
    for axes, (label, band), colour in zip(panels.flat, bands.items(), COLOURS * len(bands), strict=False):
        axes.fill_between(band.hours, band.low, band.high, color=colour, alpha=0.2, linewidth=0)
        axes.plot(band.hours, band.difference, color=colour, linewidth=1.4)
        axes.axhline(0.0, color="#666666", linewidth=0.8)
        axes.set_title(label.replace("$", r"\$"), fontsize="small")
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    low = min(float(np.nanmin(band.low)) for band in bands.values())
    high = max(float(np.nanmax(band.high)) for band in bands.values())
    panels[0, 0].set_ylim(min(low, -1.0) * 1.05, max(high, 1.0) * 1.05)
    figure.supxlabel("Training time (simulated hours)", fontsize="small")
    figure.supylabel("Difference (s)", fontsize="small")
    return figure


def servers_table(results: Results) -> pd.DataFrame:
    """Return what became of the servers, one row per trial that was played on some."""
    rows = []
    for name in results.study.conditions:
        for record in [*results.trials.get(name, []), *results.left_out.get(name, [])]:
            servers = record.result.get("servers")
            if servers is None:
                continue
            rows.append(
                {
                    "Condition": name,
                    "Trial": str(record.result["trial"]),
                    "Pooled": "yes" if record in results.trials.get(name, []) else "no",
                    "Servers": str(servers["matches"]),
                    "replaced": str(servers["replaced"]),
                    "Cycles": f"{servers['cycles']:,}",
                    "missed": f"{100.0 * servers['missed_share']:.3f} %",
                    "Physics": ", ".join(servers["profiles"]) or NOTHING,
                    "Servers' seeds": ", ".join(seed or NOTHING for seed in servers["seeds"]),
                }
            )
    return pd.DataFrame(rows)
