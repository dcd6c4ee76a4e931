"""Reading words and numbers out of message bytes, for kernels.

Every function takes the message as a ``uint8`` array that ends in NUL, and an index; it never steps over a NUL. That
one rule replaces bounds checks: whatever bytes arrive, reading stops at the last one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import njit

NUL, TAB, RETURN, SPACE, QUOTE, LEFT_PARENTHESIS, RIGHT_PARENTHESIS = 0, 9, 13, 32, 34, 40, 41
PLUS, MINUS, POINT, ZERO, NINE, UPPER_E, LOWER_E = 43, 45, 46, 48, 57, 69, 101
LOWER_A, LOWER_Z, UNDERSCORE = 97, 122, 95

# Why a message was refused; the index where is returned with it.
(
    WANT_NAME,
    WANT_NUMBER,
    WANT_SPACE,
    WANT_OPEN,
    WANT_CLOSE,
    BAD_UNUM,
    BAD_COUNT,
    BAD_WORD,
    TOO_MANY,
    MISSING,
    BAD_RANGE,
) = range(1, 12)
REASONS = (
    "",
    "unknown message or name",
    "expected a number",
    "expected a space",
    "expected '('",
    "expected ')'",
    "expected a uniform number from 1 to 11",
    "wrong number of values",
    "unexpected word",
    "too many objects",
    "the message lacks a required part",
    "a number out of range",
)

MOST_DEGREES = 360.0
"""No server writes greater angles; the players' tables end there."""
MOST = 1e6
"""No server writes greater distances, speeds, stamina; their squares are finite."""
POWERS_OF_TEN = np.array([10.0**k for k in range(23)])
"""Those that a double holds exactly."""
_UINT8 = np.dtype(np.uint8)
_DIGITS = 15
_MANY = 10**17
_KEY_MASK = 2**56 - 1


def to_array(data: bytes) -> NDArray[np.uint8]:
    """View message bytes as an array that ends in NUL."""
    return np.frombuffer(data if data[-1:] == b"\0" else bytes(data) + b"\0", _UINT8)


@njit
def byte(data: NDArray[np.uint8], i: int) -> int:
    """Return a byte as a signed integer (unsigned ones turn into reals when mixed with signed in compiled code)."""
    return int(np.int64(data[i]))


@njit
def failure(reason: int, position: int) -> int:
    """Pack a reason and a position into the result of a parser; 0 means success."""
    return position * 16 + reason


@njit
def skip_spaces(data: NDArray[np.uint8], i: int) -> int:
    """Return the index of the next byte that is no white space."""
    while data[i] == SPACE or TAB <= data[i] <= RETURN:
        i += 1
    return i


@njit
def number(data: NDArray[np.uint8], i: int) -> tuple[float, int]:
    """Read a decimal number.

    The digits are gathered as an integer and multiplied or divided once by a power of ten. With up to 15 digits and
    powers up to 22, both are exact, so the result is the double nearest to the text, as Python's ``float`` gives it.

    Returns
    -------
    value : float
        Keeps the sign of ``-0``.
    after : int
        Index behind the number; -1 when there is none, or when it is not finite.
    """
    first = i
    negative = data[i] == MINUS
    if negative or data[i] == PLUS:
        i += 1
    start = i
    mantissa = 0
    while ZERO <= data[i] <= NINE and i - start < _DIGITS:
        mantissa = mantissa * 10 + byte(data, i) - ZERO
        i += 1
    places = 0
    digits = i - start
    if data[i] == POINT:
        i += 1
        point = i
        while ZERO <= data[i] <= NINE and i - start <= _DIGITS:
            mantissa = mantissa * 10 + byte(data, i) - ZERO
            i += 1
        places = i - point
        digits += places
    if digits == 0:
        return 0.0, -1
    if ZERO <= data[i] <= NINE or data[i] == LOWER_E or data[i] == UPPER_E:
        return _long_number(data, first)
    value = float(mantissa)
    if places > 0:
        value /= float(POWERS_OF_TEN[places])
    return (-value if negative else value), i


@njit
def is_angle(value: float) -> bool:
    """Tell whether a number can be an angle in degrees."""
    return -MOST_DEGREES <= value <= MOST_DEGREES


@njit
def is_quantity(value: float) -> bool:
    """Tell whether a number can be a distance, a speed or the like."""
    return -MOST <= value <= MOST


@njit
def _long_number(data: NDArray[np.uint8], i: int) -> tuple[float, int]:
    """Read what `number` reads, of any length and with an exponent."""
    negative = data[i] == MINUS
    if negative or data[i] == PLUS:
        i += 1
    mantissa, exponent, fraction = 0, 0, 0
    while ZERO <= data[i] <= NINE or (data[i] == POINT and fraction == 0):
        if data[i] == POINT:
            fraction = 1
        elif mantissa < _MANY:
            mantissa = mantissa * 10 + byte(data, i) - ZERO
            exponent -= fraction
        else:
            exponent += 1 - fraction
        i += 1
    if data[i] == LOWER_E or data[i] == UPPER_E:
        i += 1
        sign = -1 if data[i] == MINUS else 1
        if data[i] == MINUS or data[i] == PLUS:
            i += 1
        if not ZERO <= data[i] <= NINE:
            return 0.0, -1
        written = 0
        while ZERO <= data[i] <= NINE:
            if written < 100_000:
                written = written * 10 + byte(data, i) - ZERO
            i += 1
        exponent += sign * written
    value = scaled(float(mantissa), exponent)
    if value == np.inf:
        return 0.0, -1
    return (-value if negative else value), i


@njit
def scaled(value: float, exponent: int) -> float:
    """Return value * 10**exponent; rounded only once when the exponent is -22 .. 22 and the value below 2**53."""
    while exponent < -22 and value > 0.0:
        value /= 1e22
        exponent += 22
    while exponent > 22 and 0.0 < value < np.inf:
        value *= 1e22
        exponent -= 22
    if value == 0.0 or value == np.inf:
        return value
    return value / float(POWERS_OF_TEN[-exponent]) if exponent < 0 else value * float(POWERS_OF_TEN[exponent])


@njit
def integer(data: NDArray[np.uint8], i: int) -> tuple[int, int]:
    """Read an integer of up to nine digits; the index behind it is -1 when there is none."""
    negative = data[i] == MINUS
    if negative:
        i += 1
    start = i
    value = 0
    while ZERO <= data[i] <= NINE and i - start < 10:
        value = value * 10 + byte(data, i) - ZERO
        i += 1
    if i == start or i - start > 9:
        return 0, -1
    return (-value if negative else value), i


@njit
def word(data: NDArray[np.uint8], i: int) -> tuple[int, int]:
    """Read a word of small letters and underscores.

    Returns
    -------
    key : int
        As from `key_of`; 0 for the empty word.
    after : int
        Index behind the word.
    """
    key = 0
    while LOWER_A <= data[i] <= LOWER_Z or data[i] == UNDERSCORE:
        key = ((key & _KEY_MASK) << 7) ^ byte(data, i)
        i += 1
    return key, i


def key_of(name: str) -> int:
    """Number of a name: its last nine ASCII characters in seven bits each."""
    key = 0
    for byte in name.encode("ascii"):
        key = ((key & _KEY_MASK) << 7) ^ byte
    return key


@njit
def skip_group(data: NDArray[np.uint8], i: int) -> int:
    """Return the index behind the ``)`` that closes the group around i; -1 when it is never closed."""
    depth = 1
    while depth > 0:
        if data[i] == NUL:
            return -1
        if data[i] == LEFT_PARENTHESIS:
            depth += 1
        elif data[i] == RIGHT_PARENTHESIS:
            depth -= 1
        i += 1
    return i


@njit
def ends(data: NDArray[np.uint8], i: int) -> bool:
    """Tell whether only white space is left up to the NUL."""
    return data[skip_spaces(data, i)] == NUL
