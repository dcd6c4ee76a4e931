"""Decision lists read in another size of Keepaway."""

from __future__ import annotations

import numpy as np

from rcss_hat.hat.decision_list import PAPER_RULES, DecisionList
from rcss_hat.hat.mapping import map_rules
from rcss_hat.keepaway.state import state_names


def test_variables_keep_their_names_in_a_larger_task() -> None:
    mapped = map_rules(PAPER_RULES, 4, 3)
    small, large = state_names(3, 2), state_names(4, 3)
    for before, after in zip(PAPER_RULES.rules, mapped.rules, strict=True):
        assert [large[c.feature] for c in after.conditions] == [small[c.feature] for c in before.conditions]
        assert [(c.operator, c.threshold) for c in after.conditions] == [
            (c.operator, c.threshold) for c in before.conditions
        ]
        assert after.action == before.action and after.counts is None
    rng = np.random.default_rng(0)
    states = rng.uniform(0.0, 20.0, (2000, 19))
    shared = [large.index(name) for name in small]
    assert (mapped.predict(states) == PAPER_RULES.predict(states[:, shared])).all()
    assert len(set(mapped.predict(rng.uniform(0.0, 90.0, (5000, 19))))) > 1


def test_in_a_smaller_task_the_farthest_stands_for_those_missing() -> None:
    names = state_names(4, 3)
    text = f"if (state_{names.index('dist(K1,K4)')} <= 9 and state_{names.index('dist(K1,T3)')} >= 2) -> Action = 3"
    mapped = map_rules(DecisionList.parse(text + "\nelse -> Action = 0", 4, 3), 3, 2)
    [rule] = mapped.rules
    assert [state_names(3, 2)[c.feature] for c in rule.conditions] == ["dist(K1,K3)", "dist(K1,T2)"]
    assert rule.action == 2


def test_the_same_task_changes_nothing() -> None:
    assert map_rules(PAPER_RULES, 3, 2) is PAPER_RULES
