"""Policies of the keepers as people name them, ready for UDP and for the arena."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.brains import HOLD, KIND_NAMES, LEARNED, RULES, Brains, choose, finish, fixed_brains, learned_brains
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.keepaway.agent import FIRST
from rcss_hat.keepaway.decision import Decide, EpisodeEnd
from rcss_hat.keepaway.state import n_state_variables

FIXED = tuple(KIND_NAMES)


class PolicyError(ValueError):
    """A policy that cannot be had, and what could."""


class TeamPolicy:
    """The policy of a team of keepers.

    Parameters
    ----------
    spec : str
        As people name it.
    brains : Brains
    keepers, takers : int
    hold_cycles : int
        Cycles from a Hold to the next decision.
    """

    def __init__(self, spec: str, brains: Brains, keepers: int, takers: int, hold_cycles: int = 1) -> None:
        self.spec, self.brains, self.keepers, self.takers = spec, brains, keepers, takers
        self.hold_cycles = hold_cycles

    def warm_up(self) -> None:
        """Compile, or load from the cache, what deciding needs; this policy's own records stay as they are."""
        state = np.zeros(n_state_variables(self.keepers, self.takers))
        idle = TeamPolicy("hold", fixed_brains(HOLD, self.keepers, 0), self.keepers, self.takers)
        decide, _ = idle(0)
        decide(0, FIRST, 0.0, state)
        b = idle.brains
        finish(HOLD, b.features, b.table, b.weights[0], b.traces[0], b.learners[:1], 0.0)

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        """Return the policy of one keeper (from 0) for `rcss_hat.keepaway.session.KeepawayPlayer`."""
        b, n, m, k = self.brains, self.keepers, self.takers, number
        learner = b.learners[k : k + 1]

        def decide(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            return int(
                choose(
                    b.kind, n, m, b.rules, b.has_rules, b.features, b.table, b.weights[k], b.traces[k], learner,
                    b.method, b.streams[k], status == FIRST, reward, state,
                )
            )  # fmt: skip

        def ended(cycle: int, acted: bool, reward: float) -> None:
            finish(b.kind, b.features, b.table, b.weights[k], b.traces[k], learner, reward)

        return decide, ended if b.kind == LEARNED else None


def rules_policy(rules: DecisionList, seed: int, spec: str = "rules") -> TeamPolicy:
    """Let a decision list play."""
    brains = fixed_brains(RULES, rules.keepers, seed, rules.to_arrays())
    return TeamPolicy(spec, brains, rules.keepers, rules.takers)


def load_policy(spec: str, keepers: int, takers: int, seed: int) -> TeamPolicy:
    """Make a policy from its name or file.

    Parameters
    ----------
    spec : str
        ``hold``, ``random``, ``hand``, the file of a decision list, or the folder of a training run.
    keepers, takers : int
        The task it must fit.
    seed : int
        Of the policy's own randomness.

    Raises
    ------
    PolicyError
        Saying what would be right.
    """
    if spec in KIND_NAMES:
        return TeamPolicy(spec, fixed_brains(KIND_NAMES[spec], keepers, seed), keepers, takers)
    path = Path(spec)
    if path.is_dir():
        return _trained(path, keepers, takers)
    if not path.exists():
        raise PolicyError(f"{spec!r} is none of {', '.join(FIXED)}, and there is no such decision list or training run")
    try:
        rules = DecisionList.load(path, keepers, takers)
    except ValueError as error:
        raise PolicyError(str(error)) from error
    if (rules.keepers, rules.takers) != (keepers, takers):
        raise PolicyError(
            f"{path} is a decision list for {rules.keepers}v{rules.takers}; the task is {keepers}v{takers}"
        )
    return rules_policy(rules, seed, spec)


RUN_WEIGHTS, RUN_RULES = "learners.npz", "rules.json"
"""Files in the folder of a training run."""


def learners_policy(learners: Learners, rules: DecisionList | None, spec: str = "learned") -> TeamPolicy:
    """Let learners play; they go on learning unless switched off (`Learners.set_mode`)."""
    brains = learned_brains(learners, rules.to_arrays() if rules is not None else None)
    return TeamPolicy(spec, brains, learners.n_keepers, learners.n_takers, learners.config.hold_cycles)


def _trained(folder: Path, keepers: int, takers: int) -> TeamPolicy:
    weights, rules = folder / RUN_WEIGHTS, folder / RUN_RULES
    if not weights.exists():
        raise PolicyError(f"{folder} is not the folder of a training run: it has no {RUN_WEIGHTS}")
    try:
        learners = Learners.load(weights)
        advice = DecisionList.load(rules) if rules.exists() else None
    except ValueError as error:
        raise PolicyError(str(error)) from error
    if (learners.n_keepers, learners.n_takers) != (keepers, takers):
        raise PolicyError(f"{folder} learned {learners.n_keepers}v{learners.n_takers}; the task is {keepers}v{takers}")
    learners.set_mode(learning=False, exploring=False)
    return learners_policy(learners, advice, str(folder))
