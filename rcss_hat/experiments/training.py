"""One training run: a folder that holds its settings, weights and episodes, and from which it can go on.

========================  ==============================================================================
``config.json``           task, learner, method, seed, hours, versions; never changes
``rules.json``            the decision list, where the method uses one
``learners.npz``          weights and everything else that learning needs to go on; replaced at every checkpoint
``episodes.csv``          one row per episode, see `rcss_hat.experiments.episode_log`
========================  ==============================================================================

A checkpoint says how many bytes of the log belong to it. A run that was killed is resumed from its last checkpoint,
and the log is cut back to it; in the arena everything that follows is then the same, number for number, as if nothing
had happened.
"""

from __future__ import annotations

import json
import platform
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rcss_hat import __version__
from rcss_hat.arena.match import ArenaMatch
from rcss_hat.experiments.episode_log import CYCLES_PER_HOUR, EpisodeLog, EpisodeLogError, read_episode_log
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.files import write_text
from rcss_hat.hat.policy import RUN_RULES, RUN_WEIGHTS, TeamPolicy, learners_policy
from rcss_hat.hat.transfer import CHAT, PPR, Decisions, Learners, TransferMethod, make_method, parameters
from rcss_hat.keepaway.report import Episode, mean_and_ci95
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.checkpoint import load_checkpoint
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.learning.exploration import NO_ACTION

CONFIG, EPISODES = "config.json", "episodes.csv"
FORMAT, VERSION = "rcss-hat training run", 1
ARENA = "arena"
WINDOW = 1000
"""Episodes of the sliding mean, as in the paper."""
CHECKPOINT_S = 60.0
"""Wall time between checkpoints, seconds."""
_PREFIX = "arena_"


class TrainingError(ValueError):
    """A training run that cannot be made or resumed; the message says why and what would be right."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunConfig:
    """Everything that decides a training run, apart from the decision list.

    Attributes
    ----------
    task : Task
    learner : LearnerConfig
    method : TransferMethod
    seed : int
        Of the match and the learners.
    hours : float
        Simulated hours to learn for.
    stage : str
        Where it is played: ``arena``, ``fake``, ``real`` or ``HOST:PORT``.
    source : str
        Where rules or demonstrations came from, for people.
    """

    task: Task
    learner: LearnerConfig
    method: TransferMethod
    seed: int
    hours: float
    stage: str = ARENA
    source: str = ""

    def __post_init__(self) -> None:
        """Check what the parts have not checked themselves."""
        if not (isinstance(self.hours, int | float) and 0.0 <= self.hours <= 10_000.0):
            raise ValueError(f"hours must be 0 to 10000, not {self.hours!r}")
        if self.seed < 0:
            raise ValueError(f"a seed is a whole number of at least 0, not {self.seed}")

    @property
    def cycles(self) -> int:
        """Simulated cycles to learn for."""
        return round(self.hours * CYCLES_PER_HOUR)

    def to_dict(self) -> dict[str, Any]:
        """Return JSON data; `from_dict` takes it back."""
        return {
            "task": asdict(self.task),
            "learner": self.learner.to_dict(),
            "method": self.method.name,
            "method_settings": parameters(self.method),
            "seed": self.seed,
            "hours": self.hours,
            "stage": self.stage,
            "source": self.source,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> RunConfig:
        """Make a configuration from what `to_dict` returned.

        Raises
        ------
        ValueError, KeyError, TypeError
            When something is missing, unknown or not allowed.
        """
        return cls(
            task=Task(**data["task"]),
            learner=LearnerConfig.from_dict(data["learner"]),
            method=make_method(data["method"], data["method_settings"]),
            seed=data["seed"],
            hours=data["hours"],
            stage=data["stage"],
            source=data["source"],
        )


class TrainingRun:
    """A training run; make it with `create`, or open it again with `open`.

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
    recent : deque of int
        Durations of the last `WINDOW` episodes, cycles.
    """

    def __init__(self, folder: Path, config: RunConfig, learners: Learners, rules: DecisionList | None) -> None:
        self.folder, self.config, self.learners, self.rules = folder, config, learners, rules
        self.log = EpisodeLog(folder / EPISODES)
        self.cycles = self.episodes = self.sessions = self.round = self.reuse_from = 0
        self.recent: deque[int] = deque(maxlen=WINDOW)
        self._arena: dict[str, NDArray[Any]] = {}
        self._session_cycle = self._session_episode = self._session_log = 0

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
        """
        if (folder / CONFIG).exists():
            raise TrainingError(f"{folder} holds a training run already; resume it, or give another folder")
        task, method = config.task, config.method
        if method.needs_advice and rules is None:
            raise TrainingError(f"transfer method {method.name} needs rules: a decision list")
        if rules is not None and not method.needs_advice:
            raise TrainingError(f"transfer method {method.name} uses no rules")
        if rules is not None and (rules.keepers, rules.takers) != (task.keepers, task.takers):
            raise TrainingError(f"the rules are for {rules.keepers}v{rules.takers}; the task is {task.size}")
        if method.replay_passes and demonstrations is None:
            raise TrainingError(f"transfer method {method.name} needs demonstrations")
        learners = Learners.create(config.learner, method, task.keepers, task.takers, config.seed)
        if method.replay_passes and demonstrations is not None:
            learners.replay(demonstrations)
        folder.mkdir(parents=True, exist_ok=True)
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
        """
        try:
            config = read_config(folder)
            learners = Learners.load(folder / RUN_WEIGHTS)
            saved = load_checkpoint(folder / RUN_WEIGHTS)
            rules = DecisionList.load(folder / RUN_RULES) if (folder / RUN_RULES).exists() else None
            state = saved.header["run"]
            run = cls(folder, config, learners, rules)
            run.log.cut(int(state["log_bytes"]))
            run.cycles, run.episodes = int(state["cycles"]), int(state["episodes"])
            run.sessions, run.round = int(state["sessions"]), int(state["round"])
            run.reuse_from = int(state["reuse_from"])
            durations = read_episode_log(run.log.path)["duration"]
        except (FileNotFoundError, EpisodeLogError, KeyError) as problem:
            raise TrainingError(f"{folder} cannot be resumed: {problem}") from problem
        except TrainingError:
            raise
        except ValueError as problem:
            raise TrainingError(str(problem)) from problem
        if len(durations) != run.episodes:
            raise TrainingError(f"{run.log.path} has {len(durations)} episodes, its checkpoint {run.episodes}")
        run.recent = _recent(durations)
        run._arena = {name.removeprefix(_PREFIX): a for name, a in saved.arrays.items() if name.startswith(_PREFIX)}
        return run

    def extend(self, hours: float) -> None:
        """Let the run go on for longer than it was made for; shorter changes nothing."""
        if hours <= self.config.hours:
            return
        self.config = replace(self.config, hours=hours)
        data = json.loads((self.folder / CONFIG).read_text(encoding="utf-8"))
        write_text(self.folder / CONFIG, json.dumps({**data, "hours": hours}, indent=1) + "\n")

    # -- state -------------------------------------------------------------------------------------------------------
    @property
    def policy(self) -> TeamPolicy:
        """The learners as a team's policy; they go on learning as they play."""
        return learners_policy(self.learners, self.rules, self.config.method.name)

    @property
    def hours(self) -> float:
        """Simulated hours played so far."""
        return self.cycles / CYCLES_PER_HOUR

    @property
    def done(self) -> bool:
        """Whether the run has played all its hours."""
        return self.cycles >= self.config.cycles

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
        arrays = {_PREFIX + name: array for name, array in (arena or {}).items()}
        self.learners.save(self.folder / RUN_WEIGHTS, {"run": state}, arrays)

    # -- over UDP ----------------------------------------------------------------------------------------------------
    def begin_session(self) -> int:
        """Prepare for joining a server: its clock starts anew, and half an episode cannot be carried over.

        Returns
        -------
        int
            Seed for this session, another one than those of sessions before.
        """
        self._session_cycle, self._session_episode, self._session_log = self.cycles, self.episodes, self.log.size
        self.learners.records["last_action"] = NO_ACTION
        self.learners.records["episode_decisions"] = 0
        # A keeper counts an episode when it next decides, so at a checkpoint some may have been a step behind.
        self.learners.records["episodes"] = self.episodes - self.reuse_from
        seed = session_seed(self.config.seed, self.sessions)
        self.sessions += 1
        return seed

    def record(self, episodes: Iterable[Episode]) -> None:
        """Log episodes that have just ended.

        Parameters
        ----------
        episodes : iterable of Episode
            Numbered, and in cycles counted, from the begin of the match or session.
        """
        counted = [
            Episode(
                e.number + self._session_episode, e.start + self._session_cycle, e.end + self._session_cycle, e.reason
            )
            for e in episodes
        ]
        if not counted:
            return
        self.log.append(counted, lambda number: psi_after(self.config.method, number - self.reuse_from))
        self.recent.extend(e.cycles for e in counted)
        self.episodes = counted[-1].number
        self.cycles = max(self.cycles, counted[-1].end)

    def settle(self, episodes: Iterable[Episode]) -> None:
        """Log the episodes of this session again, as the server's own log has them: with its reasons.

        Does nothing when they are not as many as were recorded.
        """
        known = list(episodes)
        if len(known) == self.episodes - self._session_episode:
            self.log.cut(self._session_log)
            self.record(known)
            self.recent = _recent(read_episode_log(self.log.path)["duration"])

    # -- in the arena ------------------------------------------------------------------------------------------------
    def train(
        self,
        progress: Callable[[TrainingRun], None] | None = None,
        stop: Callable[[], bool] | None = None,
        checkpoint_s: float = CHECKPOINT_S,
        until: int | None = None,
    ) -> bool:
        """Learn in the arena until all hours are played.

        Parameters
        ----------
        progress : callable, optional
            Called about once per simulated hour.
        stop : callable, optional
            Asked as often; true ends training after a checkpoint.
        checkpoint_s : float
            Wall time between checkpoints, seconds. It does not influence the results.
        until : int, optional
            Stop after so many cycles in all, for example to begin a new round.

        Returns
        -------
        bool
            Whether it was not stopped.
        """
        last = self.config.cycles if until is None else min(until, self.config.cycles)
        if self.cycles >= last:
            return True
        match = ArenaMatch(self.config.task, self.config.seed, self.policy)
        if self._arena:
            match.restore(self._arena)
        saved = time.monotonic()
        for episodes in match.advance(cycles=last):
            self.record(episodes)
            self.cycles = match.cycle
            if progress is not None:
                progress(self)
            stopping = stop is not None and stop()
            if stopping or self.cycles >= last or time.monotonic() - saved >= checkpoint_s:
                self._arena = match.arrays()
                self.checkpoint(self._arena)
                saved = time.monotonic()
            if stopping:
                break
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


def _recent(durations: pd.Series) -> deque[int]:
    return deque((int(cycles) for cycles in durations[-WINDOW:]), maxlen=WINDOW)


def read_config(folder: Path) -> RunConfig:
    """Read the settings of the training run in a folder.

    Raises
    ------
    TrainingError
        When it holds none, or one of another version.
    """
    path = folder / CONFIG
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError) as problem:
        raise TrainingError(f"{folder} is not the folder of a training run: it has no {CONFIG}") from problem
    except (json.JSONDecodeError, UnicodeDecodeError) as problem:
        raise TrainingError(f"{path} is not valid: {problem}") from problem
    if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != VERSION:
        raise TrainingError(f"{path} is not the configuration of a training run of this version")
    try:
        return RunConfig.from_dict(data)
    except (KeyError, TypeError, ValueError) as problem:
        raise TrainingError(f"{path} is not valid: {problem}") from problem


def psi_after(method: TransferMethod, episodes: int) -> float | None:
    """Return psi after so many episodes; None for methods without it and for psi that fades with decisions."""
    if isinstance(method, PPR | CHAT):
        if method.schedule == "episode":
            return float(method.decay**episodes)
        if method.schedule == "within-episode":
            return 1.0
    return None


def session_seed(seed: int, session: int) -> int:
    """Return the seed of a session over UDP: the run's own for the first, then others drawn from it."""
    if session == 0:
        return seed
    return int(np.random.SeedSequence(seed, spawn_key=(session,)).generate_state(1, np.uint32)[0] >> 1)


def versions() -> dict[str, str]:
    """Versions of what decides the numbers of a run."""
    return {
        "rcss-hat": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "machine": f"{platform.system()} {platform.machine()}",
    }


@contextmanager
def interrupt_flag() -> Iterator[Callable[[], bool]]:
    """Turn the first Ctrl-C into a flag, so that a checkpoint can be written; the second interrupts as usual.

    Yields
    ------
    callable
        Whether Ctrl-C was pressed. Only the main thread may use this.
    """
    pressed = False
    usual = signal.getsignal(signal.SIGINT)

    def note(number: int, frame: Any) -> None:
        nonlocal pressed
        pressed = True
        signal.signal(signal.SIGINT, usual)

    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, usual)
