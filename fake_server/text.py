"""What the server tells a player of the match's record: whose values go into which message (`rcss_hat.protocol`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.protocol import sense_body_writer
from rcss_hat.protocol.digits import Buffer
from rcss_hat.protocol.hear import BY_OPPONENT, BY_SELF, BY_TEAM_MATE, put_hear
from rcss_hat.protocol.messages import fullstate
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.protocol.see import write_see
from rcss_hat.protocol.sense_body_writer import NO_CARD, RED_CARD, YELLOW_CARD
from rcss_hat.simulation import body, hearing, vision
from rcss_hat.simulation.hearing import HEAR_FULL, HEAR_PART, HEAR_SELF, voice_direction
from rcss_hat.simulation.state import C_CHANGE_FOCUS, F_RED_CARD, F_YELLOW_CARD, unum_of
from rcss_hat.simulation.world import World

FIRST_VERSION, LAST_VERSION = 8, 19
"""Protocol versions of players that are served."""


class Pages(NamedTuple):
    """Datagrams one behind the other.

    Attributes
    ----------
    buffer : ndarray of uint8
        All their bytes, each datagram with its NUL. `MAX_DATAGRAM` bytes for each are enough.
    ends : ndarray of int64
        Where each ends.
    readers : ndarray of int64
        Index of the player to whom each is addressed.
    """

    buffer: Buffer
    ends: NDArray[np.int64]
    readers: NDArray[np.int64]


class Names(NamedTuple):
    """What is called how in see messages.

    Attributes
    ----------
    teams : ndarray of uint8, shape (2, 3, n)
        As from `rcss_hat.protocol.see.team_names`, for observers of the left and the right team.
    sizes : ndarray of int64, shape (2, 3)
    landmarks : ndarray of uint8
        Numbers of the landmarks that are told.
    """

    teams: Buffer
    sizes: NDArray[np.int64]
    landmarks: NDArray[np.uint8]


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


# --- everybody's of a step, one datagram behind the other -------------------------------------------------------------
@kernel
def write_senses(world: World, players: NDArray[np.int64], sense: NDArray[np.void], pages: Pages) -> int:
    """Write the sense_body message of every player; returns how many there are.

    Parameters
    ----------
    world : World
    players : ndarray of int64
        Indices, rising.
    sense : ndarray of records.SENSE_BODY, shape (1,)
        To work with.
    pages : Pages
    """
    at = 0
    for k in range(players.shape[0]):
        i = players[k]
        body.sense_body(world, i, sense)
        at = _turn_page(pages, k, i, at, write_sense_body(sense, world.match, i, pages.buffer[at:]))
    return players.shape[0]


@kernel
def write_hears(world: World, players: NDArray[np.int64], order: NDArray[np.int32], pages: Pages) -> int:
    """Write what every player hears of players; returns how many messages that is.

    Parameters
    ----------
    world : World
    players : ndarray of int64
        Indices, rising.
    order : ndarray of int32, shape (MAX_MESSAGES, 2)
        To work with.
    pages : Pages
    """
    at = written = 0
    for k in range(players.shape[0]):
        i = players[k]
        n = hearing.deliver(world, i, order)
        write_hear(world.match, i, order, n, pages.buffer[at:], pages.ends[written:])
        for m in range(written, written + n):
            pages.ends[m] += at
            pages.readers[m] = i
        written += n
        at = pages.ends[written - 1] if n > 0 else at
    return written


@kernel
def write_sees(world: World, due: NDArray[np.uint8], names: Names, see: NDArray[np.void], pages: Pages) -> int:
    """Write so many see messages for every player; returns how many there are.

    Parameters
    ----------
    world : World
    due : ndarray of uint8, shape (N_PLAYERS,)
        How often each player sees; there must be room for all.
    names : Names
    see : ndarray of records.SEE, shape (1,)
        To work with.
    pages : Pages
    """
    at = written = 0
    for i in range(due.shape[0]):
        team = 0 if i < MAX_PLAYERS else 1
        for _ in range(due[i]):
            vision.see(world, i, names.landmarks, True, see)
            size = write_see(see, names.teams[team], names.sizes[team], pages.buffer[at:])
            at = _turn_page(pages, written, i, at, size)
            written += 1
    return written


@inlined
def _turn_page(pages: Pages, k: int, reader: int, at: int, size: int) -> int:
    """End a datagram with its NUL and note whose it is; returns where the next one begins."""
    end = at + size + 1
    pages.buffer[end - 1] = 0
    pages.ends[k] = end
    pages.readers[k] = reader
    return end
