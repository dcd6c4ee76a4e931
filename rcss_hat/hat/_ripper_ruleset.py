"""Rule sets of one class: counting, description lengths, and deleting rules that do not pay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._ripper_grow import Conditions
from rcss_hat.hat._ripper_length import TOLERANCE, exception_bits, theory_bits
from rcss_hat.hat._ripper_table import Mask, Table
from rcss_hat.hat.conditions import covered_by_all


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A rule under way: its conditions and which rows of the table fulfil them, whatever other rules take."""

    conditions: Conditions
    covers: Mask


class Tally(NamedTuple):
    """What a rule takes at its place in the list: weight of all rows and of the negative ones."""

    covered: float
    false_pos: float


@dataclass(frozen=True, slots=True)
class Totals:
    """What a whole rule set covers and where it errs."""

    covered: float
    uncovered: float
    false_pos: float
    false_neg: float

    def without(self, tally: Tally) -> Totals:
        """Totals after deleting a rule, the rows it took falling to no other rule."""
        covered, false_pos = tally
        return Totals(
            self.covered - covered,
            self.uncovered + covered,
            self.false_pos - false_pos,
            self.false_neg + covered - false_pos,
        )


@dataclass(frozen=True, slots=True, eq=False)
class ClassTask:
    """Learning the rules of one class against all rows not yet covered.

    Attributes
    ----------
    table : Table
    rows : ndarray of bool
        Rows that no rule of an earlier class covers.
    positive : ndarray
        Weight of each row of the table if it is of the class, else 0.
    share : float
        Share of the class among itself and all more frequent ones; expected share of false positives.
    check_error : bool
        A rule that errs on at least half of what it covers is not kept.
    """

    table: Table
    rows: Mask
    positive: NDArray[np.float64]
    share: float
    check_error: bool

    def candidate(self, conditions: Conditions) -> Candidate:
        """Look up which rows fulfil some conditions."""
        return Candidate(conditions, covered_by_all(conditions, self.table.values))

    def weight(self, rows: Mask) -> float:
        """Weight of some rows."""
        return float(self.table.weights[rows].sum())

    def positive_weight(self, rows: Mask) -> float:
        """Weight of the positive ones of some rows."""
        return float(self.positive[rows].sum())

    def tally(self, rule: Candidate, rows: Mask) -> Tally:
        """Count what a rule takes of some rows."""
        taken = rule.covers & rows
        covered = self.weight(taken)
        return Tally(covered, covered - self.positive_weight(taken))

    def too_wrong(self, tally: Tally) -> bool:
        """Whether the error check speaks against a rule."""
        return self.check_error and tally.covered > 0.0 and tally.false_pos / tally.covered >= 0.5

    def count(self, rules: Sequence[Candidate]) -> tuple[list[Tally], Totals]:
        """Count a list of rules, each on the rows that those before it leave."""
        left = self.rows
        tallies = []
        for rule in rules:
            tallies.append(self.tally(rule, left))
            left = left & ~rule.covers
        covered = sum(tally.covered for tally in tallies)
        false_pos = sum(tally.false_pos for tally in tallies)
        return tallies, Totals(covered, self.weight(left), false_pos, self.positive_weight(left))

    def data_bits(self, totals: Totals) -> float:
        """Bits to name the errors of a rule set."""
        return exception_bits(self.share, totals.covered, totals.uncovered, totals.false_pos, totals.false_neg)

    def theory_bits(self, rule: Candidate) -> float:
        """Bits to state a rule."""
        return theory_bits(self.table.n_possible, len(rule.conditions))

    def default_bits(self) -> float:
        """Description length of having no rule at all."""
        return self.data_bits(self.count(())[1])

    def potential(self, rule: Candidate, tally: Tally, totals: Totals) -> tuple[float, bool]:
        """How many bits deleting a rule saves, and whether it is to be deleted."""
        saved = self.data_bits(totals) + self.theory_bits(rule) - self.data_bits(totals.without(tally))
        return saved, saved >= -TOLERANCE or self.too_wrong(tally)

    def reachable_bits(self, rules: Sequence[Candidate], first: int) -> float:
        """Least length that deleting rules from position ``first`` on could reach; kept rules' own length left out."""
        tallies, totals = self.count(rules)
        saved = 0.0
        for rule, tally in zip(rules[first:], tallies[first:], strict=True):
            potential, deletable = self.potential(rule, tally, totals)
            if deletable:
                saved += potential
                totals = totals.without(tally)
        return self.data_bits(totals) - saved

    def relative_bits(self, rules: Sequence[Candidate], index: int) -> float:
        """Length that a rule adds to a rule set: least reachable length with it less that without it."""
        kept = self.reachable_bits(rules, index + 1) + self.theory_bits(rules[index])
        return kept - self.reachable_bits([*rules[:index], *rules[index + 1 :]], index)

    def delete_unpaying(self, rules: Sequence[Candidate]) -> list[Candidate]:
        """Delete the rules, from the last to the first, without which the rule set is shorter to describe."""
        tallies, totals = self.count(rules)
        kept: list[Candidate] = []
        for rule, tally in zip(reversed(rules), reversed(tallies), strict=True):
            if self.potential(rule, tally, totals)[1]:
                totals = totals.without(tally)
            else:
                kept.insert(0, rule)
        return kept
