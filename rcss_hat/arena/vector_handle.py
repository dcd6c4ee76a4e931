"""The compiled loop of many matches, called by the addresses of its arrays; see `rcss_hat.arena.handle`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.records import CONTROL, DECISION, FRAME, ORDER
from rcss_hat.arena.vector_loop import play_rows
from rcss_hat.arena.vector_records import LANE, Batch, Part
from rcss_hat.hat.brains import EXTERNAL, Brains
from rcss_hat.hat.rule_rows import RULE_ROW
from rcss_hat.numeric.addresses import address_of, array_at
from rcss_hat.numeric.jit import inlined, releasing
from rcss_hat.player.records import AGENT
from rcss_hat.protocol.params import PARAMS
from rcss_hat.protocol.records import ACTION, HEARD, SEE, SENSE_BODY
from rcss_hat.simulation.player_types import PLAYER_TYPE
from rcss_hat.simulation.state import EPISODE, MATCH

Numbers = NDArray[np.int64]
_F8, _F4, _I8, _U8, _U1 = np.dtype("f8"), np.dtype("f4"), np.dtype("i8"), np.dtype("u8"), np.dtype("u1")


@inlined
def _batch(h: Numbers) -> Batch:
    n, players, variables = h[0], h[1], h[2]
    return Batch(
        array_at(h[9], (n,), MATCH), array_at(h[10], (1,), PARAMS), array_at(h[11], (h[4],), PLAYER_TYPE),
        array_at(h[12], (n, h[5], 4), _U8), array_at(h[13], (n, players), AGENT), array_at(h[14], (players,), _I8),
        array_at(h[15], (n, players), _U1), array_at(h[16], (n, 1), SENSE_BODY), array_at(h[17], (n, 1), HEARD),
        array_at(h[18], (n, players), SEE), array_at(h[19], (n, players), _U1), array_at(h[20], (n, h[6]), _U1),
        array_at(h[21], (h[7],), _U1), array_at(h[22], (n, players), ACTION), array_at(h[23], (n, players), ORDER),
        array_at(h[24], (n, h[3]), _F8), array_at(h[25], (1,), _U1), array_at(h[26], (n,), _I8),
        array_at(h[27], (n, variables), _F8), array_at(h[28], (n, variables), _F8), array_at(h[29], (variables,), _F8),
        array_at(h[30], (variables,), _F8), array_at(h[31], (n, variables), _F4), array_at(h[32], (n, variables), _F4),
        array_at(h[33], (n, 1), CONTROL), array_at(h[34], (n, 1), EPISODE), array_at(h[35], (h[8],), DECISION),
        array_at(h[36], (1,), FRAME), array_at(h[37], (n,), LANE),
    )  # fmt: skip


@inlined
def _brains(h: Numbers) -> Brains:
    keepers = h[8]
    rules, streams = array_at(h[38], (1,), RULE_ROW), array_at(h[39], (keepers, 4), _U8)
    return Brains(EXTERNAL, keepers, h[1] - keepers, rules, streams, array_at(h[40], (2,), _I8))


@releasing
def _play(h: Numbers, first: int, last: int, max_cycles: int, goes_on: bool) -> int:
    part = Part(first, last, max_cycles, goes_on)
    return play_rows(_batch(h), _brains(h), array_at(h[41], (h[0],), _I8), part)


class VectorHandle:
    """The loop of many matches, ready to go on; threads can call it side by side for different rows.

    Parameters
    ----------
    batch : Batch
    brains : Brains
        Of kind EXTERNAL.
    rows : ndarray of int64, shape (matches,)
        See `rcss_hat.arena.vector_loop.play_rows`.
    """

    def __init__(self, batch: Batch, brains: Brains, rows: NDArray[np.int64]) -> None:
        sizes = [
            *batch.agents.shape, batch.states.shape[1], batch.taker_states.shape[1], len(batch.types),
            batch.streams.shape[1], batch.due.shape[1], len(batch.landmarks), len(batch.decisions),
        ]  # fmt: skip
        arrays = [*batch, *brains[3:], rows]
        self._arrays = arrays
        self._numbers = np.array([*sizes, *map(address_of, arrays)], dtype=np.int64)

    def play(self, part: Part) -> int:
        """Let some matches do what they are doing; see `rcss_hat.arena.vector_loop.play_rows`."""
        return _play(self._numbers, *part)
