"""The referee of Keepaway: start, placement, end of episodes.

Source: 19.0.0, src/referee.cpp (KeepawayRef).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import integer, uniform
from rcss_hat.protocol.records import LEFT, empty
from rcss_hat.simulation.clock import TICK_MS, period, see_interval, sees_due, think_offset
from rcss_hat.simulation.placement import place_ball, place_player, recover_all
from rcss_hat.simulation.state import (
    E_EPISODE_OUT,
    E_EPISODE_TAKEN,
    E_PLAY_ON,
    EPISODE,
    PHYSICS,
    PLAY_ON,
    side_of,
)
from rcss_hat.simulation.world import World

TURNOVER_TIME = 4
"""Steps that takers need in kicking range of the ball."""
_CORNER = 3.0
"""Players start within a square of this size (m) at a corner of the region."""
_BALL_OFFSET = 4.0
_MIDDLE = 1.0


@kernel
def reset_field(world: World) -> None:
    """Place ball and players for a new episode.

    The keepers take the upper left, upper right and lower right corner in turn, from a random one on, further keepers
    the middle; all takers the lower left corner. Angles stay; stamina is restored, except in 11.1. The ball lies still,
    4 m from both borders of the upper left corner.
    """
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    half_x, half_y = 0.5 * params["keepaway_length"][0], 0.5 * params["keepaway_width"][0]
    n_keepers = match["n_keepers"][0]
    slot = integer(rng, n_keepers) if n_keepers > 1 else 0
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        if side_of(i) == LEFT:
            if slot >= 3:
                x, y = uniform(rng, -_MIDDLE, _MIDDLE), uniform(rng, -_MIDDLE, _MIDDLE)
            else:
                x, y = uniform(rng, 0.0, _CORNER), uniform(rng, 0.0, _CORNER)
                x = x - half_x if slot == 0 else half_x - x
                y = half_y - y if slot == 2 else y - half_y
            if n_keepers > 0:
                slot = (slot + 1) % n_keepers
        else:
            x, y = uniform(rng, 0.0, _CORNER) - half_x, half_y - uniform(rng, 0.0, _CORNER)
        place_player(match, i, x, y)
    place_ball(match, _BALL_OFFSET - half_x, _BALL_OFFSET - half_y, 0.0, 0.0)
    match["kick_off_side"][0] = 0
    if not params["version_11"][0]:
        recover_all(match, params)
    match["taken"][0] = 0


@kernel
def _first_episode(world: World) -> None:
    """Count the teams, once and for all, and start episode 1."""
    match = world.match
    match["episode"][0] = 1
    for k in range(match["n_players"][0]):
        if side_of(match["players"][0, k]) == LEFT:
            match["n_keepers"][0] += 1
        else:
            match["n_takers"][0] += 1
    reset_field(world)


@kernel
def _fix_see_phases(world: World) -> None:
    """Start the see schedule afresh: the clock before its first step, every player as if he had joined at some think.

    In a real server the phase of a player's sees depends on when he connected, which in synch mode can only be at the
    think of one of the cycles of the visual period. Drawing that cycle makes a seed decide everything.
    """
    match, params, rng = world.match, world.params, world.streams[PHYSICS]
    step = int(params["simulator_step"][0])
    match["clock"][0] = 0
    cycles = period(params) // step
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        joined = (integer(rng, cycles) - cycles) * step + think_offset(params)
        match["see_ticks"][0, i] = sees_due(match, params, i, joined, -TICK_MS) % see_interval(match, i)


@kernel
def kick_off(world: World) -> None:
    """Start the play of Keepaway.

    The first call counts keepers and takers, starts episode 1 and, in synch mode, restarts the clock's
    period and draws every player's see phase. Sets E_PLAY_ON.

    Parameters
    ----------
    world : World
    """
    match, params = world.match, world.params
    match["mode"][0] = PLAY_ON
    match["mode_steps"][0] = 0
    match["events"][0] |= E_PLAY_ON
    if match["episode"][0] == 0:
        _first_episode(world)
        if params["synch_mode"][0] > 0.0:
            _fix_see_phases(world)


@inlined
def _possession(match: NDArray[np.void], params: NDArray[np.void]) -> int:
    """Who is in kicking range of a type 0 player: 1 a taker (perhaps a keeper too), -1 keepers only, 0 nobody."""
    reach = params["player_size"][0] + params["ball_size"][0] + params["kickable_margin"][0]
    bx, by = match["ball_pos"][0, 0], match["ball_pos"][0, 1]
    pos = match["pos"][0]
    found = 0
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        dx, dy = pos[i, 0] - bx, pos[i, 1] - by
        if dx * dx + dy * dy < reach * reach:
            if side_of(i) != LEFT:
                return 1
            found = -1
    return found


@kernel
def _end_episode(world: World, taken: bool) -> None:
    match = world.match
    match["events"][0] |= E_EPISODE_TAKEN if taken else E_EPISODE_OUT
    match["last_start"][0] = match["episode_start"][0]
    match["last_end"][0] = match["time"][0]
    match["last_taken"][0] = taken
    match["episode"][0] += 1
    match["episode_start"][0] = match["time"][0]
    reset_field(world)


@inlined
def analyse_keepaway(world: World) -> None:
    """End the episode when the ball is out or taken, else count who has it; once per step, in play_on.

    Out: not ``|x| < length/2 and |y| < width/2``. Taken: the step after the fourth one with a taker in range; a step
    with only keepers in range sets the count back to 0.
    """
    match, params = world.match, world.params
    if params["keepaway"][0] == 0.0 or match["mode"][0] != PLAY_ON:
        return
    inside_x = abs(match["ball_pos"][0, 0]) < 0.5 * params["keepaway_length"][0]
    if not (inside_x and abs(match["ball_pos"][0, 1]) < 0.5 * params["keepaway_width"][0]):
        _end_episode(world, False)
    elif match["taken"][0] >= TURNOVER_TIME:
        _end_episode(world, True)
    else:
        who = _possession(match, params)
        if who > 0:
            match["taken"][0] += 1
        elif who < 0:
            match["taken"][0] = 0


def last_episode(match: NDArray[np.void]) -> NDArray[np.void]:
    """Return the episode that ended last.

    Meaningful after a step with E_EPISODE_OUT or E_EPISODE_TAKEN in ``match["events"]``.

    Returns
    -------
    ndarray of EPISODE, shape (1,)
    """
    record = empty(EPISODE)
    record["episode"][0] = match["episode"][0] - 1
    record["start"][0] = match["last_start"][0]
    record["end"][0] = match["last_end"][0]
    record["taken"][0] = match["last_taken"][0]
    return record
