"""The report of a study: what people demonstrated, what learners made of it, and what holds for people in general."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from rcss_hat.experiments.document import Block, Code, Document, FigureBlock, Heading, Paragraph, TableBlock
from rcss_hat.experiments.results import Results
from rcss_hat.experiments.statistics import Comparison
from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.folder import Kept, StudyFolder
from rcss_hat.studies.inference import Components, between, components, within
from rcss_hat.studies.learned import learned_blocks
from rcss_hat.studies.parts import said
from rcss_hat.studies.power import Power, power_of
from rcss_hat.studies.shown import MEASURES, USUAL, Shown, measured, shown_by, too_little
from rcss_hat.studies.tables import COLUMNS, tables_of
from rcss_hat.system.files import write_text

REHEARSED = """**These are no people.** The participants of this folder are scripted: it is a rehearsal, which tries
everything but says nothing about people."""
METHOD = """Participants are the unit: of each there is one number per measure, and differences are tested over
participants, not over games, so that they hold for people like these. Intervals are 95 % bootstrap intervals (BCa)
over participants, p is Welch's, or within participants that of a t-test of the differences; it is not corrected for the
number of comparisons. **Latency**: median real time from a keeper's getting the ball to the key that was played.
**Consistency**: how well it can be told from a participant's decisions in other games, by the 25 most similar ones,
whether he passes (area under the ROC curve; 0.5: not at all, 1: always). **Accuracy of the rules**: stratified 10-fold
cross-validation, as in the paper. Where somebody plays while the participant does not, games are of both; passes,
consistency and rules are of what the participant decided himself or called right afterwards."""
SIZES = (4, 8, 12, 20, 30, 50)
"""Participants per condition whose power is told."""


def write_people_report(folder: StudyFolder, out: Path, results: Results | None = None) -> list[Path]:
    """Write the report of a study so far.

    Parameters
    ----------
    folder : StudyFolder
    out : Path
    results : Results, optional
        Of the learners; without, only what people did is told.

    Returns
    -------
    list of Path
        The Markdown and HTML pages; tables and figures are beside them.

    Raises
    ------
    FileFormatError
        When something that is kept is damaged.
    """
    people = folder.participants()
    shown = [s for kept in people for s in shown_by(kept)]
    tables = tables_of(people)
    document = Document(said(folder.study.title, folder.study.language, folder.study.language))
    if folder.rehearsal:
        document.add(Paragraph(" ".join(REHEARSED.split())))
    document.add(Paragraph(_state(folder, tables["participants"])))
    if shown:
        document.add(*_demonstrated(folder, shown, people))
        if results is not None:
            document.add(*learned_blocks(folder, shown, results))
        document.add(*_size(folder, shown))
    document.add(*_answered(tables["answers"]), *_trouble(people, tables), *_rules(shown))
    pages = document.save(out)
    for name, table in tables.items():
        write_text(out / "data" / f"{name}.csv", table.to_csv(index=False, lineterminator="\n"))
    write_text(out / "data" / "codebook.md", _codebook())
    return pages


def _state(folder: StudyFolder, table: pd.DataFrame) -> str:
    states = table["state"].value_counts()
    told = ", ".join(f"{n} {state}" for state, n in states.items())
    design = "each meets one condition" if folder.study.design == "between" else "each meets all conditions"
    removed = folder.removed()
    gone = f" The data of {len(removed)} were removed." if removed else ""
    n = len(folder.study.conditions)
    return f"{len(table)} participants ({told or 'nobody yet'}); {n} conditions, {design}.{gone}"


# -- what people demonstrated ----------------------------------------------------------------------------------------


def _demonstrated(folder: StudyFolder, shown: Sequence[Shown], people: Sequence[Kept]) -> list[Block]:
    rows = []
    for s in shown:
        row: dict[str, Any] = {
            "Participant": s.participant,
            "Condition": s.condition or "–",
            "Games": len(s.demonstration),
        }
        rows.append(row | {_title(m): _number(s.figures[m], MEASURES[m][2]) for m in measured(shown)})
    blocks: list[Block] = [
        Heading("Demonstrations"),
        Paragraph(" ".join(METHOD.split())),
        TableBlock(pd.DataFrame(rows), name="demonstrations"),
    ]
    left_out = [step for kept in people for step in too_little(kept)]
    if left_out:
        blocks.append(Paragraph(f"Left out, for there is nothing to learn from: {'; '.join(left_out)}."))
    conditions = [c.name for c in folder.study.conditions if any(s.condition == c.name for s in shown)]
    if len(conditions) > 1:
        blocks += [Heading("Conditions", 3), TableBlock(_condition_table(conditions, shown), name="conditions")]
        compared = _compared(folder, conditions, shown)
        if len(compared):
            blocks.append(TableBlock(compared, name="conditions-compared"))
    caption = "Games of every participant (dots), his mean (line), and the mean of the participants' means (dashed)."
    return [*blocks, FigureBlock(_games_figure(shown), "games", caption), *_variance(shown)]


def _title(measure: str) -> str:
    words, unit, _ = MEASURES[measure]
    return f"{words} ({unit})" if unit else words


def _number(value: float | None, decimals: int, sign: bool = False) -> str:
    if value is None or not np.isfinite(value):
        return "–"
    return f"{value:+.{decimals}f}" if sign else f"{value:.{decimals}f}"


def _values(shown: Sequence[Shown], condition: str, measure: str) -> dict[str, float]:
    """Return a measure of every participant of a condition; the mean where he has several steps of it."""
    found: dict[str, list[float]] = {}
    for s in shown:
        value = s.figures[measure]
        if s.condition == condition and value is not None:
            found.setdefault(s.participant, []).append(value)
    return {participant: float(np.mean(values)) for participant, values in found.items()}


def _condition_table(conditions: Sequence[str], shown: Sequence[Shown]) -> pd.DataFrame:
    rows = []
    for condition in conditions:
        row: dict[str, Any] = {"Condition": condition}
        row["Participants"] = len({s.participant for s in shown if s.condition == condition})
        for measure in measured(shown):
            decimals = MEASURES[measure][2]
            values = list(_values(shown, condition, measure).values())
            spread = f" ± {np.std(values, ddof=1) / np.sqrt(len(values)):.{decimals}f}" if len(values) > 1 else ""
            row[_title(measure)] = (_number(float(np.mean(values)), decimals) + spread) if values else "–"
        rows.append(row)
    return pd.DataFrame(rows)


def _compared(folder: StudyFolder, conditions: Sequence[str], shown: Sequence[Shown]) -> pd.DataFrame:
    rows = []
    for measure in measured(shown):
        if measure in USUAL:
            continue  # it is the condition that decides it
        values = {c: _values(shown, c, measure) for c in conditions}
        found: Mapping[tuple[str, str], Comparison]
        if all(len(set(v.values())) < 2 for v in values.values()):
            continue  # nothing varies
        if folder.study.design == "within":
            found = within(values, folder.study.seed)
        else:
            found = between({c: list(v.values()) for c, v in values.items()}, folder.study.seed)
        rows += [_comparison(_title(measure), pair, c, MEASURES[measure][2]) for pair, c in found.items()]
    return pd.DataFrame(rows)


def _comparison(what: str, pair: tuple[str, str], c: Comparison, decimals: int) -> dict[str, str]:
    return {
        "Measure": what,
        "Compared": f"{pair[0]} – {pair[1]}",
        "Difference": _number(c.difference, decimals, True),
        "95 % interval": f"{_number(c.low, decimals, True)} to {_number(c.high, decimals, True)}",
        "p": f"{c.p_welch:.3f}",
        "Hedges' g": f"{c.hedges_g:+.2f}",
    }


def _games_figure(shown: Sequence[Shown]) -> Figure:
    figure = Figure(figsize=(max(5.0, 0.45 * len(shown) + 1.5), 3.8), layout="constrained")
    axes = figure.add_subplot()
    ordered = sorted(shown, key=lambda s: (s.condition, s.participant))
    rng = np.random.default_rng(0)
    for k, s in enumerate(ordered):
        d = s.demonstration.durations
        axes.plot(k + rng.uniform(-0.18, 0.18, len(d)), d, "o", color="#0072b2", alpha=0.55, markersize=3.5, mew=0)
        axes.plot([k - 0.3, k + 0.3], [d.mean()] * 2, color="#000000", linewidth=1.6)
    for condition in dict.fromkeys(s.condition for s in ordered):
        places = [k for k, s in enumerate(ordered) if s.condition == condition]
        mean = float(np.mean([ordered[k].demonstration.durations.mean() for k in places]))
        axes.plot([places[0] - 0.45, places[-1] + 0.45], [mean] * 2, "--", color="#d55e00", linewidth=1.2)
        axes.text((places[0] + places[-1]) / 2, 1.01, condition, ha="center", transform=axes.get_xaxis_transform())
    axes.set_xticks(range(len(ordered)), [s.participant for s in ordered], rotation=90, fontsize=8)
    axes.set_ylabel("Duration of a game (s)")
    axes.set_ylim(bottom=0.0)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure


def _components(shown: Sequence[Shown]) -> Components | None:
    conditions = list(dict.fromkeys(s.condition for s in shown))
    try:
        return components([[s.demonstration.durations for s in shown if s.condition == c] for c in conditions])
    except ValueError:
        return None


def _variance(shown: Sequence[Shown]) -> list[Block]:
    found = _components(shown)
    if found is None:
        return []
    return [
        Paragraph(
            f"A random-effects model of the games' durations (participants random, conditions fixed): standard "
            f"deviation {found.between:.2f} s between participants, {found.within:.2f} s between the games of one; "
            f"{100 * found.icc:.0f} % of the variance lies between participants."
        )
    ]


# -- how many participants -------------------------------------------------------------------------------------------


def _size(folder: StudyFolder, shown: Sequence[Shown]) -> list[Block]:
    """Tell the power of comparisons of the mean duration."""
    powers = _powers(folder, shown, SIZES, None)
    if not powers:
        return []
    games = powers[0].games
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for p in powers:
        row = rows.setdefault((p.first, p.second), {"Compared": f"{p.first} – {p.second}"})
        row["Difference (s)"] = f"{p.difference:+.2f}"
        row[str(p.participants)] = f"{p.power:.2f}"
    each = "participants per condition" if folder.study.design == "between" else "participants"
    text = (
        f"Power of the comparison of mean durations, by simulation, if the differences and the variances are those "
        f"found here: share of studies with p < 0.05, by {each}, with {games} games each."
    )
    return [
        Heading("How many participants?"),
        Paragraph(text),
        TableBlock(pd.DataFrame(list(rows.values())), name="power"),
    ]


def powers_of(folder: StudyFolder, sizes: Sequence[int], games: int | None) -> list[Power]:
    """Return the power of comparing mean durations, from what was played so far.

    Raises
    ------
    FileFormatError
        When it is too little, or something that is kept is damaged.
    """
    found = _powers(folder, [s for kept in folder.participants() for s in shown_by(kept)], sizes, games)
    if not found:
        raise FileFormatError(f"{folder.path} is too small: two conditions and two participants of one are needed")
    return found


def _powers(folder: StudyFolder, shown: Sequence[Shown], sizes: Sequence[int], games: int | None) -> list[Power]:
    found = _components(shown)
    conditions = [c.name for c in folder.study.conditions]
    means = {c: list(_values(shown, c, "mean_s").values()) for c in conditions}
    known = {c: float(np.mean(values)) for c, values in means.items() if values}
    if found is None or len(known) < 2:
        return []
    each = games or round(float(np.mean([len(s.demonstration) for s in shown])))
    return power_of(known, found, sizes, each, folder.study.design, folder.study.seed)


# -- answers, trouble, rules -----------------------------------------------------------------------------------------


def _answered(answers: pd.DataFrame) -> list[Block]:
    rows = []
    for key, mine in answers.groupby(["step", "question"], sort=False):
        step, question = cast(tuple[str, str], key)
        numbers = pd.to_numeric(mine["answer"], errors="coerce")
        given = mine["answer"].dropna()
        if len(given) and numbers.notna().sum() == len(given):
            spread = f" ± {numbers.std(ddof=1):.1f}" if len(given) > 1 else ""
            told = f"mean {numbers.mean():.1f}{spread} (sd)"
        else:
            counts = given.astype(str).value_counts()
            told = "; ".join(f"{str(answer)[:60]}: {n}" for answer, n in counts.head(8).items()) or "–"
        rows.append({"Step": step, "Question": question, "Answered": f"{len(given)} of {len(mine)}", "Answers": told})
    if not rows:
        return []
    return [Heading("Answers"), TableBlock(pd.DataFrame(rows), prose=True, name="answers")]


def _trouble(people: Sequence[Kept], tables: Mapping[str, pd.DataFrame]) -> list[Block]:
    rows = []
    for kept in people:
        games = tables["games"][tables["games"]["participant"] == kept.name]
        lag = [e for e in kept.events if e["event"] == "lag"]
        pictures, late = sum(e["pictures"] for e in lag), sum(e["late"] for e in lag)
        rows.append(
            {
                "Participant": kept.name,
                "Games without a key": f"{int(games['idle'].sum())} of {len(games)}",
                "Games that stood still": int((games["stood"] > 0).sum()),
                "Pictures that came late": f"{100 * late / pictures:.1f} %" if pictures else "–",
                "Worst wait (ms)": max((e["worst_ms"] for e in lag), default=0),
                "Server started again": sum(e["event"] == "resumed" for e in kept.events),
                "Failures": sum(e["event"] == "failed" for e in kept.events),
            }
        )
    return [Heading("How it went"), TableBlock(pd.DataFrame(rows), name="how-it-went")] if rows else []


def _rules(shown: Sequence[Shown]) -> list[Block]:
    blocks: list[Block] = [Heading("Rules of every participant")] if shown else []
    for s in shown:
        blocks += [Heading(f"{s.participant} {s.condition}", 3), Code(s.rules.format(comments=False))]
    return blocks


def _codebook() -> str:
    parts = [
        "# Tables of a study's report",
        "Made of the study's folder; see its `codebook.md` for the files themselves.",
    ]
    for name, columns in COLUMNS.items():
        rows = [f"| `{column}` | {text or 'See above.'} |" for column, text in columns.items()]
        parts += [f"## `{name}.csv`", "\n".join(["| column | meaning |", "|---|---|", *rows])]
    return "\n\n".join(parts) + "\n"
