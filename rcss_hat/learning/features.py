"""Linear features of one state variable at a time: CMAC tiles and Gaussian radial basis functions (RBF).

Both share one layout, so that one compiled learner serves both. T tilings of width w, each shifted by w / T against
the one before, have the tile edges c w / T, c = 0, 1, 2, ...: number the tile that begins at c w / T with c, whatever
tiling it belongs to. Then the tiles that hold x are T *neighbours*, c = q - T + 1 .. q with q = floor(T x / w), one of
every tiling. The RBF puts a Gaussian of x / w on every c w / T instead of a tile; those that are not cut off are
neighbours again. So the active features of a variable are always a run of ``active`` weights that begins somewhere
("start"), with values that depend only on where x lies between two neighbouring edges ("row" of a table of values;
a single row of ones for the CMAC). Inner loops run over contiguous memory, and no exponential is computed in play.

A weight matrix has shape (actions, n_features): for every action, the runs of variable 0, 1, 2, ... one after another.

Sources: UT Austin players 0.6 (LinearSarsaAgent.cc and tiles2, 32 tilings); Taylor, Suay and Chernova (2011) for the
use of RBFs, whose sigma of 0.25 tile widths is that of Taylor, Stone and Liu (2007).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.numeric.jit import kernel

MAX_VARIABLES = 64
"""Room for 11 v 11 (63 variables)."""

PLACES = 2048
"""Distinguishable places within one tile width of an RBF: x is rounded to w / 2048 (about 1 mm)."""

FEATURES = np.dtype(
    [
        ("n_variables", "i4"),
        ("n_features", "i4"),  # weights of one action
        ("active", "i4"),  # length of the run of active features of a variable
        ("shift", "i4"),  # 2**shift rows in the table of values
        ("resolution", "f8"),  # cells in one tile width
        ("offset", "f8"),  # 0.5: x goes to the nearest cell, 0: to the cell below
        ("width", "f8", (MAX_VARIABLES,)),  # tile widths, m or degrees
        ("last", "i4", (MAX_VARIABLES,)),  # greatest cell
        ("first", "i4", (MAX_VARIABLES,)),  # where the run of cell 0 starts
    ]
)
"""Where the features of each state variable lie."""


@kernel
def locate(features: NDArray[np.void], variable: int, x: float) -> tuple[int, int]:
    """Find the active features of one state variable.

    Parameters
    ----------
    features : FEATURES, shape (1,)
    variable : int
        From 0.
    x : float
        Its value; values outside the range are taken for the nearer end.

    Returns
    -------
    start : int
        First active feature; ``active`` of them follow each other.
    row : int
        Row of the table that holds their values.
    """
    place = np.floor(x * features["resolution"][0] / features["width"][0, variable] + features["offset"][0])
    cell = int(min(max(place, 0.0), float(features["last"][0, variable])))
    shift = int(features["shift"][0])
    return int(features["first"][0, variable]) + (cell >> shift), cell & ((1 << shift) - 1)


@kernel
def weighted_sum(
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    start: NDArray[np.int32],
    row: NDArray[np.int32],
    n_variables: int,
) -> float:
    """Sum weight times value over all active features.

    Parameters
    ----------
    table : ndarray of float64, shape (rows + 1, active)
        The last row is working space and is overwritten.
    weights : ndarray of float64, shape (n_features,)
        Of one action.
    start, row : ndarray of int32, shape (MAX_VARIABLES,)
        From `locate`, for every variable.
    n_variables : int

    Notes
    -----
    Variables are added up position by position, four at a time: that fixes the order of additions and still lets the
    compiler use vector instructions, which it may not do for one running sum.
    """
    active = table.shape[1]
    sums = table[table.shape[0] - 1]
    for i in range(active):
        sums[i] = 0.0
    v = 0
    while v + 4 <= n_variables:
        w0, w1 = weights[start[v] : start[v] + active], weights[start[v + 1] : start[v + 1] + active]
        w2, w3 = weights[start[v + 2] : start[v + 2] + active], weights[start[v + 3] : start[v + 3] + active]
        x0, x1, x2, x3 = table[row[v]], table[row[v + 1]], table[row[v + 2]], table[row[v + 3]]
        for i in range(active):
            sums[i] += (w0[i] * x0[i] + w1[i] * x1[i]) + (w2[i] * x2[i] + w3[i] * x3[i])
        v += 4
    while v < n_variables:
        w0, x0 = weights[start[v] : start[v] + active], table[row[v]]
        for i in range(active):
            sums[i] += w0[i] * x0[i]
        v += 1
    total = 0.0
    for i in range(active):
        total += sums[i]
    return total


@kernel
def add_features(
    table: NDArray[np.float64],
    weights: NDArray[np.float64],
    start: NDArray[np.int32],
    row: NDArray[np.int32],
    n_variables: int,
    amount: float,
) -> None:
    """Add ``amount`` times its value to the weight of every active feature; arguments as in `weighted_sum`."""
    active = table.shape[1]
    for v in range(n_variables):
        run = weights[start[v] : start[v] + active]
        values = table[row[v]]
        for i in range(active):
            run[i] += amount * values[i]


@dataclass(frozen=True, eq=False)
class Approximator:
    """A linear approximator: its features, ready for the kernels.

    Attributes
    ----------
    record : FEATURES, shape (1,)
    table : ndarray of float64, shape (rows + 1, active)
        Values of a run of active features, by row; the last row is working space of the kernels.
    tilings : int
        Features in one tile width.
    lowest : int
        The run of cell 0 begins with the feature that sits at ``lowest * width / tilings``.
    """

    record: NDArray[np.void]
    table: NDArray[np.float64]
    tilings: int
    lowest: int

    @property
    def n_variables(self) -> int:
        """State variables."""
        return int(self.record["n_variables"][0])

    @property
    def n_features(self) -> int:
        """Weights of one action."""
        return int(self.record["n_features"][0])

    @property
    def n_tiles(self) -> int:
        """Tilings times variables: the players' N, by which their step size is divided."""
        return self.tilings * self.n_variables

    @property
    def norm(self) -> float:
        """Mean over all places of the sum of squared feature values of one action."""
        return self.n_variables * float((self.table[:-1] ** 2).sum(axis=1).mean())

    @property
    def sum(self) -> float:
        """Mean over all places of the sum of feature values of one action."""
        return self.n_variables * float(self.table[:-1].sum(axis=1).mean())

    def active_features(self, state: ArrayLike) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """List the active features of a state, for looking at them (play does not use this).

        Parameters
        ----------
        state : array_like, shape (n_variables,)

        Returns
        -------
        indices : ndarray of int, shape (n_variables, active)
            Columns of the weight matrix.
        values : ndarray of float64, shape (n_variables, active)

        Raises
        ------
        ValueError
            When the state has another shape.
        """
        numbers = self.check_state(state)
        places = [locate(self.record, v, float(x)) for v, x in enumerate(numbers)]
        run = np.arange(self.table.shape[1])
        indices = np.array([start + run for start, _ in places])
        return indices, np.array([self.table[row] for _, row in places])

    def check_state(self, state: ArrayLike) -> NDArray[np.float64]:
        """Return a state as the kernels take it.

        Raises
        ------
        ValueError
            When its shape is not (n_variables,) or a number is not finite.
        """
        numbers = np.ascontiguousarray(state, dtype=np.float64)
        if numbers.shape != (self.n_variables,):
            raise ValueError(f"a state has shape ({self.n_variables},), not {numbers.shape}")
        if not np.isfinite(numbers).all():
            raise ValueError(f"a state holds finite numbers only, not {numbers.tolist()}")
        return numbers


def cmac(widths: ArrayLike, maxima: ArrayLike, tilings: int = 32) -> Approximator:
    """Make a CMAC: ``tilings`` one-dimensional tilings of each state variable, no conjunctions.

    Parameters
    ----------
    widths : array_like, shape (n_variables,)
        Tile widths, in units of the variables.
    maxima : array_like, shape (n_variables,)
        Upper ends of the ranges, which begin at 0.
    tilings : int

    Raises
    ------
    ValueError
        For widths or ranges that are not positive, or more than 64 variables.
    """
    _check_tilings(tilings)
    return _lay_out(widths, maxima, tilings, shift=0, offset=0.0, lowest=1 - tilings, table=np.ones((1, tilings)))


def rbf(
    widths: ArrayLike,
    maxima: ArrayLike,
    tilings: int = 32,
    sigma: float = 0.25,
    cutoff: float = 0.75,
    normalise: bool = False,
) -> Approximator:
    """Make one-dimensional Gaussian radial basis functions of each state variable.

    Centres lie ``width / tilings`` apart; the value at x is ``exp(-d**2 / (2 sigma**2))`` with d the distance in tile
    widths, and 0 from ``cutoff`` on.

    Parameters
    ----------
    widths, maxima : array_like, shape (n_variables,)
        As in `cmac`.
    tilings : int
        Centres in one tile width: 32, or 1 for a single one per tile.
    sigma, cutoff : float
        In tile widths.
    normalise : bool
        Scale the values of each variable so that they sum to 1.

    Raises
    ------
    ValueError
        For numbers that are not positive, more than 64 variables, or a cutoff so small that between two centres no
        function is active.
    """
    _check_tilings(tilings)
    if not sigma > 0.0 or not math.isfinite(sigma):
        raise ValueError(f"sigma must be a positive number of tile widths, not {sigma}")
    if not cutoff * tilings > 0.5 or not math.isfinite(cutoff):
        raise ValueError(f"cutoff must be greater than half the distance of two centres (0.5 / tilings), not {cutoff}")
    shift = max(0, round(math.log2(PLACES / tilings)))
    reach = math.ceil(cutoff * tilings)
    centres = np.arange(1 - reach, reach + 1)
    fractions = np.arange(1 << shift)[:, None] / (1 << shift)
    distance = np.abs(centres[None, :] - fractions) / tilings
    # Not NumPy's exponential, whose last digit depends on the processor.
    heights = np.array([math.exp(value) for value in (-(distance**2) / (2.0 * sigma**2)).ravel()])
    table = np.where(distance < cutoff, heights.reshape(distance.shape), 0.0)
    if normalise:
        table /= table.sum(axis=1, keepdims=True)
    return _lay_out(widths, maxima, tilings, shift, offset=0.5, lowest=1 - reach, table=table)


def _check_tilings(tilings: int) -> None:
    if not 1 <= tilings <= 256:
        raise ValueError(f"tilings must be 1 to 256, not {tilings}")


def _lay_out(
    widths: ArrayLike,
    maxima: ArrayLike,
    tilings: int,
    shift: int,
    offset: float,
    lowest: int,
    table: NDArray[np.float64],
) -> Approximator:
    width = np.asarray(widths, dtype=np.float64)
    highest = np.asarray(maxima, dtype=np.float64)
    n = width.size
    if width.ndim != 1 or width.shape != highest.shape or not 1 <= n <= MAX_VARIABLES:
        raise ValueError(
            f"widths and maxima must be two lists of equal length, 1 to {MAX_VARIABLES}, "
            f"not of shapes {width.shape} and {highest.shape}"
        )
    for name, numbers in (("tile widths", width), ("ends of ranges", highest)):
        if not (np.isfinite(numbers).all() and (numbers > 0.0).all()):
            raise ValueError(f"{name} must be positive, not {numbers.tolist()}")
    resolution = float(tilings << shift)
    last = np.floor(highest * resolution / width + offset).astype(np.int64)
    slots = (last >> shift) + table.shape[1]
    record = np.zeros(1, dtype=FEATURES)
    record["n_variables"][0] = n
    record["n_features"][0] = slots.sum()
    record["active"][0] = table.shape[1]
    record["shift"][0] = shift
    record["resolution"][0] = resolution
    record["offset"][0] = offset
    record["width"][0, :n] = width
    record["last"][0, :n] = last
    record["first"][0, :n] = np.cumsum(slots) - slots
    with_space = np.vstack([table, np.zeros((1, table.shape[1]))])
    return Approximator(record, with_space, tilings, lowest)
