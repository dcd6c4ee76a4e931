"""Q-values of learned policies, for display."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rcss_hat.hat.brains import LEARNED
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.learning.sarsa import Learner, observe
from rcss_hat.viewer.narrator import Values


def values_of(policy: TeamPolicy) -> Values | None:
    """Return what tells the Q-values of a team's keepers, in cycles to come; None for a policy without any."""
    brains = policy.brains
    if brains.kind != LEARNED:
        return None
    actions = policy.keepers

    def values(keeper: int, state: Sequence[float]) -> Sequence[float] | None:
        if not 1 <= keeper <= len(brains.weights):
            return None
        # On a copy of the learner's record: looking must not change what it remembers.
        k = keeper - 1
        own = brains.records[k : k + 1].copy(), brains.streams[k], brains.features, brains.table
        learner = Learner(*own, brains.weights[k], brains.traces[k])
        observe(learner, np.asarray(state, dtype=np.float64))
        return [float(q) for q in learner.record["q"][0, :actions]]

    return values
