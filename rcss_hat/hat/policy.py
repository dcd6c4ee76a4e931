"""Policies of the keepers as people name them, ready for UDP and for the arena."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.brains import (
    EXTERNAL,
    HOLD,
    KIND_NAMES,
    LEARNED,
    RULES,
    Brains,
    choose,
    finish,
    fixed_brains,
    learned_brains,
)
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.foreign import Policy as Policy
from rcss_hat.hat.foreign import foreign_policy, guarded, is_foreign
from rcss_hat.hat.registry import Registry
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.agent import FIRST
from rcss_hat.keepaway.decision import Decide, DecisionTimes, EpisodeEnd, OnFrame, Onlooker, legal_action
from rcss_hat.keepaway.decision import PolicyError as PolicyError
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.keepaway.task import Task
from rcss_hat.schema import did_you_mean

FIXED = tuple(KIND_NAMES)


POLICIES = Registry("policy", "rcss_hat.policies", {})
"""Policies of other packages: functions (keepers, takers, seed) that return a `Policy`."""


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
    function : callable, optional
        A policy in Python that decides instead of the brains.
    on_frame : callable, optional
        Told what there is to see in every cycle, before the function is asked in it: by a stage that shows its whole
        field, others refuse such a policy.

    Attributes
    ----------
    times : DecisionTimes
        What the function took over UDP; not counted in the arena, which waits.
    onlooker : Onlooker or None
        Who looks over the players' shoulders, where they play over UDP.
    learners : Learners or None
        Who decides, where they learn or have learned.
    """

    onlooker: Onlooker | None = None
    learners: Learners | None = None

    def __init__(
        self,
        spec: str,
        brains: Brains,
        keepers: int,
        takers: int,
        hold_cycles: int = 1,
        function: Policy | None = None,
        on_frame: OnFrame | None = None,
    ) -> None:
        self.spec, self.brains, self.keepers, self.takers = spec, brains, keepers, takers
        self.hold_cycles, self.function, self.on_frame = hold_cycles, function, on_frame
        self.times = DecisionTimes()

    def __getstate__(self) -> object:
        """Return what is copied or pickled.

        Raises
        ------
        TypeError
            For learners: their brains hold addresses, which a copy does not keep alive, nor another process has.
        """
        if self.learners is not None:
            raise TypeError("a policy of learners cannot be copied or pickled; copy or save its learners instead")
        return super().__getstate__()

    def warm_up(self) -> None:
        """Compile, or load from the cache, what deciding needs; this policy's own records stay as they are."""
        state = np.zeros(n_state_variables(self.keepers, self.takers))
        idle = fixed_brains(HOLD, self.keepers, self.takers, 0)
        choose(idle, 0, True, 0.0, state)
        finish(idle, 0, 0.0)

    def __call__(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        """Return the policy of one keeper (from 0) for `rcss_hat.keepaway.session.KeepawayPlayer`."""
        brains = self.brains
        if self.function is not None:
            return _asking(self.function, number, self.keepers, self.times)

        def decide(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
            return int(choose(brains, number, status == FIRST, reward, state))

        def ended(cycle: int, acted: bool, reward: float) -> None:
            finish(brains, number, reward)

        return decide, ended if brains.kind == LEARNED else None


def _asking(function: Policy, number: int, keepers: int, times: DecisionTimes) -> tuple[Decide, EpisodeEnd]:
    """Return a keeper's policy that asks a function in Python."""
    episode = 1

    def decide(cycle: int, status: int, reward: float, state: NDArray[np.float64]) -> int:
        info = {"episode": episode, "cycle": cycle, "keeper": number + 1, "status": status, "reward": reward}
        begun = time.monotonic()
        answer = function(state.copy(), info)
        times.seconds.append(time.monotonic() - begun)
        return legal_action(answer, keepers)

    def ended(cycle: int, acted: bool, reward: float) -> None:
        nonlocal episode
        episode += 1

    return decide, ended


def python_policy(
    function: Policy, keepers: int, takers: int, spec: str = "python", on_frame: OnFrame | None = None
) -> TeamPolicy:
    """Let a function in Python play; see `TeamPolicy`."""
    brains = fixed_brains(EXTERNAL, keepers, takers, 0)
    return TeamPolicy(spec, brains, keepers, takers, function=function, on_frame=on_frame)


def rules_policy(rules: DecisionList, seed: int, spec: str = "rules") -> TeamPolicy:
    """Let a decision list play."""
    brains = fixed_brains(RULES, rules.keepers, rules.takers, seed, rules.to_arrays())
    return TeamPolicy(spec, brains, rules.keepers, rules.takers)


def load_policy(spec: str, keepers: int, takers: int, seed: int, task: Task | None = None) -> TeamPolicy:
    """Make a policy from its name or file.

    Parameters
    ----------
    spec : str
        ``hold``, ``random``, ``hand``, the name of another package's policy, the file of a decision list, the folder
        of a training run, or what `rcss_hat.hat.foreign` knows: ``module:object``, ``model.zip``, ``model.joblib``.
    keepers, takers : int
        The task it must fit.
    seed : int
        Of the policy's own randomness.
    task : Task, optional
        For policies in Python that ask for it.  [default: the usual one of that size]

    Raises
    ------
    PolicyError
        Saying what would be right.

    Examples
    --------
    >>> from rcss_hat import load_policy
    >>> load_policy("hand", keepers=3, takers=2, seed=1).spec
    'hand'
    >>> load_policy("hnad", keepers=3, takers=2, seed=1)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    rcss_hat.keepaway.decision.PolicyError: 'hnad' is none of hold, random, hand, ...; did you mean 'hand'?
    """
    if spec in KIND_NAMES:
        return TeamPolicy(spec, fixed_brains(KIND_NAMES[spec], keepers, takers, seed), keepers, takers)
    if spec in POLICIES:
        return _registered(spec, keepers, takers, seed)
    if is_foreign(spec):
        task = task or Task.parse(f"{keepers}v{takers}")
        return python_policy(foreign_policy(spec, task, seed), keepers, takers, spec)
    path = Path(spec)
    if path.is_dir():
        return _trained(path, keepers, takers)
    if not path.exists():
        raise PolicyError(
            f"{spec!r} is none of {', '.join([*FIXED, *POLICIES])}, and there is no such decision list or training run "
            f"(policies in Python are written module:object){did_you_mean(spec, [*FIXED, *POLICIES])}"
        )
    try:
        rules = DecisionList.load(path, keepers, takers)
    except ValueError as error:
        raise PolicyError(str(error)) from error
    if (rules.keepers, rules.takers) != (keepers, takers):
        raise PolicyError(
            f"{path} is a decision list for {rules.keepers}v{rules.takers}; the task is {keepers}v{takers}"
        )
    return rules_policy(rules, seed, spec)


def _registered(name: str, keepers: int, takers: int, seed: int) -> TeamPolicy:
    try:
        function = POLICIES[name](keepers, takers, seed)
    except Exception as error:  # whatever a stranger's function does
        raise PolicyError(f"the policy {name!r} cannot be had for {keepers}v{takers}: {error}") from error
    if not callable(function):
        raise PolicyError(f"the policy {name!r} is {function!r}, no function of (state, info)")
    return python_policy(guarded(function, name), keepers, takers, name)


RUN_WEIGHTS, RUN_RULES = "learners.npz", "rules.json"
"""Files in the folder of a training run."""


def learners_policy(learners: Learners, rules: DecisionList | None, spec: str = "learned") -> TeamPolicy:
    """Let learners play; they go on learning unless switched off (`Learners.set_mode`)."""
    brains = learned_brains(learners, rules.to_arrays() if rules is not None else None)
    policy = TeamPolicy(spec, brains, learners.n_keepers, learners.n_takers, learners.config.hold_cycles)
    policy.learners = learners
    return policy


def run_rules(folder: Path, learners: Learners) -> DecisionList | None:
    """Read the decision list of a training run; None when its method uses none.

    Raises
    ------
    FileFormatError
        When the method needs one and it is missing or damaged, or it is of another task.
    """
    path = folder / RUN_RULES
    if not learners.method.needs_advice:
        return None
    rules = DecisionList.load(path)
    if (rules.keepers, rules.takers) != (learners.n_keepers, learners.n_takers):
        raise FileFormatError(
            f"{path} is a decision list for {rules.keepers}v{rules.takers}; its run learned "
            f"{learners.n_keepers}v{learners.n_takers}"
        )
    return rules


def _trained(folder: Path, keepers: int, takers: int) -> TeamPolicy:
    weights = folder / RUN_WEIGHTS
    if not weights.exists():
        raise PolicyError(f"{folder} is not the folder of a training run: it has no {RUN_WEIGHTS}")
    try:
        learners = Learners.load(weights)
        advice = run_rules(folder, learners)
    except (OSError, ValueError) as error:
        raise PolicyError(str(error)) from error
    if (learners.n_keepers, learners.n_takers) != (keepers, takers):
        raise PolicyError(f"{folder} learned {learners.n_keepers}v{learners.n_takers}; the task is {keepers}v{takers}")
    learners.set_mode(learning=False, exploring=False)
    return learners_policy(learners, advice, str(folder))
