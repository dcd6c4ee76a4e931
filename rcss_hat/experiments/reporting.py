"""The report of an experiment: the paper's tables and figures with ours beside them, statistics, and verdicts."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from rcss_hat.experiments.document import Code, Document, FigureBlock, Heading, Paragraph, TableBlock
from rcss_hat.experiments.experiment import Experiment, ExperimentError
from rcss_hat.experiments.figures import learning_curve_figure
from rcss_hat.experiments.predictors import FIGURES, predict, predictor_figure, sampled_frame
from rcss_hat.experiments.report_tables import (
    NOTHING,
    more_table,
    number,
    p_text,
    result_table,
    statistics_table,
    tables_of,
)
from rcss_hat.experiments.results import MEASURES, Evidence, Results
from rcss_hat.experiments.stage_report import comparisons, servers_table
from rcss_hat.experiments.study_parts import Figure
from rcss_hat.system.files import write_text

METRIC_WORDS = {"hours": "hours to threshold", "jumpstart": "initial policy", "early": "first 1,000 episodes"}
"""What claims call a metric, where its name says too little."""
DEFINITIONS = """Episode durations are in seconds of simulated time (ten cycles). **Jumpstart**: mean duration of the
initial policy without learning and exploration, minus the baseline's. **Final**: mean of the last 1,000 episodes of
training. **Total Reward**: sum, over every whole hour, of the mean of the 1,000 episodes before it (of all there are in
the first hours). **Without exploration**: mean of episodes played after training with learning and exploration off.
± is the standard error over trials; bold is significantly different from the baseline by the paper's test (two-sided
Student t, p < 0.05). The statistics below a table: difference of means with its bootstrap 95 % interval (BCa), p by
Student's t-test and by Welch's with Holm's correction over the table, Hedges' g (difference in pooled standard
deviations), and the probability that a trial of the condition beats one of the baseline. Trials differ by seed and
share their demonstrations, so statements are about these sets."""


def report_folder(experiment: Experiment) -> Path:
    """Return where the report of an experiment goes unless told otherwise."""
    return experiment.folder / "report"


def write_report(experiment: Experiment, folder: Path | None = None) -> list[Path]:
    """Write the report of what has been run so far.

    Parameters
    ----------
    experiment : Experiment
    folder : Path, optional
        By default ``report`` in the experiment's folder.

    Returns
    -------
    list of Path
        The Markdown and HTML pages; tables and figures are beside them.

    Raises
    ------
    ExperimentError
        When no trial has ended yet.
    """
    results = Results(experiment)
    if not results.trials:
        left_out = ": those that have missed too much" if results.left_out else " yet"
        raise ExperimentError(f"no trial in {experiment.folder} that can be shown has ended{left_out}")
    folder = report_folder(experiment) if folder is None else folder
    document = make_document(results)
    pages = document.save(folder)
    write_text(folder / "trials.csv", results.frame().to_csv(index=False, lineterminator="\n"))
    return pages


def make_document(results: Results) -> Document:
    """Put the report together."""
    study = results.study
    document = Document(study.title)
    if study.description:
        document.add(Paragraph(study.description))
    document.add(Paragraph(_state(results)))
    if study.claims:
        document.add(Heading("Claims"), *_claims(results))
    shown = [t for t in tables_of(results) if any(name in results.trials for name in t.conditions)]
    if shown:
        document.add(Heading("Results"), Paragraph(" ".join(DEFINITIONS.split())))
    for table in shown:
        document.add(Heading(table.title, 3), TableBlock(result_table(results, table), name=table.name))
        statistics = statistics_table(results, table)
        if len(statistics):
            document.add(TableBlock(statistics, name=f"{table.name}-statistics"))
    document.add(*_figures(results))
    document.add(*comparisons(results))
    if shown:
        more = TableBlock(more_table(results), name="all-conditions")
        document.add(Heading("All conditions"), Paragraph(_threshold_text(results)), more)
    document.add(*_predictors(results))
    document.add(*_sets(results))
    document.add(Heading("How it was run"), *_how(results))
    return document


# -- parts -----------------------------------------------------------------------------------------------------------


def _state(results: Results) -> str:
    study = results.study
    done, wanted = sum(map(len, results.trials.values())), sum(c.trials for c in study.conditions.values())
    learning = {f"{c.hours:g}" for c in study.conditions.values() if c.hours > 0}
    hours = f", {' or '.join(sorted(learning))} simulated hours each" if learning else ""
    left = sum(map(len, results.left_out.values()))
    missed = f"more than {100 * study.missed_at_most:g} % of the cycles, or an episode's end"
    marked = f" **{left} trials are left out**: their players missed {missed}." if left else ""
    absent = wanted - done - left
    missing = f"{marked} **{absent} trials are missing**, so this is a preliminary report." if absent else marked
    conditions = f"{len(results.trials)} condition{'s' if len(results.trials) > 1 else ''}"
    return f"{conditions}, {done} finished trials{hours}.{missing}"


def _claims(results: Results) -> list[Heading | Paragraph | TableBlock]:
    verdicts = results.verdicts()
    rows = [
        {
            "": str(k),
            "Claim": verdict.claim.text,
            "Verdict": f"**{verdict.verdict}**",
            "Comparisons that hold": f"{sum(bool(e.holds) for e in verdict.evidence)} of {len(verdict.evidence)}",
        }
        for k, verdict in enumerate(verdicts, 1)
    ]
    evidence = [
        {"Claim": str(k), **_evidence_row(results, e)}
        for k, verdict in enumerate(verdicts, 1)
        for e in verdict.evidence
    ]
    meaning = (
        "A claim is reproduced when all comparisons behind it hold, not reproduced when none does, different when some "
        "do. The paper's test decides (two-sided Student t, p < 0.05)."
    )
    return [
        TableBlock(pd.DataFrame(rows), prose=True, name="claims"),
        Paragraph(meaning),
        TableBlock(pd.DataFrame(evidence), prose=True, name="claims-evidence"),
    ]


def _evidence_row(results: Results, e: Evidence) -> dict[str, str]:
    row = {
        "Comparison": _claimed(results, e),
        "Difference": NOTHING,
        "95 % interval": NOTHING,
        "p, Student": NOTHING,
        "p, Welch": NOTHING,
    }
    if e.comparison is not None:
        c, m = e.comparison, e.test.metric
        row["Difference"] = number(c.difference, m, True)
        row["95 % interval"] = f"{number(c.low, m, True)} to {number(c.high, m, True)}"
        row["p, Student"], row["p, Welch"] = p_text(c.p_student), p_text(c.p_welch)
    return {**row, "Holds": {True: "yes", False: "no", None: "not tested"}[e.holds]}


def _claimed(results: Results, e: Evidence) -> str:
    metric, than = METRIC_WORDS.get(e.test.metric, e.test.metric), e.test.than_metric
    if e.test.teachers:
        other = f"the demonstrations' mean, {results.study.sets[e.than].title}"
    else:
        other = results.label(e.than)
    if than is not None:
        other = f"{METRIC_WORDS.get(than, than)} of {other}"
    link = "similar to" if e.test.test == "similar" else f"{e.test.test} than"
    return f"{results.label(e.condition)}: {metric} {link} {other}"


def _figures(results: Results) -> list[Heading | FigureBlock]:
    blocks: list[Heading | FigureBlock] = []
    conditions = results.study.conditions
    names = tuple(n for n in results.trials if conditions[n].hours > 0 and not conditions[n].sampled)
    everything = (Figure(name="learning-curves", title="Learning curves", conditions=names),)
    for figure in results.study.figures or everything:
        curves = {}
        for name in figure.conditions:
            found = results.curves(name) if name in results.trials else None
            if found is not None:
                curves[results.label(name)] = found
        if not curves:
            continue
        lines = {}
        for name in figure.teachers:
            prepared = results.experiment.sets.prepare(name)
            if "mean_s" in prepared.figures:
                lines[f"{prepared.label}, demonstrations"] = prepared.figures["mean_s"]
        drawn = learning_curve_figure(curves, lines)
        caption = (
            f"{figure.title}. Mean over trials of the mean duration of the last 1,000 episodes; bars: standard error."
        )
        blocks.append(FigureBlock(drawn, figure.name, caption))
    return [Heading("Learning curves"), *blocks] if blocks else []


def _threshold_text(results: Results) -> str:
    if results.threshold is None:
        return "All measures, in seconds."
    return (
        f"All measures, in seconds. Hours to threshold: when the mean learning curve reaches {results.threshold:g} s, "
        "which is 0.3 s below the baseline's final reward, as in the paper; beside it the mean of when the single "
        "trials do, which is sooner, because a single trial's curve fluctuates more (a trial that never does counts "
        "with all its hours)."
    )


def _predictors(results: Results) -> list[Heading | Paragraph | TableBlock | FigureBlock]:
    if results.study.sampling is None:
        return []
    blocks: list[Heading | Paragraph | TableBlock | FigureBlock] = [Heading("What predicts how much a set helps")]
    outcomes = ["jumpstart"] + (["total"] if results.study.sampling.hours >= 1 else [])
    for outcome in outcomes:
        frame = sampled_frame(results, outcome)
        try:
            prediction = predict(frame, outcome, results.study.seed)
        except ValueError as problem:
            blocks.append(Paragraph(f"{str(problem).capitalize()}."))
            continue
        rows = [
            {"Figure of the set": FIGURES[str(k)], "Rank correlation": f"{r['rho']:+.2f}",
             "95 % interval": f"{r['low']:+.2f} to {r['high']:+.2f}", "p": p_text(r["p"])}
            for k, r in prediction.correlations.iterrows()
        ]  # fmt: skip
        blocks += [
            Heading(f"{MEASURES[outcome]}, {len(frame)} sets", 3),
            Paragraph(
                f"{MEASURES[outcome]} from {frame[outcome].min():+.2f} to {frame[outcome].max():+.2f}, mean "
                f"{frame[outcome].mean():+.2f}. On sets left out, a ridge regression on all figures explains "
                f"{100 * prediction.r2_linear:.0f} % of the variance, a random forest "
                f"{100 * prediction.r2_forest:.0f} %."
            ),
            FigureBlock(
                predictor_figure(prediction, "s" if outcome == "jumpstart" else "s, summed over hours"),
                f"predictors-{outcome}",
                f"{MEASURES[outcome]} of sampled demonstration sets against the figures that correlate with it most.",
            ),
            TableBlock(pd.DataFrame(rows), name=f"predictors-{outcome}"),
        ]
    return blocks


def _sets(results: Results) -> list[Heading | Paragraph | TableBlock | Code]:
    sampled = {c.demonstrations for c in results.study.conditions.values() if c.sampled}
    names = [name for name in results.experiment.used_sets() if name not in sampled]
    if not names:
        return []
    rows, texts = [], []
    for name in names:
        prepared = results.experiment.sets.prepare(name)
        f = prepared.figures
        row = {"Set": prepared.label, "Rules": str(f.get("rules", NOTHING))}
        if prepared.demonstrations is not None:
            row |= {
                "Episodes": str(f["episodes"]),
                "Mean (s)": f"{f['mean_s']:.1f}",
                "Decisions": str(f["decisions"]),
                "Passes": f"{100 * f['pass_share']:.1f} %",
                "Accuracy of D": _percent(f["accuracy"]),
                "episodes left out": _percent(f["episode_accuracy"]),
                "Most frequent action": _percent(f["majority_share"]),
            }
        rows.append(row)
        texts.append(f"{prepared.label}:\n{prepared.rules.format(comments=False, digits=2)}")
    explained = (
        "D is the decision list that RIPPER learns from a set. Its accuracy is that of stratified cross-validation, as "
        "in the paper; beside it whole episodes are left out, and the share of the most frequent action says what "
        "always giving the same answer would reach."
    )
    table = TableBlock(pd.DataFrame(rows).fillna(NOTHING), name="demonstration-sets")
    return [Heading("Demonstrations"), table, Paragraph(explained), Code("\n\n".join(texts))]


def _percent(value: float | None) -> str:
    return NOTHING if value is None else f"{100 * value:.1f} %"


def _how(results: Results) -> list[Paragraph | TableBlock | Code]:
    info, study = results.experiment.info, results.study
    machine, versions = info["machine"], info["versions"]
    wall = sum(record.result["wall_s"] for records in results.trials.values() for record in records)
    learners = {c.learner.name: c.learner for c in study.conditions.values()}
    settings = "; ".join(
        f"learner {name}: "
        + ", ".join(f"{k} {v}" for k, v in learner.to_dict().items() if k not in ("name", "description"))
        for name, learner in learners.items()
    )
    text = (
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; rcss-hat {versions['rcss-hat']}, "
        f"Python {versions['python']}, NumPy {versions['numpy']}, numba {versions['numba']}. "
        f"{_duration(info['seconds'])} for {info['finished_trials']} trials ({_duration(wall)} of trials' own time)."
    )
    rows = []
    for name, records in results.trials.items():
        c = study.conditions[name]
        if c.sampled:
            continue
        rows.append(
            {
                "Condition": name,
                "Stage": c.stage,
                "Task": f"{c.task.size}, {c.task.field} m, vision {c.task.vision}, physics of {c.task.profile}",
                "Method": c.method.describe(),
                "Learner": c.learner.name,
                "Demonstrations": c.demonstrations or NOTHING,
                "Hours": f"{c.hours:g}",
                "Seeds": ", ".join(str(record.result["seed"]) for record in records),
            }
        )
    command = [Code(info["command"])] if info["command"] else []
    servers = servers_table(results)
    played = [TableBlock(servers, prose=True, name="servers")] if len(servers) else []
    return [
        *command,
        Paragraph(text),
        Paragraph(f"Settings of the learners. {settings}. Seeds are drawn from the study's, {study.seed}."),
        TableBlock(pd.DataFrame(rows), prose=True, name="runs"),
        *played,
    ]


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
