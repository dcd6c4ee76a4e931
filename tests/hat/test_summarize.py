"""Policy summarisation: what is learned from a known policy, and figures against their definitions."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hat_samples import hand_coded
from sklearn.model_selection import StratifiedKFold

from rcss_hat.hat.conditions import Condition
from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.ripper import RipperClassifier
from rcss_hat.hat.summarize import Summary, summarize
from rcss_hat.keepaway.report import OUT, Episode


@pytest.fixture(scope="module")
def summary() -> Summary:
    return summarize(hand_coded(), seed=3)


def test_hand_coded_policy_is_recovered(summary: Summary) -> None:
    # The policy holds while the nearest taker is farther than 5 m
    for rule in summary.decision_list.rules:
        assert rule.conditions[0] == Condition(3, "<=", 5.0)
    assert summary.decision_list.default_action == 0
    assert summary.accuracy > 0.97
    assert summary.episode_accuracy > 0.97


def test_figures_follow_their_definitions(summary: Summary) -> None:
    X, y = hand_coded().X, hand_coded().y
    assert summary.majority_share == (y == 0).mean()
    assert summary.training_accuracy == (summary.decision_list.predict(X) == y).mean()
    right = 0
    for train, test in StratifiedKFold(10, shuffle=True, random_state=3).split(X, y):
        right += (RipperClassifier(random_state=3).fit(X[train], y[train]).predict(X[test]) == y[test]).sum()
    assert summary.accuracy == right / len(y)
    assert summary.confusion.sum() == len(y)
    assert summary.confusion.trace() == right
    assert summary.confusion.sum(axis=1).tolist() == np.bincount(y).tolist()


def test_seed_decides(summary: Summary) -> None:
    assert summarize(hand_coded(), seed=3).to_dict() == summary.to_dict()


def test_report_shows_rules_and_figures(summary: Summary) -> None:
    text = summary.to_text()
    assert summary.printed.format() in text
    assert max(len(number.partition(".")[2]) for number in re.findall(r"[<>]=? (\S+?)[ )]", text)) < 10
    X = hand_coded().X
    assert summary.printed.predict(X).tolist() == summary.decision_list.predict(X).tolist()
    assert f"accuracy, stratified cross-validation:    {100 * summary.accuracy:.1f} %" in text
    assert "share of the most frequent action (Hold): 86.5 %" in text
    assert "from 834 decisions in 20 episodes of hand:" in text
    json.dumps(summary.to_dict())


def test_left_out_episodes_show_what_near_duplicates_hide() -> None:
    """Each episode has one action and one place: its rows predict each other, but other episodes do not."""
    rng = np.random.default_rng(0)
    episodes = []
    for number in range(1, 21):
        states = np.full((30, 13), rng.uniform(0, 20)) + rng.normal(0, 1e-6, (30, 13))
        actions = np.full(30, rng.integers(0, 3))
        episodes.append(Demonstration(Episode(number, 0, 50, OUT), "A", np.arange(30), np.ones(30), states, actions))
    summary = summarize(DemonstrationSet(DemonstrationInfo("A", "arena"), tuple(episodes)), seed=0)
    assert summary.accuracy > summary.episode_accuracy + 0.2


def few(actions: list[int], episodes: int = 1) -> DemonstrationSet:
    n = len(actions)
    made = [
        Demonstration(Episode(k, 0, 50, OUT), "A", np.arange(n), np.ones(n), np.eye(n, 13), np.array(actions))
        for k in range(1, episodes + 1)
    ]
    return DemonstrationSet(DemonstrationInfo("A", "arena"), tuple(made))


def test_single_episode_has_no_episode_accuracy() -> None:
    summary = summarize(few([0] * 12 + [1]), seed=0)
    assert math.isnan(summary.episode_accuracy)
    assert summary.accuracy > 0.5
    assert "accuracy, whole episodes left out:        not possible, too few" in summary.to_text()
    assert summary.to_dict()["episode_accuracy"] is None


def test_too_few_rows_to_cross_validate() -> None:
    summary = summarize(few([0, 1, 2]), seed=0)
    assert math.isnan(summary.accuracy)
    assert not summary.confusion.any()
    assert "predicted" not in summary.to_text()


def test_nothing_to_learn_from_is_an_error() -> None:
    with pytest.raises(ValueError, match="the demonstration of A holds 2 decisions; at least 3 are needed"):
        summarize(few([0, 1]), seed=0)


def test_learner_can_be_chosen() -> None:
    summary = summarize(hand_coded(), seed=0, learner=RipperClassifier(prune=False))
    assert summary.training_accuracy > summarize(hand_coded(), seed=0).training_accuracy


def test_rules_are_learned_from_lessons() -> None:
    """What a learner did while a person looked on teaches nothing; what the person called right does."""
    taught = hand_coded().split(6)[0]
    wrong = [
        replace(d, by=("learner",) * len(d), actions=2 - d.actions, right=tuple(d.actions.tolist())) for d in taught
    ]
    ignored = [replace(d, by=("learner",) * len(d), actions=0 * d.actions) for d in taught]
    marked = DemonstrationSet(replace(taught.info, marked=True), (*wrong, *ignored))
    learned = summarize(marked, seed=0)
    assert learned.decision_list.to_json() == summarize(taught, seed=0).decision_list.to_json()
    assert learned.n_decisions == taught.n_decisions
