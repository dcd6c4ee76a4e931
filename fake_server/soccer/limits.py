"""What the referees here do not judge, said to whoever runs or watches a match that might need it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.params import ServerParams
from rcss_hat.simulation.state import BEFORE_KICK_OFF

NOT_JUDGED = "not judged here: offside, fouls, back passes, free kick faults, illegal defence"
NO_SHOOT_OUT = "drawn: the penalty shoot-out is not simulated here, the match ends"


class Limits:
    """Warnings of a match, each given once.

    Parameters
    ----------
    params : ServerParams
    match : ndarray of MATCH, shape (1,)
    """

    def __init__(self, params: ServerParams, match: NDArray[np.void]) -> None:
        self._params, self._match = params, match
        self._due = {NOT_JUDGED, NO_SHOOT_OUT}

    def missed(self, announced: list[str]) -> list[str]:
        """Return warnings of what a match that has just begun, or ended, misses."""
        if not self._due:
            return []
        match, warnings = self._match, []
        if match["time"][0] > 0 or match["mode"][0] != BEFORE_KICK_OFF:
            warnings.append(NOT_JUDGED)
        drawn = match["score"][0, 0] == match["score"][0, 1]
        if self._params["penalty_shoot_outs"] and drawn and "time_up" in announced:
            warnings.append(NO_SHOOT_OUT)
        due = [warning for warning in warnings if warning in self._due]
        self._due.difference_update(due)
        return due
