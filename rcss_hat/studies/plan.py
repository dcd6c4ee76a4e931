"""Who is assigned to what, and the steps that follow from it: functions of the study and the number of the place.

Places are filled in blocks. Between subjects every block of as many places as there are conditions has each condition
once; within subjects every block has each order once: all orders of up to three conditions, beyond that those of a
Williams design, in which every condition comes equally often in every position and after every other one. Which place
of its block has which is drawn from the study's seed, block by block, so that places that are added later change
nothing.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from msgspec.structs import fields

from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.policy import FIXED, TeamPolicy, load_policy, rules_policy
from rcss_hat.keepaway.decision import PERSON, action_name
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.studies.parts import (
    MAX_STEPS,
    STEPS,
    AnyStep,
    Condition,
    DemonstrationStep,
    GameOptions,
    GameStep,
    PeopleStudy,
    PracticeStep,
)

ALL_ORDERS = 3
"""Up to so many conditions, a block has all their orders."""
_BLOCKS, _MATCHES = 1, 2
"""What seeds are drawn for."""


@dataclass(frozen=True, slots=True)
class Game:
    """What is played in a step.

    Attributes
    ----------
    task : Task
    speed : float
        Times real time.
    actions : tuple of int
        What people may do; Hold, 0, is always among them.
    episodes : int
    seed : int
        Of its first match.
    keepers : str
        Who plays while the participant does not, see `GameOptions`.
    correct : bool
        Whether participants look at every game again, and say what would have been right.
    """

    task: Task
    speed: float
    actions: tuple[int, ...]
    episodes: int
    seed: int
    keepers: str
    correct: bool

    @property
    def limited(self) -> bool:
        """Whether people may do less than the keepers can."""
        return len(self.actions) < self.task.keepers

    @property
    def described(self) -> str:
        """What is unusual about it, for people: begins with a comma where anything is."""
        partner = self.keepers if self.keepers in FIXED else "a decision list"
        unusual = [
            (self.limited, f"{', '.join(map(str, self.actions))} allowed"),
            (self.keepers != PERSON, f"turns with {partner}"),
            (self.correct, "looked at again"),
        ]
        return "".join(f", {what}" for holds, what in unusual if holds)


@dataclass(frozen=True, slots=True)
class Planned:
    """A step of one participant.

    Attributes
    ----------
    name : str
        Unique among the participant's: that of a step that comes once per condition ends in the condition's.
    step : AnyStep
    condition : str or None
        For which it is gone through.
    game : Game or None
    """

    name: str
    step: AnyStep
    condition: str | None
    game: Game | None

    @property
    def step_kind(self) -> str:
        """Such as ``demonstration``, as the study's file says it."""
        return next(kind for kind, of in STEPS.items() if isinstance(self.step, of))

    @property
    def kept(self) -> bool:
        """Whether games are played whose decisions are kept."""
        return isinstance(self.step, DemonstrationStep) or (isinstance(self.step, PracticeStep) and self.step.keep)


def participant_name(place: int) -> str:
    """Name of the participant of a place, from 1."""
    return f"p{place:03d}"


def assigned(study: PeopleStudy, place: int) -> tuple[str, ...]:
    """Return the conditions of a place, from 1, in the order in which its participant meets them."""
    names = [condition.name for condition in study.conditions]
    rows = [(name,) for name in names] if study.design == "between" else _orders(names)
    block, position = divmod(place - 1, len(rows))
    drawn = np.random.default_rng(derived_seed(study.seed, _BLOCKS, block)).permutation(len(rows))
    return rows[int(drawn[position])]


def _orders(names: list[str]) -> list[tuple[str, ...]]:
    n = len(names)
    if n <= ALL_ORDERS:
        return list(itertools.permutations(names))
    # Williams (1949): 0, 1, n-1, 2, n-2, ... shifted; for an odd number the mirrored rows as well.
    first = [0, *(k // 2 + 1 if k % 2 == 0 else n - k // 2 - 1 for k in range(n - 1))]
    rows = [tuple(names[(k + shift) % n] for k in first) for shift in range(n)]
    return rows if n % 2 == 0 else rows + [row[::-1] for row in rows]


def plan_of(study: PeopleStudy, place: int) -> tuple[Planned, ...]:
    """Return all steps of the participant of a place.

    Raises
    ------
    ValueError
        When a game cannot be played, or the way is too long; the message names the step.
    """
    conditions = {condition.name: condition for condition in study.conditions}
    mine = [conditions[name] for name in assigned(study, place)]
    planned: list[Planned] = []
    for repeated, group in itertools.groupby(study.steps, key=lambda step: step.per_condition):
        steps = list(group)
        for condition in mine if repeated else [None]:
            planned += [_planned(study, place, step, condition) for step in steps]
    if len(planned) > MAX_STEPS:
        raise ValueError(f"a participant would go through {len(planned)} steps; {MAX_STEPS} are the limit")
    return tuple(planned)


def _planned(study: PeopleStudy, place: int, step: AnyStep, condition: Condition | None) -> Planned:
    name = step.name if condition is None else f"{step.name}-{condition.name}"
    of = None if condition is None else condition.name
    return Planned(name, step, of, _game(study, place, step, condition) if isinstance(step, GameStep) else None)


def _game(study: PeopleStudy, place: int, step: GameStep, condition: Condition | None) -> Game:
    layers = [layer for layer in (study.game, condition, step) if layer is not None]
    chosen = {name: _last(layers, name) for name in (field.name for field in fields(GameOptions))}
    where = f"step {step.name!r}" + (f" in condition {condition.name!r}" if condition is not None else "")
    try:
        task = Task.parse(
            chosen["size"] or "3v2", chosen["field"], chosen["vision"] or 360, chosen["profile"] or "19.0"
        )
        actions = _actions(chosen["actions"], task.keepers)
        keepers = chosen["keepers"] or PERSON
        companion_policy(keepers, task, 0)
    except ValueError as problem:
        raise ValueError(f"{where}: {problem}") from problem
    if chosen["episodes"] is None:
        raise ValueError(f"{where} needs episodes: how many games are played; or give them in [game]")
    number = next(k for k, known in enumerate(study.steps) if known.name == step.name)
    row = 0 if condition is None else 1 + [c.name for c in study.conditions].index(condition.name)
    whose = place if chosen["seeds"] != "same" else 0
    seed = derived_seed(study.seed, _MATCHES, whose, number, row)
    return Game(task, chosen["speed"] or 1.0, actions, chosen["episodes"], seed, keepers, bool(chosen["correct"]))


def companion_policy(keepers: str, task: Task, seed: int) -> TeamPolicy | None:
    """Return the policy that plays while the participant does not; None: there is none.

    Parameters
    ----------
    keepers : str
        ``person``, the name of a fixed policy, or a decision list as JSON.
    task : Task
    seed : int

    Raises
    ------
    ValueError
        When it is for teams of another size, or no decision list.
    """
    if keepers == PERSON:
        return None
    if keepers in FIXED:
        return load_policy(keepers, task.keepers, task.takers, seed)
    rules = DecisionList.from_json(keepers)
    if (rules.keepers, rules.takers) != (task.keepers, task.takers):
        raise ValueError(f"keepers: the decision list is for {rules.keepers}v{rules.takers}, the game is {task.size}")
    return rules_policy(rules, seed)


def _last(layers: list[GameOptions], name: str) -> Any:
    return next((value for layer in reversed(layers) if (value := getattr(layer, name)) is not None), None)


def _actions(names: tuple[str, ...] | None, keepers: int) -> tuple[int, ...]:
    if names is None:
        return tuple(range(keepers))
    known = {action_name(action).lower(): action for action in range(keepers)}
    for name in names:
        if name.lower() not in known:
            raise ValueError(f"there is no action {name!r}; with {keepers} keepers there are {', '.join(known)}")
    chosen = tuple(sorted({0, *(known[name.lower()] for name in names)}))
    if len(chosen) < 2:
        raise ValueError("actions need at least one pass")
    return chosen
