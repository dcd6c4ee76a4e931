"""The whole game in one compiled loop: simulation, perception, players, policies.

The order inside a cycle is that of a server in synch mode: step, sense_body and hearing of every player, the see
messages that come before ``(think)``, decisions, commands in the order of the players, and the see messages that come
after it. Perception writes the records a client would have read from the text, so that the same players behave here
as over UDP, number for number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation import body, clock, commands, cycle, hearing, vision
from fake_server.simulation.state import E_EPISODE_OUT, E_EPISODE_TAKEN, PHYSICS
from rcss_hat.arena.records import COMMAND, DECIDE, FINISHED, LOG_FULL, NEEDS_ACTION, PERCEIVE, SIMULATE
from rcss_hat.hat.brains import EXTERNAL, choose, finish
from rcss_hat.keepaway import agent as players
from rcss_hat.numeric.jit import njit

Records = NDArray[np.void]


@njit
def _log_episode(match: Records, control: Records, log: Records) -> None:
    k = control["logged"][0]
    log["episode"][k] = match["episode"][0] - 1
    log["start"][k] = match["last_start"][0]
    log["end"][k] = match["last_end"][0]
    log["taken"][k] = match["last_taken"][0]
    control["logged"][0] = k + 1
    control["episodes"][0] += 1


@njit
def _log_frame(match: Records, control: Records, frames: Records) -> None:
    k = control["framed"][0]
    frames["time"][k] = match["time"][0]
    frames["mode"][k] = match["mode"][0]
    frames["episode"][k] = match["episode"][0]
    frames["episode_start"][k] = match["episode_start"][0]
    frames["events"][k] = match["events"][0]
    for axis in range(2):
        frames["ball"][k, axis] = match["ball_pos"][0, axis]
        frames["ball"][k, 2 + axis] = match["ball_vel"][0, axis]
    for i in range(match["enabled"].shape[1]):
        frames["enabled"][k, i] = match["enabled"][0, i]
        frames["body"][k, i] = match["body"][0, i]
        frames["neck"][k, i] = match["neck"][0, i]
        frames["flags"][k, i] = match["flags"][0, i]
        frames["stamina"][k, i] = match["stamina"][0, i]
        for axis in range(2):
            frames["pos"][k, i, axis] = match["pos"][0, i, axis]
            frames["vel"][k, i, axis] = match["vel"][0, i, axis]
        for c in range(match["counts"].shape[2]):
            frames["counts"][k, i, c] = match["counts"][0, i, c]
    control["framed"][0] = k + 1


@njit
def _perceive(
    match: Records,
    params: Records,
    types: Records,
    streams: NDArray[np.uint64],
    agents: Records,
    seats: NDArray[np.int64],
    landmarks: NDArray[np.uint8],
    started: NDArray[np.uint8],
    due: NDArray[np.uint8],
    sense: Records,
    heard: Records,
    sees: Records,
    has_see: NDArray[np.uint8],
) -> None:
    clock.sees_before_think(match, params, due)
    for p in range(seats.shape[0]):
        i = seats[p]
        body.sense_body(match, params, types, i, sense)
        hearing.hear_teammate(match, params, i, streams, heard)
        see = sees[p : p + 1]
        if due[i]:
            vision.see(match, params, types, i, streams, landmarks, see)
            has_see[p] = 1
        players.perceive(agents[p : p + 1], params, sense, see, has_see[p] != 0, heard, started[p] != 0)
        has_see[p] = 0
        started[p] = 0


@njit
def run(
    match: Records,
    params: Records,
    types: Records,
    streams: NDArray[np.uint64],
    agents: Records,
    seats: NDArray[np.int64],
    landmarks: NDArray[np.uint8],
    started: NDArray[np.uint8],
    due: NDArray[np.uint8],
    sense: Records,
    heard: Records,
    sees: Records,
    has_see: NDArray[np.uint8],
    actions: Records,
    state: NDArray[np.float64],
    kind: int,
    rules: Records,
    has_rules: NDArray[np.uint8],
    features: Records,
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    traces: NDArray[np.float64],
    learners: Records,
    method: Records,
    policy_streams: NDArray[np.uint64],
    control: Records,
    episodes: Records,
    decisions: Records,
    states: NDArray[np.float64],
    frames: Records,
) -> int:
    """Play until an episode, cycle or log limit, or until a policy outside the loop is asked.

    Returns
    -------
    int
        FINISHED, NEEDS_ACTION (answer in ``control["choice"]``, then call again) or LOG_FULL.
    """
    n_players = seats.shape[0]
    n_keepers = weights.shape[0]
    n_takers = n_players - n_keepers
    while True:
        phase = control["phase"][0]
        if phase == SIMULATE:
            if control["logged"][0] >= episodes.shape[0] or control["decided"][0] + n_keepers > decisions.shape[0]:
                return LOG_FULL
            if control["log_frames"][0] and control["framed"][0] >= frames.shape[0]:
                return LOG_FULL
            if match["time"][0] >= control["stop_cycle"][0] or control["episodes"][0] >= control["stop_episode"][0]:
                return FINISHED
            cycle.step(match, params, types, streams)
            if match["events"][0] & (E_EPISODE_OUT | E_EPISODE_TAKEN):
                _log_episode(match, control, episodes)
                started[:] = 1
            if control["log_frames"][0]:
                _log_frame(match, control, frames)
            control["phase"][0] = PERCEIVE
        elif phase == PERCEIVE:
            _perceive(
                match, params, types, streams, agents, seats, landmarks, started, due, sense, heard, sees, has_see
            )  # fmt: skip
            control["player"][0] = 0
            control["phase"][0] = DECIDE
        elif phase == DECIDE:
            while control["player"][0] < n_players:
                p = control["player"][0]
                agent = agents[p : p + 1]
                choice = 0
                if p < n_keepers:
                    if control["has_choice"][0]:
                        control["has_choice"][0] = 0
                        status = control["status"][0]
                        reward = control["reward"][0]
                        choice = control["choice"][0]
                    else:
                        status = players.decide(agent, params, state)
                        reward = agent["reward"][0]
                        if agent["ended"][0]:
                            finish(
                                kind,
                                features,
                                table,
                                weights[p],
                                traces[p],
                                learners[p : p + 1],
                                agent["final_reward"][0],
                            )
                        if status == players.FIRST or status == players.STEP:
                            if kind == EXTERNAL:
                                control["status"][0] = status
                                control["reward"][0] = reward
                                return NEEDS_ACTION
                            choice = choose(
                                kind,
                                n_keepers,
                                n_takers,
                                rules,
                                has_rules,
                                features,
                                table,
                                weights[p],
                                traces[p],
                                learners[p : p + 1],
                                method,
                                policy_streams[p],
                                status == players.FIRST,
                                reward,
                                state,
                            )
                    if control["log_decisions"][0] and (status == players.FIRST or status == players.STEP):
                        k = control["decided"][0]
                        decisions["episode"][k] = match["episode"][0]
                        decisions["cycle"][k] = match["time"][0]
                        decisions["keeper"][k] = p + 1
                        decisions["status"][k] = status
                        decisions["reward"][k] = reward
                        decisions["action"][k] = choice
                        states[k, :] = state
                        control["decided"][0] = k + 1
                players.act(agent, params, choice, actions[p : p + 1])
                control["player"][0] = p + 1
            control["phase"][0] = COMMAND
        else:
            for p in range(n_players):
                commands.act(match, params, types, seats[p], actions[p : p + 1], streams[PHYSICS])
            clock.sees_after_think(match, params, due)
            for p in range(n_players):
                if due[seats[p]]:
                    vision.see(match, params, types, seats[p], streams, landmarks, sees[p : p + 1])
                    has_see[p] = 1
            control["phase"][0] = SIMULATE
