"""What learners made of people's demonstrations: the paper's questions, with participants drawn at random."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rcss_hat.experiments.document import Block, FigureBlock, Heading, Paragraph, TableBlock
from rcss_hat.experiments.figures import learning_curve_figure
from rcss_hat.experiments.results import Results
from rcss_hat.experiments.statistics import compare_with_number
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.inference import between, gain, rank_correlation
from rcss_hat.studies.learning import BASELINE, Names, names_of
from rcss_hat.studies.shown import Shown

QUESTIONS = {"jumpstart": "Initial policy", "total": "Total Reward", "final": "Final"}
"""Measures of learners: mean duration before learning, sum over hours of mean durations, mean of the last 1,000."""


def learned_blocks(folder: StudyFolder, shown: Sequence[Shown], results: Results) -> list[Block]:
    """Answer the paper's questions from the trials that have ended."""
    names = names_of(shown)
    taught = [s for s in shown if names.participants[s.participant, s.step] in results.trials]
    if BASELINE not in results.trials or len(taught) < 2:
        return []
    hours = results.study.conditions[BASELINE].hours
    intro = (
        f"Every participant's demonstration taught learners ({_trials(results, taught, names)}, {hours:g} simulated "
        "hours); a participant's number is the mean of his trials."
    )
    blocks: list[Block] = [Heading("Learners"), Paragraph(intro), *_helped(folder, taught, names, results)]
    blocks += _groups(folder, taught, names, results)
    blocks += _skill(folder, taught, names, results)
    return blocks + _together(names, results)


def _trials(results: Results, taught: Sequence[Shown], names: Names) -> str:
    numbers = {len(results.trials[names.participants[s.participant, s.step]]) for s in taught}
    low, high = min(numbers), max(numbers)
    return f"{low} trial{'s' * (low > 1)} each" if low == high else f"{low} to {high} trials each"


def _sample(results: Results, name: str, measure: str) -> NDArray[np.float64]:
    return results.sample(name, measure)


def _by_participant(
    results: Results, taught: Sequence[Shown], names: Names, measure: str, condition: str | None = None
) -> list[NDArray[np.float64]]:
    """Return the trials of every participant, of a condition or of all."""
    found: dict[str, list[NDArray[np.float64]]] = {}
    for s in taught:
        if condition in (None, s.condition):
            name = names.participants[s.participant, s.step]
            found.setdefault(s.participant, []).append(_sample(results, name, measure))
    return [np.concatenate(trials) for trials in found.values()]


def _helped(folder: StudyFolder, taught: Sequence[Shown], names: Names, results: Results) -> list[Block]:
    """Tell whether being taught by a person helps: the paper's first claim."""
    conditions = list(dict.fromkeys(s.condition for s in taught if s.condition))
    rows = []
    for condition in [None, *(conditions if len(conditions) > 1 else [])]:
        row: dict[str, str | int] = {"Taught by": "anybody" if condition is None else condition}
        for measure, title in QUESTIONS.items():
            trials, without = (
                _by_participant(results, taught, names, measure, condition),
                _sample(results, BASELINE, measure),
            )
            if len(trials) < 2 or not _whole([*trials, without]):
                row[title] = "–"
                continue
            g = gain(trials, without, folder.study.seed)
            row["Participants"] = g.participants
            row[title] = f"{g.estimate:+.2f} ({g.low:+.2f} to {g.high:+.2f}), p = {g.p:.3f}"
        rows.append(row)
    base = ", ".join(f"{title} {_sample(results, BASELINE, m).mean():.2f}" for m, title in QUESTIONS.items())
    text = (
        f"Gain over learning without a teacher (No Prior: {base}), with the 95 % interval over participants and trials."
    )
    return [Heading("Does a person's teaching help?", 3), Paragraph(text), TableBlock(pd.DataFrame(rows), name="gain")]


def _whole(samples: Sequence[NDArray[np.float64]]) -> bool:
    return all(bool(np.isfinite(sample).all()) for sample in samples)


def _groups(folder: StudyFolder, taught: Sequence[Shown], names: Names, results: Results) -> list[Block]:
    """Tell whether learners of one group are better than those of another."""
    conditions = list(dict.fromkeys(s.condition for s in taught if s.condition))
    rows = []
    for measure, title in QUESTIONS.items():
        means = {c: [float(t.mean()) for t in _by_participant(results, taught, names, measure, c)] for c in conditions}
        if not _whole([np.array(m) for m in means.values()]):
            continue
        for (a, b), c in between(means, folder.study.seed).items():
            interval = f"{c.low:+.2f} to {c.high:+.2f}"
            row = {"Measure": title, "Compared": f"{a} – {b}", "Difference": f"{c.difference:+.2f}"}
            rows.append(row | {"95 % interval": interval, "p": f"{c.p_welch:.3f}", "Hedges' g": f"{c.hedges_g:+.2f}"})
    if not rows:
        return []
    return [
        Heading("Does the condition matter to learners?", 3),
        TableBlock(pd.DataFrame(rows), name="learners-compared"),
    ]


def _skill(folder: StudyFolder, taught: Sequence[Shown], names: Names, results: Results) -> list[Block]:
    """Tell whether better players are better teachers, and whether learners overtake them."""
    skill = [float(s.demonstration.durations.mean()) for s in taught]
    lines = []
    for measure, title in QUESTIONS.items():
        learned = [float(_sample(results, names.participants[s.participant, s.step], measure).mean()) for s in taught]
        if len(taught) >= 4 and np.isfinite(learned).all():
            r, low, high = rank_correlation(skill, learned, folder.study.seed)
            lines.append(f"{title} {r:+.2f} ({low:+.2f} to {high:+.2f})")
    blocks: list[Block] = [Heading("Are better players better teachers?", 3)]
    if lines:
        blocks.append(
            Paragraph(
                f"Rank correlation of a participant's mean game with what his learners reach: {'; '.join(lines)}."
            )
        )
    final = np.array([_sample(results, names.participants[s.participant, s.step], "final").mean() for s in taught])
    if np.isfinite(final).all():
        c = compare_with_number(final - np.array(skill), 0.0, folder.study.seed)
        above = int((final > np.array(skill)).sum())
        blocks.append(
            Paragraph(
                f"In the end {above} of {len(taught)} learners play longer than their teacher did, by "
                f"{c.difference:+.2f} s on average ({c.low:+.2f} to {c.high:+.2f}, p = {c.p_welch:.3f})."
            )
        )
    return blocks if len(blocks) > 1 else []


def _together(names: Names, results: Results) -> list[Block]:
    """Show what becomes of groups' demonstrations together."""
    wanted = [BASELINE, *names.groups.values(), *names.together.values()]
    curves = {results.label(name): c for name in wanted if name in results.trials and (c := results.curves(name))}
    rows = []
    for name in wanted:
        if name in results.trials:
            row = {"Demonstrations": results.label(name), "Trials": str(len(results.trials[name]))}
            rows.append(row | {title: f"{_sample(results, name, m).mean():.2f}" for m, title in QUESTIONS.items()})
    text = "Of these there is one set each, so differences are between sets, not between people."
    blocks: list[Block] = [
        Heading("Many teachers together", 3), Paragraph(text), TableBlock(pd.DataFrame(rows), name="together")
    ]  # fmt: skip
    if curves:
        caption = "Learning curves: mean over trials with standard errors."
        blocks.append(FigureBlock(learning_curve_figure(curves), "learning", caption))
    return blocks
