"""The state of a simulated match in one piece, as kernels hand it on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class World(NamedTuple):
    """A match and what decides how it goes on.

    Attributes
    ----------
    match : MATCH, shape (1,)
        See `rcss_hat.simulation.state`.
    params : PARAMS, shape (1,)
        Server parameters.
    types : PLAYER_TYPE, shape (n_types,)
    streams : ndarray of uint64, shape (n_streams, 4)
        Random streams by what they are for.
    """

    match: NDArray[np.void]
    params: NDArray[np.void]
    types: NDArray[np.void]
    streams: NDArray[np.uint64]
