"""The whole game in one compiled loop: simulation, perception, players, policies.

The order inside a cycle is that of a server in synch mode: step, sense_body and hearing of every player, the see
messages that come before ``(think)``, decisions, commands in the order of the players, and the see messages that come
after it. Perception writes the records a client would have read from the text, so that the same players behave here
as over UDP, number for number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.records import (
    BALL_STUCK,
    COMMAND,
    DECIDE,
    EPISODE_OVER,
    FINISHED,
    JUDGE,
    LOG_FULL,
    NEEDS_ACTION,
    PERCEIVE,
    SIMULATE,
    Logs,
    Team,
)
from rcss_hat.hat.brains import EXTERNAL, Brains, choose, finish
from rcss_hat.keepaway import agent as players
from rcss_hat.keepaway.taker import HAND_CODED
from rcss_hat.keepaway.taker_state import taker_state_variables
from rcss_hat.numeric.jit import kernel
from rcss_hat.simulation import body, clock, commands, cycle, hearing, vision
from rcss_hat.simulation.state import E_EPISODE_OUT, E_EPISODE_TAKEN
from rcss_hat.simulation.world import World

Records = NDArray[np.void]
ASK = -1
"""No action: somebody outside the loop decides."""


@kernel
def _log_episode(match: Records, control: Records, log: Records) -> None:
    k = control["logged"][0]
    log["episode"][k] = match["episode"][0] - 1
    log["start"][k] = match["last_start"][0]
    log["end"][k] = match["last_end"][0]
    log["taken"][k] = match["last_taken"][0]
    control["logged"][0] = k + 1
    control["episodes"][0] += 1


@kernel
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


@kernel
def _see(world: World, team: Team, p: int) -> None:
    """Write a player's see message, if he gets one in this half of the cycle."""
    if team.due[team.seats[p]]:
        see = team.sees[p : p + 1]
        vision.see(world, team.seats[p], team.landmarks, False, see)
        team.has_see[p] = 1


@kernel
def _perceive(world: World, team: Team) -> None:
    clock.sees_before_think(world.match, world.params, team.due)
    for p in range(team.seats.shape[0]):
        i = team.seats[p]
        body.sense_body(world, i, team.sense)
        hearing.hear_teammate(world, i, team.heard)
        _see(world, team, p)
        agent, see = team.agents[p : p + 1], team.sees[p : p + 1]
        players.perceive(agent, world.params, team.sense, see, team.has_see[p] != 0, team.heard, team.started[p] != 0)
        team.has_see[p] = 0
        team.started[p] = 0


@kernel
def _log_decision(world: World, control: Records, logs: Logs, choice: int, state: NDArray[np.float64]) -> None:
    decisions, k = logs.decisions, control["decided"][0]
    decisions["episode"][k] = world.match["episode"][0]
    decisions["cycle"][k] = world.match["time"][0]
    decisions["keeper"][k] = control["player"][0] + 1
    decisions["status"][k] = control["status"][0]
    decisions["reward"][k] = control["reward"][0]
    decisions["action"][k] = choice
    for v in range(state.shape[0]):
        logs.states[k, v] = state[v]
    control["decided"][0] = k + 1


@kernel
def _choose(world: World, team: Team, brains: Brains, control: Records, logs: Logs) -> int:
    """Return what the keeper at hand does, or ASK when somebody outside the loop must say."""
    p = control["player"][0]
    if control["has_choice"][0]:
        control["has_choice"][0] = 0
        choice = control["choice"][0]
    else:
        agent = team.agents[p : p + 1]
        point = players.decide(agent, team.state)
        if point.ended:
            finish(brains, p, point.final_reward)
        control["status"][0], control["reward"][0] = point.status, point.reward
        if point.status != players.FIRST and point.status != players.STEP:
            return 0
        if brains.kind == EXTERNAL:
            return ASK
        choice = choose(brains, p, point.status == players.FIRST, point.reward, team.state)
    if control["log_decisions"][0]:
        _log_decision(world, control, logs, choice, team.state)
    return choice


@kernel
def _ordered(world: World, team: Team, control: Records) -> int:
    """Return what the taker at hand does, or ASK when somebody outside the loop must say."""
    p, orders = control["player"][0], team.orders
    if not orders["outside"][p]:
        return HAND_CODED
    if control["has_choice"][0]:
        control["has_choice"][0] = 0
        orders["order"][p] = control["choice"][0]
        orders["until"][p] = world.match["time"][0] + orders["lasts"][p]
    elif world.match["time"][0] >= orders["until"][p]:
        if taker_state_variables(team.agents[p : p + 1], team.taker_state):
            return ASK
        return HAND_CODED
    return orders["order"][p]


@kernel
def _judge(world: World, team: Team, control: Records, logs: Logs) -> bool:
    """Finish the step; tell whether an episode has ended."""
    cycle.judge(world)
    ended = world.match["events"][0] & (E_EPISODE_OUT | E_EPISODE_TAKEN) != 0
    if ended:
        _log_episode(world.match, control, logs.episodes)
        team.started[:] = 1
        team.orders["until"][:] = 0
    if control["log_frames"][0]:
        _log_frame(world.match, control, logs.frames)
    return ended


@kernel
def _decide(world: World, team: Team, brains: Brains, control: Records, logs: Logs) -> bool:
    """Let everybody decide who has not yet in this cycle; False when somebody outside must be asked first."""
    while control["player"][0] < team.seats.shape[0]:
        p = control["player"][0]
        keeps = p < brains.keepers
        choice = _choose(world, team, brains, control, logs) if keeps else _ordered(world, team, control)
        if choice == ASK:
            return False
        players.act(team.agents[p : p + 1], world.params, control["status"][0], choice, team.actions[p : p + 1])
        control["player"][0] = p + 1
    return True


@kernel
def _command(world: World, team: Team) -> None:
    for p in range(team.seats.shape[0]):
        commands.act(world, team.seats[p], team.actions[p : p + 1])
    clock.sees_after_think(world.match, world.params, team.due)
    for p in range(team.seats.shape[0]):
        _see(world, team, p)


@kernel
def _full(brains: Brains, control: Records, logs: Logs) -> bool:
    """Tell whether some log may have no room for what the next cycle brings."""
    return (
        control["logged"][0] >= logs.episodes.shape[0]
        or control["decided"][0] + brains.keepers > logs.decisions.shape[0]
        or (control["log_frames"][0] and control["framed"][0] >= logs.frames.shape[0])
    )


@kernel
def _enough(world: World, control: Records) -> bool:
    if world.match["time"][0] >= control["stop_cycle"][0]:
        return True
    return control["episodes"][0] >= control["stop_episode"][0]


@kernel
def run(world: World, team: Team, brains: Brains, control: Records, logs: Logs) -> int:
    """Play until an episode, cycle or log limit, or until a policy outside the loop is asked.

    Parameters
    ----------
    world : World
    team : Team
    brains : Brains
    control : CONTROL, shape (1,)
    logs : Logs

    Returns
    -------
    int
        FINISHED, NEEDS_ACTION (``control["player"]`` asks: answer in ``control["choice"]``, set ``has_choice``, then
        call again), BALL_STUCK (drop it, then call again), LOG_FULL or EPISODE_OVER.
    """
    while True:
        phase = control["phase"][0]
        if phase == SIMULATE:
            if _full(brains, control, logs):
                return LOG_FULL
            if _enough(world, control):
                return FINISHED
            control["phase"][0] = JUDGE
            if cycle.play(world):
                return BALL_STUCK
        elif phase == JUDGE:
            control["phase"][0] = PERCEIVE
            if _judge(world, team, control, logs) and team.pauses[0]:
                return EPISODE_OVER
        elif phase == PERCEIVE:
            _perceive(world, team)
            control["player"][0] = 0
            control["phase"][0] = DECIDE
        elif phase == DECIDE:
            if not _decide(world, team, brains, control, logs):
                return NEEDS_ACTION
            control["phase"][0] = COMMAND
        else:
            _command(world, team)
            control["phase"][0] = SIMULATE
