"""A match in the arena: all records of the compiled loop, and how people run them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.bounds import check_match
from rcss_hat.arena.compilation import compile_players, compile_rest, other_half
from rcss_hat.arena.loop import run
from rcss_hat.arena.records import (
    BALL_STUCK,
    CONTROL,
    DECISION,
    EPISODE_OVER,
    FINISHED,
    FRAME,
    LOG_FULL,
    NEEDS_ACTION,
    ORDER,
    Logs,
    Team,
    decision_dtype,
)
from rcss_hat.hat.brains import EXTERNAL
from rcss_hat.hat.policy import Policy, TeamPolicy, load_policy
from rcss_hat.hat.taker_policy import TakerPolicy
from rcss_hat.keepaway import agent as players
from rcss_hat.keepaway.decision import PolicyFailed, legal_action
from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.keepaway.state import n_state_variables, state_variables
from rcss_hat.keepaway.taker_state import n_taker_variables
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.records import ACTION, HEARD, LEFT, RIGHT, SEE, SENSE_BODY, empty
from rcss_hat.simulation import keepaway
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.referee import award_drop_ball
from rcss_hat.simulation.state import EPISODE, N_PLAYERS, connect, index, new_match, streams
from rcss_hat.simulation.world import World

PROTOCOL_VERSION = 11
NEVER = 2**31 - 1
CHUNK = 36_000
"""Cycles per call of the loop, so that Ctrl-C and progress are served: one simulated hour."""


SPEED = "as fast as possible"
"""How fast the arena plays, for reports."""


@cache
def prepare() -> None:
    """Compile, so that what comes is play.

    Once per process, before the first match: see to it that the loop is quick to compile.
    """
    with other_half():
        spare = ArenaMatch(Task(), 0, load_policy("hold", 3, 2, 0))
        compile_rest(spare)
        keepaway.kick_off(spare.world)
    run(spare.world, spare.team, spare.brains, spare.control, spare.logs)  # to its last cycle, which is 0


def prepare_players() -> None:
    """Compile the half of the loop that another process compiles while this one compiles the rest."""
    params = Task().params().record()
    compile_players(new_team(Task(), params, 0, 1), params)


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
        A policy in Python, called once per decision point instead of ``policy``.  [default: that of ``policy``]
    log_decisions, log_frames : bool
        Keep all decisions, or what a monitor would show of every cycle, until they are taken.
    orders : TakerPolicy, optional
        Of the takers.  [default: hand-coded]

    Raises
    ------
    ValueError
        When the policy is for another size.
    """

    def __init__(
        self,
        task: Task,
        seed: int,
        policy: TeamPolicy,
        external: Policy | None = None,
        log_decisions: bool = False,
        log_frames: bool = False,
        orders: TakerPolicy | None = None,
    ) -> None:
        if (policy.keepers, policy.takers) != (task.keepers, task.takers):
            raise ValueError(f"the policy is for {policy.keepers}v{policy.takers}, the task is {task.size}")
        self.task, self.seed, self.policy = task, seed, policy
        self.external = external or policy.function
        self.brains = policy.brains if self.external is None else policy.brains._replace(kind=EXTERNAL)
        params = task.params()
        record = params.record()
        self.world = World(new_match(record), record, player_types(params, 0), streams(seed))
        self.team = new_team(task, record, seed, policy.hold_cycles)
        for seat in self.team.seats:
            connect(self.world.match, record, int(seat), PROTOCOL_VERSION, False)
        self.orders = orders
        self.team.orders["outside"][task.keepers :], self.team.orders["lasts"] = orders is not None, 1
        self.control = empty(CONTROL)
        self.log(log_decisions, log_frames)
        room = 20_000 if log_decisions else 64
        self.logs = Logs(
            np.zeros(4096, dtype=EPISODE),
            np.zeros(room, dtype=DECISION),
            np.zeros((room, len(self.team.state))),
            np.zeros(2_000 if log_frames else 1, dtype=FRAME),
        )
        self._kicked_off = False
        self._last, self._finals = 0, dict[int, tuple[float, ...]]()

    @property
    def cycle(self) -> int:
        """Cycles simulated so far."""
        return int(self.world.match["time"][0])

    def _answer(self) -> None:
        player = int(self.control["player"][0])
        self.control["choice"][0] = self._decided(player) if player < self.task.keepers else self._ordered(player)
        self.control["has_choice"][0] = 1

    def _ordered(self, player: int) -> int:
        assert self.orders is not None
        return self.orders.order(self.team.taker_state, self.cycle, player - self.task.keepers)

    def _decided(self, player: int) -> int:
        assert self.external is not None
        info = {
            "episode": int(self.world.match["episode"][0]),
            "cycle": self.cycle,
            "keeper": player + 1,
            "status": int(self.control["status"][0]),
            "reward": float(self.control["reward"][0]),
        }
        return legal_action(self.external(self.team.state.copy(), info), self.task.keepers)

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

        Raises
        ------
        PolicyFailed
            When a policy in Python did not answer with an action; what ended before is yielded first.
        """
        prepare()
        if not self._kicked_off:
            keepaway.kick_off(self.world)
            self._kicked_off = True
        last_cycle = NEVER if cycles is None else cycles
        self.control["stop_episode"][0] = NEVER if episodes is None else episodes
        while True:
            self.control["stop_cycle"][0] = min(last_cycle, self.cycle + CHUNK)
            reason = run(self.world, self.team, self.brains, self.control, self.logs)
            if reason == NEEDS_ACTION:
                try:
                    self._answer()
                except PolicyFailed:
                    yield self._take_episodes()
                    raise
                continue
            if reason == EPISODE_OVER:
                self._look_back()
                continue
            if reason == BALL_STUCK:
                award_drop_ball(self.world)
                continue
            yield self._take_episodes()
            if reason == LOG_FULL:
                self._make_room()
            enough = self.control["episodes"][0] >= self.control["stop_episode"][0] or self.cycle >= last_cycle
            if reason == FINISHED and enough:
                return

    def _make_room(self) -> None:
        """Let the logs grow that nobody has taken."""
        logs, keepers = self.logs, self.task.keepers
        if int(self.control["decided"][0]) + keepers > len(logs.decisions):
            logs = logs._replace(decisions=_doubled(logs.decisions), states=_doubled(logs.states))
        if self.control["log_frames"][0] and int(self.control["framed"][0]) >= len(logs.frames):
            logs = logs._replace(frames=_doubled(logs.frames))
        self.logs = logs

    def _take_episodes(self) -> list[Episode]:
        n = int(self.control["logged"][0])
        self.control["logged"][0] = 0
        return [
            Episode(
                int(e["episode"]), int(e["start"]), int(e["end"]), TAKEN if e["taken"] else OUT,
                self._finals.pop(int(e["episode"]), None),
            )
            for e in self.logs.episodes[:n]
        ]  # fmt: skip

    def _look_back(self) -> None:
        """Keep what the keeper who decided last believes at an episode's end, or the first who knows where all are."""
        decided, state = int(self.control["decided"][0]), np.zeros(len(self.team.state))
        if decided:
            self._last = int(self.logs.decisions["keeper"][decided - 1]) - 1
        others = (k for k in range(self.task.keepers) if k != self._last)
        if any(state_variables(self.team.agents[k : k + 1].copy(), state) for k in (self._last, *others)):
            ended = int(self.world.match["episode"][0]) - 1
            self._finals[ended] = tuple(state.tolist())

    def log(self, decisions: bool, frames: bool) -> None:
        """Keep all decisions, with them the states at the ends of episodes, or frames from here on, or no more."""
        self.team.pauses[0] = decisions
        self.control["log_decisions"][0], self.control["log_frames"][0] = decisions, frames

    def take_decisions(self) -> NDArray[np.void]:
        """Return the decisions logged since the last call (see `decision_dtype`)."""
        n = int(self.control["decided"][0])
        self.control["decided"][0] = 0
        if n:
            self._last = int(self.logs.decisions["keeper"][n - 1]) - 1
        decisions = np.zeros(n, dtype=decision_dtype(len(self.team.state)))
        for name in DECISION.names or ():
            decisions[name] = self.logs.decisions[name][:n]
        decisions["state"] = self.logs.states[:n]
        return decisions

    def take_frames(self) -> NDArray[np.void]:
        """Return the frames logged since the last call (dtype FRAME)."""
        n = int(self.control["framed"][0])
        self.control["framed"][0] = 0
        return self.logs.frames[:n].copy()

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything that changes while playing, for a checkpoint; brains apart."""
        return {
            "match": self.world.match, "streams": self.world.streams, "agents": self.team.agents,
            "started": self.team.started, "sees": self.team.sees, "has_see": self.team.has_see, "control": self.control,
            "kicked_off": np.array([self._kicked_off]),
        }  # fmt: skip

    def restore(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Go back to what `arrays` returned, in this or another process.

        Raises
        ------
        ValueError
            When the arrays belong to another task or another version of this package, or hold numbers that no match
            can; the message names them.
        """
        fresh = self.arrays()
        check_match(self.task, arrays, fresh)
        for name, mine in fresh.items():
            mine[...] = arrays[name]
        self._kicked_off = bool(fresh["kicked_off"][0])


def new_team(task: Task, params: NDArray[np.void], seed: int, hold_cycles: int) -> Team:
    """Make both teams before their first cycle."""
    n, m = task.keepers, task.takers
    agents = [players.new_agent(LEFT, k + 1, n, m, params, seed, hold_cycles) for k in range(n)]
    agents += [players.new_agent(RIGHT, k + 1, n, m, params, seed) for k in range(m)]
    return Team(
        agents=np.concatenate(agents),
        seats=np.array([index(LEFT, k + 1) for k in range(n)] + [index(RIGHT, k + 1) for k in range(m)]),
        started=np.ones(n + m, dtype=np.uint8),
        sense=empty(SENSE_BODY),
        heard=empty(HEARD),
        sees=np.zeros(n + m, dtype=SEE),
        has_see=np.zeros(n + m, dtype=np.uint8),
        due=np.zeros(N_PLAYERS, dtype=np.uint8),
        landmarks=np.flatnonzero(players.landmarks_wanted(params)).astype(np.uint8),
        actions=np.zeros(n + m, dtype=ACTION),
        state=np.zeros(n_state_variables(n, m)),
        orders=np.zeros(n + m, dtype=ORDER),
        taker_state=np.zeros(n_taker_variables(n, m)),
        pauses=np.zeros(1, dtype=np.uint8),
    )


def _doubled(log: NDArray[Any]) -> NDArray[Any]:
    return np.concatenate([log, np.zeros_like(log)])
