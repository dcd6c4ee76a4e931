"""Studies in TOML files that people copy and change, and those of the package.

The file has these parts; `load_study` checks every name and value, and `rcss_hat/experiments/conditions/paper.toml` is
the model to copy. `rcss_hat.experiments.study_parts` says what each may hold.

``title``, ``description``, ``seed``, ``baseline``
    ``seed`` decides all others; ``baseline`` is the condition that the others are compared with.
``[defaults]``
    What holds for conditions that do not say otherwise: size, field, vision, profile, learner, learner_settings,
    hours, trials, evaluation_episodes, stage.
``[demonstrations.NAME]``
    A demonstration set, see `SetSpec`.
``[[condition]]``
    See `Condition`.
``[[table]]``, ``[[figure]]``, ``[[claim]]``
    What the report shows, see `Table`, `Figure` and `Claim`. Without them: one table and one figure of everything.
``[[comparison]]``
    Conditions that differ in where they are played only, see `StageComparison`.
``missed_at_most``
    A trial on a server is not pooled with others when players missed more than this share of their cycles.
``[sampling]``
    Many conditions at once, one per demonstration set drawn from pools, see `Sampling`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from rcss_hat.experiments.study import Condition, Study, StudyError, check_known
from rcss_hat.experiments.study_parts import (
    Claim,
    ConditionEntry,
    Defaults,
    Figure,
    Sampling,
    SetSpec,
    StageComparison,
    StudyFile,
    Table,
)
from rcss_hat.hat.teachers import style
from rcss_hat.hat.transfer import make_method
from rcss_hat.inputs import FileFormatError, check_name
from rcss_hat.learning.config import LearnerConfig, load_config
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.schema import parse_toml, read, toml_text

Named = TypeVar("Named", Table, Figure, StageComparison)


def study_names() -> list[str]:
    """Names of the studies in the package."""
    folder = files("rcss_hat.experiments") / "conditions"
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def study_text(name_or_path: str) -> tuple[str, Path]:
    """Return the text of a study of the package, or of a file, and the folder its file names are relative to.

    Raises
    ------
    StudyError
        When there is none.
    """
    try:
        return toml_text(name_or_path, "rcss_hat.experiments", study_names())
    except FileFormatError as problem:
        raise StudyError(str(problem)) from problem


def load_study(name_or_path: str) -> Study:
    """Read a study of the package, or a TOML file.

    Raises
    ------
    StudyError
        Naming the place and what would be right.
    """
    text, folder = study_text(name_or_path)
    try:
        return parse_study(text, folder)
    except StudyError as problem:
        raise StudyError(f"{name_or_path}: {problem}") from problem


def parse_study(text: str, folder: Path) -> Study:
    """Read a study from the text of its file.

    Parameters
    ----------
    text : str
        TOML.
    folder : Path
        What file names in it are relative to.

    Raises
    ------
    StudyError
    """
    try:
        data = parse_toml(text)
    except FileFormatError as problem:
        raise StudyError(f"not valid TOML: {problem}") from problem
    try:
        return _study(read(StudyFile, data, "the study"), folder)
    except FileFormatError as problem:
        raise StudyError(str(problem)) from problem


# -- parts ---------------------------------------------------------------------------------------------------------


def _study(file: StudyFile, folder: Path) -> Study:
    defaults = read(Defaults, file.defaults, "[defaults]")
    sets = {name: _set(name, entry) for name, entry in file.demonstrations.items()}
    conditions = _by_name(
        (_condition(entry, file.defaults, folder, number) for number, entry in enumerate(file.condition, 1)),
        "conditions",
    )
    if file.sampling is not None:
        sampled_sets, sampled = _sampled(file.sampling, file.defaults, folder, file.seed)
        sets, conditions = {**sets, **sampled_sets}, {**conditions, **sampled}
    if not conditions:
        raise StudyError("the study has no [[condition]]")
    with _at("[defaults]"):
        task = defaults.task
    study = Study(
        title=file.title,
        description=file.description,
        seed=file.seed,
        baseline=file.baseline,
        conditions=conditions,
        sets=sets,
        tables=_shown(Table, file.table, "table"),
        figures=_shown(Figure, file.figure, "figure"),
        claims=tuple(_claim(entry, f"claim {number}") for number, entry in enumerate(file.claim, 1)),
        comparisons=_shown(StageComparison, file.comparison, "comparison"),
        missed_at_most=file.missed_at_most,
        sampling=file.sampling,
        task=task,
        folder=folder,
    )
    _check_references(study)
    return study


@contextmanager
def _at(where: str) -> Iterator[None]:
    try:
        yield
    except (ValueError, TypeError, OSError) as problem:
        raise StudyError(f"{where}: {problem}") from problem


def _set(name: str, entry: Any) -> SetSpec:
    where = f"[demonstrations.{check_name(name, 'the name of a demonstration set')}]"
    if isinstance(entry, dict):
        if "name" in entry:
            raise StudyError(f"{where} has no entry 'name': the brackets give it")
        entry = {"name": name, **entry}
    return read(SetSpec, entry, where)


def _condition(entry: Any, defaults: Mapping[str, Any], folder: Path, number: int) -> Condition:
    where = f"condition {number}"
    if isinstance(entry, dict):
        where = f"condition {check_name(entry.get('name', ''), f'{where}: name')!r}"
        entry = {**defaults, **entry}
    own = read(ConditionEntry, entry, where)
    with _at(where):
        task = own.task
        make_method(own.method)
    with _at(f"{where}: settings"):
        method = make_method(own.method, own.settings)
    with _at(f"{where}: learner"):
        learner = _learner(own, folder)
    needs = method.needs_advice or method.needs_decisions
    if needs != (own.demonstrations is not None):
        raise StudyError(f"{where}: method {own.method} {'needs' if needs else 'uses no'} demonstrations")
    return Condition(
        name=own.name,
        label=own.name if own.label is None else own.label,
        task=task,
        learner=learner,
        method=method,
        demonstrations=own.demonstrations,
        rounds=own.rounds,
        hours=own.hours,
        trials=own.trials,
        evaluation_episodes=own.evaluation_episodes,
        published=own.published,
        stage=own.stage,
        baseline=own.baseline,
    )


def _learner(own: ConditionEntry, folder: Path) -> LearnerConfig:
    base = load_config(folder / own.learner if own.learner.endswith(".toml") else own.learner)
    return LearnerConfig.from_dict({**base.to_dict(), **own.learner_settings})


def _shown(kind: type[Named], entries: Iterable[Any], what: str) -> tuple[Named, ...]:
    found = (read(kind, entry, f"{what} {number}") for number, entry in enumerate(entries, 1))
    return tuple(_by_name(found, f"{what}s").values())


def _by_name(parts: Iterable[Any], what: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for part in parts:
        if part.name in found:
            raise StudyError(f"there are two {what} {part.name!r}")
        found[part.name] = part
    return found


def _claim(entry: Any, where: str) -> Claim:
    claim = read(Claim, entry, where)
    if not claim.text or not claim.tests:
        raise StudyError(f"{where} needs a text and tests")
    return claim


def _sampled(
    sampling: Sampling, defaults: Mapping[str, Any], folder: Path, seed: int
) -> tuple[dict[str, SetSpec], dict[str, Condition]]:
    drawn, conditions = {}, {}
    for k in range(sampling.sets):
        pool = sampling.pools[k % len(sampling.pools)]
        size = sampling.episodes[(k // len(sampling.pools)) % len(sampling.episodes)]
        name = f"set-{k + 1:03d}"
        draw = derived_seed(seed, k)
        drawn[name] = SetSpec(name=name, label=f"{size} of {pool}", of=(pool,), pick="random", episodes=size, seed=draw)
        entry = {"name": name, "label": drawn[name].label, "method": sampling.method, "demonstrations": name}
        condition = _condition({**entry, "hours": sampling.hours, "trials": 1}, defaults, folder, k + 1)
        conditions[name] = replace(condition, sampled=True)
    return drawn, conditions


# -- what refers to each other -------------------------------------------------------------------------------------


def _check_references(study: Study) -> None:
    if study.baseline is not None:
        check_known(study.baseline, study.conditions, "condition", "baseline")
    for name, spec in study.sets.items():
        for part in spec.of:
            check_known(part, study.sets, "demonstration set", f"[demonstrations.{name}]")
    _check_circles(study.sets)
    for condition in study.conditions.values():
        _check_demonstrations(condition, study.sets)
        _check_baseline(condition, study)
    for table in study.tables:
        _check_all(table.conditions, study.conditions, "condition", f"table {table.name!r}")
        if len({study.baseline_of(name) for name in table.conditions}) > 1:
            raise StudyError(f"table {table.name!r}: its conditions have different baselines; make a table of each")
    for comparison in study.comparisons:
        names = [name for pair in comparison.pairs for name in pair]
        _check_all(names, study.conditions, "condition", f"comparison {comparison.name!r}")
    for figure in study.figures:
        _check_all(figure.conditions, study.conditions, "condition", f"figure {figure.name!r}")
        _check_all(figure.teachers, study.sets, "demonstration set", f"figure {figure.name!r}")
    for claim in study.claims:
        for test in claim.tests:
            _check_all((*test.conditions, *test.than), study.conditions, "condition", f"claim {claim.text!r}")
            _check_all(test.teachers, study.sets, "demonstration set", f"claim {claim.text!r}")


def _check_all(names: Iterable[str], known: Mapping[str, Any], what: str, where: str) -> None:
    for name in names:
        check_known(name, known, what, where)


def _check_baseline(condition: Condition, study: Study) -> None:
    where = f"condition {condition.name!r}: baseline"
    name = study.baseline_of(condition.name)
    if name is None:
        return
    check_known(name, study.conditions, "condition", where)
    if condition.stage != study.conditions[name].stage:
        raise StudyError(
            f"{where}: {name!r} is played on {study.conditions[name].stage}, this on {condition.stage}; name one there"
        )


def _check_demonstrations(condition: Condition, sets: Mapping[str, SetSpec]) -> None:
    where = f"condition {condition.name!r}"
    used = [condition.demonstrations, *(r.demonstrations for r in condition.rounds)]
    _check_all(filter(None, used), sets, "demonstration set", where)
    watched = [r.watch for r in condition.rounds if r.watch is not None]
    with _at(f"{where}: rounds"):
        for teacher in watched:
            style(teacher)
    if condition.rounds and not condition.method.needs_advice:
        raise StudyError(f"{where}: method {condition.method.name} uses no rules, so rounds would change nothing")
    source = sets[condition.demonstrations] if condition.demonstrations else None
    if source is not None and source.rules is not None and (watched or condition.method.needs_decisions):
        raise StudyError(f"{where} needs demonstrations, and set {source.name!r} is a decision list")


def _check_circles(sets: Mapping[str, SetSpec]) -> None:
    sound = {name for name, spec in sets.items() if not spec.of}
    left = sets.keys() - sound
    while ready := {name for name in left if sound.issuperset(sets[name].of)}:
        sound |= ready
        left = left - ready
    if left:
        raise StudyError(f"demonstration set {min(left)!r} is made of itself")
