"""One trial: a training run with evaluations before and after, as a plain function of plain data.

`run_trial` takes a job (JSON data) and a folder; `run_trial_away` takes the job alone and gives the files back, for
machines that share no disk. Both are top-level functions of a module, so that joblib and Dask can send them anywhere.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rcss_hat.experiments.demonstrating import watch
from rcss_hat.experiments.episode_log import CYCLES_PER_HOUR
from rcss_hat.experiments.evaluation import frozen_policy
from rcss_hat.experiments.run_folder import RunConfig, TrainingError, session_seed, versions
from rcss_hat.experiments.sets import fingerprint, summary_of
from rcss_hat.experiments.training import CHECKPOINT_S, TrainingRun
from rcss_hat.experiments.venue import Supply, Venue, venue
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.demonstrations import DemonstrationSet, combine
from rcss_hat.hat.transfer import Decisions, Learners
from rcss_hat.inputs import item
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.stage.place import Place
from rcss_hat.stage.stages import Part, open_stage
from rcss_hat.stage.terms import Terms
from rcss_hat.system.files import write_text
from rcss_hat.system.locks import sole_writer

RESULT = "result.json"
Job = dict[str, Any]
"""A trial as JSON data.

``condition``, ``trial``: for people. ``config``: `RunConfig.to_dict`. ``rules``: JSON text of a decision list, or None.
``demonstrations``: texts of a demonstration's table and header, or None. ``rounds``: list of ``{hour, rules}`` or
``{hour, watch, episodes}``. ``evaluation_episodes``: int.
"""
INITIAL, FINAL, WATCHED = range(1, 4)
"""Keys of the seeds of a trial's evaluations and of what its teachers watch."""
PATIENCE_S = 60.0
"""How long a trial waits for another process that runs it: a worker whose parent was killed is about to end."""


def read_result(folder: Path) -> dict[str, Any] | None:
    """Return the result of a finished trial, or None.

    Raises
    ------
    TrainingError
        When it is damaged.
    """
    path = folder / RESULT
    if not path.exists():
        return None
    try:
        result: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        item(result, "job", str)
    except (ValueError, RecursionError) as problem:
        raise TrainingError(f"{path} is damaged: {problem}; delete it, and the trial is run again") from problem
    return result


def run_trial(
    job: Job, folder: Path | str, checkpoint_s: float = CHECKPOINT_S, supply: Supply | None = None
) -> dict[str, Any]:
    """Run a trial, or what is missing of it.

    Parameters
    ----------
    job : dict
        See `Job`.
    folder : Path or str
        Of this trial alone. A finished trial is not run again, an interrupted one goes on at its last checkpoint.
    checkpoint_s : float
    supply : Supply, optional
        Servers, for trials that are played on some.

    Returns
    -------
    dict
        The result, as in ``result.json``.

    Raises
    ------
    TrainingError
        When the folder holds a trial of another job.
    InUse
        When another process runs it, and goes on to.
    """
    folder = Path(folder)
    with sole_writer(folder, patience=PATIENCE_S):
        return _run(job, folder, checkpoint_s, supply)


def _run(job: Job, folder: Path, checkpoint_s: float, supply: Supply | None) -> dict[str, Any]:
    known = read_result(folder)
    if known is not None:
        if known["job"] != fingerprint(job):
            raise TrainingError(f"{folder} holds a trial with other settings; use a new folder for the results")
        return known
    started = time.monotonic()
    config = RunConfig.from_dict(job["config"])
    rules = None if job["rules"] is None else DecisionList.from_json(job["rules"])
    demonstrations = _demonstrations(job)
    decisions = Decisions.of(*demonstrations.sequences()) if demonstrations and config.method.needs_decisions else None
    n, seed = job["evaluation_episodes"], config.seed
    tested = Tests(venue(config.stage, config.task, folder, supply), config, folder, n)
    result: dict[str, Any] = {
        "condition": job["condition"],
        "trial": job["trial"],
        "seed": seed,
        "job": fingerprint(job),
        "hours": config.hours,
        "initial": tested.result("initial", _fresh(config, decisions), rules, derived_seed(seed, INITIAL)),
        "greedy": None,
        "episodes": 0,
        "cycles": 0,
    }
    if config.hours > 0:
        with _opened(folder, config, rules, decisions) as run:
            _Lessons(run, tested.venue, checkpoint_s).learn(job["rounds"], demonstrations)
        result["greedy"] = tested.result("greedy", run.learners, run.rules, derived_seed(seed, FINAL))
        result["episodes"], result["cycles"] = run.episodes, run.cycles
    result["wall_s"] = round(time.monotonic() - started, 2)
    result["versions"] = versions()
    result |= tested.venue.account()
    write_text(folder / RESULT, json.dumps(result, indent=1) + "\n")
    tested.forget()
    return result


def run_trial_away(job: Job, supply: Supply | None = None) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Run a trial in a temporary folder of this machine; see `run_trial`.

    Returns
    -------
    dict
        The result.
    dict of str to bytes
        The files of the trial, by their paths in its folder.
    """
    with tempfile.TemporaryDirectory(prefix="rcss-hat-") as name:
        result = run_trial(job, name, supply=supply)
        files = [path for path in sorted(Path(name).rglob("*")) if path.is_file()]
        return result, {path.relative_to(name).as_posix(): path.read_bytes() for path in files}


def keep_files(folder: Path, contents: dict[str, bytes]) -> None:
    """Write the files that `run_trial_away` returned, the result last."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in sorted(contents, key=lambda name: name == RESULT):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(contents[name])


def _opened(folder: Path, config: RunConfig, rules: DecisionList | None, decisions: Decisions | None) -> TrainingRun:
    if not (folder / "config.json").exists():
        return TrainingRun.create(folder, config, rules, decisions)
    run = TrainingRun.open(folder)
    if run.config != config:
        raise TrainingError(f"{folder} holds a trial with other settings; use a new folder for the results")
    return run


@dataclass(frozen=True, slots=True)
class _Lessons:
    """The learning of a trial."""

    run: TrainingRun
    venue: Venue
    checkpoint_s: float

    def learn(self, rounds: list[dict[str, Any]], demonstrations: DemonstrationSet | None) -> None:
        """Train through all rounds; those behind the run are only made again as far as later ones need them."""
        run, gathered = self.run, demonstrations
        for number, entry in enumerate(rounds, 1):
            if run.round < number:
                self._train(round(entry["hour"] * CYCLES_PER_HOUR))
            if "watch" in entry:
                path = run.folder / f"watched-{number}.csv"
                if run.round < number:
                    _watched(run, entry, number).save(path)
                assert gathered is not None
                gathered = combine([gathered, DemonstrationSet.load(path)])
            if run.round < number:
                if "watch" in entry:
                    assert gathered is not None
                    rules = summary_of(gathered)[0]
                else:
                    rules = DecisionList.from_json(entry["rules"])
                run.new_round(rules)
        self._train()

    def _train(self, until: int | None = None) -> None:
        def match(place: Place, terms: Terms) -> tuple[RunReport, bool]:
            done = self.run.train(checkpoint_s=self.checkpoint_s, until=until, place=place, terms=terms)
            assert self.run.report is not None
            return self.run.report, done

        if self.run.cycles < (self.run.config.cycles if until is None else until):
            self.venue.play("training", match)


def _watched(run: TrainingRun, entry: dict[str, Any], number: int) -> DemonstrationSet:
    seed = derived_seed(run.config.seed, WATCHED, number)
    policy = frozen_policy(run.learners, run.rules, seed)
    return watch(run.config.task, policy, entry["watch"], entry["episodes"], seed)


def _fresh(config: RunConfig, decisions: Decisions | None) -> Learners:
    task = config.task
    learners = Learners.create(config.learner, config.method, task.keepers, task.takers, config.seed)
    if decisions is not None:
        config.method.prepare(learners, decisions)
    return learners


@dataclass(frozen=True, slots=True)
class Tests:
    """Evaluations of a trial: episodes without learning and exploration, kept until the trial has its result."""

    venue: Venue
    config: RunConfig
    folder: Path
    episodes: int

    def result(self, what: str, learners: Learners, rules: DecisionList | None, seed: int) -> dict[str, Any] | None:
        """Return what came of an evaluation, which is played unless it has been; None when there are no episodes."""
        if not self.episodes:
            return None
        path = self.folder / f"{what}.json"
        known = _kept(path)
        if known is None or (known.get("seed"), known.get("episodes")) != (seed, self.episodes):
            known = self._played(what, learners, rules, seed)
            write_text(path, json.dumps(known) + "\n")
        return known

    def forget(self) -> None:
        """Remove what the trial's result says, too."""
        for what in ("initial", "greedy"):
            (self.folder / f"{what}.json").unlink(missing_ok=True)

    def _played(self, what: str, learners: Learners, rules: DecisionList | None, seed: int) -> dict[str, Any]:
        episodes: list[Episode] = []
        matches = 0

        def match(place: Place, terms: Terms) -> tuple[RunReport, bool]:
            nonlocal matches
            drawn = session_seed(seed, matches)
            matches += 1
            policy = frozen_policy(learners, rules, drawn)
            with open_stage(place, self.config.task, drawn, policy, terms) as stage:
                report = stage.play(Part(self.episodes - len(episodes)))
            episodes.extend(report.episodes)
            return report, len(episodes) == self.episodes

        self.venue.play(what, match)
        durations = np.array([episode.cycles / 10.0 for episode in episodes])
        return {
            "seed": seed,
            "episodes": len(durations),
            "mean_s": float(durations.mean()),
            "sd_s": float(durations.std(ddof=1)) if len(durations) > 1 else 0.0,
            "out_share": float(np.mean([episode.reason == "o" for episode in episodes])),
        }


def _kept(path: Path) -> dict[str, Any] | None:
    """Read an evaluation that was kept; None when there is none, or none that can be read: it is played again."""
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return known if isinstance(known, dict) else None


def _demonstrations(job: Job) -> DemonstrationSet | None:
    if job["demonstrations"] is None:
        return None
    with tempfile.TemporaryDirectory(prefix="rcss-hat-") as name:
        for ending, text in job["demonstrations"].items():
            (Path(name) / f"demonstrations.{ending}").write_text(text, encoding="utf-8")
        return DemonstrationSet.load(Path(name) / "demonstrations.csv")
