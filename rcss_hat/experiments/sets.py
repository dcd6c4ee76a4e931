"""The demonstration sets of a study: found or made, summarised, measured, and kept in the experiment's folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs

from rcss_hat.experiments.demonstrating import demonstrate
from rcss_hat.experiments.study import Study, StudyError
from rcss_hat.experiments.study_parts import SetSpec
from rcss_hat.hat.decision_list import PAPER_RULES, DecisionList
from rcss_hat.hat.demonstrations import DemonstrationSet, combine
from rcss_hat.hat.mapping import map_rules
from rcss_hat.hat.summarize import summarize
from rcss_hat.inputs import FileFormatError, item
from rcss_hat.keepaway.task import Task
from rcss_hat.schema import did_you_mean
from rcss_hat.system.files import write_text

SUMMARY_SEED = 1
"""Of RIPPER's splits and the folds of cross-validation, for every set."""


@dataclass(frozen=True, slots=True, eq=False)
class PreparedSet:
    """A demonstration set, ready for use.

    Attributes
    ----------
    name, label : str
    demonstrations : DemonstrationSet or None
        None when the study gives rules instead.
    rules : DecisionList
        D.
    figures : dict
        Episodes, durations, shares of actions, accuracy of D and more; JSON data.
    """

    name: str
    label: str
    demonstrations: DemonstrationSet | None
    rules: DecisionList
    figures: dict[str, Any]


class SetStore:
    """The demonstration sets of one experiment, in files of its folder.

    Parameters
    ----------
    study : Study
    folder : Path
        ``NAME.csv`` and ``NAME.json`` (demonstrations), ``NAME.rules.json``, ``NAME.rules.txt`` and
        ``NAME.figures.json``.
    """

    def __init__(self, study: Study, folder: Path) -> None:
        self.study, self.folder = study, folder
        self._demonstrations: dict[str, DemonstrationSet] = {}

    def is_prepared(self, name: str) -> bool:
        """Whether the files of a set are there.

        Raises
        ------
        StudyError
            When they are of a set that the study now defines otherwise.
        """
        path = self._path(name, "figures.json")
        if not path.exists():
            return False
        if self._figures(name)["definition"] != self._definition(name):
            raise StudyError(
                f"{path} belongs to another definition of demonstration set {name!r}; use a new folder for the results"
            )
        return True

    def prepare(self, name: str) -> PreparedSet:
        """Make a set with everything that belongs to it, or read it when that was done before.

        Raises
        ------
        StudyError
            When it cannot be had; the message says why.
        """
        spec = self.study.sets[name]
        if self.is_prepared(name):
            return self._read(spec)
        try:
            if spec.rules is not None:
                prepared = self._from_rules(spec)
            else:
                prepared = self._from_demonstrations(spec)
        except (FileFormatError, FileNotFoundError) as problem:
            raise StudyError(f"demonstration set {name!r}: {problem}") from problem
        except StudyError:
            raise
        except ValueError as problem:
            raise StudyError(f"demonstration set {name!r}: {problem}") from problem
        if prepared.demonstrations is not None:
            prepared.demonstrations.save(self._path(name, "csv"))
        prepared.rules.save(self._path(name, "rules.json"))
        prepared.rules.save(self._path(name, "rules.txt"))
        # Last: who finds the figures finds everything.
        write_text(self._path(name, "figures.json"), json.dumps(prepared.figures, indent=1) + "\n")
        return prepared

    # -- making ------------------------------------------------------------------------------------------------------
    def demonstrations(self, name: str) -> DemonstrationSet:
        """Return the demonstrations of a set, without summarising them.

        Raises
        ------
        ValueError
            When the set is a decision list, or its definition cannot be followed.
        """
        if name not in self._demonstrations:
            self._demonstrations[name] = self._find(self.study.sets[name])
        return self._demonstrations[name]

    def _find(self, spec: SetSpec) -> DemonstrationSet:
        if spec.rules is not None:
            raise StudyError(f"set {spec.name!r} is a decision list; it has no demonstrations")
        if self._path(spec.name, "csv").exists() and self.is_prepared(spec.name):
            return DemonstrationSet.load(self._path(spec.name, "csv"))
        if spec.package is not None:
            found = package_demonstrations(spec.package)
        elif spec.file is not None:
            found = DemonstrationSet.load(self.study.folder / spec.file)
        elif spec.teacher is not None:
            assert spec.episodes is not None
            return demonstrate(self._task(spec), spec.teacher, spec.episodes, spec.seed)
        else:
            found = combine(self._picked(spec, name) for name in spec.of)
        return found

    def _picked(self, spec: SetSpec, name: str) -> DemonstrationSet:
        part, n = self.demonstrations(name), spec.episodes
        return part if spec.pick == "all" or n is None else part.split(n, spec.pick, spec.seed)[0]

    def _task(self, spec: SetSpec) -> Task:
        task = self.study.task
        if spec.size is None and spec.field is None:
            return task
        return Task.parse(spec.size or task.size, spec.field, task.vision, task.profile)

    def _from_demonstrations(self, spec: SetSpec) -> PreparedSet:
        demonstrations = self.demonstrations(spec.name)
        rules, figures = summary_of(demonstrations)
        figures = {"definition": self._definition(spec.name), **figures}
        return PreparedSet(spec.name, spec.title, demonstrations, self._mapped(spec, rules), figures)

    def _from_rules(self, spec: SetSpec) -> PreparedSet:
        assert spec.rules is not None
        task = self._task(spec)
        path = self.study.folder / spec.rules
        rules = PAPER_RULES if spec.rules == "paper" else DecisionList.load(path, task.keepers, task.takers)
        figures = {"definition": self._definition(spec.name), "rules": len(rules)}
        return PreparedSet(spec.name, spec.title, None, self._mapped(spec, rules), figures)

    def _mapped(self, spec: SetSpec, rules: DecisionList) -> DecisionList:
        if spec.map_to is None:
            return rules
        task = Task.parse(spec.map_to)
        return map_rules(rules, task.keepers, task.takers)

    # -- files -------------------------------------------------------------------------------------------------------
    def _read(self, spec: SetSpec) -> PreparedSet:
        table = self._path(spec.name, "csv")
        return PreparedSet(
            spec.name,
            spec.title,
            DemonstrationSet.load(table) if table.exists() else None,
            DecisionList.load(self._path(spec.name, "rules.json")),
            self._figures(spec.name),
        )

    def _figures(self, name: str) -> dict[str, Any]:
        path = self._path(name, "figures.json")
        try:
            figures: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            item(figures, "definition", str)
        except (ValueError, RecursionError) as problem:
            raise StudyError(f"{path} is damaged: {problem}; delete it, and the set is made again") from problem
        return figures

    def _path(self, name: str, ending: str) -> Path:
        return self.folder / f"{name}.{ending}"

    def _definition(self, name: str) -> str:
        """Return a short fingerprint of a set's definition, with all sets it is made of and the teacher's task."""

        def full(part: str) -> dict[str, Any]:
            spec = self.study.sets[part]
            entry = {k: v for k, v in structs.asdict(spec).items() if k not in ("name", "label")}
            entry["of"] = [full(name) for name in spec.of]
            if spec.teacher is not None:
                entry["task"] = asdict(self._task(spec))
            return entry

        return fingerprint(full(name))


def summary_of(demonstrations: DemonstrationSet) -> tuple[DecisionList, dict[str, Any]]:
    """Summarise demonstrations and measure what may matter about them.

    Returns
    -------
    DecisionList
    dict
        See `rcss_hat.experiments.predictors` for the meaning of the entries.
    """
    summary = summarize(demonstrations, SUMMARY_SEED)
    figures = summary.to_dict()
    text = figures.pop("text")
    figures.pop("confusion")
    return summary.decision_list, {**figures, **set_figures(demonstrations, summary.decision_list), "text": text}


def set_figures(demonstrations: DemonstrationSet, rules: DecisionList) -> dict[str, float]:
    """Measure a demonstration set: numbers that might predict how much it helps."""
    durations, y, X = demonstrations.durations, demonstrations.y, demonstrations.X
    description = demonstrations.describe()
    advised = rules.predict(X)
    passes = y > 0
    seconds = float(durations.sum())
    nearest_taker = demonstrations.info.task.keepers  # dist(K1,T1) comes after K1 to centre and the team mates
    return {
        "mean_s": float(durations.mean()),
        "sd_s": float(durations.std(ddof=1)) if len(durations) > 1 else 0.0,
        "shortest_s": float(durations.min()),
        "longest_s": float(durations.max()),
        "seconds": seconds,
        "pass_share": float(passes.mean()),
        "near_pass_share": float((y == 1).mean()),
        "far_pass_share": float((y > 1).mean()),
        "passes_per_s": float(passes.sum()) / seconds if seconds else 0.0,
        "taker_at_pass_m": float(X[passes, nearest_taker].mean()) if passes.any() else 0.0,
        "share_out": float(description.share_out),
        "coverage": float(np.mean(description.coverage)),
        "advised_pass_share": float((advised > 0).mean()),
    }


def package_demonstrations(name: str) -> DemonstrationSet:
    """Load a demonstration set that ships with the package.

    Raises
    ------
    StudyError
        When there is none of that name.

    Examples
    --------
    >>> from rcss_hat import package_demonstrations
    >>> len(package_demonstrations("A"))
    20
    """
    folder = files("rcss_hat.hat") / "data" / "demonstrations"
    known = (
        sorted(e.name.removesuffix(".csv") for e in folder.iterdir() if e.name.endswith(".csv"))
        if folder.is_dir()
        else []
    )
    if name not in known:
        raise StudyError(
            f"no demonstration set {name!r} ships with the package; there are {', '.join(known) or 'none'}"
            f"{did_you_mean(name, known)}"
        )
    with as_file(folder) as path:
        return DemonstrationSet.load(path / f"{name}.csv")


def fingerprint(data: Mapping[str, Any]) -> str:
    """Return a short hash of JSON data."""
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]
