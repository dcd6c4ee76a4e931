"""Learning the rules of one class: building a rule set, then optimising it (Cohen 1995, section 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rcss_hat.hat._ripper_grow import Conditions, grow, prune
from rcss_hat.hat._ripper_length import TOLERANCE
from rcss_hat.hat._ripper_ruleset import Candidate, ClassTask
from rcss_hat.hat._ripper_table import Mask, split_rows

SURPLUS_BITS = 64.0
"""Adding rules ends when the description is this much longer than the shortest so far (Cohen 1995)."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Parameters of the learner; see ``RipperClassifier``."""

    folds: int
    min_weight: float
    optimizations: int
    prune: bool


@dataclass(slots=True)
class Length:
    """Description length while rules are added, and the least so far."""

    now: float
    least: float

    def add(self, bits: float) -> None:
        """Count the bits of one more rule."""
        self.now += bits
        self.least = min(self.least, self.now)


def learn_rules(task: ClassTask, settings: Settings, rng: np.random.RandomState) -> list[Candidate]:
    """Learn the rule set of one class."""
    rules = _build(task, settings, rng)
    if settings.prune:
        for _ in range(settings.optimizations):
            rules = _optimise(task, rules, settings, rng)
    return rules


def _build(task: ClassTask, settings: Settings, rng: np.random.RandomState) -> list[Candidate]:
    bits = task.default_bits()
    length = Length(bits, bits)
    rules: list[Candidate] = []
    left = task.rows
    while task.positive_weight(left) > TOLERANCE:
        rule = _next_rule(task, rules, left, length, settings, rng)
        if rule is None:
            break
        rules.append(rule)
        left = left & ~rule.covers
    return rules


def _next_rule(
    task: ClassTask,
    rules: Sequence[Candidate],
    left: Mask,
    length: Length,
    settings: Settings,
    rng: np.random.RandomState,
) -> Candidate | None:
    """Learn one more rule on the rows that are left; None when it is not worth keeping."""
    if settings.prune:
        grow_rows, prune_rows = split_rows(task.table.labels, left, settings.folds, rng)
        grown = grow(task.table, grow_rows, task.positive, (), settings.min_weight)
        conditions = prune(task.table, prune_rows, task.positive, grown, whole_set=False)
    else:
        conditions = grow(task.table, left, task.positive, (), settings.min_weight)
    rule = task.candidate(conditions)
    length.add(task.relative_bits([*rules, rule], len(rules)))
    tally = task.tally(rule, left)
    no_positive = tally.covered - tally.false_pos <= 0.0
    too_long = length.now > length.least + SURPLUS_BITS
    return None if no_positive or too_long or task.too_wrong(tally) else rule


def _optimise(
    task: ClassTask, rules: Sequence[Candidate], settings: Settings, rng: np.random.RandomState
) -> list[Candidate]:
    """Settle the rules one after the other, each as it is, revised or replaced; then add what is missing."""
    bits = task.default_bits()
    length = Length(bits, bits)
    settled: list[Candidate] = []
    left = task.rows
    while task.positive_weight(left) > TOLERANCE:
        position = len(settled)
        if position < len(rules):
            rule: Candidate | None = _best_variant(task, settled, rules[position:], left, settings, rng)
        else:
            rule = _next_rule(task, settled, left, length, settings, rng)
        if rule is None:
            break
        settled.append(rule)
        left = left & ~rule.covers
    return task.delete_unpaying([*settled, *rules[len(settled) :]])


def _best_variant(
    task: ClassTask,
    settled: Sequence[Candidate],
    ahead: Sequence[Candidate],
    left: Mask,
    settings: Settings,
    rng: np.random.RandomState,
) -> Candidate:
    """Choose between the next rule as it is, its revision and its replacement: the one that adds least length."""
    old, later = ahead[0], ahead[1:]
    if not (old.covers & left).any():
        return old
    grow_rows, prune_rows = split_rows(task.table.labels, left, settings.folds, rng)
    for rule in later:
        prune_rows &= ~rule.covers

    def variant(start: Conditions, rows: Mask) -> Candidate:
        grown = grow(task.table, rows, task.positive, start, settings.min_weight)
        return task.candidate(prune(task.table, prune_rows, task.positive, grown, whole_set=True))

    replacement = variant((), grow_rows)
    revision = variant(old.conditions, grow_rows & old.covers)
    # min takes the first of equals
    return min(
        (old, revision, replacement), key=lambda rule: task.relative_bits([*settled, rule, *later], len(settled))
    )
