"""The 55 landmarks in the order of the see message (19.0.0 and 11.1.2, src/landmarkreader)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PITCH_LENGTH = 105.0
PITCH_WIDTH = 68.0
PITCH_MARGIN = 5.0


def _all() -> dict[str, tuple[float, float]]:
    marks: dict[str, tuple[float, float]] = {
        "f c": (0.0, 0.0), "f c t": (0, -34), "f c b": (0, 34),
        "f r t": (52.5, -34), "f r b": (52.5, 34), "f l t": (-52.5, -34), "f l b": (-52.5, 34),
        "f g r b": (52.5, 7.01), "g r": (52.5, 0), "f g r t": (52.5, -7.01),
        "f g l b": (-52.5, 7.01), "g l": (-52.5, 0), "f g l t": (-52.5, -7.01),
        "f p r b": (36, 20.16), "f p r c": (36, 0), "f p r t": (36, -20.16),
        "f p l b": (-36, 20.16), "f p l c": (-36, 0), "f p l t": (-36, -20.16),
    }  # fmt: skip
    for name, edge in (("t", -39.0), ("b", 39.0)):
        marks[f"f {name} 0"] = (0.0, edge)
        for side, sign in (("r", 1), ("l", -1)):
            for x in (10, 20, 30, 40, 50):
                marks[f"f {name} {side} {x}"] = (sign * x, edge)
    for name, edge in (("r", 57.5), ("l", -57.5)):
        marks[f"f {name} 0"] = (edge, 0.0)
        for side, sign in (("t", -1), ("b", 1)):
            for y in (10, 20, 30):
                marks[f"f {name} {side} {y}"] = (edge, sign * y)
    return marks


LANDMARKS: dict[str, tuple[float, float]] = _all()
"""Name, as in the see message, to position (m); insertion order is message order."""
LANDMARK_NAMES: tuple[str, ...] = tuple(LANDMARKS)
LANDMARK_POSITIONS: NDArray[np.float64] = np.array(list(LANDMARKS.values()), dtype=np.float64)
"""Shape (55, 2), metres; row i is the landmark with see code i."""
N_LANDMARKS = len(LANDMARKS)
LINE_NAMES: tuple[str, ...] = ("l l", "l r", "l t", "l b")
"""Lines in the order the server checks and reports them."""
