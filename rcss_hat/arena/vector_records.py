"""The records of many matches that are played together: one row of every array per match."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.match import NEVER, PROTOCOL_VERSION, new_team
from rcss_hat.arena.records import CONTROL, DECISION, FRAME
from rcss_hat.keepaway.observation import observation_scale
from rcss_hat.keepaway.task import Task
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.state import EPISODE, connect, new_match, streams

Records = NDArray[np.void]

NOT_ENDED, ENDED_OUT, ENDED_TAKEN, CUT_OFF = range(4)
"""How an episode ended; CUT_OFF: it was played no longer than was asked for."""
WAITING, STEPPING, BEGINNING, DISCARDING = range(4)
"""What a match is doing: it waits for an action; it plays on to the next decision; to the first one of the next
episode; to the end of an episode that nobody wants."""

LANE = np.dtype(
    [
        ("doing", "i4"),
        ("mark", "i4"),  # cycle up to which steps were counted
        ("dt", "i4"),  # cycles of the step
        ("ended", "i4"),
        ("cycle", "i4"),  # of the decision at hand
        ("keeper", "i4"),  # who decides, from 0
        ("status", "i4"),
        ("episode", "i4"),
        ("start", "i4"),  # of the episode
        ("keepers", "i4"),
        ("skipped", "i4"),  # episodes so far that ended before anybody decided
        ("last_episode", "i4"),  # that ended last: its number, duration and end
        ("duration", "i4"),
        ("last_cycle", "i4"),
        ("last_keeper", "i4"),  # who decided last in it
        ("perceived", "i4"),  # somebody knew at the end where everybody was
    ]
)
"""What comes of a match in a step, shape (matches,); all numbers of one type, for a view as a table."""


class Batch(NamedTuple):
    """The records of many matches of one task, see `World` and `Team`: rows of what changes, one copy of the rest.

    Attributes
    ----------
    match : MATCH, shape (matches,)
    params, types, seats, landmarks, pauses
        Shared.
    streams : ndarray of uint64, shape (matches, n_streams, 4)
    agents, started, sees, has_see, actions, orders : shape (matches, players)
    sense, heard, control, episodes : shape (matches, 1)
    due : ndarray of uint8, shape (matches, all seats)
    taker_states : ndarray of float64, shape (matches, n_taker_variables)
    choices : ndarray of int64, shape (matches,)
        Actions of those that wait.
    states, finals : ndarray of float64, shape (matches, n_variables)
        State variables of the decision at hand, and of the end of an episode: as the keeper believed them who decided
        last, in the last cycle in which anything was perceived of it.
    lanes : LANE, shape (matches,)
    scale, high : ndarray of float64, shape (n_variables,)
        An observation is ``minimum(state * scale, high)``.
    observations, final_observations : ndarray of float32, shape (matches, n_variables)
        Of states and finals.
    decisions, frames : DECISION, FRAME, shape (keepers,), (1,)
        Logs that nothing is written to.
    """

    match: Records
    params: Records
    types: Records
    streams: NDArray[np.uint64]
    agents: Records
    seats: NDArray[np.int64]
    started: NDArray[np.uint8]
    sense: Records
    heard: Records
    sees: Records
    has_see: NDArray[np.uint8]
    due: NDArray[np.uint8]
    landmarks: NDArray[np.uint8]
    actions: Records
    orders: Records
    taker_states: NDArray[np.float64]
    pauses: NDArray[np.uint8]
    choices: NDArray[np.int64]
    states: NDArray[np.float64]
    finals: NDArray[np.float64]
    scale: NDArray[np.float64]
    high: NDArray[np.float64]
    observations: NDArray[np.float32]
    final_observations: NDArray[np.float32]
    control: Records
    episodes: Records
    decisions: Records
    frames: Records
    lanes: Records


class Part(NamedTuple):
    """Which matches of a batch are played, and how.

    Attributes
    ----------
    first, last : int
        A chunk of rows.
    max_cycles : int
        Cycles after which an episode is cut off; 0: none.
    goes_on : bool
        Go on into the next episode where one has ended.
    """

    first: int
    last: int
    max_cycles: int
    goes_on: bool


def new_batch(task: Task, seeds: Sequence[int], hold_cycles: int, normalize: bool) -> Batch:
    """Make matches before their kick-off.

    Parameters
    ----------
    task : Task
    seeds : sequence of int
        Of each match.
    hold_cycles : int
    normalize : bool
        See `rcss_hat.keepaway.observation.observation_scale`.
    """
    params = task.params()
    record, n = params.record(), len(seeds)
    scale, high = observation_scale(task, normalize)
    teams = [new_team(task, record, seed, hold_cycles) for seed in seeds]
    matches = [new_match(record) for _ in seeds]
    for match in matches:
        for seat in teams[0].seats:
            connect(match, record, int(seat), PROTOCOL_VERSION, False)

    def rows(name: str) -> NDArray[Any]:
        return np.stack([getattr(team, name) for team in teams])

    control = np.zeros((n, 1), dtype=CONTROL)
    control["stop_cycle"] = control["stop_episode"] = NEVER
    return Batch(
        match=np.concatenate(matches), params=record, types=player_types(params, 0),
        streams=np.stack([streams(seed) for seed in seeds]), agents=rows("agents"), seats=teams[0].seats,
        started=rows("started"), sense=rows("sense"), heard=rows("heard"), sees=rows("sees"), has_see=rows("has_see"),
        due=rows("due"), landmarks=teams[0].landmarks, actions=rows("actions"), orders=rows("orders"),
        taker_states=rows("taker_state"), pauses=np.ones(1, dtype=np.uint8), choices=np.zeros(n, dtype=np.int64),
        states=rows("state"), finals=rows("state"), scale=scale, high=high,
        observations=np.zeros((n, len(scale)), dtype=np.float32),
        final_observations=np.zeros((n, len(scale)), dtype=np.float32), control=control,
        episodes=np.zeros((n, 1), dtype=EPISODE), decisions=np.zeros(task.keepers, dtype=DECISION),
        frames=np.zeros(1, dtype=FRAME), lanes=np.zeros(n, dtype=LANE),
    )  # fmt: skip
