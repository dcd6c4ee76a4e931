"""Datagrams that are nearly right: recorded ones with bytes changed, cut off, spliced, or with impossible numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from hypothesis import strategies as st

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_NUMBERS = (
    b"0", b"-0", b"-1", b"12", b"255", b"256", b"180", b"360", b"-360", b"359.9", b"0.5", b"0.0000001", b"1e-320",
    b"-1e5", b"1e6", b"-1e6", b"999999999", b"-999999999", b"2147483647", b"-2147483649", b"99999999999999999999",
    b"1e18", b"1e19", b"1e40", b"1e150", b"1e308", b"-1e308", b"1e400", b"nan", b"inf", b"-inf",
)  # fmt: skip
_BYTES = b'()" \0\nptk-.e0915fgbl\xff'
Draw = Callable[..., object]


def _change_byte(draw: Draw, data: bytes, others: Sequence[bytes]) -> bytes:
    place = draw(st.integers(0, max(0, len(data) - 1)))
    return data[:place] + bytes([draw(st.sampled_from(_BYTES))]) + data[place + 1 :]


def _cut(draw: Draw, data: bytes, others: Sequence[bytes]) -> bytes:
    return data[: draw(st.integers(0, len(data)))]


def _splice(draw: Draw, data: bytes, others: Sequence[bytes]) -> bytes:
    other = draw(st.sampled_from(others))
    return data[: draw(st.integers(0, len(data)))] + other[draw(st.integers(0, len(other))) :]


def _renumber(draw: Draw, data: bytes, others: Sequence[bytes]) -> bytes:
    numbers = list(_NUMBER.finditer(data))
    if not numbers:
        return data
    number = draw(st.sampled_from(numbers))
    return data[: number.start()] + draw(st.sampled_from(_NUMBERS)) + data[number.end() :]


@st.composite
def mutated(draw: Draw, datagrams: Sequence[bytes]) -> bytes:
    """One of some datagrams, changed in up to three ways."""
    data = draw(st.sampled_from(datagrams))
    for _ in range(draw(st.sampled_from([0, 1, 1, 1, 2, 3]))):
        change = draw(st.sampled_from([_change_byte, _cut, _splice, _renumber, _renumber, _renumber]))
        data = change(draw, data, datagrams)
    return data
