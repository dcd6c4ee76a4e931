"""What the places at which a server puts players tell: a number, and how many keepers the server counts.

Whoever joins is put beside the pitch, by side and number. When an episode begins, the first three of the keepers that
the server has counted stand in a corner each, further ones in the middle; if it has counted too few, two share one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway import agent as kernels
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import HEARD, LEFT, MAX_PLAYERS, SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body

BENCH_Y, BENCH_STEP = -37.0, 3.0
"""A player who joins stands at (-3 UNUM, -37) m when its team is the left one, at (3 UNUM, -37) m on the right."""
TOLERANCE = 1.0
"""Metres by which the place that a player sees itself at may differ."""
CORNER = 3.0
"""Keepers are put within so many metres of both borders of their corner (19.0.0, src/referee.cpp, resetField)."""
BLUR = 1.5
"""Metres by which the place of another player may differ, with a cycle's run."""
_ROOMY = 6.0
"""Half of a side (m) from which on corners and middle are apart."""


class Whereabouts:
    """Finds a player's uniform number by its first sense_body and see messages.

    Parameters
    ----------
    team : str
    """

    def __init__(self, team: str) -> None:
        self._team = team.encode()
        self._sense, self._see, self._heard = empty(SENSE_BODY), empty(SEE), empty(HEARD)
        self._heard["time"][0] = -1
        self._has_sense = self._has_see = False

    def unum(self, data: bytes) -> int | None:
        """Take a datagram; returns the number as soon as it is certain.

        Raises
        ------
        RemoteProtocolError
            When the datagram is malformed.
        """
        if data.startswith(b"(sense_body "):
            parse_sense_body(data, self._sense)
            self._has_sense = True
        elif data.startswith(b"(see "):
            parse_see(data, self._team, self._see)
            self._has_see = True
        if not (self._has_sense and self._has_see):
            return None
        self._has_see = False
        return self._look()

    def _look(self) -> int | None:
        params = ServerParams().record()
        agent = kernels.new_agent(LEFT, 1, 1, 1, params, 0)  # a left player's axes are the server's
        kernels.perceive(agent, params, self._sense, self._see, True, self._heard, True)
        x, y = (float(v) for v in agent["pos"][0])
        unum = round(abs(x) / BENCH_STEP)
        off = float(np.hypot(abs(x) - BENCH_STEP * unum, y - BENCH_Y))
        return unum if off < TOLERANCE and 1 <= unum <= MAX_PLAYERS else None


def shares_corner(agent: NDArray[np.void], sides: tuple[float, float]) -> int | None:
    """Find another keeper in one's own corner; to be asked with the first see of an episode.

    Parameters
    ----------
    agent : AGENT, shape (1,)
        A keeper, who has taken in the see.
    sides : (float, float)
        Length and width of the region (m).

    Returns
    -------
    int or None
        The uniform number of one who was seen there; None when each has a corner of his own, or nobody was seen.
    """
    half = 0.5 * np.asarray(sides)
    if half.min() < _ROOMY:
        return None
    me, seen = int(agent["me"][0]), agent["player_seen"][0] == agent["see_time"][0]
    own, others = agent["pos"][0], agent["player_pos"][0]
    near, far = half - CORNER - BLUR, half + BLUR
    if not ((near <= np.abs(own)) & (np.abs(own) <= far)).all():
        return None
    there = ((near <= np.abs(others)) & (np.abs(others) <= far) & (np.sign(others) == np.sign(own))).all(axis=1)
    return next((o + 1 for o in range(int(agent["n_keepers"][0])) if o != me and seen[o] and there[o]), None)
