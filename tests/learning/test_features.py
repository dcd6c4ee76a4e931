from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_sarsa import cmac_features, rbf_features

from rcss_hat.learning.features import cmac, rbf
from rcss_hat.learning.widths import n_state_variables, tile_widths, variable_maxima


def test_widths_are_those_the_players_compute() -> None:
    assert tile_widths(3, 2).tolist() == [2, 2, 3, 2, 3, 2, 3, 3, 3, 4, 4, 10, 10]
    assert tile_widths(4, 3).tolist() == [2, 2, 2, 3, 3, 3, 3, 2, 2, 3, 3, 3, 3, 4, 4, 4, 10, 10, 10]
    assert tile_widths(5, 4).tolist() == [2] * 4 + [3] * 5 + [2] * 3 + [3] * 5 + [4] * 4 + [10] * 4
    assert tile_widths(3, 2, "article").tolist() == [3.0] * 11 + [10.0] * 2


@pytest.mark.parametrize(("n", "m"), [(3, 2), (4, 3), (5, 4), (11, 11)])
def test_every_variable_has_a_width_and_a_range(n: int, m: int) -> None:
    assert tile_widths(n, m).shape == variable_maxima(n, m, 60.0).shape == (n_state_variables(n, m),)
    assert np.count_nonzero(variable_maxima(n, m, 60.0) == 180.0) == n - 1


@pytest.mark.parametrize(("n", "m"), [(2, 2), (3, 1), (12, 2)])
def test_widths_of_other_sizes_are_refused(n: int, m: int) -> None:
    with pytest.raises(ValueError, match=f"not {n}v{m}"):
        tile_widths(n, m)


@given(st.floats(0.0, 60.0), st.sampled_from([2.0, 3.0, 4.0, 10.0]), st.integers(1, 40))
def test_tiles_follow_the_formula(x: float, width: float, tilings: int) -> None:
    approximator = cmac([width], [60.0], tilings)
    indices, values = approximator.active_features([x])
    assert (values == 1.0).all()
    # The feature at index i is the tile that begins at edge c, of the tiling c mod T.
    edges = indices[0] + approximator.lowest
    found = {(0, int(c) % tilings, int(c) // tilings) for c in edges}
    assert found == set(cmac_features([x], [width], tilings))


def test_tiles_change_exactly_at_their_edges() -> None:
    approximator = cmac([3.0], [60.0])
    for k in range(1, 600):
        edge = 3.0 * k / 32.0
        at, below = (approximator.active_features([x])[0][0, 0] for x in (edge, math.nextafter(edge, 0.0)))
        assert at == below + 1


@given(
    st.floats(0.0, 60.0),
    st.sampled_from([2.0, 3.0, 10.0]),
    st.sampled_from([(32, 0.25, 0.75), (1, 0.25, 0.75), (8, 0.5, 1.3)]),
)
def test_gaussians_follow_the_formula(x: float, width: float, shape: tuple[int, float, float]) -> None:
    approximator = rbf([width], [60.0], *shape)
    indices, values = approximator.active_features([x])
    found = {(0, int(i) + approximator.lowest): value for i, value in zip(indices[0], values[0], strict=True) if value}
    expected = rbf_features([x], [width], *shape)
    assert found.keys() == expected.keys()
    assert all(math.isclose(found[key], expected[key], rel_tol=1e-9) for key in found)


def test_gaussians_round_the_state_to_a_fraction_of_a_millimetre() -> None:
    indices, values = rbf([2.0], [60.0]).active_features([7.7773])
    exact = np.exp(-((7.7773 / 2.0 - (indices - 23) / 32.0) ** 2) / (2 * 0.25**2))
    assert np.abs(values - exact).max() < 7e-4


def test_active_gaussians_and_their_norm_are_those_of_the_recommended_layout() -> None:
    approximator = rbf(tile_widths(3, 2), variable_maxima(3, 2, 60.0))
    assert approximator.table[:-1].shape == (64, 48)
    assert approximator.n_tiles == 416
    assert approximator.norm == pytest.approx(13 * 32 * 0.25 * math.sqrt(math.pi), rel=2e-3)


def test_normalised_gaussians_sum_to_one() -> None:
    approximator = rbf([2.0, 3.0], [60.0, 60.0], tilings=1, normalise=True)
    for x in np.linspace(0.0, 60.0, 97):
        assert approximator.active_features([x, x])[1].sum(axis=1) == pytest.approx([1.0, 1.0])
    assert approximator.sum == pytest.approx(2.0)


@pytest.mark.parametrize("make", [cmac, rbf])
def test_variables_never_share_a_weight_and_all_weights_are_in_reach(make: type) -> None:
    widths, maxima = tile_widths(3, 2), variable_maxima(3, 2, 60.0)
    approximator = make(widths, maxima)
    low, _ = approximator.active_features(np.zeros(13))
    high, _ = approximator.active_features(maxima)
    assert low[0, 0] == 0
    assert (low[1:, 0] == high[:-1, -1] + 1).all()
    assert high[-1, -1] == approximator.n_features - 1


@pytest.mark.parametrize("make", [cmac, rbf])
def test_values_outside_the_range_are_taken_for_its_ends(make: type) -> None:
    approximator = make([2.0], [60.0])
    for outside, end in ((-3.0, 0.0), (61.0, 60.0), (1e30, 60.0)):
        for a, b in zip(approximator.active_features([outside]), approximator.active_features([end]), strict=True):
            assert (a == b).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([2.0], [60.0, 60.0]), "equal length"),
        (([0.0], [60.0]), "tile widths must be positive"),
        (([2.0], [math.inf]), "ends of ranges must be positive"),
        (([1.0] * 65, [1.0] * 65), "1 to 64"),
        (([2.0], [60.0], 0), "tilings must be 1 to 256"),
        (([2.0], [60.0], 32, 0.0), "sigma must be a positive number"),
        (([2.0], [60.0], 1, 0.25, 0.5), "cutoff must be greater"),
    ],
)
def test_impossible_layouts_are_refused(arguments: tuple, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rbf(*arguments)


def test_states_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(1,\), not \(2,\)"):
        cmac([2.0], [60.0]).active_features([1.0, 2.0])
    with pytest.raises(ValueError, match="finite"):
        cmac([2.0], [60.0]).active_features([math.nan])
