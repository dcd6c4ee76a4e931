"""Studies: the conditions of an experiment, defined once in a TOML file that people copy and change.

The file has these parts; `load_study` checks every name and value, and `rcss_hat/experiments/conditions/paper.toml` is
the model to copy.

``title``, ``description``, ``seed``, ``baseline``
    ``seed`` decides all others; ``baseline`` is the condition that the others are compared with.
``[defaults]``
    What holds for conditions that do not say otherwise: size, field, vision, profile, learner, learner_settings,
    hours, trials, evaluation_episodes.
``[demonstrations.NAME]``
    A demonstration set, see `SetSpec`.
``[[condition]]``
    See `Condition`.
``[[table]]``, ``[[figure]]``, ``[[claim]]``
    What the report shows, see `Table`, `Figure` and `Claim`. Without them: one table and one figure of everything.
``[sampling]``
    Many conditions at once, one per demonstration set drawn from pools, see `Sampling`.
"""

from __future__ import annotations

import re
import tomllib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rcss_hat.experiments.training import RunConfig
from rcss_hat.hat.demonstrations import PICKS
from rcss_hat.hat.transfer import TransferMethod, make_method
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import LearnerConfig, load_config

TESTS = ("higher", "lower", "similar", "not lower", "not higher")
METRICS = ("jumpstart", "final", "total", "greedy", "early", "hours")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
T = TypeVar("T")


class StudyError(ValueError):
    """A study that is not valid; the message names the place and what would be right."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetSpec:
    """Where a demonstration set comes from: exactly one of ``package``, ``file``, ``teacher``, ``of`` or ``rules``.

    Attributes
    ----------
    name, label : str
    package : str or None
        A set that ships with the package.
    file : str or None
        A demonstration file, relative to the study's file.
    teacher : str or None
        A scripted teacher, who demonstrates in the arena; with ``episodes``, ``seed`` and, if it is another than the
        study's, a task.
    of : tuple of str
        Other sets, joined; each contributes what ``pick`` and ``episodes`` say.
    rules : str or None
        No demonstrations but a decision list: a file, or ``paper`` for the one printed in the HAT paper.
    pick : {"all", "first", "best", "worst", "random"}
        Which episodes of each set in ``of``; best: the longest.
    episodes : int or None
        How many.
    seed : int
        Of the teacher, or of random picks.
    size, field : str or None
        The teacher's task.
    map_to : str or None
        Summarised rules are translated to this size, such as ``4v3``.
    """

    name: str
    label: str = ""
    package: str | None = None
    file: str | None = None
    teacher: str | None = None
    of: tuple[str, ...] = ()
    rules: str | None = None
    pick: str = "all"
    episodes: int | None = None
    seed: int = 0
    size: str | None = None
    field: str | None = None
    map_to: str | None = None

    @property
    def title(self) -> str:
        """What people call it: its label, or its name."""
        return self.label or self.name

    def __post_init__(self) -> None:
        """Check what does not need the other sets."""
        sources = [k for k in ("package", "file", "teacher", "rules") if getattr(self, k) is not None]
        sources += ["of"] if self.of else []
        if len(sources) != 1:
            raise ValueError(f"needs exactly one of package, file, teacher, of and rules, not {sources or 'none'}")
        if self.pick not in ("all", *PICKS):
            raise ValueError(f"pick must be one of all, {', '.join(PICKS)}, not {self.pick!r}")
        if self.pick != "all" and (not self.of or self.episodes is None):
            raise ValueError(f"pick = {self.pick!r} needs 'of' and 'episodes'")
        if self.episodes is not None and self.episodes < 1:
            raise ValueError(f"episodes must be at least 1, not {self.episodes}")
        if self.teacher is not None and self.episodes is None:
            raise ValueError("a teacher needs a number of episodes")
        if self.seed < 0:
            raise ValueError(f"seed must be at least 0, not {self.seed}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Round:
    """A later round of demonstrations: from ``hour`` on, D is another one and reuse begins anew.

    Attributes
    ----------
    hour : float
        Simulated hours of learning before it.
    demonstrations : str or None
        The set whose summary is D from now on.
    watch : str or None
        Instead: a teacher who watches the learner play ``episodes`` episodes and says for every decision what he
        would have done; these decisions are added to all demonstrations before.
    episodes : int
    """

    hour: float
    demonstrations: str | None = None
    watch: str | None = None
    episodes: int = 0

    def __post_init__(self) -> None:
        """Check the round."""
        if (self.demonstrations is None) == (self.watch is None):
            raise ValueError("a round needs either demonstrations or watch")
        if self.watch is not None and self.episodes < 1:
            raise ValueError("a round with watch needs a number of episodes")
        if not self.hour > 0.0:
            raise ValueError(f"the hour of a round must be more than 0, not {self.hour!r}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """What a paper reports of a condition; None: nothing. ``hours``: simulated hours to the threshold."""

    jumpstart: float | None = None
    final: float | None = None
    total: float | None = None
    hours: float | None = None
    significant: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """One condition: what is learned, how, and how often.

    Attributes
    ----------
    name, label : str
        For files, and for people.
    task : Task
    learner : LearnerConfig
    method : TransferMethod
    demonstrations : str or None
        Set that is summarised to D, or replayed.
    rounds : tuple of Round
    hours : float
    trials : int
    evaluation_episodes : int
        Episodes without learning, before and after.
    published : Published
    sampled : bool
        Whether it was drawn by ``[sampling]``: one trial, whatever is asked for.
    """

    name: str
    label: str
    task: Task
    learner: LearnerConfig
    method: TransferMethod
    demonstrations: str | None
    rounds: tuple[Round, ...]
    hours: float
    trials: int
    evaluation_episodes: int
    published: Published
    sampled: bool = False

    def run_config(self, seed: int) -> RunConfig:
        """Return the settings of one trial's training run."""
        return RunConfig(
            task=self.task,
            learner=self.learner,
            method=self.method,
            seed=seed,
            hours=self.hours,
            source=self.demonstrations or "",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of the report: some conditions, in this order."""

    name: str
    title: str
    conditions: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A figure of the report: learning curves, and mean durations of demonstration sets as lines."""

    name: str
    title: str
    conditions: tuple[str, ...]
    teachers: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimTest:
    """One comparison: each of ``conditions`` against each of ``than`` or of ``teachers``.

    Attributes
    ----------
    test : str
        One of `TESTS`.
    metric : str
        One of `METRICS`; ``jumpstart`` is the duration of the initial policy, ``hours`` the time to the threshold.
    conditions : tuple of str
    than : tuple of str
        Conditions.
    than_metric : str or None
        Another metric of those than of ``conditions``.
    teachers : tuple of str
        Instead of ``than``: demonstration sets, whose mean duration is compared with.
    """

    test: str
    metric: str
    conditions: tuple[str, ...]
    than: tuple[str, ...] = ()
    than_metric: str | None = None
    teachers: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check the words."""
        if self.test not in TESTS:
            raise ValueError(f"test must be one of {', '.join(TESTS)}, not {self.test!r}")
        if self.metric not in METRICS:
            raise ValueError(f"metric must be one of {', '.join(METRICS)}, not {self.metric!r}")
        if self.than_metric is not None and self.than_metric not in METRICS:
            raise ValueError(f"than_metric must be one of {', '.join(METRICS)}, not {self.than_metric!r}")
        if bool(self.than) == bool(self.teachers):
            raise ValueError("a test needs either than or teachers")


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A qualitative claim, and the comparisons that decide whether it is reproduced."""

    text: str
    tests: tuple[ClaimTest, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """Draw demonstration sets from pools, and make a condition of each.

    Attributes
    ----------
    pools : tuple of str
        Demonstration sets to draw from, one pool per set.
    episodes : tuple of int
        Sizes to draw.
    sets : int
        How many sets; pools and sizes alternate.
    method : str
    hours : float
        0: only the initial policy is evaluated.
    """

    pools: tuple[str, ...]
    episodes: tuple[int, ...]
    sets: int
    method: str = "ppr"
    hours: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not self.pools or not self.episodes or min(self.episodes) < 1 or self.sets < 1:
            raise ValueError("sampling needs pools, episodes of at least 1 and sets of at least 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A whole experiment.

    Attributes
    ----------
    title, description : str
    seed : int
    baseline : str or None
    conditions : dict of str to Condition
    sets : dict of str to SetSpec
    tables, figures, claims : tuple
    sampling : Sampling or None
    task : Task
        Of teachers that are not told another.
    folder : Path
        What file names in the study are relative to.
    """

    title: str
    description: str
    seed: int
    baseline: str | None
    conditions: dict[str, Condition]
    sets: dict[str, SetSpec]
    tables: tuple[Table, ...]
    figures: tuple[Figure, ...]
    claims: tuple[Claim, ...]
    sampling: Sampling | None
    task: Task
    folder: Path

    def trial_seed(self, condition: str, trial: int) -> int:
        """Return the seed of a trial: drawn from the study's seed, the condition's name and the trial's number."""
        key = (zlib.crc32(condition.encode()), trial)
        return int(np.random.SeedSequence(self.seed, spawn_key=key).generate_state(1, np.uint32)[0] >> 1)

    def scaled(self, trials: int | None = None, hours: float | None = None) -> Study:
        """Return the study with other numbers of trials and hours in all conditions.

        Later rounds keep their share of the time. Conditions that only evaluate (0 hours) stay so.
        """
        changed = {}
        for name, condition in self.conditions.items():
            factor = 1.0 if hours is None or condition.hours == 0.0 else hours / condition.hours
            changed[name] = replace(
                condition,
                trials=condition.trials if trials is None or condition.sampled else trials,
                hours=condition.hours * factor,
                rounds=tuple(replace(r, hour=r.hour * factor) for r in condition.rounds),
            )
        return replace(self, conditions=changed)

    def learned_by(self, learner: str) -> Study:
        """Return the study with another learner in all conditions.

        Parameters
        ----------
        learner : str
            A preset, or a ``.toml`` file. Settings that conditions change are changed in it no more.

        Raises
        ------
        StudyError
            When there is no such learner.
        """
        try:
            config = load_config(learner)
        except (ValueError, FileNotFoundError) as problem:
            raise StudyError(f"learner: {problem}") from problem
        conditions = {name: replace(condition, learner=config) for name, condition in self.conditions.items()}
        return replace(self, conditions=conditions)

    def chosen(self, names: tuple[str, ...]) -> Study:
        """Return the study with some of its conditions only.

        Raises
        ------
        StudyError
            When there is no such condition.
        """
        for name in names:
            _known(name, self.conditions, "condition", "--only")
        kept = {name: c for name, c in self.conditions.items() if name in names}
        return replace(
            self,
            baseline=self.baseline if self.baseline in kept else None,
            conditions=kept,
            tables=tuple(replace(t, conditions=_those(t.conditions, kept)) for t in self.tables),
            figures=tuple(replace(f, conditions=_those(f.conditions, kept)) for f in self.figures),
            claims=tuple(c for c in self.claims if all({*t.conditions, *t.than} <= kept.keys() for t in c.tests)),
        )


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
    if name_or_path in study_names():
        resource = files("rcss_hat.experiments") / "conditions" / f"{name_or_path}.toml"
        return resource.read_text(encoding="utf-8"), Path.cwd()
    path = Path(name_or_path)
    if not path.is_file():
        known = ", ".join(study_names())
        raise StudyError(f"no study {name_or_path!r}: there are {known}, or give a TOML file of the same form")
    try:
        return path.read_text(encoding="utf-8"), path.resolve().parent
    except UnicodeDecodeError as problem:
        raise StudyError(f"{path} is not UTF-8 text") from problem


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
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise StudyError(f"not valid TOML: {problem}") from problem
    _only(
        data,
        "title description seed baseline defaults demonstrations condition table figure claim sampling",
        "the study",
    )
    defaults = _table(data, "defaults")
    sets = {
        name: _make(SetSpec, {"name": name, **_entry(entry, f"[demonstrations.{name}]")}, f"[demonstrations.{name}]")
        for name, entry in _table(data, "demonstrations").items()
    }
    conditions: dict[str, Condition] = {}
    for number, entry in enumerate(_list(data, "condition"), 1):
        condition = _condition(entry, defaults, folder, f"condition {number}")
        if condition.name in conditions:
            raise StudyError(f"there are two conditions {condition.name!r}")
        conditions[condition.name] = condition
    sampling = _make(Sampling, data["sampling"], "[sampling]") if "sampling" in data else None
    if sampling is not None:
        sampled_sets, sampled = _sampled(sampling, sets, defaults, folder, int(data.get("seed", 0)))
        sets, conditions = {**sets, **sampled_sets}, {**conditions, **sampled}
    if not conditions:
        raise StudyError("the study has no [[condition]]")
    study = Study(
        title=str(data.get("title", "Experiment")),
        description=str(data.get("description", "")),
        seed=_of_type(data.get("seed", 0), int, "seed"),
        baseline=data.get("baseline"),
        conditions=conditions,
        sets=sets,
        tables=_parts(Table, data, "table"),
        figures=_parts(Figure, data, "figure"),
        claims=tuple(_claim(entry, k) for k, entry in enumerate(_list(data, "claim"), 1)),
        sampling=sampling,
        task=_task(defaults, "[defaults]"),
        folder=folder,
    )
    _check_references(study)
    return study


# -- parts ---------------------------------------------------------------------------------------------------------


def _condition(entry: Any, defaults: Mapping[str, Any], folder: Path, where: str) -> Condition:
    own = _entry(entry, where)
    if not NAME.fullmatch(str(own.get("name", ""))):
        raise StudyError(f"{where}: name must consist of letters, digits, '.', '_' and '-', not {own.get('name')!r}")
    where = f"condition {own['name']!r}"
    _only(own, f"name label method settings demonstrations rounds published {DEFAULTS}", where)
    values = {**defaults, **own}
    method_name = _of_type(values.get("method", "no-prior"), str, f"{where}: method")
    try:
        method = make_method(method_name, values.get("settings"))
        learner = _learner(str(values.get("learner", "paper")), values.get("learner_settings", {}), folder)
    except (ValueError, TypeError, FileNotFoundError) as problem:
        raise StudyError(f"{where}: {problem}") from problem
    needs = method.needs_advice or bool(method.replay_passes)
    if needs != ("demonstrations" in own):
        raise StudyError(f"{where}: method {method_name} {'needs' if needs else 'uses no'} demonstrations")
    condition = Condition(
        name=own["name"],
        label=str(own.get("label", own["name"])),
        task=_task(values, where),
        learner=learner,
        method=method,
        demonstrations=own.get("demonstrations"),
        rounds=tuple(_make(Round, r, f"{where}, rounds") for r in _list(own, "rounds")),
        hours=float(_of_type(values.get("hours", 30), (int, float), f"{where}: hours")),
        trials=_of_type(values.get("trials", 10), int, f"{where}: trials"),
        evaluation_episodes=_of_type(values.get("evaluation_episodes", 1000), int, f"{where}: evaluation_episodes"),
        published=_make(Published, own.get("published", {}), f"{where}, published"),
    )
    hours = [r.hour for r in condition.rounds]
    if hours != sorted(hours) or (hours and hours[-1] >= condition.hours):
        raise StudyError(f"{where}: rounds must follow each other before the end of the {condition.hours:g} hours")
    if condition.trials < 1 or condition.hours < 0 or condition.evaluation_episodes < 0:
        raise StudyError(f"{where}: trials must be at least 1; hours and evaluation_episodes must not be negative")
    return condition


DEFAULTS = "size field vision profile learner learner_settings hours trials evaluation_episodes"


def _learner(name: str, changes: Mapping[str, Any], folder: Path) -> LearnerConfig:
    source: str | Path = name
    if name.endswith(".toml") and not Path(name).is_absolute():
        source = folder / name
    return LearnerConfig.from_dict({**load_config(source).to_dict(), **changes})


def _task(values: Mapping[str, Any], where: str) -> Task:
    try:
        return Task.parse(
            values.get("size", "3v2"), values.get("field"), values.get("vision", 360), values.get("profile", "19.0")
        )
    except (ValueError, TypeError) as problem:
        raise StudyError(f"{where}: {problem}") from problem


def _claim(entry: Any, number: int) -> Claim:
    where = f"claim {number}"
    own = _entry(entry, where)
    _only(own, "text tests", where)
    tests = tuple(_make(ClaimTest, test, where) for test in _list(own, "tests"))
    if not tests or "text" not in own:
        raise StudyError(f"{where} needs a text and tests")
    return Claim(text=str(own["text"]), tests=tests)


def _sampled(
    sampling: Sampling, sets: Mapping[str, SetSpec], defaults: Mapping[str, Any], folder: Path, seed: int
) -> tuple[dict[str, SetSpec], dict[str, Condition]]:
    drawn, conditions = {}, {}
    for k in range(sampling.sets):
        pool = sampling.pools[k % len(sampling.pools)]
        size = sampling.episodes[(k // len(sampling.pools)) % len(sampling.episodes)]
        name = f"set-{k + 1:03d}"
        draw = int(np.random.SeedSequence(seed, spawn_key=(k,)).generate_state(1, np.uint32)[0] >> 1)
        drawn[name] = SetSpec(name=name, label=f"{size} of {pool}", of=(pool,), pick="random", episodes=size, seed=draw)
        entry: dict[str, Any] = {"name": name, "label": drawn[name].label, "method": sampling.method}
        entry |= {"demonstrations": name, "hours": sampling.hours, "trials": 1}
        conditions[name] = replace(_condition(entry, defaults, folder, f"[sampling] {name}"), sampled=True)
    return drawn, conditions


def _check_references(study: Study) -> None:
    if study.baseline is not None:
        _known(study.baseline, study.conditions, "condition", "baseline")
    for name, spec in study.sets.items():
        for part in spec.of:
            _known(part, study.sets, "demonstration set", f"[demonstrations.{name}]")
        _check_cycle(study.sets, name, ())
    for condition in study.conditions.values():
        used = [condition.demonstrations, *(r.demonstrations for r in condition.rounds)]
        for name in filter(None, used):
            _known(name, study.sets, "demonstration set", f"condition {condition.name!r}")
    parts: list[Table | Figure] = [*study.tables, *study.figures]
    for shown in parts:
        for name in shown.conditions:
            _known(name, study.conditions, "condition", f"{shown.name!r}")
    for figure in study.figures:
        for name in figure.teachers:
            _known(name, study.sets, "demonstration set", f"figure {figure.name!r}")
    for claim in study.claims:
        for test in claim.tests:
            for name in (*test.conditions, *test.than):
                _known(name, study.conditions, "condition", f"claim {claim.text!r}")
            for name in test.teachers:
                _known(name, study.sets, "demonstration set", f"claim {claim.text!r}")


def _check_cycle(sets: Mapping[str, SetSpec], name: str, seen: tuple[str, ...]) -> None:
    if name in seen:
        raise StudyError(f"demonstration set {name!r} is made of itself")
    for part in sets[name].of:
        _check_cycle(sets, part, (*seen, name))


# -- reading tables ------------------------------------------------------------------------------------------------


def _make(kind: type[T], entry: Any, where: str) -> T:
    values = dict(_entry(entry, where))
    known = {field.name for field in fields(kind)}  # type: ignore[arg-type]
    _only(values, " ".join(sorted(known)), where)
    for key, value in values.items():
        if isinstance(value, list):
            values[key] = tuple(value)
    try:
        return kind(**values)
    except (TypeError, ValueError) as problem:
        raise StudyError(f"{where}: {problem}") from problem


def _parts(kind: type[T], data: Mapping[str, Any], key: str) -> tuple[T, ...]:
    return tuple(_make(kind, entry, f"{key} {number}") for number, entry in enumerate(_list(data, key), 1))


def _only(values: Mapping[str, Any], known: str, where: str) -> None:
    unknown = sorted(set(values) - set(known.split()))
    if unknown:
        raise StudyError(f"{where} has no entry {unknown[0]!r}; known are {', '.join(known.split())}")


def _table(data: Mapping[str, Any], key: str) -> dict[str, Any]:
    values = _entry(data.get(key, {}), f"[{key}]")
    if key == "defaults":
        _only(values, DEFAULTS, "[defaults]")
    return values


def _entry(entry: Any, where: str) -> dict[str, Any]:
    if not isinstance(entry, dict):
        raise StudyError(f"{where} must be a table, not {entry!r}")
    return entry


def _list(data: Mapping[str, Any], key: str) -> list[Any]:
    values = data.get(key, [])
    if not isinstance(values, list):
        raise StudyError(f"{key!r} must be a list of tables ([[{key}]])")
    return values


def _of_type(value: Any, kind: Any, where: str) -> Any:
    if not isinstance(value, kind) or isinstance(value, bool):
        raise StudyError(f"{where} has a value of the wrong kind: {value!r}")
    return value


def _known(name: str, known: Mapping[str, Any], what: str, where: str) -> None:
    if name not in known:
        raise StudyError(f"{where}: there is no {what} {name!r}; there are {', '.join(known) or 'none'}")


def _those(names: tuple[str, ...], kept: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(name for name in names if name in kept)
