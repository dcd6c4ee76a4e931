"""One rule of a decision list: conditions, the action they advise, and its training counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.conditions import Condition
from rcss_hat.inputs import FileFormatError, excerpt, item


@dataclass(frozen=True, slots=True)
class Rule:
    """Conditions, all of which must hold, and the action they advise.

    Attributes
    ----------
    conditions : tuple of Condition
        In the order they were learned; none in a default rule.
    action : int
    counts : tuple of float or None
        Weight, per action, of the training rows that the rule decides.
    """

    conditions: tuple[Condition, ...]
    action: int
    counts: tuple[float, ...] | None = None

    def covers(self, state: Sequence[float] | NDArray[np.float64]) -> bool:
        """Whether all conditions hold in a state."""
        return all(condition.holds(float(state[condition.feature])) for condition in self.conditions)

    @property
    def precision(self) -> float | None:
        """Share of the training rows decided whose action is the rule's; None without any."""
        if self.counts is None or sum(self.counts) <= 0.0:
            return None
        return self.counts[self.action] / sum(self.counts)

    @property
    def confidence(self) -> float:
        """Laplace estimate of that share, (right + 1) / (all + number of actions); 1 without training counts."""
        if self.counts is None:
            return 1.0
        return (self.counts[self.action] + 1.0) / (sum(self.counts) + len(self.counts))


def rule_from(entry: Any, where: str) -> Rule:
    """Read a rule of a list kept as JSON; raises FileFormatError, naming the entry."""
    conditions = []
    for condition in item(entry, "if", list, where):
        try:
            conditions.append(
                Condition(
                    item(condition, "variable", int, where),
                    item(condition, "operator", str, where),
                    float(item(condition, "threshold", (int, float), where)),
                )
            )
        except FileFormatError:
            raise
        except (ValueError, OverflowError) as error:
            raise FileFormatError(f"{where}: {error}") from error
    return Rule(tuple(conditions), item(entry, "action", int, where), counts_from(entry, where))


def counts_from(entry: Any, where: str) -> tuple[float, ...] | None:
    """Read the training counts of a rule kept as JSON; None where it has none."""
    counts = entry.get("counts")
    if counts is None:
        return None
    if not isinstance(counts, list) or any(isinstance(c, bool) or not isinstance(c, int | float) for c in counts):
        raise FileFormatError(f"{where}: 'counts' must be a list of numbers or null, not {excerpt(counts)}")
    return tuple(float(count) for count in counts)
