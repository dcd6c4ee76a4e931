from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.numeric import angles, rng, wire
from rcss_hat.numeric.sources import _imports, source_digest


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e15, max_value=1e15))
def test_six_digits_is_what_reading_the_text_gives(value: float) -> None:
    if abs(value) > 1e-15:
        assert wire.six_digits(value) == float(f"{value:g}")


def test_six_digits_keeps_negative_zero() -> None:
    assert math.copysign(1.0, wire.six_digits(-0.0)) == -1.0


def test_quantize_rounds_halves_to_even() -> None:
    assert wire.quantize(2.5, 1.0) == 2.0
    assert wire.quantize(3.5, 1.0) == 4.0
    assert wire.quantize(1.23456, 1e-11) == 1.23456


def test_streams_repeat_and_differ() -> None:
    a, b, c = rng.stream(1, rng.SERVER, 0), rng.stream(1, rng.SERVER, 0), rng.stream(1, rng.SERVER, 1)
    first = [rng.uniform(a, 0.0, 1.0) for _ in range(5)]
    assert first == [rng.uniform(b, 0.0, 1.0) for _ in range(5)]
    assert first != [rng.uniform(c, 0.0, 1.0) for _ in range(5)]


def test_stream_is_xoshiro256plusplus() -> None:
    # First outputs for the state 1, 2, 3, 4, as published with the reference implementation.
    state = np.array([1, 2, 3, 4], dtype=np.uint64)
    assert [int(rng.next_uint64(state)) for _ in range(4)] == [41943041, 58720359, 3588806011781223, 3591011842654386]


def test_uniform_of_an_empty_interval_takes_no_draw() -> None:
    state = np.array([1, 2, 3, 4], dtype=np.uint64)
    assert rng.uniform(state, 2.0, 2.0) == 2.0
    assert list(state) == [1, 2, 3, 4]


def test_draws_have_the_right_moments() -> None:
    state = rng.stream(7, 0)
    normals = np.array([rng.normal(state) for _ in range(20_000)])
    assert abs(normals.mean()) < 0.03
    assert abs(normals.std() - 1.0) < 0.03
    integers = np.bincount([rng.integer(state, 3) for _ in range(9_000)], minlength=3)
    assert integers.min() > 2_800
    assert abs(np.mean([rng.bernoulli(state, 0.25) for _ in range(20_000)]) - 0.25) < 0.015


@given(st.floats(-2000, 2000))
def test_normalized_degrees_name_the_same_direction(angle: float) -> None:
    result = angles.normalize_degrees(angle)
    assert -180.0 < result <= 180.0
    assert math.isclose(math.cos(math.radians(result)), math.cos(math.radians(angle)), abs_tol=1e-6)


def test_normalize_radians_leaves_both_ends() -> None:
    assert angles.normalize_radians(math.pi) == math.pi
    assert angles.normalize_radians(-math.pi) == -math.pi


def test_fingerprint_covers_imported_modules() -> None:
    assert source_digest("rcss_hat.numeric.wire") != source_digest("rcss_hat.numeric.angles")
    assert "rcss_hat.numeric.jit" in _imports("from rcss_hat.numeric.jit import njit\n")
    assert "rcss_hat.numeric.rng" in _imports("from rcss_hat.numeric import (\n    rng,\n    wire,\n)\n")


@given(st.floats(-1000, 1000), st.floats(-1000, 1000))
def test_quick_atan2_is_near_enough(y: float, x: float) -> None:
    error = abs(angles.quick_atan2(y, x) - math.atan2(y, x))
    assert min(error, 2.0 * math.pi - error) < 5e-12 or (x == 0.0 and y == 0.0)


def test_quick_atan2_is_exact_on_axes_and_diagonals() -> None:
    for y, x in ((0, 3), (3, 0), (0, -3), (-3, 0), (2, 2), (2, -2), (-2, -2), (-2, 2)):
        assert angles.quick_atan2(float(y), float(x)) == math.atan2(y, x)
    assert angles.quick_atan2(0.0, 0.0) == 0.0


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3.1, 3.1), st.sampled_from([0.0, 0.5, -1.0]))
def test_cut_degrees_are_those_of_the_exact_arctangent(x: float, y: float, body: float, neck: float) -> None:
    heading = math.atan2(y, x) if x or y else 0.0
    assert angles.cut_degrees(x, y, body, neck) == int(angles.normalize_radians(heading - body - neck) * angles.RAD)


def test_whole_degrees_are_not_cut_below_themselves() -> None:
    for degrees in range(-180, 181):
        way = degrees * angles.DEG
        exact = int(angles.normalize_radians(math.atan2(math.sin(way), math.cos(way)) - 0.0) * angles.RAD)
        assert angles.cut_degrees(math.cos(way), math.sin(way), 0.0, 0.0) == exact


def test_arrays_are_found_by_their_addresses() -> None:
    from rcss_hat.numeric.addresses import _plain_array_at, address_of

    numbers = np.arange(6.0).reshape(2, 3)
    found = _plain_array_at(address_of(numbers), (2, 3), np.dtype("f8"))
    found[1, 2] = -1.0
    assert numbers[1, 2] == -1.0
    assert _plain_array_at(0, (2, 0), np.dtype("f8")).shape == (2, 0)
    with pytest.raises(ValueError, match="in C's order"):
        address_of(numbers[:, ::2])
