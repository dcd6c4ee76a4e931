"""Description lengths in bits: what a rule costs to state, and what the exceptions to a rule set cost to name.

References
----------
.. [1] J. R. Quinlan, "MDL and Categorical Theories (Continued)", ICML 1995, pp. 464-470.
.. [2] W. W. Cohen, "Fast Effective Rule Induction", ICML 1995, pp. 115-123.
"""

from __future__ import annotations

from math import log2

TOLERANCE = 1e-6
"""Two counts that differ by no more than this are the same count."""

REDUNDANCY = 0.5
"""Rules contain redundant conditions, so only half of their length counts (Cohen 1995)."""


def subset_bits(n: float, k: float, p: float) -> float:
    """Bits to name which k of n things are marked, when each is expected to be marked with probability p.

    Terms of the form 0 log 0 are 0. The expectation comes from rounded shares and may exceed 1, where no code exists;
    it is then taken as 1, and for unmarked things as just below.
    """
    p = min(p, 1.0)
    bits = 0.0
    if p > TOLERANCE:
        bits -= k * log2(p)
    if n - k > TOLERANCE:
        bits -= (n - k) * log2(1.0 - min(p, 1.0 - TOLERANCE))
    return bits


def theory_bits(n_possible: int, n_conditions: int) -> float:
    """Bits to state a rule: how many conditions it has, and which of the possible ones they are.

    Parameters
    ----------
    n_possible : int
        Number of conditions the training data offer.
    n_conditions : int
        Number of conditions of the rule.
    """
    if n_conditions == 0:
        return 0.0
    bits = log2(n_conditions)
    if n_conditions > 1:
        bits += 2.0 * log2(bits)
    return REDUNDANCY * (bits + subset_bits(n_possible, n_conditions, n_conditions / n_possible))


def exception_bits(share: float, covered: float, uncovered: float, false_pos: float, false_neg: float) -> float:
    """Bits to name the rows on which a rule set errs.

    Parameters
    ----------
    share : float
        Expected share of false positives among the errors.
    covered, uncovered : float
        Weight of the rows the rule set covers and of the others.
    false_pos, false_neg : float
        Weight of the errors among the covered and among the uncovered rows.
    """
    errors = false_pos + false_neg
    bits = log2(covered + uncovered + 1.0)
    if covered > uncovered:
        bits += subset_bits(covered, false_pos, share * errors / covered)
        if uncovered > 0.0:
            bits += subset_bits(uncovered, false_neg, false_neg / uncovered)
    elif uncovered > 0.0:
        bits += subset_bits(uncovered, false_neg, (1.0 - share) * errors / uncovered)
        if covered > 0.0:
            bits += subset_bits(covered, false_pos, false_pos / covered)
    return bits
