"""Playing a policy without learning, to see how good it is."""

from __future__ import annotations

import copy

from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.policy import TeamPolicy, learners_policy
from rcss_hat.hat.transfer import Learners
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric import rng
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Part, open_stage


def frozen_policy(
    learners: Learners, rules: DecisionList | None, seed: int, exploring: bool = False, spec: str = "learned"
) -> TeamPolicy:
    """Return the policy that learners have now, as a copy that does not learn.

    Parameters
    ----------
    learners : Learners
        Left as they are.
    rules : DecisionList, optional
        The advice D of their method.
    seed : int
        Of the copy's own randomness: ties, reuse of advice, and exploration if it is on.
    exploring : bool
        Whether epsilon applies.
    spec : str
        What reports call it.
    """
    frozen = copy.deepcopy(learners)
    frozen.set_mode(learning=False, exploring=exploring)
    for k in range(frozen.n_keepers):
        frozen.streams[k] = rng.stream(seed, rng.LEARNER, k)
    return learners_policy(frozen, rules, spec)


def evaluate(policy: TeamPolicy, task: Task, seed: int, episodes: int) -> RunReport:
    """Play a policy in the arena.

    Parameters
    ----------
    policy : TeamPolicy
        See `frozen_policy`.
    task : Task
    seed, episodes : int

    Returns
    -------
    RunReport
    """
    with open_stage(Place(ARENA), task, seed, policy) as stage:
        return stage.play(Part(episodes))
