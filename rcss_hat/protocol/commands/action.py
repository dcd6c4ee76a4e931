"""From an ACTION record straight to a datagram and back: what a player sends in most cycles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import njit
from rcss_hat.protocol import scan
from rcss_hat.protocol.digits import Buffer, ascii_bytes, put_bytes, put_int, put_text, text_table
from rcss_hat.protocol.errors import LocalProtocolError
from rcss_hat.protocol.records import CATCH, DASH, KICK, MOVE, NO_COMMAND, SAY_SIZE, TACKLE, TURN
from rcss_hat.protocol.scan import MINUS, NINE, QUOTE, RIGHT_PARENTHESIS, SPACE, ZERO, byte

_LARGEST = 1_000_000.0
_ROOM = 128  # the longest datagram has 77 bytes
_UINT8 = np.dtype(np.uint8)
_COMMANDS, _SIZES = text_table(
    {DASH: "(dash ", TURN: "(turn ", KICK: "(kick ", TACKLE: "(tackle ", CATCH: "(catch ", MOVE: "(move "}
)
_TURN_NECK, _SAY, _DONE = ascii_bytes("(turn_neck "), ascii_bytes('(say "'), ascii_bytes("(done)")
NOT_PLAIN, ACTS, IS_DONE = -1, 1, 2
"""What `read_action` finds: another form, or the sum of: something to be done, and ``(done)``."""
_DIGITS = 9
_SAY_ALLOWED = np.array(
    [chr(byte).isascii() and (chr(byte).isalnum() or chr(byte) in " ().+-*/?<>_") for byte in range(256)]
)


def action_to_bytes(action: NDArray[np.void]) -> bytes:
    """Write the commands of a cycle as one datagram.

    Parameters
    ----------
    action : ndarray of ACTION, shape (1,)
        Numbers are integers (others are rounded, halves to even); a direction of dash of 0 is left out.

    Returns
    -------
    bytes
        Body command, turn_neck, quoted say, and NUL; empty when there is nothing to do.

    Raises
    ------
    LocalProtocolError
        For an unknown kind, a number that is not finite or beyond a million, or a message that servers refuse.
    """
    buffer = np.empty(_ROOM, _UINT8)
    size = _write(action, buffer)
    if size < 0:
        raise LocalProtocolError(_complaint(action))
    return buffer[:size].tobytes()


@njit
def _write(action: NDArray[np.void], buffer: NDArray[np.uint8]) -> int:
    """Write the datagram; returns its size, -1 when something in it is illegal."""
    kind = int(np.int64(action["kind"][0]))
    turns_neck = action["turns_neck"][0] != 0
    a = action["a"][0] if kind != NO_COMMAND else 0.0
    b = action["b"][0] if kind != NO_COMMAND else 0.0
    neck = action["neck"][0] if turns_neck else 0.0
    n = int(np.int64(action["say_n"][0]))
    if kind > MOVE or n > SAY_SIZE or not (abs(a) <= _LARGEST and abs(b) <= _LARGEST and abs(neck) <= _LARGEST):
        return -1
    i = 0
    if kind != NO_COMMAND:
        i = put_bytes(buffer, i, _COMMANDS[kind], _SIZES[kind])
        i = put_int(buffer, i, int(np.int64(np.rint(a))))
        if kind in (KICK, MOVE) or (kind == DASH and np.rint(b) != 0.0):
            buffer[i] = SPACE
            i = put_int(buffer, i + 1, int(np.int64(np.rint(b))))
        buffer[i] = RIGHT_PARENTHESIS
        i += 1
    if turns_neck:
        i = put_text(buffer, i, _TURN_NECK)
        i = put_int(buffer, i, int(np.int64(np.rint(neck))))
        buffer[i] = RIGHT_PARENTHESIS
        i += 1
    if n > 0:
        i = put_text(buffer, i, _SAY)
        for k in range(n):
            if not _SAY_ALLOWED[action["say"][0, k]]:
                return -1
            buffer[i] = action["say"][0, k]
            i += 1
        buffer[i] = QUOTE
        buffer[i + 1] = RIGHT_PARENTHESIS
        i += 2
    if i > 0:
        buffer[i] = 0
        i += 1
    return i


def _complaint(action: NDArray[np.void]) -> str:
    """Say what is wrong with an action, and what would be right."""
    if action["kind"][0] > MOVE:
        return f"action kind must be 0 to {MOVE} (NO_COMMAND to MOVE), not {action['kind'][0]}"
    for name in ("a", "b", "neck"):
        if not abs(action[name][0]) <= _LARGEST:
            return f"action field {name} must be a finite number of at most a million, not {action[name][0]}"
    if action["say_n"][0] > SAY_SIZE:
        return f"a message has at most {SAY_SIZE} characters, the action says {action['say_n'][0]}"
    said = bytes(action["say"][0][: action["say_n"][0]])
    return f"a message has only letters, digits, spaces and ().+-*/?<>_, not {said!r}"


# --- reading ----------------------------------------------------------------------------------------------------------
def read_action(data: bytes, action: NDArray[np.void]) -> int:
    r"""Read a datagram of the plain form in which `action_to_bytes` writes, with or without ``(done)`` at its end.

    Servers read much more (`rcss_hat.protocol.commands.parse_commands`); what they read in these is the same.

    Parameters
    ----------
    data : bytes
    action : ndarray of ACTION, shape (1,)
        Overwritten; dash, turn or kick, turn_neck, say, all numbers whole. It means nothing with NOT_PLAIN.

    Returns
    -------
    int
        NOT_PLAIN, or the sum of ACTS and IS_DONE.

    Examples
    --------
    >>> from rcss_hat.protocol.records import ACTION, empty
    >>> action = empty(ACTION)
    >>> read_action(b"(dash 100)(turn_neck -5)(done)\0", action)
    3
    >>> read_action(b"(dash 1e2)\0", action)
    -1
    """
    if data[-1:] != b"\0":
        return NOT_PLAIN
    return _read(scan.to_array(data), action)


@njit
def _read(data: Buffer, action: NDArray[np.void]) -> int:
    i = _read_body(data, action)
    after = _behind(data, i, _TURN_NECK, _TURN_NECK.shape[0])
    action["turns_neck"][0] = after >= 0
    if after >= 0:
        action["neck"][0], i = _whole(data, after)
        i = _behind_parenthesis(data, i)
    after = _behind(data, i, _SAY, _SAY.shape[0])
    action["say_n"][0] = 0
    if after >= 0:
        i = _read_words(data, after, action)
    found = ACTS if i > 0 else 0
    after = _behind(data, i, _DONE, _DONE.shape[0])
    if after >= 0:
        found |= IS_DONE
        i = after
    return found if i == data.shape[0] - 1 and found else NOT_PLAIN


@njit
def _read_body(data: Buffer, action: NDArray[np.void]) -> int:
    """Read the body command; returns the index behind it, 0 when there is none, -1 when it is not plain."""
    action["kind"][0] = NO_COMMAND
    for kind in (DASH, TURN, KICK):
        i = _behind(data, 0, _COMMANDS[kind], _SIZES[kind])
        if i >= 0:
            action["kind"][0] = kind
            action["a"][0], i = _whole(data, i)
            action["b"][0] = 0.0
            if kind == KICK and i >= 0:
                action["b"][0], i = _whole(data, i + 1) if data[i] == SPACE else (0.0, -1)
            return _behind_parenthesis(data, i)
    return 0


@njit
def _behind(data: Buffer, i: int, text: Buffer, size: int) -> int:
    """Return the index behind a text that stands at i; -1 when it does not, or i is -1."""
    if i < 0:
        return -1
    for k in range(size):
        if data[i + k] != text[k]:
            return -1  # at the final NUL at the latest
    return i + size


@njit
def _behind_parenthesis(data: Buffer, i: int) -> int:
    return i + 1 if i >= 0 and data[i] == RIGHT_PARENTHESIS else -1


@njit
def _whole(data: Buffer, i: int) -> tuple[float, int]:
    """Read a whole number as it is usually written; returns it and the index behind, -1 when it is not."""
    sign = 1.0
    if data[i] == MINUS:
        sign = -1.0
        i += 1
    value, start = 0, i
    while ZERO <= data[i] <= NINE and i - start <= _DIGITS:
        value = 10 * value + (byte(data, i) - ZERO)
        i += 1
    if not 1 <= i - start <= _DIGITS or (data[start] == ZERO and (i - start > 1 or sign < 0.0)):
        return 0.0, -1
    return sign * value, i


@njit
def _read_words(data: Buffer, i: int, action: NDArray[np.void]) -> int:
    """Read what is said, up to its parenthesis; returns the index behind it, or -1."""
    n = 0
    while n <= SAY_SIZE and _SAY_ALLOWED[data[i]]:
        if n < SAY_SIZE:
            action["say"][0, n] = data[i]
        n += 1
        i += 1
    if not 1 <= n <= SAY_SIZE or data[i] != QUOTE:
        return -1
    action["say_n"][0] = n
    return _behind_parenthesis(data, i + 1)
