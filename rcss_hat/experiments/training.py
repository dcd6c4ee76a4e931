"""One training run: a folder that holds its settings, weights and episodes, and from which it can go on.

========================  ==============================================================================
``config.json``           task, learner, method, seed, hours, versions; never changes
``rules.json``            the decision list, where the method uses one
``learners.npz``          weights and everything else that learning needs to go on; replaced at every checkpoint
``episodes.csv``          one row per episode, see `rcss_hat.experiments.episode_log`
========================  ==============================================================================

A checkpoint says how many bytes of the log belong to it. A run that was killed is resumed from its last checkpoint,
and the log is cut back to it; in the arena everything that follows is then the same, number for number, as if nothing
had happened. While a run is open no other process can open it.
"""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import pandas as pd
from numpy.typing import NDArray

from rcss_hat.experiments.episode_log import CYCLES_PER_HOUR, EpisodeLog, EpisodeLogError, read_episode_log
from rcss_hat.experiments.run_folder import (
    ARENA_PREFIX,
    CONFIG,
    FORMAT,
    VERSION,
    RunConfig,
    TrainingError,
    arena_arrays,
    read_config,
    read_run,
    run_state,
    session_seed,
    versions,
)
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.policy import RUN_RULES, RUN_WEIGHTS, TeamPolicy, learners_policy
from rcss_hat.hat.transfer import Decisions, Learners
from rcss_hat.inputs import load_json, read_text
from rcss_hat.keepaway.report import Episode, RunReport, mean_and_ci95, shifted
from rcss_hat.learning.exploration import NO_ACTION
from rcss_hat.stage.place import Place
from rcss_hat.stage.stages import Part, open_stage
from rcss_hat.stage.terms import Terms
from rcss_hat.system.files import named, write_text
from rcss_hat.system.locks import SoleWriter

EPISODES = "episodes.csv"
WINDOW = 1000
"""Episodes of the sliding mean, as in the paper."""
CHECKPOINT_S = 60.0
"""Wall time between checkpoints, seconds."""


class TrainingRun:
    """A training run; make it with `create`, or open it again with `open`.

    It holds its folder (`rcss_hat.system.locks.SoleWriter`) until `close`, the end of a ``with``, or of the process.

    Attributes
    ----------
    folder : Path
    config : RunConfig
    learners : Learners
    rules : DecisionList or None
    cycles, episodes : int
        Played so far, over all sessions.
    sessions : int
        How often a server was joined; 0 for the arena.
    round : int
        How often the rules were replaced, see `new_round`.
    reuse_from : int
        Episodes played before reuse of the rules began, or began anew.
    report : RunReport or None
        Of the last match.
    recent : deque of int
        Durations of the last `WINDOW` episodes, cycles.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from rcss_hat import METHODS, RunConfig, Task, TrainingRun, load_config
    >>> config = RunConfig(task=Task(), learner=load_config("best"), method=METHODS["no-prior"](), seed=1, hours=0.1)
    >>> with tempfile.TemporaryDirectory() as folder, TrainingRun.create(Path(folder), config) as run:
    ...     run.train()
    True
    """

    def __init__(self, folder: Path, config: RunConfig, learners: Learners, rules: DecisionList | None) -> None:
        self._right = SoleWriter(folder)
        self.folder, self.config, self.learners, self.rules = folder, config, learners, rules
        self.log = EpisodeLog(folder / EPISODES)
        self.cycles = self.episodes = self.sessions = self.round = self.reuse_from = 0
        self.recent: deque[int] = deque(maxlen=WINDOW)
        self._arena: dict[str, NDArray[Any]] = {}
        self.report: RunReport | None = None
        self._session_cycle = self._session_episode = self._session_log = 0
        self._session_start: int | None = 0

    # -- making and opening ------------------------------------------------------------------------------------------
    @classmethod
    def create(
        cls,
        folder: Path,
        config: RunConfig,
        rules: DecisionList | None = None,
        demonstrations: Decisions | None = None,
    ) -> TrainingRun:
        """Begin a run in a new or empty folder.

        Parameters
        ----------
        folder : Path
        config : RunConfig
        rules : DecisionList, optional
            D; needed by methods with advice, refused by others.
        demonstrations : Decisions, optional
            Needed by methods that replay them.

        Raises
        ------
        TrainingError
            When the folder holds a run already, or the method lacks what it needs.
        InUse
            When another process makes a run there.
        """
        _refuse_second(folder)
        task, method = config.task, config.method
        if method.needs_advice and rules is None:
            raise TrainingError(f"transfer method {method.name} needs rules: a decision list")
        if rules is not None and not method.needs_advice:
            raise TrainingError(f"transfer method {method.name} uses no rules")
        if rules is not None and (rules.keepers, rules.takers) != (task.keepers, task.takers):
            raise TrainingError(f"the rules are for {rules.keepers}v{rules.takers}; the task is {task.size}")
        if method.needs_decisions and demonstrations is None:
            raise TrainingError(f"transfer method {method.name} needs demonstrations")
        learners = Learners.create(config.learner, method, task.keepers, task.takers, config.seed)
        if method.needs_decisions and demonstrations is not None:
            method.prepare(learners, demonstrations)
        with SoleWriter(folder):
            _refuse_second(folder)  # another process may have been faster
            (folder / EPISODES).unlink(missing_ok=True)
            if rules is not None:
                rules.save(folder / RUN_RULES)
            run = cls(folder, config, learners, rules)
            run.checkpoint()
            # Last, so that a folder with settings is always one that can be resumed.
            data = {"format": FORMAT, "version": VERSION, **config.to_dict(), "versions": versions()}
            write_text(folder / CONFIG, json.dumps(data, indent=1) + "\n")
        return run

    @classmethod
    def open(cls, folder: Path) -> TrainingRun:
        """Open a run at its last checkpoint, dropping what its log holds beyond it.

        Raises
        ------
        TrainingError
            When the folder holds no run, or files of it are missing, damaged or of another version.
        InUse
            When another process goes on with it.
        """
        read_config(folder)  # what is no run is not locked
        with SoleWriter(folder):
            return cls._reopened(folder)

    @classmethod
    def _reopened(cls, folder: Path) -> TrainingRun:
        saved = read_run(folder)
        run = cls(folder, saved.config, saved.learners, saved.rules)
        try:
            state = run_state(saved.checkpoint)
            durations = run.log.check(state["log_bytes"], state["episodes"])
            run._arena = arena_arrays(saved, state)
        except (EpisodeLogError, ValueError) as problem:
            raise TrainingError(f"{folder} cannot be resumed: {problem}") from problem
        run.log.cut(state["log_bytes"])
        run.cycles, run.episodes = state["cycles"], state["episodes"]
        run.sessions, run.round, run.reuse_from = state["sessions"], state["round"], state["reuse_from"]
        run.recent = _recent(durations)
        return run

    def close(self) -> None:
        """Let other processes go on with the run; it is not to be used afterwards."""
        self._right.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def extend(self, hours: float) -> None:
        """Let the run go on for longer than it was made for; shorter changes nothing."""
        if hours <= self.config.hours:
            return
        self.config = replace(self.config, hours=hours)
        data = load_json(read_text(self.folder / CONFIG, "training run"))
        write_text(self.folder / CONFIG, json.dumps({**data, "hours": hours}, indent=1) + "\n")

    # -- state -------------------------------------------------------------------------------------------------------
    @property
    def policy(self) -> TeamPolicy:
        """The learners as a team's policy; they go on learning as they play."""
        return learners_policy(self.learners, self.rules, self.config.method.name)

    @property
    def place(self) -> Place:
        """Where it is played."""
        return Place.parse(self.config.stage)

    @property
    def hours(self) -> float:
        """Simulated hours played so far."""
        return self.cycles / CYCLES_PER_HOUR

    @property
    def done(self) -> bool:
        """Whether the run has played all its hours."""
        return self.cycles >= self.config.cycles

    @property
    def failure(self) -> str | None:
        """What ended the last match early."""
        return None if self.report is None else self.report.failure

    @property
    def windowed_mean(self) -> float:
        """Mean duration of the last `WINDOW` episodes, seconds; nan before the first."""
        return mean_and_ci95([cycles / 10.0 for cycles in self.recent])[0]

    def checkpoint(self, arena: Mapping[str, NDArray[Any]] | None = None) -> None:
        """Save everything, so that the run can go on from here.

        Parameters
        ----------
        arena : mapping of str to ndarray, optional
            What `ArenaMatch.arrays` returned.
        """
        state = {
            "cycles": self.cycles,
            "episodes": self.episodes,
            "sessions": self.sessions,
            "round": self.round,
            "reuse_from": self.reuse_from,
            "log_bytes": self.log.size,
        }
        arrays = {ARENA_PREFIX + name: array for name, array in (arena or {}).items()}
        with named(self.folder / RUN_WEIGHTS):
            self.learners.save(self.folder / RUN_WEIGHTS, {"run": state}, arrays)

    # -- on a server -------------------------------------------------------------------------------------------------
    def begin_session(self) -> None:
        """Prepare for joining a server: its clock starts anew, and half an episode cannot be carried over.

        The next one has another seed.
        """
        self._session_cycle, self._session_episode, self._session_log = self.cycles, self.episodes, self.log.size
        self._session_start = None  # known with the first episode
        self.learners.records["last_action"] = NO_ACTION
        self.learners.records["episode_decisions"] = 0
        # A keeper counts an episode when it next decides, so at a checkpoint some may have been a step behind.
        self.learners.records["episodes"] = self.episodes - self.reuse_from
        self.sessions += 1

    def record(self, episodes: Sequence[Episode]) -> None:
        """Log episodes that have just ended.

        Parameters
        ----------
        episodes : sequence of Episode
            Numbered, and in cycles counted, as in their match.
        """
        counted = self._counted(episodes)
        if not counted:
            return
        self.log.append(counted, self._psi)
        self.recent.extend(e.cycles for e in counted)
        self.episodes = counted[-1].number
        self.cycles = max(self.cycles, counted[-1].end)

    def settle(self, episodes: Sequence[Episode]) -> None:
        """Log the episodes of this session on a server again, as the server's own log has them: with its reasons.

        Does nothing when they are not as many as were recorded.
        """
        known = self._counted(episodes) if self.sessions else []
        if known and len(known) == self.episodes - self._session_episode:
            self.log.replace(self._session_log, known, self._psi)
            self.cycles = max(self.cycles, known[-1].end)
            self.recent = _recent(read_episode_log(self.log.path)["duration"])

    def _counted(self, episodes: Sequence[Episode]) -> list[Episode]:
        """Number and time episodes of this session as they count in the run."""
        if self._session_start is None and episodes:
            self._session_start = episodes[0].start
        return shifted(episodes, self._session_episode, self._session_cycle - (self._session_start or 0))

    def _psi(self, number: int) -> float | None:
        return self.config.method.psi_after(number - self.reuse_from)

    # -- learning ----------------------------------------------------------------------------------------------------
    def train(
        self,
        progress: Callable[[TrainingRun], None] | None = None,
        stop: Callable[[], bool] | None = None,
        checkpoint_s: float = CHECKPOINT_S,
        until: int | None = None,
        place: Place | None = None,
        terms: Terms | None = None,
    ) -> bool:
        """Learn until all hours are played.

        Parameters
        ----------
        progress : callable, optional
            Called in the arena about once per simulated hour, on a server after every episode.
        stop : callable, optional
            Asked as often; true ends training after a checkpoint.
        checkpoint_s : float
            Wall time between checkpoints, seconds. In the arena it does not influence the results.
        until : int, optional
            Stop after so many cycles in all, for example to begin a new round.
        place : Place, optional
            Instead of the settings' (the same with an executable, for example).
        terms : Terms, optional
            Of a server.

        Returns
        -------
        bool
            Whether so much was played. If not, it was stopped, or ``failure`` says what ended it early; a checkpoint
            was made in any case.
        """
        last = self.config.cycles if until is None else min(until, self.config.cycles)
        if self.cycles >= last:
            return True
        place, begun = place or self.place, self.cycles
        seed = session_seed(self.config.seed, self.sessions)
        with open_stage(place, self.config.task, seed, self.policy, terms) as stage:
            if not stage.waits:
                self.begin_session()
            elif self._arena:
                stage.restore(self._arena)
            before, saved = begun - stage.cycle, time.monotonic()

            def told(episodes: Sequence[Episode], cycle: int) -> bool:
                nonlocal saved
                self.record(episodes)
                self.cycles = max(self.cycles, before + cycle)
                if progress is not None:
                    progress(self)
                if time.monotonic() - saved >= checkpoint_s:
                    self.checkpoint(stage.arrays())
                    saved = time.monotonic()
                return self.cycles >= last or (stop is not None and stop())

            report = stage.play(Part(cycles=last - before, on_episodes=told))
            self.settle(report.episodes)
            self.cycles = max(self.cycles, begun + report.cycles)
            self._arena = stage.arrays()
            self.checkpoint(self._arena)
        self.report = report
        return self.cycles >= last

    def new_round(self, rules: DecisionList) -> None:
        """Replace the rules and let their reuse begin anew, keeping what has been learned.

        Between calls of `train`. The method counts episodes from here: psi is 1 again, forced episodes are forced
        again.
        """
        rules.save(self.folder / RUN_RULES)
        self.rules = rules
        self.round += 1
        self.reuse_from = self.episodes
        self.learners.records["episodes"] = 0
        self.checkpoint(self._arena)


def _refuse_second(folder: Path) -> None:
    if (folder / CONFIG).exists():
        raise TrainingError(f"{folder} holds a training run already; resume it, or give another folder")


def _recent(durations: pd.Series) -> deque[int]:
    return deque((int(cycles) for cycles in durations[-WINDOW:]), maxlen=WINDOW)
