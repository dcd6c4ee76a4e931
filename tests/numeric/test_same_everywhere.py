"""What results rest on is the same on every processor: NumPy's vectorised functions differ in the last digit."""

from __future__ import annotations

import math

import numpy as np

from rcss_hat.learning.features import rbf
from rcss_hat.numeric import angles


def test_tables_hold_what_the_c_library_calculates() -> None:
    cells = np.arange(257) / 256
    assert angles._ARCTANGENTS[:, 0].tolist() == [math.atan(value) for value in cells]
    slopes = [1.0 / (1.0 + value * value) for value in cells.tolist()]
    cubes = [(value * value - 1.0 / 3.0) * slope**3 for value, slope in zip(cells.tolist(), slopes, strict=True)]
    assert angles._ARCTANGENTS[:, 3].tolist() == cubes


def test_heights_of_radial_basis_functions_are_what_the_c_library_calculates() -> None:
    found = rbf([1.0], [8.0], tilings=4, sigma=0.25, cutoff=0.9)
    heights = {float(height) for height in found.table.ravel()}
    centres, n = range(-3, 5), found.table.shape[0] - 1  # the last row is no place
    expected = {
        math.exp(-((abs(centre - k / n) / 4) ** 2) / (2.0 * 0.25**2)) if abs(centre - k / n) / 4 < 0.9 else 0.0
        for centre in centres
        for k in range(n)
    }
    assert heights - {0.0} <= expected
