"""The hear message, the fast way: who spoke, and a team mate's words into the HEARD record; and how it is written."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel, njit
from rcss_hat.protocol.digits import Buffer, ascii_bytes, put_int, put_spaced_int, put_text
from rcss_hat.protocol.records import MAX_PLAYERS, SAY_SIZE
from rcss_hat.protocol.scan import (
    LEFT_PARENTHESIS,
    NUL,
    QUOTE,
    RIGHT_PARENTHESIS,
    SPACE,
    byte,
    ends,
    integer,
    key_of,
    number,
    to_array,
    word,
)

HEARD_OTHER, HEARD_REFEREE, HEARD_TEAM_MATE, HEARD_OPPONENT, HEARD_SELF, HEARD_PARTIAL, HEARD_LONG = range(7)
"""OTHER: anything else, perhaps malformed; `rcss_hat.protocol.messages.parse` tells. PARTIAL: somebody spoke, but the
words were lost. LONG: a team mate's message that does not fit the record."""
_HEAR, _REFEREE, _SELF, _OUR, _OPP = (key_of(name) for name in ("hear", "referee", "self", "our", "opp"))


def parse_hear_fast(data: bytes, heard: NDArray[np.void]) -> int:
    """Tell which kind of hear message this is; write the record when it is a team mate's complete message.

    Parameters
    ----------
    data : bytes
        A message to a player of version 8 or later, with or without its NUL.
    heard : ndarray of HEARD, shape (1,)
        Left alone unless the kind is HEARD_TEAM_MATE.

    Returns
    -------
    int
        One of HEARD_OTHER .. HEARD_LONG.
    """
    return _parse(to_array(data), heard)


@njit
def _parse(data: NDArray[np.uint8], heard: NDArray[np.void]) -> int:
    """Read ``(hear TIME SOURCE ...``."""
    if data[0] != LEFT_PARENTHESIS:
        return HEARD_OTHER
    key, i = word(data, 1)
    if key != _HEAR or data[i] != SPACE:
        return HEARD_OTHER
    time, i = integer(data, i + 1)
    if i < 0 or data[i] != SPACE:
        return HEARD_OTHER
    source, after = word(data, i + 1)
    if after > i + 1:
        if source == _REFEREE and data[after] == SPACE:
            return HEARD_REFEREE
        if source == _SELF and data[after] == SPACE:
            return HEARD_SELF
        partial = source in (_OUR, _OPP) and (data[after] == SPACE or data[after] == RIGHT_PARENTHESIS)
        return HEARD_PARTIAL if partial else HEARD_OTHER
    direction, i = number(data, i + 1)
    if i < 0 or data[i] != SPACE:
        return HEARD_OTHER
    source, i = word(data, i + 1)
    if source == _OPP and data[i] == SPACE:
        return HEARD_OPPONENT
    if source != _OUR or data[i] != SPACE:
        return HEARD_OTHER
    return _team_mate(data, i + 1, time, direction, heard)


@njit
def _team_mate(data: NDArray[np.uint8], i: int, time: int, direction: float, heard: NDArray[np.void]) -> int:
    """Read ``UNUM "TEXT")``."""
    unum, i = integer(data, i)
    if i < 0 or not 1 <= unum <= MAX_PLAYERS or data[i] != SPACE or data[i + 1] != QUOTE:
        return HEARD_OTHER
    start = i + 2
    i = start
    while data[i] != QUOTE and data[i] != NUL:
        i += 1
    if data[i] != QUOTE or data[i + 1] != RIGHT_PARENTHESIS or not ends(data, i + 2):
        return HEARD_OTHER
    n = i - start
    if n > SAY_SIZE:
        return HEARD_LONG
    heard["time"][0] = time
    heard["direction"][0] = direction
    heard["unum"][0] = unum
    heard["n"][0] = n
    for k in range(SAY_SIZE):
        heard["text"][0, k] = byte(data, start + k) if k < n else 0
    return HEARD_TEAM_MATE


# --- writing ----------------------------------------------------------------------------------------------------------
BY_SELF, BY_TEAM_MATE, BY_OPPONENT = range(3)
_START, _BY_SELF = ascii_bytes("(hear "), ascii_bytes(" self")
_BY_TEAM_MATE, _BY_OPPONENT = ascii_bytes(" our "), ascii_bytes(" opp")


@kernel
def put_hear(buffer: Buffer, at: int, time: int, speaker: tuple[int, int, int], words: Buffer) -> int:
    """Write how a player hears a player, with its NUL.

    Parameters
    ----------
    buffer : ndarray of uint8
    at : int
        Where it begins.
    time : int
    speaker : tuple of int
        BY_SELF, BY_TEAM_MATE or BY_OPPONENT, uniform number, direction (degrees relative to the listener's body).
    words : ndarray of uint8
        Empty when only the fact of speaking was heard.

    Returns
    -------
    int
        The position behind it.
    """
    who, unum, direction = speaker
    at = put_int(buffer, put_text(buffer, at, _START), time)
    if who == BY_SELF:
        at = put_text(buffer, at, _BY_SELF)
    else:
        if words.size > 0:
            at = put_spaced_int(buffer, at, direction)
        if who == BY_TEAM_MATE:
            at = put_int(buffer, put_text(buffer, at, _BY_TEAM_MATE), unum)
        else:
            at = put_text(buffer, at, _BY_OPPONENT)
    if words.size > 0:
        buffer[at] = SPACE
        buffer[at + 1] = QUOTE
        at = put_text(buffer, at + 2, words)
        buffer[at] = QUOTE
        at += 1
    buffer[at] = RIGHT_PARENTHESIS
    buffer[at + 1] = NUL
    return at + 2
