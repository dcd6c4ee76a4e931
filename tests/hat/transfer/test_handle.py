"""Learners called by addresses decide and learn as they do when they are called by name, and live as long."""

from __future__ import annotations

import copy
import dataclasses
import gc
import pickle
import weakref

import numpy as np
import pytest

from rcss_hat.hat.brains import choose, finish, learned_brains
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.policy import learners_policy, load_policy
from rcss_hat.hat.rule_rows import deciding_row
from rcss_hat.hat.transfer import Learners
from rcss_hat.hat.transfer.handle import handle_of
from rcss_hat.hat.transfer.making import make_method
from rcss_hat.hat.transfer.method import NO_ADVICE
from rcss_hat.learning.config import load_config


def team(method: str, lambda_: float = 0.0) -> Learners:
    config = dataclasses.replace(load_config("paper"), lambda_=lambda_)
    return Learners.create(config, make_method(method), seed=3)


@pytest.mark.parametrize("method", ["no-prior", "value-bonus", "extra-action", "ppr"])
@pytest.mark.parametrize("lambda_", [0.0, 0.9])
def test_learners_learn_the_same_by_address_as_by_name(method: str, lambda_: float) -> None:
    by_address, by_name = team(method, lambda_), team(method, lambda_)
    rules = PAPER_RULES.to_arrays() if by_name.method.needs_advice else None
    brains, drawn = learned_brains(by_address, rules), np.random.default_rng(5)
    for _ in range(20):
        for k in range(3):
            for step in range(4):
                state = drawn.uniform(0.0, 25.0, 13)
                row = deciding_row(rules, state) if rules is not None else 0
                advice = (int(rules["action"][row]), float(rules["confidence"][row])) if rules is not None else ()
                wanted = by_name.keeper(k).decide(state, 3.0, *(advice or (NO_ADVICE, 0.0)))
                assert choose(brains, k, step == 0, 3.0, state) == wanted
            finish(brains, k, 2.0)
            by_name.keeper(k).finish_episode(2.0)
    assert by_address.weights.any()
    for name in ("records", "streams", "weights", "traces"):
        assert getattr(by_address, name).tobytes() == getattr(by_name, name).tobytes(), name


def test_arrays_live_as_long_as_the_handle_that_tells_where_they_are() -> None:
    learners = team("ppr")
    rules = PAPER_RULES.to_arrays()
    arrays = [weakref.ref(array) for array in (learners.weights, learners.records, learners.approximator.table, rules)]
    handle = handle_of(learners, rules)
    del learners, rules
    gc.collect()
    assert all(array() is not None for array in arrays)
    del handle
    gc.collect()
    assert arrays[0]() is None and arrays[3]() is None


def test_weights_with_gaps_are_refused() -> None:
    learners = team("no-prior")
    learners.weights = np.repeat(learners.weights, 2, axis=2)[:, :, ::2]
    with pytest.raises(ValueError, match="in C's order"):
        handle_of(learners)


def test_a_policy_of_learners_is_not_copied_with_addresses_that_nobody_keeps() -> None:
    policy = learners_policy(team("no-prior"), None)
    for copied in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="cannot be copied or pickled; copy or save its learners"):
            copied(policy)
    assert pickle.loads(pickle.dumps(load_policy("hand", 3, 2, 1))).spec == "hand"
