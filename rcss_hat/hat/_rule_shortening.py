"""Thresholds for people: as few decimals as decide the same."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal

from rcss_hat.hat.conditions import AT_MOST
from rcss_hat.hat.rule import Rule

MAX_DECIMALS = 17
"""More than any threshold has that is not tiny."""


def shorten(rules: tuple[Rule, ...], decide_the_same: Callable[[tuple[Rule, ...]], bool]) -> tuple[Rule, ...]:
    """Return rules with thresholds of as few decimals as can be, one threshold after the other.

    Parameters
    ----------
    rules : tuple of Rule
    decide_the_same : callable
        Whether such rules do.
    """
    for number, rule in enumerate(rules):
        for place, condition in enumerate(rule.conditions):
            towards = -math.inf if condition.operator == AT_MOST else math.inf
            for threshold in _rounded(condition.threshold, towards):
                conditions = list(rules[number].conditions)
                conditions[place] = replace(condition, threshold=threshold)
                shorter = (*rules[:number], replace(rule, conditions=tuple(conditions)), *rules[number + 1 :])
                if decide_the_same(shorter):
                    rules = shorter
                    break
    return rules


def _rounded(number: float, towards: float) -> Iterator[float]:
    """Yield a number with ever more decimals, first the nearest, then its neighbours; each also as ``<`` or ``>``."""
    exact = Decimal(repr(number))
    if abs(exact) >= 10**MAX_DECIMALS:  # far from metres and degrees
        return
    for decimals in range(MAX_DECIMALS + 1):
        for rounding in (ROUND_HALF_EVEN, ROUND_CEILING, ROUND_FLOOR):
            rounded = float(exact.quantize(Decimal(1).scaleb(-decimals), rounding=rounding)) + 0.0  # no -0
            yield rounded
            yield math.nextafter(rounded, towards)
