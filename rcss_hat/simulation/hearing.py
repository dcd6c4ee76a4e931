"""Speech: who hears what, in which order, fully or in part.

Source: 19.0.0, src/audio.cpp (AudioSenderPlayerv8), for clients of version 8 and later. A message is kept by every
listener who was near enough when it was said and delivered at the next sense_body: first what the listener said
himself, then the others' messages in random order, those of the player he attends to before all others. A listener
hears a message in full while his capacity for that team lasts, afterwards only that somebody spoke.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import cut_degrees
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import integer
from rcss_hat.protocol.records import NO_SIDE
from rcss_hat.simulation.state import (
    EAR_OTHER_COMPLETE,
    EAR_OTHER_PARTIAL,
    EAR_OWN_COMPLETE,
    EAR_OWN_PARTIAL,
    MAX_MESSAGES,
    PHYSICS,
    index,
    side_of,
    unum_of,
)
from rcss_hat.simulation.world import World

HEAR_SELF, HEAR_FULL, HEAR_PART = range(3)
"""How a message is delivered."""


@inlined
def keep_message(match: NDArray[np.void], params: NDArray[np.void], i: int, text: NDArray[np.uint8], n: int) -> bool:
    """Keep what a player says for everybody who is near enough, ``audio_cut_dist`` (m), and has open ears."""
    at = match["n_said"][0]
    if at >= MAX_MESSAGES:
        return False
    match["said_by"][0, at] = i
    match["said_n"][0, at] = n
    for k in range(n):
        match["said"][0, at, k] = text[k]
    audience = 0
    cut = params["audio_cut_dist"][0]
    pos = match["pos"][0]
    for k in range(match["n_players"][0]):
        j = match["players"][0, k]
        same = side_of(i) == side_of(j)
        deaf = EAR_OWN_COMPLETE | EAR_OWN_PARTIAL if same else EAR_OTHER_COMPLETE | EAR_OTHER_PARTIAL
        dx, dy = pos[i, 0] - pos[j, 0], pos[i, 1] - pos[j, 1]
        if j == i or (dx * dx + dy * dy <= cut * cut and match["ear_off"][0, j] & deaf != deaf):
            audience |= 1 << j
    match["said_to"][0, at] = audience
    match["n_said"][0] = at + 1
    return True


@inlined
def pass_on_messages(match: NDArray[np.void]) -> None:
    """Make the messages said since the last step those to be heard in the new cycle."""
    n = match["n_said"][0]
    match["n_heard"][0] = n
    match["n_said"][0] = 0
    for m in range(n):
        match["heard_by"][0, m] = match["said_by"][0, m]
        match["heard_to"][0, m] = match["said_to"][0, m]
        match["heard_n"][0, m] = match["said_n"][0, m]
        for k in range(match["said_n"][0, m]):
            match["heard"][0, m, k] = match["said"][0, m, k]


@inlined
def _focus(match: NDArray[np.void], i: int) -> int:
    """Index of the player a listener attends to, -1: nobody."""
    side = match["focus_side"][0, i]
    return -1 if side == NO_SIDE else index(side, match["focus_unum"][0, i])


@inlined
def _next_message(match: NDArray[np.void], waiting: int, n_waiting: int, focus: int, rng: NDArray[np.uint64]) -> int:
    """Draw the message that a listener hears next among those waiting (bits)."""
    of_focus = 0
    n_focus = 0
    if focus >= 0:
        for m in range(match["n_heard"][0]):
            if waiting >> m & 1 and match["heard_by"][0, m] == focus:
                of_focus |= 1 << m
                n_focus += 1
    if n_focus > 0:
        waiting, n_waiting = of_focus, n_focus
    skip = integer(rng, n_waiting) if n_waiting > 1 else 0
    found = -1
    for m in range(match["n_heard"][0]):  # to the end: which one it is, no processor can guess
        waits = waiting >> m & 1
        if (waits != 0) & (skip == 0):
            found = m
        skip -= waits
    return found


@inlined
def _hear(match: NDArray[np.void], params: NDArray[np.void], i: int, speaker: int) -> int:
    """How a listener hears a message now: HEAR_FULL (which costs capacity), HEAR_PART, or -1, not at all."""
    same = side_of(i) == side_of(speaker)
    off = match["ear_off"][0, i]
    capacity = match["hear_own"][0, i] if same else match["hear_other"][0, i]
    if capacity < params["hear_decay"][0]:
        deaf = off & (EAR_OWN_PARTIAL if same else EAR_OTHER_PARTIAL)
        return -1 if deaf else HEAR_PART
    if off & (EAR_OWN_COMPLETE if same else EAR_OTHER_COMPLETE):
        return -1
    if same:
        match["hear_own"][0, i] -= params["hear_decay"][0]
    else:
        match["hear_other"][0, i] -= params["hear_decay"][0]
    return HEAR_FULL


@kernel
def deliver(world: World, i: int, order_out: NDArray[np.int32]) -> int:
    """Deliver the messages of the cycle before to one listener, in the sense_body step; call once per listener.

    Parameters
    ----------
    world : World
        Messages are in ``heard_by``, ``heard``, ``heard_n``; PHYSICS is drawn from when several wait.
    i : int
        Index of the listener.
    order_out : ndarray of int32, shape (MAX_MESSAGES, 2)
        Filled in order of delivery: number of the message, and HEAR_SELF, HEAR_FULL or HEAR_PART.

    Returns
    -------
    int
        Number of messages delivered.
    """
    match, params, streams = world.match, world.params, world.streams
    n = 0
    waiting = 0
    n_waiting = 0
    for m in range(match["n_heard"][0]):
        if match["heard_to"][0, m] >> i & 1:
            if match["heard_by"][0, m] == i:
                order_out[n, 0], order_out[n, 1] = m, HEAR_SELF
                n += 1
            else:
                waiting |= 1 << m
                n_waiting += 1
    focus = _focus(match, i)
    while n_waiting > 0:
        m = _next_message(match, waiting, n_waiting, focus, streams[PHYSICS])
        waiting &= ~(1 << m)
        n_waiting -= 1
        how = _hear(match, params, i, match["heard_by"][0, m])
        if how >= 0:
            order_out[n, 0], order_out[n, 1] = m, how
            n += 1
    return n


@inlined
def voice_direction(match: NDArray[np.void], i: int, speaker: int) -> int:
    """Direction (whole degrees, cut towards 0) of a speaker, relative to the listener's body."""
    dx = match["pos"][0, speaker, 0] - match["pos"][0, i, 0]
    dy = match["pos"][0, speaker, 1] - match["pos"][0, i, 1]
    return cut_degrees(dx, dy, match["body"][0, i], 0.0)


@kernel
def hear_teammate(world: World, i: int, heard_out: NDArray[np.void]) -> None:
    """Deliver to one listener as :func:`deliver` does, and keep the last complete message of a team mate.

    Parameters
    ----------
    world, i
        As for :func:`deliver`.
    heard_out : ndarray of HEARD, shape (1,)
        ``time`` is -1 when no team mate was heard in full.
    """
    match, params, streams = world.match, world.params, world.streams
    heard_out["time"][0] = -1
    waiting = 0
    n_waiting = 0
    for m in range(match["n_heard"][0]):
        if match["heard_to"][0, m] >> i & 1 and match["heard_by"][0, m] != i:
            waiting |= 1 << m
            n_waiting += 1
    if n_waiting == 0:
        return
    focus = _focus(match, i)
    last = -1
    while n_waiting > 0:
        m = _next_message(match, waiting, n_waiting, focus, streams[PHYSICS])
        waiting &= ~(1 << m)
        n_waiting -= 1
        speaker = match["heard_by"][0, m]
        if _hear(match, params, i, speaker) == HEAR_FULL and side_of(speaker) == side_of(i):
            last = m
    if last < 0:
        return
    speaker = match["heard_by"][0, last]
    heard_out["time"][0] = match["time"][0]
    heard_out["direction"][0] = voice_direction(match, i, speaker)
    heard_out["unum"][0] = unum_of(speaker)
    heard_out["n"][0] = match["heard_n"][0, last]
    for k in range(match["heard_n"][0, last]):
        heard_out["text"][0, k] = match["heard"][0, last, k]
