"""The learners of a team: one for every keeper, with the same settings, approximator and transfer method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.hat.transfer.kernels import decide_first, decide_step, finish_episode
from rcss_hat.hat.transfer.making import make_method, parameters
from rcss_hat.hat.transfer.method import METHOD, NO_ADVICE, TransferMethod
from rcss_hat.hat.transfer.replay import Decisions, replay_decisions
from rcss_hat.inputs import excerpt, item, whole
from rcss_hat.learning.bounds import MAX_WEIGHT, check_learners
from rcss_hat.learning.checkpoint import Checkpoint, CheckpointError, load_checkpoint, save_checkpoint
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.learning.create import initial_traces, initial_weights, learner_record
from rcss_hat.learning.exploration import NO_ACTION
from rcss_hat.learning.features import Approximator
from rcss_hat.learning.sarsa import LEARNER, Learner
from rcss_hat.numeric import rng
from rcss_hat.numeric.bounds import BoundsError, check_streams, check_values

KIND = "learners"


@dataclass(eq=False)
class Learners:
    """The learners of all keepers. Make them with `create` or `load`.

    Attributes
    ----------
    config : LearnerConfig
    method : TransferMethod
    n_keepers, n_takers : int
    seed : int
        Keeper k (from 0) draws from the stream ``stream(seed, LEARNER, k)``.
    approximator : Approximator
        Shared; kernels take its ``record`` and ``table``.
    method_record : METHOD, shape (1,)
    records : LEARNER, shape (n_keepers,)
    streams : ndarray of uint64, shape (n_keepers, 4)
    weights : ndarray of float64, shape (n_keepers, actions, n_features)
        Actions include pseudo-actions.
    traces : ndarray of float64, the shape of the weights, or (n_keepers, 0, 0) when lambda is 0

    """

    config: LearnerConfig
    method: TransferMethod
    n_keepers: int
    n_takers: int
    seed: int
    approximator: Approximator
    method_record: NDArray[np.void]
    records: NDArray[np.void]
    streams: NDArray[np.uint64]
    weights: NDArray[np.float64]
    traces: NDArray[np.float64]

    @classmethod
    def create(
        cls, config: LearnerConfig, method: TransferMethod, n_keepers: int = 3, n_takers: int = 2, seed: int = 0
    ) -> Learners:
        """Make learners that have not learned yet; learning and exploring are on.

        Raises
        ------
        ValueError
            For sizes of teams the learner is not defined for.
        """
        approximator = config.build(n_keepers, n_takers)
        rows = n_keepers + method.n_extra_actions
        return cls(
            config,
            method,
            n_keepers,
            n_takers,
            seed,
            approximator,
            method.to_record(),
            records=np.concatenate([learner_record(config, approximator, n_keepers)] * n_keepers),
            streams=np.stack([rng.stream(seed, rng.LEARNER, k) for k in range(n_keepers)]),
            weights=np.stack([initial_weights(config, approximator, rows)] * n_keepers),
            traces=np.stack([initial_traces(config, approximator, rows)] * n_keepers),
        )

    def learner(self, k: int) -> Learner:
        """Return keeper k (from 0) as kernels take it."""
        own = self.records[k : k + 1], self.streams[k], self.approximator.record, self.approximator.table
        return Learner(*own, self.weights[k], self.traces[k])

    def keeper(self, index: int) -> KeeperLearner:
        """Return one keeper's learner (from 0), for players that decide from Python."""
        if not 0 <= index < self.n_keepers:
            raise ValueError(f"keepers are numbered 0 to {self.n_keepers - 1}, not {index}")
        return KeeperLearner(self, index)

    @property
    def learning(self) -> bool:
        """Whether all keepers learn."""
        return bool(self.records["learning"].all())

    @property
    def episodes(self) -> int:
        """Episodes finished while learning, the same for all keepers."""
        return int(self.records["episodes"].max())

    @property
    def psi(self) -> float:
        """Probability with which the next decision reuses the advice; nan for methods that do not work with one."""
        return self.method.psi(self.records[:1])

    def set_mode(self, learning: bool, exploring: bool) -> None:
        """Switch learning and exploration of all keepers, between episodes.

        While not learning, weights, counts of episodes and all schedules stand still: the keepers play the policy that
        their method has now.
        """
        self.records["learning"] = learning
        self.records["exploring"] = exploring
        self.records["last_action"] = NO_ACTION
        self.records["episode_decisions"] = 0

    def replay(self, decisions: Decisions, passes: int) -> None:
        """Teach every keeper the recorded decisions of all keepers, so many times over.

        Raises
        ------
        ValueError
            When the decisions do not fit the task.
        """
        if decisions.states.shape[1] != self.approximator.n_variables:
            raise ValueError(
                f"the decisions have {decisions.states.shape[1]} state variables, "
                f"{self.n_keepers}v{self.n_takers} has {self.approximator.n_variables}"
            )
        if decisions.actions.size and decisions.actions.max() >= self.n_keepers:
            raise ValueError(f"action {decisions.actions.max()} does not exist with {self.n_keepers} keepers")
        for k in range(self.n_keepers):
            arrays = decisions.states, decisions.actions, decisions.rewards, decisions.last
            replay_decisions(self.learner(k), *arrays, passes)

    def save(
        self,
        path: Path | str,
        header: Mapping[str, Any] | None = None,
        arrays: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """Write everything that learning needs to go on, atomically.

        Parameters
        ----------
        path : Path or str
        header : mapping, optional
            More JSON data to keep, under names of the caller's.
        arrays : mapping of str to ndarray, optional
            More arrays, for example the random streams of the simulation.

        Raises
        ------
        ValueError
            When a name is taken.
        """
        own_header = {
            "kind": KIND,
            "config": self.config.to_dict(),
            "method": self.method.name,
            "method_settings": parameters(self.method),
            "n_keepers": self.n_keepers,
            "n_takers": self.n_takers,
            "seed": self.seed,
        }
        own = {
            "records": self.records,
            "streams": self.streams,
            "weights": self.weights,
            "traces": self.traces,
            "method_record": _lasting(self.method_record),
        }
        taken = (own_header.keys() & (header or {}).keys()) | (own.keys() & (arrays or {}).keys())
        if taken:
            raise ValueError(f"the name {min(taken)!r} is taken in a checkpoint of learners")
        save_checkpoint(path, {**own_header, **(header or {})}, {**own, **(arrays or {})})

    @classmethod
    def load(cls, path: Path | str) -> Learners:
        """Read learners; `rcss_hat.learning.checkpoint.load_checkpoint` gives what else the file holds.

        Raises
        ------
        CheckpointError
            When the file does not hold learners of this version, or its arrays do not fit its settings.
        FileNotFoundError
        """
        return cls.from_checkpoint(load_checkpoint(path))

    @classmethod
    def from_checkpoint(cls, checkpoint: Checkpoint) -> Learners:
        """Take the learners out of a checkpoint that was read.

        Raises
        ------
        CheckpointError
            When it does not hold learners of this version, or its arrays do not fit its settings.
        """
        path, header = checkpoint.path, checkpoint.header
        if header.get("kind") != KIND:
            raise CheckpointError(f"{path} holds {excerpt(header.get('kind'))}, not {KIND!r}")
        try:
            fresh = cls.create(
                LearnerConfig.from_dict(item(header, "config", dict)),
                make_method(item(header, "method", str), item(header, "method_settings", dict)),
                whole(header, "n_keepers", low=3, high=11),
                whole(header, "n_takers", low=2, high=11),
                whole(header, "seed", high=2**128),
            )
        except (KeyError, TypeError, ValueError, ArithmeticError) as problem:
            raise CheckpointError(f"{path}: the settings in the file are not valid: {problem}") from problem
        fresh._take_arrays(checkpoint)
        return fresh

    def _take_arrays(self, checkpoint: Checkpoint) -> None:
        """Take over the arrays of a checkpoint that was made with the same settings."""
        path = checkpoint.path
        if checkpoint.array("method_record", METHOD, (1,)) != _lasting(self.method_record):
            raise CheckpointError(f"{path}: the method's record does not agree with its settings")
        records = checkpoint.array("records", LEARNER, self.records.shape)
        streams = checkpoint.array("streams", self.streams.dtype, self.streams.shape)
        weights = checkpoint.array("weights", self.weights.dtype, self.weights.shape)
        traces = checkpoint.array("traces", self.traces.dtype, self.traces.shape)
        try:
            check_learners(records, self.records, self.approximator, weights.shape[1])
            check_streams("streams", streams)
            check_values("weights", weights, -MAX_WEIGHT, MAX_WEIGHT)
            check_values("traces", traces, 0.0, 1.0)
        except BoundsError as problem:
            raise CheckpointError(f"{path}: {problem}") from problem
        self.records, self.streams, self.weights, self.traces = records, streams, weights, traces


@dataclass(frozen=True, eq=False)
class KeeperLearner:
    """One keeper of `Learners`: the same kernels that the arena compiles into its loop, called from Python.

    Attributes
    ----------
    learners : Learners
    index : int
        From 0.
    """

    learners: Learners
    index: int

    @property
    def has_acted(self) -> bool:
        """Whether this keeper has taken a decision in this episode."""
        return bool(self.learners.records["last_action"][self.index] != NO_ACTION)

    @property
    def q(self) -> NDArray[np.float64]:
        """Values of all actions (and pseudo-actions) in the state of the last decision, shape (actions,); a copy."""
        return self.learners.records["q"][self.index, : self.learners.weights.shape[1]].copy()

    def decide(self, state: ArrayLike, reward: float = 0.0, advice: int = NO_ADVICE, confidence: float = 1.0) -> int:
        """Take a decision, the first of the episode or a later one.

        Parameters
        ----------
        state : array_like, shape (n_variables,)
        reward : float
            Cycles since this keeper's last decision in this episode; ignored for its first.
        advice : int
            D(state), or `NO_ADVICE`.
        confidence : float
            Of the advice, 0 to 1.

        Returns
        -------
        int
            The action to execute.

        Raises
        ------
        ValueError
            When the state or the advice does not fit the task.
        """
        team, k = self.learners, self.index
        if not NO_ADVICE <= advice < team.n_keepers:
            raise ValueError(f"advice must be an action from 0 to {team.n_keepers - 1} or {NO_ADVICE}, not {advice}")
        numbers = team.approximator.check_state(state)
        learner, method = team.learner(k), team.method_record
        if self.has_acted:
            return int(decide_step(learner, method, float(reward), numbers, int(advice), float(confidence)))
        return int(decide_first(learner, method, numbers, int(advice), float(confidence)))

    def finish_episode(self, reward: float = 0.0) -> None:
        """Tell this keeper that the episode is over, ``reward`` cycles after its last decision if it took any."""
        finish_episode(self.learners.learner(self.index), float(reward))


def _lasting(record: NDArray[np.void]) -> NDArray[np.void]:
    """A method's record as another process would have it: without the address of its kernel."""
    record = record.copy()
    record["select"] = 0
    return record


def warm_up() -> None:
    """Compile, or load from the cache, everything a deciding keeper needs; sizes and settings make no difference."""
    team = Learners.create(LearnerConfig(), make_method("no-prior"))
    keeper, state = team.keeper(0), np.zeros(team.approximator.n_variables)
    keeper.decide(state)
    keeper.decide(state, 1.0)
    keeper.finish_episode(1.0)
