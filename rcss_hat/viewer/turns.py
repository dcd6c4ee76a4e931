"""A learner that plays while the person does not: they take turns."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.policy import TeamPolicy


class Companion:
    """Answers for the keepers by a policy; asked at every decision, also of the person's, so that it knows the game.

    Parameters
    ----------
    policy : TeamPolicy
        Should not be learning.

    Attributes
    ----------
    name : str
    """

    def __init__(self, policy: TeamPolicy) -> None:
        self.name = policy.spec
        self._decide = [policy(number)[0] for number in range(policy.keepers)]

    def answer(self, state: NDArray[np.float64], info: dict[str, Any]) -> int:
        """Decide; see `rcss_hat.hat.policy.Policy`."""
        decide = self._decide[info["keeper"] - 1]
        return int(decide(info["cycle"], info["status"], info["reward"], state))
