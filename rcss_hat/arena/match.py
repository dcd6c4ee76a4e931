"""A match in the arena: all records of the compiled loop, and how people run them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation import keepaway
from fake_server.simulation.player_types import player_types
from fake_server.simulation.state import EPISODE, N_PLAYERS, connect, index, new_match, streams
from rcss_hat.arena.compilation import compile_halves
from rcss_hat.arena.loop import run
from rcss_hat.arena.records import CONTROL, DECISION, FINISHED, FRAME, NEEDS_ACTION, decision_dtype
from rcss_hat.hat.brains import EXTERNAL
from rcss_hat.hat.policy import TeamPolicy, load_policy
from rcss_hat.keepaway import agent as players
from rcss_hat.keepaway.report import OUT, TAKEN, Episode, RunReport
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.records import ACTION, HEARD, LEFT, RIGHT, SEE, SENSE_BODY, empty

PROTOCOL_VERSION = 11
NEVER = 2**31 - 1
CHUNK = 36_000
"""Cycles per call of the loop, so that Ctrl-C and progress are served: one simulated hour."""


@cache
def _compile() -> None:
    """Once per process, before the first match: see to it that the loop is quick to compile."""
    compile_halves(ArenaMatch(Task(), 0, load_policy("hold", 3, 2, 0)))


Policy = Callable[[NDArray[np.float64], dict[str, Any]], int]
"""A policy in Python: (state variables, info) -> action; info holds episode, cycle, keeper, status and reward."""


class ArenaMatch:
    """One match: fake_server's simulation and our players in one compiled loop.

    Parameters
    ----------
    task : Task
    seed : int
        Decides everything; the same seed plays the same match as ``--on fake`` over UDP.
    policy : TeamPolicy
        Of the keepers.
    external : callable, optional
        A policy in Python, called once per decision point instead of ``policy``.
    log_decisions, log_frames : bool
        Keep all decisions, or what a monitor would show of every cycle.
    """

    def __init__(
        self,
        task: Task,
        seed: int,
        policy: TeamPolicy,
        external: Policy | None = None,
        log_decisions: bool = False,
        log_frames: bool = False,
    ) -> None:
        self.task, self.seed, self.policy, self.external = task, seed, policy, external
        params = task.params()
        self.params = params.record()
        self.types = player_types(params, 0)
        self.streams = streams(seed)
        self.match = new_match(self.params)
        n, m = task.keepers, task.takers
        self.seats = np.array([index(LEFT, k + 1) for k in range(n)] + [index(RIGHT, k + 1) for k in range(m)])
        for seat in self.seats:
            connect(self.match, self.params, int(seat), PROTOCOL_VERSION, False)
        agents = [players.new_agent(LEFT, k + 1, n, m, self.params, seed, policy.hold_cycles) for k in range(n)]
        agents += [players.new_agent(RIGHT, k + 1, n, m, self.params, seed) for k in range(m)]
        self.agents = np.concatenate(agents)
        self.landmarks = players.landmarks_wanted(self.params)
        size = n + m
        self.started = np.ones(size, dtype=np.uint8)
        self.due = np.zeros(N_PLAYERS, dtype=np.uint8)
        self.sense, self.heard = empty(SENSE_BODY), empty(HEARD)
        self.sees, self.has_see = np.zeros(size, dtype=SEE), np.zeros(size, dtype=np.uint8)
        self.actions = np.zeros(size, dtype=ACTION)
        self.state = np.zeros(n_state_variables(n, m))
        self.control = empty(CONTROL)
        self.control["log_decisions"][0] = log_decisions
        self.control["log_frames"][0] = log_frames
        self.episode_log = np.zeros(4096, dtype=EPISODE)
        room = 20_000 if log_decisions else 64
        self.decision_log, self.state_log = np.zeros(room, dtype=DECISION), np.zeros((room, len(self.state)))
        self.frame_log = np.zeros(2_000 if log_frames else 1, dtype=FRAME)
        self._kicked_off = False

    @property
    def cycle(self) -> int:
        """Cycles simulated so far."""
        return int(self.match["time"][0])

    def _call(self) -> int:
        brains = self.policy.brains
        return int(
            run(
                self.match, self.params, self.types, self.streams, self.agents, self.seats, self.landmarks,
                self.started, self.due, self.sense, self.heard, self.sees, self.has_see, self.actions, self.state,
                EXTERNAL if self.external is not None else brains.kind, brains.rules, brains.has_rules, brains.features,
                brains.table, brains.weights, brains.traces, brains.learners, brains.method, brains.streams,
                self.control, self.episode_log, self.decision_log, self.state_log, self.frame_log,
            )
        )  # fmt: skip

    def _answer(self) -> None:
        assert self.external is not None
        player = int(self.control["player"][0])
        info = {
            "episode": int(self.match["episode"][0]),
            "cycle": self.cycle,
            "keeper": player + 1,
            "status": int(self.control["status"][0]),
            "reward": float(self.control["reward"][0]),
        }
        action = int(self.external(self.state.copy(), info))
        if not 0 <= action < self.task.keepers:
            raise ValueError(
                f"the policy returned action {action}; legal are 0 (Hold) to {self.task.keepers - 1} (pass to the "
                "farthest team mate)"
            )
        self.control["choice"][0] = action
        self.control["has_choice"][0] = 1

    def advance(self, cycles: int | None = None, episodes: int | None = None) -> Iterator[list[Episode]]:
        """Play on, yielding the episodes that ended, chunk by chunk.

        Parameters
        ----------
        cycles, episodes : int, optional
            Stop when so many have been played in all (not: since the last call).

        Yields
        ------
        list of Episode
            May be empty; the match can be saved or dropped between any two.
        """
        _compile()
        if not self._kicked_off:
            keepaway.kick_off(self.match, self.params, self.streams)
            self._kicked_off = True
        last_cycle = NEVER if cycles is None else cycles
        self.control["stop_episode"][0] = NEVER if episodes is None else episodes
        while True:
            self.control["stop_cycle"][0] = min(last_cycle, self.cycle + CHUNK)
            reason = self._call()
            if reason == NEEDS_ACTION:
                self._answer()
                continue
            yield self._take_episodes()
            enough = self.control["episodes"][0] >= self.control["stop_episode"][0] or self.cycle >= last_cycle
            if reason == FINISHED and enough:
                return

    def _take_episodes(self) -> list[Episode]:
        n = int(self.control["logged"][0])
        self.control["logged"][0] = 0
        return [
            Episode(int(e["episode"]), int(e["start"]), int(e["end"]), TAKEN if e["taken"] else OUT)
            for e in self.episode_log[:n]
        ]

    def take_decisions(self) -> NDArray[np.void]:
        """Return the decisions logged since the last call (see `decision_dtype`)."""
        n = int(self.control["decided"][0])
        self.control["decided"][0] = 0
        decisions = np.zeros(n, dtype=decision_dtype(len(self.state)))
        for name in DECISION.names or ():
            decisions[name] = self.decision_log[name][:n]
        decisions["state"] = self.state_log[:n]
        return decisions

    def take_frames(self) -> NDArray[np.void]:
        """Return the frames logged since the last call (dtype FRAME)."""
        n = int(self.control["framed"][0])
        self.control["framed"][0] = 0
        return self.frame_log[:n].copy()

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything that changes while playing, for a checkpoint; brains apart."""
        return {
            "match": self.match, "streams": self.streams, "agents": self.agents, "started": self.started,
            "sees": self.sees, "has_see": self.has_see, "control": self.control,
            "kicked_off": np.array([self._kicked_off]),
        }  # fmt: skip

    def restore(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Go back to what `arrays` returned, in this or another process.

        Raises
        ------
        ValueError
            When the arrays belong to another task or another version of this package.
        """
        for name, mine in self.arrays().items():
            theirs = arrays.get(name)
            if theirs is None or theirs.dtype != mine.dtype or theirs.shape != mine.shape:
                raise ValueError(f"the saved {name!r} is not that of a {self.task.size} match of this version")
            if name == "kicked_off":
                self._kicked_off = bool(theirs[0])
            else:
                mine[...] = theirs


def play(
    report: RunReport,
    task: Task,
    seed: int,
    policy: TeamPolicy,
    episodes: int,
    progress: Callable[[int, int], None] | None = None,
    external: Policy | None = None,
) -> None:
    """Play a number of episodes in the arena and fill a report, as `rcss_hat.team.match.play` does over UDP."""
    match = ArenaMatch(task, seed, policy, external)
    begun = time.monotonic()
    try:
        for finished in match.advance(episodes=episodes):
            report.episodes += finished
            if progress is not None:
                progress(len(report.episodes), match.cycle)
    except KeyboardInterrupt:
        report.failure = "interrupted"
    report.wall_s = time.monotonic() - begun
    report.cycles = match.cycle
