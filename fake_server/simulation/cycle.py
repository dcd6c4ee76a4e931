"""One simulation step.

Source: 19.0.0, src/stadium.cpp (step). Order: dashes act and commands are free again; objects move; the time advances;
the referees look; stamina and hearing recover; the state flags are published for frames and logs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fake_server.simulation.collision import resolve_collisions
from fake_server.simulation.dash import apply_dash
from fake_server.simulation.hearing import pass_on_messages
from fake_server.simulation.keepaway import analyse_keepaway
from fake_server.simulation.motion import move_ball, move_player, stand_still
from fake_server.simulation.referee import STOPPED, analyse
from fake_server.simulation.stamina import update_hearing, update_stamina
from fake_server.simulation.state import (
    BEFORE_KICK_OFF,
    F_KICK,
    F_KICK_FAULT,
    F_TACKLE,
    F_TACKLE_FAULT,
    PHYSICS,
    TIME_OVER,
)
from rcss_hat.numeric.jit import inlined, kernel

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


@inlined
def _move_all(
    match: NDArray[np.void], params: NDArray[np.void], types: NDArray[np.void], rng: NDArray[np.uint64]
) -> None:
    """Advance ball and players, resolve collisions, keep a caught ball in front of the goalie."""
    move_ball(match, params, rng)
    for k in range(match["n_players"][0]):
        move_player(match, params, types, match["players"][0, k], rng)
    resolve_collisions(match, params, rng)
    catcher = match["catcher"][0]
    if catcher >= 0:
        reach = match["size"][0, catcher] + params["ball_size"][0]
        body = match["body"][0, catcher]
        match["ball_pos"][0, 0] = match["pos"][0, catcher, 0] + reach * np.cos(body)
        match["ball_pos"][0, 1] = match["pos"][0, catcher, 1] + reach * np.sin(body)


@kernel
def step(
    match: NDArray[np.void], params: NDArray[np.void], types: NDArray[np.void], streams: NDArray[np.uint64]
) -> None:
    """Advance a match by one simulation step (100 ms).

    ``match["events"]`` afterwards has the E_* bits of what the referee did. A server announces them in this order: half
    time or time up, drop_ball, play_on, end of an episode (whose data ``keepaway.last_episode`` returns).

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    params : ndarray of PARAMS, shape (1,)
    types : ndarray of PLAYER_TYPE, shape (n,)
    streams : ndarray of uint64, shape (3, 4)
        Rows PHYSICS, PERCEPTION, LANDMARKS; only PHYSICS is drawn from.
    """
    rng = streams[PHYSICS]
    match["events"][0] = 0
    pass_on_messages(match)
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        if not params["version_11"][0]:
            apply_dash(match, params, types, i, rng)
        _free_commands(match, i)
    mode = match["mode"][0]
    if mode == BEFORE_KICK_OFF:
        for k in range(match["n_players"][0]):
            stand_still(match, match["players"][0, k])
        match["stopped"][0] += 1
        analyse(match, params, rng)
    elif mode == TIME_OVER:
        match["stopped"][0] += 1
    elif STOPPED[mode]:
        match["catcher"][0] = -1
        _move_all(match, params, types, rng)
        match["stopped"][0] += 1
        analyse(match, params, rng)
        if match["mode"][0] != mode:
            match["time"][0] += 1
            match["stopped"][0] = 0
    else:
        _move_all(match, params, types, rng)
        match["time"][0] += 1
        match["stopped"][0] = 0
        analyse(match, params, rng)
        analyse_keepaway(match, params, rng)
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        update_stamina(match, params, types, i)
        update_hearing(match, params, i)
        _publish_flags(match, i)
