"""Records that come from a file are checked, field by field, before compiled code indexes with them or counts to them.

Kernels have no checks of their own: a wrong index writes over memory, a wrong count never ends. So every record that is
read has a table that gives each of its fields the least and the greatest value, or says that it is always as in a
record made anew. A field without an entry is a mistake of ours and refuses everything.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Bounds = Mapping[str, tuple[float, float] | None]
"""Field to (least, greatest), or to `SAME`."""
SAME = None
"""The field never changes: its value is that of a fresh record."""
FLAG = (0.0, 1.0)


class BoundsError(ValueError):
    """A number is not one that can be there; the message names record, field, number and bounds."""


def check_records(name: str, found: NDArray[np.void], fresh: NDArray[np.void], bounds: Bounds) -> None:
    """Check records that were read.

    Parameters
    ----------
    name : str
        Of the records, for the message.
    found, fresh : structured arrays of one type and shape
        What was read, and the same made anew.
    bounds : Bounds

    Raises
    ------
    BoundsError
    """
    for field in found.dtype.names or ():
        limits = bounds[field]
        if limits is SAME:
            if not np.array_equal(found[field], fresh[field]):
                raise BoundsError(f"{name}: {field!r} is not that of these settings")
        else:
            check_values(f"{name}: {field!r}", found[field], *limits)


def check_values(name: str, values: NDArray, low: float, high: float) -> None:
    """Check that all values lie within bounds; nan never does.

    Raises
    ------
    BoundsError
    """
    wrong = ~((values >= low) & (values <= high))
    if wrong.any():
        raise BoundsError(f"{name} is {values[wrong].flat[0]}; it must be {low:.10g} to {high:.10g}")


def check_streams(name: str, streams: NDArray[np.uint64]) -> None:
    """Check the states of random streams, shape (..., 4): the generator never leaves the state of four zeros.

    Raises
    ------
    BoundsError
    """
    if not streams.any(axis=-1).all():
        raise BoundsError(f"{name}: a random stream of zeros draws nothing but zeros")
