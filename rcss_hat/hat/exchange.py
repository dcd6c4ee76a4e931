"""Demonstrations as trajectories of other libraries: Minari's data sets, and `imitation`'s.

A trajectory holds what `rcss_hat.envs.keepaway_env.KeepawayEnv` would have given: the observations of all decisions and
of the end, the actions, and as rewards the cycles from one decision to the next, the first from the episode's start. So
the rewards sum up to the duration. Where the end was not recorded, over UDP and in old files, the last observation
stands in its place, and ``final_is_real`` says so.
"""

from __future__ import annotations

import importlib
import json
import warnings
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.inputs import excerpt
from rcss_hat.keepaway.observation import observation_scale
from rcss_hat.keepaway.report import OUT, TAKEN, UNKNOWN, Episode
from rcss_hat.keepaway.task import Task

ENDS = (OUT, TAKEN, UNKNOWN)
"""How an episode ended, by the number that ``infos["end"]`` holds."""
_KEY = "rcss_hat"


class ExchangeError(ValueError):
    """A library that is missing, or a data set that cannot be read as demonstrations; one line."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """One episode as learners of others take it.

    Attributes
    ----------
    observations : ndarray of float32, shape (n + 1, n_variables)
        Of the decisions and of the end, metres and degrees.
    actions : ndarray of int64, shape (n,)
    rewards : ndarray of float64, shape (n,)
        Cycles; their sum is the duration.
    final_is_real : bool
        Whether the last observation was recorded.
    """

    observations: NDArray[np.float32]
    actions: NDArray[np.int64]
    rewards: NDArray[np.float64]
    final_is_real: bool


def trajectory(demonstration: Demonstration) -> Trajectory:
    """Make a trajectory of an episode in which somebody decided.

    Raises
    ------
    ExchangeError
        When nobody did.
    """
    d, final = demonstration, demonstration.episode.final
    if not len(d):
        raise ExchangeError(f"episode {d.episode.number} holds no decision")
    states = np.vstack([d.states, d.states[-1] if final is None else final]).astype(np.float32)
    times = np.concatenate([[d.episode.start], d.cycles[1:], [d.episode.end]])
    return Trajectory(states, d.actions, np.diff(times).astype(np.float64), final is not None)


def to_imitation(demonstrations: Iterable[Demonstration]) -> list[Any]:
    """Return ``TrajectoryWithRew`` of the library imitation; episodes without a decision are left out.

    Raises
    ------
    ExchangeError
        When imitation is not installed.
    """
    types = _imported("imitation.data.types", "imitation")
    made = []
    for d in demonstrations:
        if len(d):
            t = trajectory(d)
            infos = np.array([{"dt": int(r)} for r in t.rewards], dtype=object)
            made.append(types.TrajectoryWithRew(t.observations, t.actions, infos, terminal=True, rews=t.rewards))
    return made


def from_imitation(trajectories: Iterable[Any], info: DemonstrationInfo) -> DemonstrationSet:
    """Make demonstrations of trajectories with rewards in cycles, such as `to_imitation` returns.

    They do not say which keeper decided, nor in which cycle the first decision was: keeper 1 and the episode's start.

    Raises
    ------
    ValueError
        When they do not fit the task, or a reward is no number of cycles.
    """
    episodes, start = [], 0
    for number, t in enumerate(trajectories, start=1):
        cycles = _cycles(np.asarray(t.rews), start)
        known = Episode(number, start, int(cycles[-1]), UNKNOWN, tuple(map(float, t.obs[-1])))
        keepers = np.ones(len(t.acts), dtype=np.int64)
        episodes.append(Demonstration(known, info.teacher, cycles[:-1], keepers, t.obs[:-1], t.acts))
        start = known.end
    return DemonstrationSet(info, tuple(episodes))


def to_minari(demonstrations: DemonstrationSet, dataset_id: str) -> int:
    """Write a local data set of Minari; return how many episodes without a decision were left out.

    Parameters
    ----------
    demonstrations : DemonstrationSet
    dataset_id : str
        As Minari writes them, such as ``"keepaway/A-v0"``; there must be none yet.

    Raises
    ------
    ExchangeError
        When Minari or h5py is missing, there is such a data set already, or the name is none.
    """
    minari, collector = _imported("minari", "minari"), _imported("minari.data_collector", "minari")
    spaces = _imported("gymnasium.spaces", "gymnasium")
    _imported("h5py", "h5py")
    if dataset_id in minari.list_local_datasets():
        raise ExchangeError(f"there is a data set {dataset_id!r} already; give another name")
    info, task = demonstrations.info, demonstrations.info.task
    high = observation_scale(task, normalize=False)[1].astype(np.float32)
    decided = [d for d in demonstrations if len(d)]
    if not decided:
        raise ExchangeError("there is no decision to write")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what the description tells in its own way
            minari.create_dataset_from_buffers(
                dataset_id,
                [collector.EpisodeBuffer(id=k, **_buffer(d)) for k, d in enumerate(decided)],
                observation_space=spaces.Box(np.zeros_like(high), high, dtype=np.float32),
                action_space=spaces.Discrete(task.keepers),
                algorithm_name=info.teacher,
                author="rcss-hat",
                description=json.dumps({_KEY: {**asdict(info), "server": dict(info.server)}}),
                requirements=["rcss-hat"],
            )
    except (ValueError, AssertionError) as error:
        raise ExchangeError(f"Minari does not take {dataset_id!r}: {excerpt(str(error), 200)}") from error
    return len(demonstrations) - len(decided)


def _buffer(d: Demonstration) -> dict[str, Any]:
    """Return an episode as Minari keeps it; infos have a row of the end, too."""
    t, n = trajectory(d), len(d)
    final = d.states[-1] if d.episode.final is None else d.episode.final
    infos = {
        "state": np.vstack([d.states, final]),
        "cycle": np.append(d.cycles, d.episode.end),
        "keeper": np.append(d.keepers, d.keepers[-1]),
        "start": np.full(n + 1, d.episode.start),
        "end": np.full(n + 1, ENDS.index(d.episode.reason)),
        "number": np.full(n + 1, d.episode.number),
        "idle": np.full(n + 1, d.idle),
        "final_is_real": np.full(n + 1, t.final_is_real),
    }
    ends = [False] * (n - 1) + [True]
    return {
        "observations": t.observations, "actions": t.actions, "rewards": t.rewards.tolist(), "terminations": ends,
        "truncations": [False] * n, "infos": infos,
    }  # fmt: skip


def from_minari(dataset_id: str) -> DemonstrationSet:
    """Read a local data set of Minari: what `to_minari` wrote, or what its collector took from a `KeepawayEnv`.

    Raises
    ------
    ExchangeError
        When Minari is missing, or there is no such data set of Keepaway.
    """
    minari = _imported("minari", "minari")
    try:
        dataset = minari.load_dataset(dataset_id)
    except (ValueError, OSError, ImportError) as error:
        raise ExchangeError(f"Minari has no data set {dataset_id!r} here: {excerpt(str(error), 200)}") from error
    info = _info_of(dataset, dataset_id)
    try:
        episodes = [_episode_of(each, number, info) for number, each in enumerate(dataset, start=1)]
        return DemonstrationSet(info, tuple(episodes))
    except (KeyError, TypeError) as error:
        raise ExchangeError(
            f"{dataset_id} lacks {error} of an episode's infos; record KeepawayEnv by DataCollector(record_infos=True)"
        ) from error
    except ValueError as error:
        raise ExchangeError(f"{dataset_id}: {error}") from error


def _info_of(dataset: Any, dataset_id: str) -> DemonstrationInfo:
    """Return what a data set says of itself; of one that we did not write, the usual task of its size."""
    metadata = dataset.storage.metadata
    try:
        said = json.loads(metadata.get("description") or "")[_KEY]
        return DemonstrationInfo(**{**said, "task": Task.from_dict(said["task"])})
    except (ValueError, KeyError, TypeError):
        pass
    keepers = int(getattr(dataset.action_space, "n", 0))
    variables = dataset.observation_space.shape[0] if dataset.observation_space.shape else 0
    takers, rest = divmod(variables - 4 * (keepers - 1) - 1, 2)
    try:
        task = Task.parse(f"{keepers}v{takers}")
    except ValueError as error:
        raise ExchangeError(f"{dataset_id} is no data set of Keepaway: {error}") from error
    if rest or (np.asarray(dataset.observation_space.high) <= 1.0).all():
        raise ExchangeError(f"{dataset_id} must hold the {variables} state variables in metres and degrees")
    return DemonstrationInfo(str(metadata.get("algorithm_name") or dataset_id), "several", task)


def _episode_of(episode: Any, number: int, info: DemonstrationInfo) -> Demonstration:
    infos, n = episode.infos, len(episode.actions)
    if infos is None:
        raise KeyError("cycle")
    states = np.asarray(infos.get("state", episode.observations), dtype=np.float64)
    cycles, keepers = np.asarray(infos["cycle"]), np.asarray(infos["keeper"])
    start = int(infos["start"][0]) if "start" in infos else int(cycles[-1] - np.sum(episode.rewards))
    reason = ENDS[int(infos["end"][0])] if "end" in infos else UNKNOWN
    real = bool(infos["final_is_real"][0]) if "final_is_real" in infos else True
    known = Episode(
        int(infos["number"][0]) if "end" in infos else number, start, int(cycles[-1]), reason,
        tuple(map(float, states[-1])) if real else None,
    )  # fmt: skip
    idle = bool(infos["idle"][0]) if "idle" in infos else False
    return Demonstration(known, info.teacher, cycles[:n], keepers[:n], states[:n], episode.actions, idle)


def _cycles(rewards: NDArray[np.float64], start: int) -> NDArray[np.int64]:
    """Return the cycles of decisions and of the end, from the cycles that passed."""
    if not np.array_equal(rewards, np.round(rewards)) or (rewards < 0).any():
        raise ExchangeError("rewards must be cycles: whole numbers, not discounted")
    return start + np.concatenate([[0], np.cumsum(rewards.astype(np.int64))])


def _imported(module: str, package: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ExchangeError(
            f"this needs {package}, which cannot be imported ({error}): pip install {package}"
        ) from error
