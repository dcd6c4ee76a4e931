"""Many matches at once: each plays on to its next decision in one compiled call that holds no lock of Python's.

The records are those of single matches, one row of every array per match, and so are the kernels; a match plays as it
would alone, whoever its neighbours are and however many threads share the rows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.loop import run
from rcss_hat.arena.match import NEVER
from rcss_hat.arena.records import BALL_STUCK, EPISODE_OVER, Logs, Team
from rcss_hat.arena.vector_records import (
    BEGINNING,
    CUT_OFF,
    DISCARDING,
    ENDED_OUT,
    ENDED_TAKEN,
    NOT_ENDED,
    STEPPING,
    WAITING,
    Batch,
    Part,
)
from rcss_hat.hat.brains import Brains
from rcss_hat.keepaway.state import state_variables
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.simulation.world import World


@inlined
def _observe(batch: Batch, states: NDArray[np.float64], i: int, out: NDArray[np.float32]) -> None:
    for v in range(states.shape[1]):
        out[i, v] = min(states[i, v] * batch.scale[v], batch.high[v])


@kernel
def _look_back(batch: Batch, i: int, team: Team) -> bool:
    """Find what the keeper who decided last believes, or the first who knows where everybody is."""
    last = batch.lanes["keeper"][i]
    if state_variables(team.agents[last : last + 1], batch.finals[i]):
        return True
    for k in range(batch.lanes["keepers"][i]):
        if k != last and state_variables(team.agents[k : k + 1], batch.finals[i]):
            return True
    return False


@kernel
def _show_end(batch: Batch, i: int, team: Team) -> None:
    """Write down what is seen at the end of an episode: where nobody knows, what was seen last."""
    known = _look_back(batch, i, team)
    batch.lanes["perceived"][i] = known
    if known:
        _observe(batch, batch.finals, i, batch.final_observations)
    else:
        for v in range(batch.observations.shape[1]):
            batch.final_observations[i, v] = batch.observations[i, v]


@kernel
def _note_end(batch: Batch, i: int, team: Team) -> None:
    """Write down how the episode ended."""
    match, lane = batch.match, batch.lanes[i : i + 1]
    lane["last_episode"][0] = match["episode"][i] - 1
    lane["duration"][0] = match["last_end"][i] - match["last_start"][i]
    lane["last_cycle"][0] = match["last_end"][i]
    lane["last_keeper"][0] = lane["keeper"][0]
    lane["ended"][0] = ENDED_TAKEN if match["last_taken"][i] else ENDED_OUT
    lane["dt"][0] = match["last_end"][i] - lane["mark"][0]
    _show_end(batch, i, team)


@kernel
def _cut_off(batch: Batch, i: int, team: Team, goes_on: bool) -> bool:
    """End an episode that has lasted long enough; True when the match waits there."""
    match, lane = batch.match, batch.lanes[i : i + 1]
    doing, now = lane["doing"][0], match["time"][i]
    batch.control["stop_cycle"][i, 0] = NEVER
    lane["doing"][0] = DISCARDING
    if doing == BEGINNING:
        lane["skipped"][0] += 1
        return False
    lane["last_episode"][0] = match["episode"][i]
    lane["duration"][0] = now - match["episode_start"][i]
    lane["last_cycle"][0] = now
    lane["last_keeper"][0] = lane["keeper"][0]
    lane["ended"][0] = CUT_OFF
    lane["dt"][0] = now - lane["mark"][0]
    _show_end(batch, i, team)
    if not goes_on:
        lane["doing"][0] = WAITING
    return not goes_on


@kernel
def _note_decision(batch: Batch, i: int) -> None:
    match, lane, control = batch.match, batch.lanes[i : i + 1], batch.control[i]
    lane["cycle"][0] = match["time"][i]
    lane["keeper"][0] = control["player"][0]
    lane["status"][0] = control["status"][0]
    lane["episode"][0] = match["episode"][i]
    lane["start"][0] = match["episode_start"][i]
    _observe(batch, batch.states, i, batch.observations)


@kernel
def _take(batch: Batch, i: int, action: int, goes_on: bool) -> None:
    """Give a waiting match its action; where its episode has ended, let it begin the next instead."""
    lane, control = batch.lanes[i : i + 1], batch.control[i]
    ended = lane["ended"][0]
    lane["dt"][0], lane["ended"][0] = 0, NOT_ENDED
    if ended == NOT_ENDED or goes_on:
        control["choice"][0], control["has_choice"][0] = action, 1
        lane["doing"][0] = STEPPING
    else:
        lane["doing"][0] = DISCARDING if ended == CUT_OFF else BEGINNING


@kernel
def _asked(batch: Batch, i: int) -> bool:
    """Take a decision that is to be made; True when the match waits for it."""
    match, lane, control = batch.match, batch.lanes[i : i + 1], batch.control[i]
    doing, now = lane["doing"][0], match["time"][i]
    if doing == DISCARDING:
        control["choice"][0], control["has_choice"][0] = 0, 1
        return False
    _note_decision(batch, i)
    if doing == STEPPING:
        lane["dt"][0] = now - lane["mark"][0]
        lane["mark"][0] = now
    lane["doing"][0] = WAITING
    return True


@kernel
def _over(batch: Batch, i: int, team: Team, part: Part) -> bool:
    """Take the end of an episode; True when the match waits there for who asks for the next."""
    lane, start = batch.lanes[i : i + 1], batch.match["episode_start"][i]
    doing = lane["doing"][0]
    if doing == STEPPING:
        _note_end(batch, i, team)
    elif doing == BEGINNING:
        lane["skipped"][0] += 1
    lane["mark"][0] = start
    batch.control["stop_cycle"][i, 0] = start + part.max_cycles if part.max_cycles > 0 else NEVER
    waits = doing == STEPPING and not part.goes_on
    lane["doing"][0] = WAITING if waits else BEGINNING
    return waits


@kernel
def _to_next_decision(batch: Batch, i: int, brains: Brains, part: Part) -> bool:
    """Let a match do what it is doing until it waits; False when its ball has to be dropped first."""
    world = World(batch.match[i : i + 1], batch.params, batch.types, batch.streams[i])
    team = Team(
        batch.agents[i], batch.seats, batch.started[i], batch.sense[i], batch.heard[i], batch.sees[i],
        batch.has_see[i], batch.due[i], batch.landmarks, batch.actions[i], batch.states[i],
        batch.orders[i], batch.taker_states[i], batch.pauses,
    )  # fmt: skip
    control = batch.control[i]
    logs = Logs(batch.episodes[i], batch.decisions, batch.states, batch.frames)
    while True:
        control["logged"][0] = 0
        why = run(world, team, brains, control, logs)
        if why == BALL_STUCK:
            return False
        if why == EPISODE_OVER:
            waits = _over(batch, i, team, part)
        elif batch.match["time"][i] >= control["stop_cycle"][0]:
            waits = _cut_off(batch, i, team, part.goes_on)
        else:
            waits = _asked(batch, i)
        if waits:
            return True


@kernel
def play_rows(batch: Batch, brains: Brains, rows: NDArray[np.int64], part: Part) -> int:
    """Let matches do what they are doing until each waits, or its ball is stuck.

    Parameters
    ----------
    batch : Batch
    brains : Brains
        Of kind EXTERNAL.
    rows : ndarray of int64
        Which matches; in the end, the first so many of this chunk's are those whose ball has to be dropped.
    part : Part

    Returns
    -------
    int
        How many are stuck.
    """
    stuck = 0
    for k in range(part.first, part.last):
        i = rows[k]
        if batch.lanes["doing"][i] == WAITING:
            _take(batch, i, batch.choices[i], part.goes_on)
        if not _to_next_decision(batch, i, brains, part):
            rows[part.first + stuck] = i
            stuck += 1
    return stuck
