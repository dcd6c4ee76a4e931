"""``server::auto_mode``: kick off and end without a person (19.0.0, src/stadium.cpp, checkAutoMode)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.params import ServerParams
from rcss_hat.simulation.state import BEFORE_KICK_OFF, N_PLAYERS, TIME_OVER


class AutoMode:
    """The waits of an automatic match, counted in steps.

    Parameters
    ----------
    params : ServerParams
    match : ndarray of MATCH, shape (1,)
    """

    def __init__(self, params: ServerParams, match: NDArray[np.void]) -> None:
        self._params, self._match = params, match
        self._on = bool(params["auto_mode"])
        self._connect = self._kick_off = self._game_over = 0
        self._wind_up()

    def _wind_up(self) -> None:
        self._connect, self._kick_off = self._wait("connect_wait"), self._wait("kick_off_wait")

    def _wait(self, name: str) -> int:
        return max(0, int(self._params.number(name)))

    def kick_off_due(self) -> bool:
        """Count a step; returns whether it is time to kick off."""
        if not self._on:
            return False
        if self._match["mode"][0] != BEFORE_KICK_OFF:
            self._wind_up()
            return False
        if self._match["n_players"][0] == N_PLAYERS or self._match["time"][0] > 0:
            self._kick_off -= 1
        else:
            self._connect -= 1
        return self._kick_off <= 0 or self._connect <= 0

    def is_over(self) -> bool:
        """Count a step; returns whether the match has been over for long enough."""
        if not self._on:
            return False
        if self._match["mode"][0] != TIME_OVER:
            self._game_over = self._wait("game_over_wait")
            return False
        self._game_over -= 1
        return self._game_over <= 0
