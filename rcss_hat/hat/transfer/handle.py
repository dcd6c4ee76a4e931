"""Learners as a compiled loop calls them: by addresses, so that it is compiled without them.

Most games are played by keepers that do not learn; these wait for no learner's kernels to be compiled. A call by its
address costs some 20 ns, a learner's decision some 1,000.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from rcss_hat.hat.rule_rows import RULE_ROW, deciding_row
from rcss_hat.hat.transfer.kernels import decide_first, decide_step, finish_episode
from rcss_hat.hat.transfer.method import METHOD, NO_ADVICE
from rcss_hat.learning.features import FEATURES
from rcss_hat.learning.sarsa import LEARNER, Learner
from rcss_hat.numeric.addresses import address_of, array_at
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.pointers import Slot

if TYPE_CHECKING:
    from rcss_hat.hat.transfer.learners import Learners

Numbers = NDArray[np.int64]
"""A handle: addresses of two kernels, sizes, addresses of arrays. It holds in this process only."""
_NUMBERS, _STATE = numba.typeof(np.zeros(1, dtype=np.int64)), numba.typeof(np.zeros(1))
_CHOOSE = Slot(types.int64, _NUMBERS, types.int64, types.boolean, types.float64, _STATE)
_FINISH = Slot(types.int64, _NUMBERS, types.int64, types.float64)
_choose_at, _finish_at = _CHOOSE.at, _FINISH.at
_F8, _U8 = np.dtype("f8"), np.dtype("u8")


@inlined
def _learner(h: Numbers, k: int) -> Learner:
    """Return keeper k (from 0) as the kernels of learning take it."""
    keepers, actions, n_features, with_traces = h[2], h[3], h[4], h[5]
    return Learner(
        array_at(h[11], (keepers,), LEARNER)[k : k + 1],
        array_at(h[12], (keepers, 4), _U8)[k],
        array_at(h[13], (1,), FEATURES),
        array_at(h[14], (h[6], h[7]), _F8),
        array_at(h[15], (keepers, actions, n_features), _F8)[k],
        array_at(h[16], (keepers, actions * with_traces, n_features * with_traces), _F8)[k],
    )


def _choose(h: Numbers, k: int, first: bool, reward: float, state: NDArray[np.float64]) -> int:
    advice, confidence = NO_ADVICE, 0.0
    if h[8]:
        rules = array_at(h[9], (h[8],), RULE_ROW)
        row = deciding_row(rules, state)
        advice, confidence = rules["action"][row], rules["confidence"][row]
    method = array_at(h[10], (1,), METHOD)
    if first:
        return decide_first(_learner(h, k), method, state, advice, confidence)
    return decide_step(_learner(h, k), method, reward, state, advice, confidence)


def _finish(h: Numbers, k: int, reward: float) -> int:
    finish_episode(_learner(h, k), reward)
    return 0


@kernel
def choose_learned(h: Numbers, k: int, first: bool, reward: float, state: NDArray[np.float64]) -> int:
    """Let keeper k (from 0) decide, and learn from the reward of its last decision; see `rcss_hat.hat.brains`."""
    chosen = _choose_at(h[0])
    return chosen(h, k, first, reward, state)


@kernel
def finish_learned(h: Numbers, k: int, reward: float) -> None:
    """Tell keeper k (from 0) that the episode is over, ``reward`` cycles after its last decision."""
    finish = _finish_at(h[1])
    finish(h, k, reward)


def handle_of(learners: Learners, rules: NDArray[np.void] | None = None) -> Numbers:
    """Return what kernels find learners by; they live as long as it, and learn where they are.

    Parameters
    ----------
    learners : Learners
    rules : ndarray of RULE_ROW, optional
        The advice D of their method.
    """
    approximator = learners.approximator
    arrays: tuple[NDArray[Any], ...] = (
        np.zeros(0, dtype=RULE_ROW) if rules is None else rules, learners.method_record, learners.records,
        learners.streams, approximator.record, approximator.table, learners.weights, learners.traces,
    )  # fmt: skip
    sizes = *learners.weights.shape, learners.traces.size > 0, *approximator.table.shape, len(arrays[0])
    kernels = _CHOOSE.address(_choose), _FINISH.address(_finish)
    numbers = np.array([*kernels, *sizes, *map(address_of, arrays)], dtype=np.int64)
    weakref.finalize(numbers, _let_go, arrays).atexit = False
    return numbers


def _let_go(arrays: tuple[NDArray[Any], ...]) -> None:
    """Do nothing: that somebody is to be told when a handle has gone keeps its arrays until then."""


NOBODY: Numbers = np.zeros(2, dtype=np.int64)
"""The handle of a team that does not learn; never called."""
