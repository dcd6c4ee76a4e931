"""Kernels that write numbers into a byte buffer, digit for digit as the server's C++ streams do (``%g``, ``%d``).

A buffer is a ``uint8`` array; every ``put_*`` kernel writes at a position and returns the position after what it wrote.
Rounding is exact: the decimal scaling keeps the part that one multiplication loses, so that numbers just beside a
tie of the seventh digit round as ``printf`` rounds them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel

Buffer = NDArray[np.uint8]

_POWERS = np.array([float(f"1e{k}") for k in range(23)])
"""The powers of ten that are exact in binary."""
_SPLIT = 134217729.0  # 2**27 + 1 halves a double (Veltkamp 1968)
_SPACE, _ZERO, _MINUS, _PLUS, _POINT, _E = 32, 48, 45, 43, 46, 101


@inlined
def product_error(a: float, b: float, product: float) -> float:
    """Return what ``a * b`` lost by rounding to ``product`` (Dekker 1971)."""
    t = _SPLIT * a
    a_high = t - (t - a)
    a_low = a - a_high
    t = _SPLIT * b
    b_high = t - (t - b)
    b_low = b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@inlined
def _nearest(scaled: float, rest: float) -> int:
    """Round ``scaled + rest`` to the nearest integer, where rest is far below the spacing of scaled; ties to even."""
    whole = round(scaled)
    ahead = scaled - whole
    if ahead == 0.5 and rest > 0.0:
        return int(whole) + 1
    if ahead == -0.5 and rest < 0.0:
        return int(whole) - 1
    return int(whole)


@inlined
def _exponent(value: float) -> int:
    """Decimal exponent of a positive number; may be one off where the logarithm falls on a whole number."""
    if value >= 1.0:
        for k in range(1, 8):
            if value < _POWERS[k]:
                return k - 1
    elif value >= 1e-2:
        return -1 if value >= 0.1 else -2
    return int(math.floor(math.log10(value)))


@kernel
def _six_digits(value: float, exponent: int) -> int:
    """Round a positive number to a whole number of units of its sixth digit."""
    places = 5 - exponent
    while places > 22:  # beyond the exact powers; nothing that a server prints comes near a tie here
        value *= 1e22
        places -= 22
    while places < -22:
        value /= 1e22
        places += 22
    if places >= 0:
        power = _POWERS[places]
        scaled = value * power
        return _nearest(scaled, product_error(value, power, scaled))
    power = _POWERS[-places]
    scaled = value / power
    back = scaled * power
    return _nearest(scaled, (value - back) - product_error(scaled, power, back))


@inlined
def put_digits(buffer: Buffer, at: int, number: int, count: int) -> int:
    """Write the last ``count`` digits of a number, with leading zeros."""
    for k in range(at + count - 1, at - 1, -1):
        rest = number // 10
        buffer[k] = _ZERO + (number - 10 * rest)
        number = rest
    return at + count


@inlined
def put_int(buffer: Buffer, at: int, number: int) -> int:
    """Write an integer (``%d``)."""
    if number < 0:
        buffer[at] = _MINUS
        at += 1
        number = -number
    count = 1
    bound = 10
    while number >= bound:
        count += 1
        bound *= 10
    return put_digits(buffer, at, number, count)


@kernel
def put_hex(buffer: Buffer, at: int, number: int) -> int:
    """Write an integer that is not negative as C++ does with ``hex`` and ``showbase``: ``0x1f``, but ``0``."""
    if number == 0:
        buffer[at] = _ZERO
        return at + 1
    buffer[at] = _ZERO
    buffer[at + 1] = 120  # x
    at += 2
    shift = 0
    while number >> (shift + 4):
        shift += 4
    while shift >= 0:
        digit = (number >> shift) & 15
        buffer[at] = _ZERO + digit if digit < 10 else 87 + digit
        at += 1
        shift -= 4
    return at


@kernel
def _put_special(buffer: Buffer, at: int, value: float) -> int:
    if math.isnan(value):
        buffer[at], buffer[at + 1], buffer[at + 2] = 110, 97, 110  # nan
    else:
        buffer[at], buffer[at + 1], buffer[at + 2] = 105, 110, 102  # inf
    return at + 3


@kernel
def _put_scientific(buffer: Buffer, at: int, digits: int, count: int, exponent: int) -> int:
    """Write ``count`` digits as ``d.ddde-07``."""
    tail = 10 ** (count - 1)
    at = put_digits(buffer, at, digits // tail, 1)
    if count > 1:
        buffer[at] = _POINT
        at = put_digits(buffer, at + 1, digits % tail, count - 1)
    buffer[at] = _E
    buffer[at + 1] = _MINUS if exponent < 0 else _PLUS
    size = abs(exponent)
    return put_digits(buffer, at + 2, size, 3 if size >= 100 else 2)


@inlined
def _put_fixed(buffer: Buffer, at: int, digits: int, count: int, exponent: int) -> int:
    """Write ``count`` digits, the first worth 10**exponent (-4 .. 5), with a point where one is needed."""
    if exponent < 0:
        buffer[at] = _ZERO
        buffer[at + 1] = _POINT
        at += 2
        for _ in range(-1 - exponent):
            buffer[at] = _ZERO
            at += 1
        return put_digits(buffer, at, digits, count)
    behind = count - 1 - exponent
    if behind <= 0:
        for _ in range(-behind):
            digits *= 10
        return put_digits(buffer, at, digits, exponent + 1)
    tail = 10**behind
    whole = digits // tail
    at = put_digits(buffer, at, whole, exponent + 1)
    buffer[at] = _POINT
    return put_digits(buffer, at + 1, digits - whole * tail, behind)


@kernel
def put_number(buffer: Buffer, at: int, value: float) -> int:
    """Write a number with six significant digits (``%g``); at most 13 bytes."""
    if value < 0.0 or (value == 0.0 and math.copysign(1.0, value) < 0.0):
        buffer[at] = _MINUS
        at += 1
        value = -value
    if value == 0.0:
        buffer[at] = _ZERO
        return at + 1
    if not math.isfinite(value):
        return _put_special(buffer, at, value)
    exponent = _exponent(value)
    digits = _six_digits(value, exponent)
    if digits < 100000:
        exponent -= 1
        digits = _six_digits(value, exponent)
    if digits >= 1000000:  # rounded up to the next power of ten, or the exponent was one too small
        exponent += 1
        digits = _six_digits(value, exponent)
    count = 6
    while digits % 10 == 0:
        digits //= 10
        count -= 1
    if -4 <= exponent < 6:
        return _put_fixed(buffer, at, digits, count, exponent)
    return _put_scientific(buffer, at, digits, count, exponent)


@inlined
def put_bytes(buffer: Buffer, at: int, text: Buffer, size: int) -> int:
    """Write the first ``size`` bytes of a text."""
    for k in range(size):
        buffer[at + k] = text[k]
    return at + size


@inlined
def put_text(buffer: Buffer, at: int, text: Buffer) -> int:
    """Write a whole text."""
    return put_bytes(buffer, at, text, text.size)


@inlined
def put_spaced(buffer: Buffer, at: int, value: float) -> int:
    """Write a space and a number (``%g``)."""
    buffer[at] = _SPACE
    return put_number(buffer, at + 1, value)


@inlined
def put_spaced_int(buffer: Buffer, at: int, number: int) -> int:
    """Write a space and an integer."""
    buffer[at] = _SPACE
    return put_int(buffer, at + 1, number)


def ascii_bytes(text: str) -> Buffer:
    """Return a text as an array of its bytes, at least one long (kernels take no empty arrays)."""
    return np.frombuffer((text or " ").encode("latin-1"), dtype=np.uint8)


def text_table(texts: dict[int, str]) -> tuple[Buffer, NDArray[np.int64]]:
    """Pack texts into rows of bytes, with their lengths; row i is text i."""
    sizes = np.zeros(max(texts) + 1, dtype=np.int64)
    rows = np.zeros((max(texts) + 1, max(map(len, texts.values()))), dtype=np.uint8)
    for i, text in texts.items():
        sizes[i] = len(text)
        rows[i, : len(text)] = np.frombuffer(text.encode("ascii"), dtype=np.uint8)
    return rows, sizes
