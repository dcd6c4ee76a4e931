"""The server's clock: when see messages are due, and in synch mode which of them come before the think.

Source: 19.0.0, src/stdtimer.cpp, src/synctimer.cpp and src/visualsenderplayer.cpp. A loop of 10 ms ticks sends visuals
whenever a multiple of send_step/4 = 37.5 ms has been passed, that is at 40, 80, 120, 150, 190, 230, 270 and 300 of
every 300 ms; a player sees at every 1st to 8th of these visual ticks, as his view demands. Players with synch_see see
in the tick of the step at every 1st to 3rd step.

``match["clock"]`` is the virtual time (ms) within the period after which all of this repeats. A server in real time
walks it with :func:`tick`; a server in synch mode and the arena walk whole cycles::

    step ... sense_body ... hear
    sees_before_think       what is due from the step's own tick to that of the think
    think, commands
    sees_after_think        what is due until the tick before the next step: it still shows the old cycle
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol.records import LOW, NARROW, NORMAL

TICK_MS = 10
"""The server's loop."""
STEP_DUE, THINK_DUE = 1, 2
"""Bits of what :func:`tick` returns."""


@inlined
def see_interval(match: NDArray[np.void], i: int) -> int:
    """Visual ticks (with synch_see: steps) from one see of a player to the next."""
    width = match["width"][0, i]
    if match["synch_see"][0, i]:
        return 1 if width == NARROW else 2 if width == NORMAL else 3
    interval = 2 if width == NARROW else 4 if width == NORMAL else 8
    return interval // 2 if match["quality"][0, i] == LOW else interval


@inlined
def view_angle(match: NDArray[np.void], params: NDArray[np.void], i: int) -> float:
    """Angle (degrees) of a player's view cone: visible_angle times 1/2, 1, 2; with synch_see 2/3, 4/3, 2."""
    width = match["width"][0, i]
    angle = params["visible_angle"][0]
    if match["synch_see"][0, i]:
        return float(angle * (2.0 / 3.0 if width == NARROW else 4.0 / 3.0 if width == NORMAL else 2.0))
    return float(angle * (0.5 if width == NARROW else 1.0 if width == NORMAL else 2.0))


@inlined
def _ceil_tick(ms: float) -> int:
    return int(math.ceil(ms / TICK_MS)) * TICK_MS


@kernel
def period(params: NDArray[np.void]) -> int:
    """Time (ms) after which all repeats: the least common multiple of simulator_step and send_step."""
    a, b = int(params["simulator_step"][0]), int(params["send_step"][0])
    product = a * b
    while b:
        a, b = b, a % b
    return product // a


@inlined
def sees_due(match: NDArray[np.void], params: NDArray[np.void], i: int, after_ms: int, to_ms: int) -> int:
    """Count a player's visual ticks (with synch_see: steps) in (after_ms, to_ms] of the clock."""
    if match["synch_see"][0, i]:
        step = int(params["simulator_step"][0])
        synch = _ceil_tick(params["synch_see_offset"][0]) % step
        return (to_ms - synch) // step - (after_ms - synch) // step
    quarter = 0.25 * params["send_step"][0]
    ticks = int(math.floor(to_ms / quarter)) - int(math.floor(after_ms / quarter))
    return min(ticks, (to_ms - after_ms) // TICK_MS)


@inlined
def _count_sees(
    match: NDArray[np.void], params: NDArray[np.void], after_ms: int, to_ms: int, due_out: NDArray[np.uint8]
) -> None:
    """Count every player's sees due in (after_ms, to_ms] of the clock, and advance his ticks."""
    see_ticks = match["see_ticks"][0]
    due_out[:] = 0
    for k in range(match["n_players"][0]):
        i = match["players"][0, k]
        interval = see_interval(match, i)
        total = see_ticks[i] + sees_due(match, params, i, after_ms, to_ms)
        if total >= interval:
            due_out[i] = total // interval
            total %= interval
        see_ticks[i] = total


@inlined
def think_offset(params: NDArray[np.void]) -> int:
    """Time (ms) from a step to the think of its cycle."""
    return _ceil_tick(params["synch_offset"][0]) % int(params["simulator_step"][0])


@kernel
def sees_before_think(match: NDArray[np.void], params: NDArray[np.void], due_out: NDArray[np.uint8]) -> None:
    """Walk the clock from a step to the think of its cycle.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
        Its clock stands at a step.
    params : ndarray of PARAMS, shape (1,)
    due_out : ndarray of uint8, shape (22,)
        Set to the number of see messages of every player; nearly always 0 or 1.
    """
    start = match["clock"][0]
    end = start + think_offset(params)
    _count_sees(match, params, start - TICK_MS, end, due_out)
    match["clock"][0] = end


@kernel
def sees_after_think(match: NDArray[np.void], params: NDArray[np.void], due_out: NDArray[np.uint8]) -> None:
    """Walk the clock from a think to the next step, whose own tick belongs to the next cycle.

    Parameters are those of :func:`sees_before_think`; the clock stands at a think.
    """
    start = match["clock"][0]
    end = start + int(params["simulator_step"][0]) - think_offset(params)
    _count_sees(match, params, start, end - TICK_MS, due_out)
    match["clock"][0] = end % period(params)


@kernel
def tick(match: NDArray[np.void], params: NDArray[np.void], due_out: NDArray[np.uint8]) -> int:
    """Walk one tick of 10 ms.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    params : ndarray of PARAMS, shape (1,)
    due_out : ndarray of uint8, shape (22,)
        Set to 1 for the players who see at this tick, after its step and sense_body messages.

    Returns
    -------
    int
        STEP_DUE when a simulation step is due at this tick, THINK_DUE when it ends with a think in synch mode.
    """
    now = (match["clock"][0] + TICK_MS) % period(params)
    match["clock"][0] = now
    _count_sees(match, params, now - TICK_MS, now, due_out)
    into_step = now % int(params["simulator_step"][0])
    due = STEP_DUE if into_step == 0 else 0
    if into_step == think_offset(params):
        due |= THINK_DUE
    return due
