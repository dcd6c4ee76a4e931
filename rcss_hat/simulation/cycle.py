"""One simulation step.

Source: 19.0.0, src/stadium.cpp (step). Order: dashes act and commands are free again; objects move; the time advances;
the referees look; stamina and hearing recover; the state flags are published for frames and logs.
Keepaway's step is here; soccer's, with its stoppages, is in ``fake_server.soccer``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.simulation.collision import resolve_collisions
from rcss_hat.simulation.dash import apply_dash
from rcss_hat.simulation.hearing import pass_on_messages
from rcss_hat.simulation.keepaway import analyse_keepaway
from rcss_hat.simulation.motion import move_ball, move_player
from rcss_hat.simulation.placement import keep_in_world
from rcss_hat.simulation.referee import award_drop_ball, ball_is_stuck
from rcss_hat.simulation.stamina import update_hearing, update_stamina
from rcss_hat.simulation.state import (
    F_KICK,
    F_KICK_FAULT,
    F_TACKLE,
    F_TACKLE_FAULT,
)
from rcss_hat.simulation.world import World

_LASTING_KICK = F_KICK | F_KICK_FAULT
_LASTING_TACKLE = F_TACKLE | F_TACKLE_FAULT


@inlined
def _free_commands(match: NDArray[np.void], i: int) -> None:
    """Let a player command again, and count down what lasts (19.0.0, src/player.cpp, resetCommandFlags; src/arm.h)."""
    if match["kick_cycles"][0, i] > 0:
        match["kick_cycles"][0, i] -= 1
    if match["tackle_cycles"][0, i] > 0:
        match["tackle_cycles"][0, i] -= 1
    match["command_done"][0, i] = match["tackle_cycles"][0, i] > 0
    match["neck_done"][0, i] = 0
    match["leg"][0, i, 0] = match["leg"][0, i, 1] = 0
    match["leg_power"][0, i, 0] = match["leg_power"][0, i, 1] = 0.0
    match["collided"][0, i] = 0
    if match["arm_movable"][0, i] > 0:
        match["arm_movable"][0, i] -= 1
    if match["arm_expires"][0, i] > 0:
        match["arm_expires"][0, i] -= 1


@inlined
def _publish_flags(match: NDArray[np.void], i: int) -> None:
    """Show the state flags of this step, and drop those that do not last (src/player.cpp, resetState)."""
    flags = match["flags_next"][0, i]
    match["flags"][0, i] = flags
    lasting = _LASTING_KICK if match["kick_cycles"][0, i] > 1 else 0
    if match["tackle_cycles"][0, i] > 0:
        lasting |= _LASTING_TACKLE
    match["flags_next"][0, i] = flags & lasting


@kernel
def move_all(world: World) -> None:
    """Advance ball and players, resolve collisions, keep a caught ball in front of the goalie."""
    match, params = world.match, world.params
    move_ball(world)
    for k in range(match["n_players"][0]):
        move_player(world, match["players"][0, k])
    resolve_collisions(world)
    catcher = match["catcher"][0]
    if catcher >= 0:
        reach = match["size"][0, catcher] + params["ball_size"][0]
        body = match["body"][0, catcher]
        match["ball_pos"][0, 0] = match["pos"][0, catcher, 0] + reach * np.cos(body)
        match["ball_pos"][0, 1] = match["pos"][0, catcher, 1] + reach * np.sin(body)


@kernel
def begin(world: World) -> None:
    """Begin a step: pass on what was said, let dashes act, and let everybody command again."""
    match, params = world.match, world.params
    match["events"][0] = 0
    pass_on_messages(match)
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        if not params["version_11"][0]:
            apply_dash(world, i)
        _free_commands(match, i)


@kernel
def finish(world: World) -> None:
    """End a step: stamina and hearing recover, and the state flags are published."""
    match, params = world.match, world.params
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        update_stamina(world, i)
        update_hearing(match, params, i)
        _publish_flags(match, i)


@kernel
def play(world: World) -> bool:
    """Do the first part of a step of Keepaway, in play_on: everything moves; True when the ball is stuck.

    Then it has to be dropped before the step goes on with :func:`judge`.
    """
    match, params = world.match, world.params
    begin(world)
    move_all(world)
    match["time"][0] += 1
    match["stopped"][0] = 0
    return ball_is_stuck(match, params)


@kernel
def judge(world: World) -> None:
    """Do the rest of a step of Keepaway: the edge of the world, its referee, recovery."""
    match = world.match
    keep_in_world(match)
    analyse_keepaway(world)
    finish(world)


def step(world: World) -> None:
    """Advance a match in play_on, without half times, by one simulation step (100 ms).

    ``match["events"]`` afterwards has the E_* bits of what the referee did. A server announces them in this order: half
    time or time up, drop_ball, play_on, end of an episode (whose data ``keepaway.last_episode`` returns).

    Parameters
    ----------
    world : World
        Of its streams only PHYSICS is drawn from.
    """
    if play(world):
        award_drop_ball(world)
    judge(world)
