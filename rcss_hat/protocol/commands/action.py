"""From an ACTION record straight to a datagram: what a player sends in most cycles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import njit
from rcss_hat.protocol.digits import ascii_bytes, put_bytes, put_int, put_text, text_table
from rcss_hat.protocol.errors import LocalProtocolError
from rcss_hat.protocol.records import CATCH, DASH, KICK, MOVE, NO_COMMAND, SAY_SIZE, TACKLE, TURN
from rcss_hat.protocol.scan import QUOTE, RIGHT_PARENTHESIS, SPACE

_LARGEST = 1_000_000.0
_ROOM = 128  # the longest datagram has 77 bytes
_UINT8 = np.dtype(np.uint8)
_COMMANDS, _SIZES = text_table(
    {DASH: "(dash ", TURN: "(turn ", KICK: "(kick ", TACKLE: "(tackle ", CATCH: "(catch ", MOVE: "(move "}
)
_TURN_NECK, _SAY = ascii_bytes("(turn_neck "), ascii_bytes('(say "')
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
