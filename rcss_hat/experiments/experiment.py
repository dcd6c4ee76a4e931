"""An experiment: a study and a folder with everything that was made for it.

==========================  ============================================================================
``study.toml``              the study as it was given
``experiment.json``         what was asked for, versions, machine, duration
``sets/``                   demonstration sets and their summaries, see `rcss_hat.experiments.sets`
``trials/CONDITION/NN/``    training runs with ``result.json``, see `rcss_hat.experiments.trial`
``report/``                 tables, figures and pages, see `rcss_hat.experiments.reporting`
==========================  ============================================================================
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from msgspec import Struct

from rcss_hat.experiments.execution import Runner
from rcss_hat.experiments.run_folder import TrainingError, machine, versions
from rcss_hat.experiments.sets import PreparedSet, SetStore, fingerprint
from rcss_hat.experiments.study import Condition, Study, StudyError
from rcss_hat.experiments.study_file import load_study, parse_study, study_text
from rcss_hat.experiments.study_parts import Trials
from rcss_hat.experiments.trial import RESULT, Job, read_result
from rcss_hat.experiments.trial_records import TrialRecord, read_trial
from rcss_hat.inputs import FileFormatError
from rcss_hat.schema import read
from rcss_hat.system.files import write_text
from rcss_hat.system.locks import FOLDER_LOCK, SoleWriter
from rcss_hat.system.workers import WorkerDied, in_parallel

STUDY, INFO = "study.toml", "experiment.json"
FORMAT, VERSION = "rcss-hat experiment", 1
MOST_DEATHS = 10
"""Worker processes that may be killed before any trial ends."""


class ExperimentError(ValueError):
    """An experiment that cannot be made, resumed or reported; the message says why and what would be right."""


class Asked(Struct, frozen=True):
    """What ``experiment.json`` must say for an experiment to go on."""

    base: str
    only: tuple[str, ...]
    trials: Trials | None
    hours: float | None
    command: str
    seconds: float
    finished_trials: int
    versions: dict[str, str]
    machine: dict[str, Any]
    learner: str | None = None
    stage: str | None = None


class Experiment:
    """A study in a folder; make it with `create`, or open it for reading with `open`.

    One that was made with `create` holds its folder (`rcss_hat.system.locks.SoleWriter`) until `close`, or the end of
    the process.

    Attributes
    ----------
    folder : Path
    study : Study
        With the numbers of trials and hours that were asked for.
    info : dict
        Contents of ``experiment.json``.
    """

    def __init__(self, folder: Path, study: Study, info: dict[str, Any]) -> None:
        self._right: SoleWriter | None = None
        self.folder, self.study, self.info = folder, study, info
        self.sets = SetStore(study, folder / "sets")

    @classmethod
    def create(
        cls,
        name_or_path: str,
        folder: Path,
        trials: int | None = None,
        hours: float | None = None,
        only: tuple[str, ...] = (),
        command: str = "",
        learner: str | None = None,
        stage: str | None = None,
    ) -> Experiment:
        """Begin an experiment, or go on with the one in the folder.

        Parameters
        ----------
        name_or_path : str
            A study of the package or a TOML file.
        folder : Path
        trials, hours : optional
            Instead of those in the study.
        only : tuple of str
            Names of conditions; by default all.
        command : str
            How this was asked for, for the report.
        learner : str, optional
            A preset or file, instead of the learners in the study.
        stage : str, optional
            Where to play all conditions, instead of what the study says.

        Raises
        ------
        StudyError
            When the study is not valid.
        ExperimentError
            When the folder holds something else.
        InUse
            When another process runs the experiment in the folder.
        """
        text, base = study_text(name_or_path)
        study = load_study(name_or_path)
        if _is_foreign(folder):
            raise ExperimentError(f"{folder} is not empty and holds no experiment; give another folder")
        right = SoleWriter(folder)
        known = _read_info(folder) if (folder / INFO).exists() else None
        asked = {"trials": trials, "hours": hours, "only": list(only), "learner": learner, "stage": stage}
        info = {
            "format": FORMAT,
            "version": VERSION,
            "study": name_or_path,
            "base": str(base),
            **asked,
            "command": command,
            "seconds": 0.0,
            "finished_trials": 0,
            **({} if known is None else {k: known[k] for k in ("seconds", "finished_trials")}),
            "versions": versions(),
            "machine": machine(),
        }
        experiment = cls(folder, _as_asked(study, info), info)
        experiment._right = right
        experiment.check()
        write_text(folder / STUDY, text)
        experiment._write_info()
        return experiment

    @classmethod
    def open(cls, folder: Path) -> Experiment:
        """Open an experiment for reporting.

        Raises
        ------
        ExperimentError
            When the folder holds none.
        """
        info = _read_info(folder)
        try:
            study = parse_study((folder / STUDY).read_text(encoding="utf-8"), Path(info["base"]))
        except (FileNotFoundError, StudyError) as problem:
            raise ExperimentError(f"{folder / STUDY} is not valid: {problem}") from problem
        return cls(folder, _as_asked(study, info), info)

    def close(self) -> None:
        """Let other processes go on with the experiment."""
        if self._right is not None:
            self._right.release()

    # -- work --------------------------------------------------------------------------------------------------------
    def trial_folder(self, condition: str, trial: int) -> Path:
        """Return the folder of a trial."""
        return self.folder / "trials" / condition / f"{trial:02d}"

    def used_sets(self) -> list[str]:
        """Names of the demonstration sets that conditions and figures need."""
        used: dict[str, None] = {}
        for condition in self.study.conditions.values():
            for name in (condition.demonstrations, *(r.demonstrations for r in condition.rounds)):
                if name is not None:
                    used[name] = None
        for figure in self.study.figures:
            used |= dict.fromkeys(figure.teachers)
        return list(used)

    def prepare_sets(self, processes: int = 1, told: Callable[[int, int], None] | None = None) -> None:
        """Make and summarise all demonstration sets that are not there yet.

        Parameters
        ----------
        processes : int
        told : callable, optional
            Told (sets ready, sets in all).

        Raises
        ------
        StudyError
            When a set cannot be had.
        """
        names = self.used_sets()
        missing = [name for name in names if not self.sets.is_prepared(name)]
        # Pools that several sets are drawn from are made once, here, and read by the others.
        parts = {part for name in missing for part in self.study.sets[name].of}
        pools = [p for p in self.study.sets if p in parts and self.study.sets[p].teacher is not None]
        for name in [p for p in pools if p not in missing and not self.sets.is_prepared(p)]:
            self.sets.prepare(name)
        first = [name for name in missing if name in pools]
        rest = [name for name in missing if name not in pools]
        ready = len(names) - len(missing)
        # The first one is made in this process, so that the others find the compiled kernels in the cache.
        for part in ([*first, *rest][:1], first[1:], rest if first else rest[1:]):
            work = [(self.study, self.sets.folder, name) for name in part]
            for _ in in_parallel(_prepare, work, processes if len(part) > 1 else 1):
                ready += 1
                if told is not None:
                    told(ready, len(names))

    def job(self, condition: Condition, trial: int) -> Job:
        """Describe a trial as data; its demonstration sets must be prepared."""
        uses = condition.demonstrations
        prepared = self.sets.prepare(uses) if uses is not None else None
        needs_decisions = condition.method.needs_decisions or any(r.watch for r in condition.rounds)
        return {
            "condition": condition.name,
            "trial": trial,
            "config": condition.run_config(self.study.trial_seed(condition.name, trial)).to_dict(),
            "rules": prepared.rules.to_json() if prepared and condition.method.needs_advice else None,
            "demonstrations": _texts(self.sets.folder, prepared) if needs_decisions else None,
            "rounds": [
                {"hour": r.hour, "watch": r.watch, "episodes": r.episodes}
                if r.watch is not None
                else {"hour": r.hour, "rules": self.sets.prepare(str(r.demonstrations)).rules.to_json()}
                for r in condition.rounds
            ],
            "evaluation_episodes": condition.evaluation_episodes,
        }

    def check(self) -> None:
        """Check that what the folder holds belongs to this study.

        Raises
        ------
        ExperimentError
        """
        try:
            ready = [self.sets.is_prepared(name) for name in self.used_sets()]
        except StudyError as problem:
            raise ExperimentError(str(problem)) from problem
        if not all(ready):
            return
        for condition in self.study.conditions.values():
            for trial in self._ended(condition):
                try:
                    known = read_result(self.trial_folder(condition.name, trial))
                except TrainingError as problem:
                    raise ExperimentError(str(problem)) from problem
                if known is not None and known["job"] != fingerprint(self.job(condition, trial)):
                    raise ExperimentError(
                        f"{self.trial_folder(condition.name, trial)} was run with other settings than the study now "
                        "has; use a new folder for the results"
                    )

    def missing(self) -> Iterator[tuple[Job, Path]]:
        """Describe trials that have not ended, with their folders; first trials of all conditions come first.

        Yields
        ------
        dict, Path
            Made when they are asked for: a study may have more trials than there is room to list.
        """
        most = max(condition.trials for condition in self.study.conditions.values())
        for trial in range(most):
            for condition in self.study.conditions.values():
                folder = self.trial_folder(condition.name, trial)
                if trial < condition.trials and not (folder / RESULT).exists():
                    yield self.job(condition, trial), folder

    @property
    def n_trials(self) -> int:
        """Number of trials of the study."""
        return sum(condition.trials for condition in self.study.conditions.values())

    @property
    def finished(self) -> int:
        """Number of trials that have ended."""
        return sum(len(self._ended(condition)) for condition in self.study.conditions.values())

    def _ended(self, condition: Condition) -> list[int]:
        """Return the numbers of the trials that have ended, as far as the study has them, in order."""
        folders = [path.parent for path in self.trial_folder(condition.name, 0).parent.glob(f"*/{RESULT}")]
        numbers = {int(folder.name): folder for folder in folders if folder.name.isdecimal()}
        ours = (n for n, folder in numbers.items() if folder == self.trial_folder(condition.name, n))
        return sorted(n for n in ours if n < condition.trials)

    def run(self, runner: Runner) -> Iterator[dict[str, Any]]:
        """Run what is missing, yielding results as they come; when worker processes are killed, others go on.

        Parameters
        ----------
        runner : callable
            See `rcss_hat.experiments.execution`.

        Raises
        ------
        ExperimentError
            When worker processes are killed again and again before any trial ends.
        """
        last, deaths = time.monotonic(), 0
        while True:
            try:
                for result in runner(self.missing()):
                    now, deaths = time.monotonic(), 0
                    self.info["seconds"] = round(self.info["seconds"] + now - last, 1)
                    self.info["finished_trials"] += 1
                    last = now
                    self._write_info()
                    yield result
                return
            except WorkerDied as problem:
                deaths += 1
                if deaths == MOST_DEATHS:
                    raise ExperimentError(f"{deaths} times in a row {problem}") from problem

    # -- results -----------------------------------------------------------------------------------------------------
    def trials(self, condition: str) -> list[TrialRecord]:
        """Read the finished trials of a condition, in order."""
        ended = self._ended(self.study.conditions[condition])
        return [record for trial in ended if (record := read_trial(self.trial_folder(condition, trial))) is not None]

    def _write_info(self) -> None:
        write_text(self.folder / INFO, json.dumps(self.info, indent=1) + "\n")


def _as_asked(study: Study, info: dict[str, Any]) -> Study:
    if info["only"]:
        study = study.chosen(tuple(info["only"]))
    if info.get("learner"):
        study = study.learned_by(info["learner"])
    if info.get("stage"):
        study = study.played_on(info["stage"])
    return study.scaled(info["trials"], info["hours"])


def _is_foreign(folder: Path) -> bool:
    """Whether a folder holds something, and no experiment."""
    if (folder / INFO).exists() or not folder.exists():
        return False
    return any(entry.name != FOLDER_LOCK for entry in folder.iterdir())


def _read_info(folder: Path) -> dict[str, Any]:
    try:
        info = json.loads((folder / INFO).read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError) as problem:
        raise ExperimentError(f"{folder} is not the folder of an experiment: it has no {INFO}") from problem
    except (ValueError, RecursionError) as problem:
        raise ExperimentError(f"{folder / INFO} is not valid: {problem}") from problem
    if not isinstance(info, dict) or info.get("format") != FORMAT or info.get("version") != VERSION:
        raise ExperimentError(f"{folder / INFO} is not of an experiment of this version")
    try:
        read(Asked, info, str(folder / INFO))
    except FileFormatError as problem:
        raise ExperimentError(str(problem)) from problem
    return info


def _prepare(study: Study, folder: Path, name: str) -> str:
    SetStore(study, folder).prepare(name)
    return name


def _texts(folder: Path, prepared: PreparedSet | None) -> dict[str, str] | None:
    if prepared is None or prepared.demonstrations is None:
        return None
    return {e: (folder / f"{prepared.name}.{e}").read_text(encoding="utf-8") for e in ("csv", "json")}
