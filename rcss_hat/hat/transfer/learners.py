"""The learners of a team: one for every keeper, with the same settings, approximator and transfer method."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.hat.transfer.kernels import decide_first, decide_step, finish_episode
from rcss_hat.hat.transfer.record import KIND_CHAT, KIND_PPR, NO_ADVICE, TransferMethod
from rcss_hat.hat.transfer.registry import make_method, parameters
from rcss_hat.hat.transfer.replay import Decisions, replay_decisions
from rcss_hat.hat.transfer.reuse import reuse_probability
from rcss_hat.learning.checkpoint import CheckpointError, load_checkpoint, save_checkpoint
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.learning.create import initial_traces, initial_weights, learner_record
from rcss_hat.learning.exploration import NO_ACTION
from rcss_hat.learning.features import Approximator
from rcss_hat.learning.sarsa import LEARNER
from rcss_hat.numeric import rng

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

    Notes
    -----
    Kernels take keeper k as ``records[k : k + 1]``, ``streams[k]``, ``weights[k]`` and ``traces[k]``.
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
        if self.method_record["kind"][0] not in (KIND_PPR, KIND_CHAT):
            return float("nan")
        return float(reuse_probability(self.method_record, self.records[:1]))

    def set_mode(self, learning: bool, exploring: bool) -> None:
        """Switch learning and exploration of all keepers, between episodes.

        While not learning, weights, counts of episodes and all schedules stand still: the keepers play the policy that
        their method has now.
        """
        self.records["learning"] = learning
        self.records["exploring"] = exploring
        self.records["last_action"] = NO_ACTION
        self.records["episode_decisions"] = 0

    @contextmanager
    def evaluating(self, exploring: bool = False) -> Iterator[None]:
        """Play without learning, and without exploring unless asked to, as long as the context lasts."""
        before = self.records[["learning", "exploring"]].copy()
        self.set_mode(learning=False, exploring=exploring)
        try:
            yield
        finally:
            self.set_mode(learning=False, exploring=False)
            self.records["learning"], self.records["exploring"] = before["learning"], before["exploring"]

    def replay(self, decisions: Decisions, passes: int | None = None) -> None:
        """Teach every keeper the recorded decisions of all keepers.

        Parameters
        ----------
        decisions : Decisions
        passes : int, optional
            By default what the method says; nothing happens for methods that do not replay.

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
        features, table = self.approximator.record, self.approximator.table
        for k in range(self.n_keepers):
            replay_decisions(
                self.records[k : k + 1],
                features,
                table,
                self.weights[k],
                self.traces[k],
                decisions.states,
                decisions.actions,
                decisions.rewards,
                decisions.last,
                self.method.replay_passes if passes is None else passes,
            )

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
            "method_record": self.method_record,
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
        checkpoint = load_checkpoint(path)
        header = checkpoint.header
        if header.get("kind") != KIND:
            raise CheckpointError(f"{path} holds {header.get('kind')!r}, not {KIND!r}")
        try:
            fresh = cls.create(
                LearnerConfig.from_dict(header["config"]),
                make_method(header["method"], header["method_settings"]),
                header["n_keepers"],
                header["n_takers"],
                header["seed"],
            )
        except (KeyError, TypeError, ValueError) as problem:
            raise CheckpointError(f"{path}: the settings in the file are not valid: {problem}") from problem
        if checkpoint.array("method_record", fresh.method_record.dtype, (1,)) != fresh.method_record:
            raise CheckpointError(f"{path}: the method's record does not agree with its settings")
        fresh.records = checkpoint.array("records", LEARNER, fresh.records.shape)
        fresh.streams = checkpoint.array("streams", fresh.streams.dtype, fresh.streams.shape)
        fresh.weights = checkpoint.array("weights", fresh.weights.dtype, fresh.weights.shape)
        fresh.traces = checkpoint.array("traces", fresh.traces.dtype, fresh.traces.shape)
        return fresh


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
        own = (team.records[k : k + 1], team.streams[k], team.approximator.record, team.approximator.table)
        memory = (team.weights[k], team.traces[k], team.method_record)
        if self.has_acted:
            return int(decide_step(*own, *memory, float(reward), numbers, int(advice), float(confidence)))
        return int(decide_first(*own, *memory, numbers, int(advice), float(confidence)))

    def finish_episode(self, reward: float = 0.0) -> None:
        """Tell this keeper that the episode is over, ``reward`` cycles after its last decision if it took any."""
        team, k = self.learners, self.index
        approximator = team.approximator
        record = team.records[k : k + 1]
        finish_episode(record, approximator.record, approximator.table, team.weights[k], team.traces[k], float(reward))


def warm_up() -> None:
    """Compile, or load from the cache, everything a deciding keeper needs; sizes and settings make no difference."""
    team = Learners.create(LearnerConfig(), make_method("no-prior"))
    keeper, state = team.keeper(0), np.zeros(team.approximator.n_variables)
    keeper.decide(state)
    keeper.decide(state, 1.0)
    keeper.finish_episode(1.0)
