"""Tables of a report: measures with the published ones beside them, and the statistics behind them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd

from rcss_hat.experiments.results import MEASURES, SIGNIFICANT, Results
from rcss_hat.experiments.study_parts import Published, Table

PAPER_MEASURES = ("jumpstart", "final", "total")
NOTHING = "–"


def tables_of(results: Results) -> tuple[Table, ...]:
    """Return the study's tables, or one of all its conditions that learn."""
    if results.study.tables:
        return results.study.tables
    conditions = results.study.conditions
    names = tuple(n for n in results.trials if conditions[n].hours > 0 and not conditions[n].sampled)
    return (Table(name="conditions", title="Conditions", conditions=names),) if names else ()


def result_table(results: Results, table: Table) -> pd.DataFrame:
    """Return a table of the three measures, ours and, where there are any, the published ones beside them."""
    names = [name for name in table.conditions if name in results.trials]
    published = {name: results.study.conditions[name].published for name in names}
    with_paper = any(p != Published() for p in published.values())
    significant = {m: _significant(results, names, m) for m in PAPER_MEASURES}
    rows = []
    for name in names:
        row = {"Method": results.label(name), "Trials": str(len(results.trials[name]))}
        for measure in PAPER_MEASURES:
            mean, error = results.value(name, measure)
            text = number(mean, measure) + (f" ± {number(error, measure)}" if math.isfinite(error) else "")
            row[MEASURES[measure]] = f"**{text}**" if name in significant[measure] else text
            if with_paper:
                row[f"{MEASURES[measure]}, paper"] = _published(published[name], measure)
        rows.append(row)
    return pd.DataFrame(rows)


def statistics_table(results: Results, table: Table) -> pd.DataFrame:
    """Return the comparisons behind a table, one row per condition and measure."""
    rows = []
    for measure in PAPER_MEASURES:
        compared = results.comparisons(table.conditions, measure)
        for name, c in compared.iterrows():
            rows.append(
                {
                    "Method": results.label(str(name)),
                    "Measure": MEASURES[measure],
                    "Difference": number(c["difference"], measure, sign=True),
                    "95 % interval": f"{number(c['low'], measure, True)} to {number(c['high'], measure, True)}",
                    "p, Student": p_text(c["p_student"]),
                    "p, Welch + Holm": p_text(c["p_holm"]),
                    "Hedges' g": f"{c['hedges_g']:+.2f}",
                    "P(improvement)": f"{c['p_improvement']:.2f}",
                    "n": f"{c['n']:.0f} / {c['n_baseline']:.0f}",
                }
            )
    return pd.DataFrame(rows)


def more_table(results: Results) -> pd.DataFrame:
    """Return all measures of all conditions that learned, with the time to the threshold; sampled sets apart."""
    published = any(c.published.hours is not None for c in results.study.conditions.values())
    rows = []
    for name in results.trials:
        if results.study.conditions[name].hours == 0 or results.study.conditions[name].sampled:
            continue
        row = {"Condition": name, "Trials": str(len(results.trials[name]))}
        for measure, words in MEASURES.items():
            row[words] = number(results.value(name, measure)[0], measure)
        row["Hours to threshold"] = number(results.hours_to_threshold(name), "final")
        row["Hours, mean of trials"] = number(results.value(name, "hours")[0], "final")
        hours = results.study.conditions[name].published.hours
        row |= {"Hours, paper": NOTHING if hours is None else f"{hours:g}"} if published else {}
        episodes = [record.result["episodes"] for record in results.trials[name]]
        row["Episodes"] = f"{sum(episodes) / len(episodes):.0f}"
        rows.append(row)
    return pd.DataFrame(rows)


def _significant(results: Results, names: Sequence[str], measure: str) -> set[str]:
    compared = results.comparisons(names, measure)
    return set() if compared.empty else {str(n) for n in compared.index[compared["p_student"] < SIGNIFICANT]}


def _published(published: Published, measure: str) -> str:
    value = getattr(published, measure)
    if value is None:
        return NOTHING
    text = f"{value:.2f}" if measure == "jumpstart" else f"{value:.0f}" if measure == "total" else f"{value:.1f}"
    return f"**{text}**" if measure in published.significant else text


def number(value: float, measure: str, sign: bool = False) -> str:
    """Write a value of a measure with its digits; a dash when there is none."""
    if not math.isfinite(value):
        return NOTHING
    digits = 1 if measure == "total" else 2
    return f"{value:{'+' if sign else ''}.{digits}f}"


def p_text(value: float) -> str:
    """Write a p value."""
    return "< 0.0001" if value < 1e-4 else f"{value:.4f}"
