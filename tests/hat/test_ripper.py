"""The rule learner: Weka's JRip as recorded, closed forms, and properties that hold for any data."""

from __future__ import annotations

import csv
import doctest
import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.base import clone
from sklearn.datasets import load_iris
from sklearn.utils.estimator_checks import parametrize_with_checks

import rcss_hat.hat.ripper
from rcss_hat.hat._ripper_grow import best_step, grow, prune
from rcss_hat.hat._ripper_length import exception_bits, subset_bits, theory_bits
from rcss_hat.hat._ripper_ruleset import ClassTask
from rcss_hat.hat._ripper_table import make_table, split_rows
from rcss_hat.hat.conditions import Condition, covered_by_all
from rcss_hat.hat.ripper import RipperClassifier, RipperRule, first_match, format_rule

FOLDER = Path(__file__).parent.parent / "data" / "ripper"
RECORDED = json.loads((FOLDER / "results.json").read_text())["datasets"]


class Data:
    def __init__(self, name: str) -> None:
        with gzip.open(FOLDER / f"{name}.csv.gz", "rt", newline="") as file:
            header, *lines = list(csv.reader(file))
        table = np.array(lines)
        self.names = header[1:-1]
        self.rows, self.labels, self.folds = table[:, 1:-1].astype(float), table[:, -1], table[:, 0].astype(int)


@parametrize_with_checks([RipperClassifier()])
def test_scikit_learn_contract(estimator: Any, check: Any) -> None:
    check(estimator)


def test_example_in_docstring() -> None:
    assert doctest.testmod(rcss_hat.hat.ripper).failed == 0


# --- description lengths, values of Weka 3.6.14 -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("n_possible", "n_conditions", "bits"),
    [
        (100, 0, 0.0),
        (100, 1, 4.039657),
        (100, 2, 7.572027),
        (100, 3, 11.176523),
        (2600, 1, 6.393357),
        (2600, 2, 12.286436),
        (2600, 4, 23.571761),
        (26000, 3, 23.242740),
    ],
)
def test_length_of_a_rule(n_possible: int, n_conditions: int, bits: float) -> None:
    assert theory_bits(n_possible, n_conditions) == pytest.approx(bits, abs=1e-6)


@pytest.mark.parametrize(
    ("share", "covered", "uncovered", "false_pos", "false_neg", "bits"),
    [
        (0.10, 0, 100, 0, 10, 53.643063),
        (0.25, 30, 70, 2, 5, 43.254677),
        (0.25, 70, 30, 5, 2, 46.242814),
        (0.40, 50, 50, 3, 4, 43.147028),
        (0.10, 900, 100, 50, 10, 426.510365),
        (0.30, 20, 80, 0, 0, 6.658211),
        (0.30, 20, 80, 0, 6, 37.924803),
        (0.05, 12, 988, 1, 30, 208.801919),
        (0.50, 60, 40, 0, 0, 6.658211),
        (0.30, 60, 40, 20, 40, 61.980450),  # JRip meets 0 log 0 here
    ],
)
def test_length_of_exceptions(
    share: float, covered: float, uncovered: float, false_pos: float, false_neg: float, bits: float
) -> None:
    assert exception_bits(share, covered, uncovered, false_pos, false_neg) == pytest.approx(bits, abs=1e-6)


@given(st.integers(0, 200), st.integers(0, 200), st.floats(0.0, 1.0), st.data())
def test_lengths_are_always_finite(covered: int, uncovered: int, share: float, data: st.DataObject) -> None:
    false_pos = data.draw(st.integers(0, covered))
    false_neg = data.draw(st.integers(0, uncovered))
    bits = exception_bits(share, covered, uncovered, false_pos, false_neg)
    assert np.isfinite(bits)
    assert bits >= np.log2(covered + uncovered + 1) - 1e-9


def test_subset_of_everything_and_nothing_costs_nothing() -> None:
    assert subset_bits(40, 40, 1.0) == 0.0
    assert subset_bits(40, 0, 0.0) == 0.0
    assert subset_bits(2, 1, 0.5) == 2.0


# --- the table --------------------------------------------------------------------------------------------------


def table_of(rows: Any, labels: Any, weights: Any = None) -> Any:
    rows = np.asarray(rows, dtype=float)
    return make_table(rows, np.asarray(labels), np.ones(len(rows)) if weights is None else np.asarray(weights, float))


def test_number_of_possible_conditions() -> None:
    iris = load_iris()
    assert table_of(iris.data, iris.target).n_possible == 246
    assert table_of([[1.0, np.nan], [1.0, 3.0], [2.0, np.nan]], [0, 1, 0]).n_possible == 2 * (2 + 1)


def test_weight_of_equal_rows_is_dealt_out() -> None:
    nan = np.nan
    table = table_of([[2, nan], [1, 0], [2, nan], [2, nan], [1, 0]], [0, 1, 0, 1, 1], [1, 2, 3, 1.25, 0])
    assert table.labels.tolist() == [1, 1, 0, 0, 0, 1, 1]
    assert table.weights.tolist() == [1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 0.25]
    assert table.values[:, 0].tolist() == [1.0, 1.0] + [2.0] * 5


@given(st.lists(st.floats(0.01, 50.0) | st.integers(1, 9).map(float), min_size=1, max_size=20), st.integers(2, 5))
def test_dealing_keeps_the_weight(weights: list[float], folds: int) -> None:
    rows = np.arange(len(weights), dtype=float)[:, np.newaxis]
    table = make_table(rows, np.zeros(len(weights), dtype=int), np.array(weights), folds)
    assert (table.weights > 0.0).all()
    for index, weight in enumerate(weights):
        pieces = table.weights[table.values[:, 0] == index]
        assert pieces.sum() == pytest.approx(weight)
        assert len(pieces) <= folds
        assert pieces.max() - pieces.min() <= 2.0


@given(st.lists(st.integers(0, 3), min_size=1, max_size=60), st.integers(2, 5), st.integers(0, 5))
def test_split_is_stratified(labels: list[int], folds: int, seed: int) -> None:
    array = np.array(labels)
    rows = np.ones(len(array), dtype=bool)
    rows[:: seed + 2] = False
    grow_rows, prune_rows = split_rows(array, rows, folds, np.random.RandomState(seed))
    assert not (grow_rows & prune_rows).any()
    assert ((grow_rows | prune_rows) == rows).all()
    assert grow_rows.sum() == rows.sum() * (folds - 1) // folds
    for label in range(4):
        whole = (rows & (array == label)).sum()
        assert abs((prune_rows & (array == label)).sum() - whole / folds) < 2.0


# --- growing and pruning ----------------------------------------------------------------------------------------


def naive_best(
    rows: np.ndarray, labels: np.ndarray, weights: np.ndarray, rate: float
) -> tuple[float, Condition | None]:
    """All thresholds one by one, in the order that decides between equals."""
    best: tuple[float, Condition | None] = (0.0, None)
    for feature in range(rows.shape[1]):
        for value in np.unique(rows[~np.isnan(rows[:, feature]), feature]):
            for operator in (">=", "<="):
                condition = Condition(feature, operator, float(value))
                covered = condition.covers(rows)
                t, p = weights[covered].sum(), weights[covered & (labels == 1)].sum()
                gain = p * (np.log2((p + 1) / (t + 1)) - np.log2(rate))
                if gain > best[0] + 1e-9:
                    best = (gain, condition)
    return best


@given(st.integers(0, 10**6), st.integers(2, 40), st.booleans(), st.booleans())
def test_best_condition_is_the_best_of_all(seed: int, n: int, weighted: bool, missing: bool) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, 6, (n, 3)).astype(float)
    if missing:
        rows[rng.random((n, 3)) < 0.2] = np.nan
    weights = rng.integers(1, 4, n).astype(float) if weighted else np.ones(n)
    table = make_table(rows, rng.integers(0, 2, n), weights)
    positive = np.where(table.labels == 1, table.weights, 0.0)
    rate = (positive.sum() + 1) / (table.weights.sum() + 1)
    gain, expected = naive_best(table.values, table.labels, table.weights, rate)
    step = best_step(table, table.order, positive, rate)
    if step is None:
        assert expected is None
        return
    p, t = step.positive, step.total
    assert p * (np.log2((p + 1) / (t + 1)) - np.log2(rate)) == pytest.approx(gain)
    assert step.condition == expected
    covered = step.condition.covers(table.values)
    assert set(step.rows) == set(np.flatnonzero(covered))
    assert t == table.weights[covered].sum()


def test_gain_of_jrip() -> None:
    # 50 positives and 100 negatives; the condition covers 40 positives of 45 rows
    column = np.concatenate([np.full(45, 1.0), np.full(105, 2.0)])
    labels = np.concatenate([np.ones(40), np.zeros(5), np.ones(10), np.zeros(95)]).astype(int)
    table = make_table(np.column_stack([column, np.arange(150) * 0.0]), labels, np.ones(150))
    positive = np.where(table.labels == 1, table.weights, 0.0)
    step = best_step(table, table.order, positive, 51 / 151)
    assert step is not None
    assert (step.positive, step.total) == (40, 45)
    assert 40 * (np.log2(41 / 46) - np.log2(51 / 151)) == pytest.approx(55.998778, abs=1e-6)


def test_growth_stops_at_too_few_positives_without_second_best() -> None:
    # The purest condition covers one positive row only; a worse one would cover three
    rows = np.array([[0.0], [1.0], [2.0], [3.0], [4.0], [5.0]])
    table = table_of(rows, [1, 0, 0, 0, 0, 0])
    positive = (table.labels == 1) * table.weights
    everything = np.ones(6, dtype=bool)
    assert grow(table, everything, positive, (), 2.0) == ()
    assert grow(table, everything, positive, (), 1.0) == (Condition(0, "<=", 0.0),)


def test_growth_continues_from_given_conditions() -> None:
    rows = [[x, y] for x in range(4) for y in range(4)]
    labels = [int(x >= 2 and y <= 1) for x, y in rows]
    table = table_of(rows, labels)
    positive = (table.labels == 1) * table.weights
    start = (Condition(1, "<=", 1.0),)
    grown = grow(table, covered_by_all(start, table.values), positive, start, 2.0)
    assert grown == (Condition(1, "<=", 1.0), Condition(0, ">=", 2.0))


def test_pruning_cuts_final_conditions_and_prefers_the_shorter_rule() -> None:
    rows = [[x, 0.0] for x in range(10)]
    table = table_of(rows, [1] * 5 + [0] * 5)
    positive = (table.labels == 1) * table.weights
    everything = np.ones(10, dtype=bool)
    useful, useless, harmful = Condition(0, "<=", 4.0), Condition(1, "<=", 0.0), Condition(0, "<=", 0.0)
    for whole_set in (False, True):
        assert prune(table, everything, positive, (useful, useless), whole_set) == (useful,)
        assert prune(table, everything, positive, (useful, harmful), whole_set) == (useful,)
        assert prune(table, everything, positive, (useless, useless), whole_set) == ()
    assert prune(table, ~everything, positive, (useful, harmful), False) == (useful, harmful)


def test_optimisation_judges_pruning_by_all_rows() -> None:
    # One row more is right on the whole with the wide rule, but the narrow one is purer
    table = table_of([[x] for x in range(12)], [1] * 4 + [0, 1, 1, 1] + [0] * 4)
    positive = (table.labels == 1) * table.weights
    rule = (Condition(0, "<=", 7.0), Condition(0, "<=", 3.0))
    everything = np.ones(12, dtype=bool)
    assert prune(table, everything, positive, rule, whole_set=True) == rule[:1]
    assert prune(table, everything, positive, rule, whole_set=False) == rule


# --- rule sets --------------------------------------------------------------------------------------------------


def steps_task(check_error: bool = True) -> ClassTask:
    table = table_of([[x] for x in range(40)], [1] * 10 + [0] * 5 + [1] * 5 + [0] * 20)
    positive = (table.labels == 1) * table.weights
    return ClassTask(table, np.ones(40, dtype=bool), positive, 15 / 40, check_error)


def test_rules_are_counted_in_sequence() -> None:
    task = steps_task()
    wide, narrow = task.candidate((Condition(0, "<=", 11.0),)), task.candidate((Condition(0, "<=", 14.0),))
    tallies, totals = task.count([wide, narrow])
    assert [tuple(tally) for tally in tallies] == [(12.0, 2.0), (3.0, 3.0)]
    assert (totals.covered, totals.uncovered, totals.false_pos, totals.false_neg) == (15.0, 25.0, 5.0, 5.0)
    assert totals.without(tallies[1]) == task.count([wide])[1]


def test_length_that_the_only_rule_adds() -> None:
    task = steps_task()
    rule = task.candidate((Condition(0, "<=", 9.0),))
    with_rule = exception_bits(15 / 40, 10, 30, 0, 5) + theory_bits(80, 1)
    assert task.relative_bits([rule], 0) == pytest.approx(with_rule - exception_bits(15 / 40, 0, 40, 0, 15))


def test_rules_that_do_not_pay_are_deleted() -> None:
    task = steps_task()
    good = task.candidate((Condition(0, "<=", 9.0),))
    junk = task.candidate((Condition(0, ">=", 20.0), Condition(0, "<=", 21.0)))
    assert task.delete_unpaying([junk, good]) == [good]
    assert task.delete_unpaying([good, junk]) == [good]


def test_error_check_rejects_rules_wrong_half_of_the_time() -> None:
    task = steps_task()
    half = task.tally(task.candidate((Condition(0, ">=", 10.0), Condition(0, "<=", 19.0))), task.rows)
    assert half == (10.0, 5.0)
    assert task.too_wrong(half)
    assert not steps_task(check_error=False).too_wrong(half)


# --- JRip's recorded models -------------------------------------------------------------------------------------


def recorded_rules(name: str, model: list[dict[str, Any]], data: Data) -> list[RipperRule]:
    """JRip's model with the counts that our own evaluation gives its rules on the training data."""
    classes = RECORDED[name]["classes"]
    conditions = [
        tuple(Condition(data.names.index(feature), operator, value) for feature, operator, value in rule["conditions"])
        for rule in model
    ]
    which = first_match(conditions, data.rows)
    return [
        RipperRule(
            conditions[index],
            classes.index(rule["class"]),
            tuple(float(((which == index) & (data.labels == label)).sum()) for label in classes),
        )
        for index, rule in enumerate(model)
    ]


@pytest.mark.parametrize("name", RECORDED)
def test_evaluation_agrees_with_jrip(name: str) -> None:
    data = Data(name)
    for outcome in RECORDED[name]["full"]:
        rules = recorded_rules(name, outcome["model"], data)
        for rule, recorded in zip(rules, outcome["model"], strict=True):
            assert rule.distribution == pytest.approx(recorded["distribution"])
        which = first_match([rule.conditions for rule in rules], data.rows)
        assert "".join(str(rules[index].prediction) for index in which) == outcome["train_predictions"]
        printed = [format_rule(rule, data.names, RECORDED[name]["classes"]) for rule in rules]
        assert printed == outcome["printed"]


def cross_validated(data: Data, seeds: range) -> tuple[float, float, float]:
    accuracy, rules, conditions = [], [], []
    for seed in seeds:
        for fold in range(10):
            train = data.folds != fold
            learner = RipperClassifier(random_state=1000 * seed + fold).fit(data.rows[train], data.labels[train])
            accuracy.append((learner.predict(data.rows[~train]) == data.labels[~train]).sum())
            rules.append(len(learner.rules_))
            conditions.append(sum(len(rule.conditions) for rule in learner.rules_))
    return sum(accuracy) / len(data.labels) / len(seeds), float(np.mean(rules)), float(np.mean(conditions))


def test_accuracy_and_size_like_jrip() -> None:
    ours, jrip = [], []
    for name, recorded in RECORDED.items():
        data = Data(name)
        ours.append(cross_validated(data, range(8) if len(data.labels) <= 150 else range(4)))
        jrip.append([recorded["jrip_mean"][key] for key in ("cv_accuracy", "cv_rules", "cv_conditions")])
    difference = np.array(ours)[:, 0] - np.array(jrip)[:, 0]
    assert difference.min() > -0.03
    assert difference.mean() > -0.01
    ratio = np.mean(ours, axis=0)[1:] / np.mean(jrip, axis=0)[1:]
    assert (abs(ratio - 1.0) < 0.15).all()


# --- the classifier ---------------------------------------------------------------------------------------------


def test_rules_of_a_noise_free_concept_are_found() -> None:
    rng = np.random.default_rng(3)
    rows = rng.random((600, 3)) * 10
    labels = np.where((rows[:, 0] <= 3.0) & (rows[:, 2] >= 6.0), "pass", "hold")
    learner = RipperClassifier(random_state=1).fit(rows, labels)
    rule, default = learner.rules_
    assert {(c.feature, c.operator) for c in rule.conditions} == {(0, "<="), (2, ">=")}
    for condition in rule.conditions:
        assert condition.threshold in rows[:, condition.feature]
        assert condition.threshold == pytest.approx({0: 3.0, 2: 6.0}[condition.feature], abs=0.3)
    assert default.conditions == ()
    assert learner.score(rows, labels) > 0.99
    assert learner.predict([[1.0, 5.0, 9.0], [9.0, 5.0, 9.0]]).tolist() == ["pass", "hold"]


def test_narrow_band_is_found() -> None:
    # A band of one variable, as in the first rule of the HAT paper
    rng = np.random.default_rng(5)
    rows = rng.random((1000, 2)) * 100
    labels = ((rows[:, 0] >= 70.0) & (rows[:, 0] <= 76.0)).astype(int)
    learner = RipperClassifier(random_state=0).fit(rows, labels)
    assert learner.score(rows, labels) > 0.99
    assert len(learner.rules_) == 2


def test_rarest_class_comes_first_and_most_frequent_is_the_default() -> None:
    rng = np.random.default_rng(0)
    rows = rng.random((300, 2))
    labels = np.select([rows[:, 0] > 0.9, rows[:, 0] > 0.6], [2, 1], 0)
    learner = RipperClassifier(random_state=0).fit(rows, labels)
    order = [rule.label for rule in learner.rules_]
    assert order == sorted(order, reverse=True)
    assert order[-1] == 0


@given(st.integers(0, 10**6), st.integers(10, 60), st.integers(1, 3))
def test_rows_are_counted_once_whatever_their_order(seed: int, n: int, n_classes: int) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, 8, (n, 3)).astype(float)
    labels = rng.integers(0, n_classes, n)
    learner = RipperClassifier(random_state=seed).fit(rows, labels)
    assert sum(sum(rule.counts) for rule in learner.rules_) == n
    assert np.allclose(learner.predict_proba(rows).sum(axis=1), 1.0)
    which = learner.apply(rows)
    for index, rule in enumerate(learner.rules_):
        taken = labels[which == index]
        assert rule.counts == tuple(float((taken == label).sum()) for label in learner.classes_)
    shuffled = rng.permutation(n)
    assert clone(learner).fit(rows[shuffled], labels[shuffled]).rules_ == learner.rules_


@given(st.integers(0, 10**6))
def test_weights_are_repetitions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, labels, weights = rng.random((30, 2)), rng.integers(0, 3, 30), rng.integers(0, 4, 30)
    labels[:3], weights[:3] = [0, 1, 2], 1
    learner = RipperClassifier(random_state=0)
    weighted = clone(learner).fit(rows, labels, sample_weight=weights)
    repeated = clone(learner).fit(np.repeat(rows, weights, axis=0), np.repeat(labels, weights))
    assert weighted.rules_ == repeated.rules_


def test_missing_values_fulfil_no_condition() -> None:
    rng = np.random.default_rng(2)
    rows = rng.random((400, 2))
    labels = (rows[:, 0] >= 0.7).astype(int)
    rows[::5, 0] = np.nan
    labels[::5] = 0
    learner = RipperClassifier(random_state=0).fit(rows, labels)
    assert learner.score(rows, labels) > 0.99
    assert learner.predict([[np.nan, 0.9]]).tolist() == [0]
    assert learner.predict([[0.9, np.nan]]).tolist() == [1]


def test_few_distinct_rows_are_learned() -> None:
    rows = [[0.0, 5.0], [1.0, 5.0]] * 5
    learner = RipperClassifier(random_state=0).fit(rows, [0, 1] * 5)
    assert learner.predict(rows).tolist() == [0, 1] * 5


def test_seed_decides() -> None:
    data = Data("keepaway_hand_noise15_n100")
    fit = [RipperClassifier(random_state=seed).fit(data.rows, data.labels).rules_ for seed in (1, 1, 2)]
    assert fit[0] == fit[1]
    assert fit[0] != fit[2]


def test_without_pruning_rules_fit_the_training_rows() -> None:
    data = Data("keepaway_hand_noise05_n300")
    grown = RipperClassifier(prune=False, random_state=0).fit(data.rows, data.labels)
    pruned = RipperClassifier(random_state=0).fit(data.rows, data.labels)
    assert grown.score(data.rows, data.labels) > pruned.score(data.rows, data.labels)
    assert len(grown.rules_) > len(pruned.rules_)


def test_single_class_gives_the_default_rule() -> None:
    learner = RipperClassifier().fit([[1.0], [2.0], [3.0]], ["hold"] * 3)
    assert learner.rules_ == (RipperRule((), 0, (3.0,)),)


def test_rule_that_covers_nothing_predicts_its_class() -> None:
    assert RipperRule((), 1, (0.0, 0.0)).distribution == (0.0, 1.0)
    assert RipperRule((), 1, (0.0, 0.0)).prediction == 1


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"folds": 1}, "folds == 1, must be >= 2"),
        ({"folds": 2.5}, "folds must be an instance of"),
        ({"min_weight": -1.0}, "min_weight == -1.0, must be >= 0"),
        ({"optimizations": -1}, "optimizations == -1, must be >= 0"),
        ({"prune": "no"}, "prune must be an instance of"),
        ({"folds": 5}, "n_samples = 4 rows of positive weight are too few: RIPPER needs at least folds = 5"),
    ],
)
def test_errors_name_what_would_be_right(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        RipperClassifier(**parameters).fit([[1.0], [2.0], [3.0], [4.0]], [0, 1, 0, 1])


def test_errors_about_data() -> None:
    learner = RipperClassifier()
    with pytest.raises(ValueError, match="infinity"):
        learner.fit([[1.0], [np.inf], [3.0]], [0, 1, 0])
    with pytest.raises(ValueError, match=r"sample_weight must be of shape \(3,\)"):
        learner.fit([[1.0], [2.0], [3.0]], [0, 1, 0], sample_weight=[1.0])
    with pytest.raises(ValueError, match="Negative values in sample_weight"):
        learner.fit([[1.0], [2.0], [3.0]], [0, 1, 0], sample_weight=[1.0, -1.0, 1.0])
    with pytest.raises(ValueError, match="1 names of features are needed, not 2"):
        learner.fit([[1.0], [2.0], [3.0]], [0, 1, 0]).to_text(["a", "b"])


def test_conditions_reject_nonsense() -> None:
    with pytest.raises(ValueError, match="'<=' or '>=', not '<'"):
        Condition(0, "<", 1.0)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="finite"):
        Condition(0, "<=", float("nan"))
    with pytest.raises(ValueError, match="0 or more, not -1"):
        Condition(-1, "<=", 1.0)
