"""Inter-task mapping: what was demonstrated in one size of Keepaway, read in another (HAT paper, section 6).

Variables keep their names: K2 is the nearest team mate, T1 the nearest taker, in every size. So a decision list for 3v2
looks, in 4v3, at the two nearest team mates and the two nearest takers, and passes to these two only. From a larger
task to a smaller one, players that do not exist stand for the farthest that does (Taylor, Stone and Liu, JMLR 2007).
"""

from __future__ import annotations

import re

from rcss_hat.hat.conditions import Condition
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.rule import Rule
from rcss_hat.keepaway.state import state_names


def map_rules(rules: DecisionList, keepers: int, takers: int) -> DecisionList:
    """Translate a decision list to another size of Keepaway.

    Parameters
    ----------
    rules : DecisionList
    keepers, takers : int
        The task it is to be used in.

    Returns
    -------
    DecisionList
        Without training counts when the number of actions differs: they were counted in the other task.
    """
    if (rules.keepers, rules.takers) == (keepers, takers):
        return rules
    variables = {name: k for k, name in enumerate(state_names(keepers, takers))}

    def feature(source: int) -> int:
        name = state_names(rules.keepers, rules.takers)[source]
        return variables[_nearest_name(name, keepers, takers)]

    mapped = tuple(
        Rule(
            tuple(Condition(feature(c.feature), c.operator, c.threshold) for c in rule.conditions),
            min(rule.action, keepers - 1),
            rule.counts if keepers == rules.keepers else None,
        )
        for rule in rules.rules
    )
    return DecisionList(
        mapped,
        min(rules.default_action, keepers - 1),
        keepers,
        takers,
        rules.default_counts if keepers == rules.keepers else None,
        title=f"{rules.title} ({rules.keepers}v{rules.takers})".strip(),
    )


def _nearest_name(name: str, keepers: int, takers: int) -> str:
    def bounded(match: re.Match[str]) -> str:
        limit = keepers if match[1] == "K" else takers
        return f"{match[1]}{min(int(match[2]), limit)}"

    return re.sub(r"([KT])(\d+)", bounded, name)
