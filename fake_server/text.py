"""What the server tells a player of the match's record: whose values go into which message (`rcss_hat.protocol`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import kernel
from rcss_hat.protocol import sense_body_writer
from rcss_hat.protocol.digits import Buffer
from rcss_hat.protocol.hear import BY_OPPONENT, BY_SELF, BY_TEAM_MATE, put_hear
from rcss_hat.protocol.messages import fullstate
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.protocol.sense_body_writer import NO_CARD, RED_CARD, YELLOW_CARD
from rcss_hat.simulation.hearing import HEAR_FULL, HEAR_PART, HEAR_SELF, voice_direction
from rcss_hat.simulation.state import C_CHANGE_FOCUS, F_RED_CARD, F_YELLOW_CARD, unum_of

FIRST_VERSION, LAST_VERSION = 8, 19
"""Protocol versions of players that are served."""


@kernel
def write_sense_body(sense: NDArray[np.void], match: NDArray[np.void], i: int, buffer: Buffer) -> int:
    """Write the sense_body message of player ``i`` for the version that its client speaks; returns its length.

    Parameters
    ----------
    sense : ndarray of records.SENSE_BODY, shape (1,)
    match : ndarray of MATCH, shape (1,)
    i : int
    buffer : ndarray of uint8, shape (MAX_DATAGRAM,)
    """
    flags = match["flags"][0, i]
    card = RED_CARD if flags & F_RED_CARD else YELLOW_CARD if flags & F_YELLOW_CARD else NO_CARD
    focus = (match["focus_dist"][0, i], match["focus_dir"][0, i] * RAD)
    version, changes = match["version"][0, i], match["counts"][0, i, C_CHANGE_FOCUS]
    return sense_body_writer.write_sense_body(sense, version, changes, card, focus, buffer)


def write_fullstate(match: NDArray[np.void], i: int, mode: Buffer, buffer: Buffer) -> int:
    """Write the fullstate message of player ``i``; returns its length.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    i : int
        Index of the player who receives it.
    mode : ndarray of uint8
        Name of the play mode.
    buffer : ndarray of uint8, shape (MAX_DATAGRAM,)
    """
    return fullstate.write_fullstate(match, i, (match["flags"][0] & F_YELLOW_CARD) != 0, mode, buffer)


@kernel
def write_hear(
    match: NDArray[np.void], i: int, order: NDArray[np.int32], n: int, buffer: Buffer, ends: NDArray[np.int64]
) -> None:
    """Write what player ``i`` hears of players, one datagram behind the other, each with its NUL.

    Parameters
    ----------
    match : ndarray of MATCH, shape (1,)
    i : int
        Index of the listener.
    order : ndarray of int32, shape (MAX_MESSAGES, 2)
        As filled by ``hearing.deliver``.
    n : int
        Number of messages.
    buffer : ndarray of uint8, shape (MAX_DATAGRAM,)
    ends : ndarray of int64, shape (MAX_MESSAGES,)
        Set to the end of every message.
    """
    at = 0
    for k in range(n):
        m, how = order[k, 0], order[k, 1]
        speaker = match["heard_by"][0, m]
        own = (speaker < MAX_PLAYERS) == (i < MAX_PLAYERS)
        who = BY_SELF if how == HEAR_SELF else BY_TEAM_MATE if own else BY_OPPONENT
        direction = int(voice_direction(match, i, speaker)) if how == HEAR_FULL else 0
        words = match["heard"][0, m, : 0 if how == HEAR_PART else match["heard_n"][0, m]]
        at = put_hear(buffer, at, match["time"][0], (who, int(unum_of(speaker)), direction), words)
        ends[k] = at
