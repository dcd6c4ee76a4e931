"""Policies of the takers in Python, as people name them, ready for UDP and for the arena."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.foreign import Policy, is_object, object_policy
from rcss_hat.keepaway.decision import Decide, DecisionTimes, EpisodeEnd, PolicyError, PolicyFailed, legal_action
from rcss_hat.keepaway.taker import n_macro_actions
from rcss_hat.keepaway.task import Task

HAND = "hand"


class TakerPolicy:
    """The policy of a team of takers, which decide on macro-actions in every cycle.

    Parameters
    ----------
    spec : str
        As people name it.
    function : callable
        (state variables of a taker, info) -> macro-action; see `rcss_hat.keepaway.taker_state` and
        `rcss_hat.keepaway.taker`. ``info`` holds ``cycle`` and ``taker`` (from 1).
    keepers : int
        Of the task.

    Attributes
    ----------
    times : DecisionTimes
        What the function took over UDP.
    """

    def __init__(self, spec: str, function: Policy, keepers: int) -> None:
        self.spec, self.function, self.actions = spec, function, n_macro_actions(keepers)
        self.times = DecisionTimes()

    def order(self, state: NDArray[np.float64], cycle: int, taker: int) -> int:
        """Return what a taker (from 0) does.

        Raises
        ------
        PolicyFailed
            When the function does not answer with a macro-action.
        """
        info: dict[str, Any] = {"cycle": cycle, "taker": taker + 1}
        answer = self.function(state.copy(), info)
        try:
            return legal_action(answer, self.actions)
        except PolicyFailed as error:
            wrong = str(error).split(";")[0]
            raise PolicyFailed(
                f"{wrong}; legal are a taker's 0 (hand-coded), 1 (go to the ball) to {self.actions - 1} (block one)"
            ) from error

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        """Return the policy of one taker (from 0) for `rcss_hat.keepaway.session.KeepawayPlayer`."""

        def decide(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            begun = time.monotonic()
            order = self.order(state, cycle, number)
            self.times.seconds.append(time.monotonic() - begun)
            return order

        return decide, None


def load_taker_policy(spec: str, task: Task, seed: int) -> TakerPolicy | None:
    """Make a policy of takers from its name; None for the hand-coded one.

    Parameters
    ----------
    spec : str
        ``hand``, or ``module:object`` as for keepers, but for objects with ``predict``.
    task : Task
    seed : int

    Raises
    ------
    PolicyError
        Saying what would be right.
    """
    if spec == HAND:
        return None
    if not is_object(spec):
        raise PolicyError(
            f"{spec!r} is no policy of takers; there is {HAND}, and functions of (state, info): module:object"
        )
    return TakerPolicy(spec, object_policy(spec, task, seed, models=False), task.keepers)
