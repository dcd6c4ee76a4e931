"""What the folder of a training run says: its settings, and what it was when it was saved, checked."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from rcss_hat import __version__
from rcss_hat.arena.match import ArenaMatch
from rcss_hat.experiments.episode_log import CYCLES_PER_HOUR
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.policy import RUN_WEIGHTS, learners_policy, run_rules
from rcss_hat.hat.transfer import Learners, TransferMethod, make_method, parameters
from rcss_hat.inputs import FileFormatError, item, load_json, read_text, whole
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.checkpoint import Checkpoint, load_checkpoint
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.stage.place import ARENA, Place

CONFIG = "config.json"
FORMAT, VERSION = "rcss-hat training run", 1
ARENA_PREFIX = "arena_"
"""Of a checkpoint's arrays that belong to the match in the arena."""


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

    Examples
    --------
    >>> from rcss_hat import METHODS, RunConfig, Task, load_config
    >>> RunConfig(task=Task(), learner=load_config("paper"), method=METHODS["no-prior"](), seed=1, hours=0.5).cycles
    18000
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
        Place.parse(self.stage)
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
            task=Task.from_dict(item(data, "task", dict)),
            learner=LearnerConfig.from_dict(item(data, "learner", dict)),
            method=make_method(item(data, "method", str), item(data, "method_settings", dict)),
            seed=whole(data, "seed", high=2**128),
            hours=item(data, "hours", (int, float)),
            stage=item(data, "stage", str),
            source=item(data, "source", str),
        )


def read_config(folder: Path) -> RunConfig:
    """Read the settings of the training run in a folder.

    Raises
    ------
    TrainingError
        When it holds none, or one of another version.
    """
    path = folder / CONFIG
    try:
        if not path.exists():
            raise TrainingError(f"{folder} is not the folder of a training run: it has no {CONFIG}")
        data = load_json(read_text(path, "training run"))
    except FileFormatError as problem:
        raise TrainingError(f"{path} is not valid: {problem}") from problem
    if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != VERSION:
        raise TrainingError(f"{path} is not the configuration of a training run of this version")
    try:
        return RunConfig.from_dict(data)
    except (KeyError, TypeError, ValueError) as problem:
        raise TrainingError(f"{path} is not valid: {problem}") from problem


@dataclass(frozen=True, slots=True)
class SavedRun:
    """What the folder of a training run holds, checked to belong together.

    Attributes
    ----------
    config : RunConfig
    learners : Learners
    rules : DecisionList or None
    checkpoint : Checkpoint
        With the state of the run, and of its match.
    """

    config: RunConfig
    learners: Learners
    rules: DecisionList | None
    checkpoint: Checkpoint


def read_run(folder: Path) -> SavedRun:
    """Read the training run in a folder, without changing anything.

    Raises
    ------
    TrainingError
        When the folder holds no run, or files of it are missing, damaged, of another version or of another run.
    """
    config = read_config(folder)
    task = config.task
    try:
        checkpoint = load_checkpoint(folder / RUN_WEIGHTS)
        learners = Learners.from_checkpoint(checkpoint)
        rules = run_rules(folder, learners)
    except FileNotFoundError as problem:
        raise TrainingError(f"{folder} cannot be resumed: it has no {RUN_WEIGHTS}") from problem
    except (OSError, ValueError) as problem:
        raise TrainingError(str(problem)) from problem
    expected = (config.learner, config.method, task.keepers, task.takers)
    if (learners.config, learners.method, learners.n_keepers, learners.n_takers) != expected:
        raise TrainingError(f"{folder / RUN_WEIGHTS} does not belong to the settings in {folder / CONFIG}")
    return SavedRun(config, learners, rules, checkpoint)


def run_state(checkpoint: Checkpoint) -> dict[str, int]:
    """Take what a checkpoint says of its run."""
    said = item(checkpoint.header, "run", dict, str(checkpoint.path))
    names = ("cycles", "episodes", "sessions", "round", "reuse_from", "log_bytes")
    state = {name: whole(said, name, f"{checkpoint.path}: run") for name in names}
    if state["reuse_from"] > state["episodes"]:
        raise FileFormatError(f"{checkpoint.path}: run: 'reuse_from' is greater than 'episodes'")
    return state


def arena_arrays(saved: SavedRun, state: Mapping[str, int]) -> dict[str, NDArray[Any]]:
    """Take the match out of a checkpoint, checked; empty when it was not played in the arena."""
    stored = saved.checkpoint.arrays.items()
    arrays = {name.removeprefix(ARENA_PREFIX): array for name, array in stored if name.startswith(ARENA_PREFIX)}
    if not arrays:
        return arrays
    match = ArenaMatch(saved.config.task, saved.config.seed, learners_policy(saved.learners, saved.rules))
    try:
        match.restore(arrays)
    except ValueError as problem:
        raise FileFormatError(f"{saved.checkpoint.path}: {problem}") from problem
    if match.cycle != state["cycles"]:
        raise FileFormatError(
            f"{saved.checkpoint.path}: its match stands at cycle {match.cycle}, its run at {state['cycles']}"
        )
    return arrays


def session_seed(seed: int, session: int) -> int:
    """Return the seed of a session over UDP: the run's own for the first, then others drawn from it."""
    return derived_seed(seed, session) if session else seed


def versions() -> dict[str, str]:
    """Versions of what decides the numbers of a run."""
    return {
        "rcss-hat": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "machine": f"{platform.system()} {platform.machine()}",
    }


def machine() -> dict[str, Any]:
    """Describe this machine, as far as it matters for durations."""
    return {"system": f"{platform.system()} {platform.machine()}", "processor": _processor(), "cores": os.cpu_count()}


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
