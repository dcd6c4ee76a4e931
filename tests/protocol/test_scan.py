from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol import scan


def read(text: str) -> tuple[float, int]:
    return scan.number(scan.to_array(text.encode()), 0)


def same_bits(a: float, b: float) -> bool:
    return struct.pack("d", a) == struct.pack("d", b)


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e21, max_value=1e21))
def test_six_digit_numbers_are_read_as_python_reads_them(value: float) -> None:
    text = f"{value:g}"
    if abs(value) > 1e-16 or value == 0.0:
        number, after = read(text)
        assert same_bits(number, float(text))
        assert after == len(text)


@given(st.integers(-(10**15) + 1, 10**15 - 1), st.integers(-22, 22))
def test_fifteen_digits_and_an_exponent_are_read_exactly(mantissa: int, exponent: int) -> None:
    text = f"{mantissa}e{exponent}"
    assert same_bits(read(text)[0], float(text))


@given(st.from_regex(r"[+-]?[0-9]{0,15}\.[0-9]{1,15}", fullmatch=True))
def test_any_decimal_of_up_to_fifteen_digits_is_exact(text: str) -> None:
    number, after = read(text)
    assert after == len(text)
    if len(text.lstrip("+-0.").replace(".", "")) <= 15:
        assert same_bits(number, float(text))
    else:
        assert number == pytest.approx(float(text), rel=1e-15)


@given(st.from_regex(r"-?[0-9]{1,40}(\.[0-9]{0,40})?([eE][+-]?[0-9]{1,3})?", fullmatch=True))
def test_long_numbers_are_right_to_the_last_digits(text: str) -> None:
    number, after = read(text)
    if math.isinf(float(text)) or abs(float(text)) > 1e300:
        assert after in (-1, len(text))
    else:
        assert after == len(text)
        assert number == pytest.approx(float(text), rel=1e-13, abs=1e-300)


def test_the_sign_of_zero_is_kept() -> None:
    assert same_bits(read("-0")[0], -0.0)
    assert same_bits(read("-0.0e5")[0], -0.0)
    assert same_bits(read("0")[0], 0.0)


@pytest.mark.parametrize("text", ["", "-", ".", "-.", "nan", "inf", "1e", "1e+", "1e400", "e5", "x"])
def test_what_is_no_finite_number_is_refused(text: str) -> None:
    assert read(text)[1] == -1


@pytest.mark.parametrize(("text", "value", "after"), [("12)", 12, 2), ("-7 3", -7, 2), ("123456789", 123456789, 9)])
def test_integers(text: str, value: int, after: int) -> None:
    assert scan.integer(scan.to_array(text.encode()), 0) == (value, after)


@pytest.mark.parametrize("text", ["", "-", "x", "1234567890"])
def test_what_is_no_small_integer_is_refused(text: str) -> None:
    assert scan.integer(scan.to_array(text.encode()), 0)[1] == -1


def test_words_have_the_key_of_their_name() -> None:
    for name in ("see", "sense_body", "change_view", "x"):
        assert scan.word(scan.to_array(name.encode() + b" 1"), 0) == (scan.key_of(name), len(name))
    assert scan.word(scan.to_array(b"1"), 0) == (0, 0)


def test_groups_are_skipped_to_their_end() -> None:
    assert scan.skip_group(scan.to_array(b" a (b) c) d"), 0) == 9
    assert scan.skip_group(scan.to_array(b" a (b c) d"), 0) == -1


def test_arrays_end_in_one_nul() -> None:
    assert bytes(scan.to_array(b"ab")) == b"ab\0"
    assert bytes(scan.to_array(b"ab\0")) == b"ab\0"
    assert bytes(scan.to_array(b"")) == b"\0"
