"""Whether somebody was moved: a second way to learn that an episode has ended.

A referee that ends an episode puts every player somewhere else. Who sees himself, or another player whose number he
reads, farther away than anybody can run since he saw him last knows that an episode has ended, whether or not the
referee's word has come. No message is needed for it, and nothing that a player decides depends on it.

How far is too far: per cycle a player gets no farther than ``player_speed_max`` with its noise (1.16 m on rcssserver
19); a place is known to a few centimetres for oneself, and to 5 % of the distance for others, since distances come in
steps of 10 %. `MARGIN` and `BLUR` are about twice that.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel
from rcss_hat.player.records import N_SLOTS, NEVER, OPPONENTS
from rcss_hat.protocol.records import BALL, CLOSE_PLAYER, HAS_DISTANCE, OWN_TEAM, PLAYER, UNKNOWN_TEAM

Record = NDArray[np.void]

STRIDE, MARGIN, BLUR = 1.15, 1.0, 0.1
"""Most that a player gets on in a cycle, in ``player_speed_max``; metres that a place may be wrong by in any case, and
more of them per metre between who sees and who is seen."""
SIGHTINGS = np.dtype(
    [("time", "i4", (N_SLOTS,)), ("pos", "f8", (N_SLOTS, 2)), ("distance", "f8", (N_SLOTS,))],
)
"""Where a player has last seen everybody, shape ``(1,)``: cycle, own frame (m), and from how far (m)."""


def new_sightings() -> Record:
    """Return the record of a player who has seen nobody yet."""
    sightings = np.zeros(1, dtype=SIGHTINGS)
    forget_sightings(sightings)
    return sightings


def forget_sightings(sightings: Record) -> None:
    """Forget where everybody was: play begins."""
    sightings["time"] = NEVER


@kernel
def _compare(agent: Record, stride: float, sightings: Record, o: int) -> int:
    """Compare where the player in a slot is seen with where he could be, and remember it."""
    now, me, before = agent["see_time"][0], agent["me"][0], sightings["time"][0, o]
    x, y = agent["player_see_pos"][0, o, 0], agent["player_see_pos"][0, o, 1]
    distance = math.hypot(x - agent["player_see_pos"][0, me, 0], y - agent["player_see_pos"][0, me, 1])
    way = math.hypot(x - sightings["pos"][0, o, 0], y - sightings["pos"][0, o, 1])
    blur = MARGIN + BLUR * (distance + sightings["distance"][0, o])
    moved = NEVER < before < now and way > stride * (now - before) + blur
    sightings["time"][0, o] = now
    sightings["pos"][0, o, 0], sightings["pos"][0, o, 1] = x, y
    sightings["distance"][0, o] = distance
    return before if moved else NEVER


@kernel
def somebody_was_moved(agent: Record, params: Record, see: Record, sightings: Record) -> int:
    """Compare where everybody is seen with where they could be; to be called after every see that was taken in.

    Others count where the see tells the numbers of all: who is recognised without one may be somebody else.

    Parameters
    ----------
    agent, params, see, sightings : record
        Of one player; the sightings are brought up to date.

    Returns
    -------
    int
        The newest cycle before the move in which who was moved had been seen; NEVER when nobody was.
    """
    stride = STRIDE * params["player_speed_max"][0]
    since = _compare(agent, stride, sightings, agent["me"][0])
    if not _tells_all_numbers(see):
        return since
    for i in range(see["n"][0] - 1, -1, -1):
        if see["code"][0, i] < BALL:
            break
        if see["code"][0, i] == PLAYER and see["fields"][0, i] & HAS_DISTANCE:
            o = int(see["unum"][0, i]) - 1
            o = o if see["team"][0, i] == OWN_TEAM else o + OPPONENTS
            since = max(since, _compare(agent, stride, sightings, o))
    return since


@kernel
def _tells_all_numbers(see: Record) -> bool:
    """Tell whether nobody in a see has to be recognised, and might be taken for one whose number is read."""
    for i in range(see["n"][0] - 1, -1, -1):
        code = see["code"][0, i]
        if code < BALL:
            break
        if code == CLOSE_PLAYER:
            return False
        if code == PLAYER and (see["unum"][0, i] == 0 or see["team"][0, i] == UNKNOWN_TEAM):
            return False
    return True
