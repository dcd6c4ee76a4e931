"""Q-values of learned policies, for display."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.learning.sarsa import observe
from rcss_hat.viewer.narrator import Values


def values_of(policy: TeamPolicy) -> Values | None:
    """Return what tells the Q-values of a team's keepers, in cycles to come; None for a policy without any."""
    learners = policy.learners
    if learners is None:
        return None
    actions = policy.keepers

    def values(keeper: int, state: Sequence[float]) -> Sequence[float] | None:
        if not 1 <= keeper <= learners.n_keepers:
            return None
        own = learners.learner(keeper - 1)
        learner = own._replace(record=own.record.copy())  # looking must not change what it remembers
        observe(learner, np.asarray(state, dtype=np.float64))
        return [float(q) for q in learner.record["q"][0, :actions]]

    return values
