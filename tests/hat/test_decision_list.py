"""Decision lists: the paper's rules, the printed form, files, and the kernel."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.hat.conditions import Condition, each_bound_once
from rcss_hat.hat.decision_list import (
    PAPER_RULES,
    DecisionList,
)
from rcss_hat.hat.ripper import RipperClassifier
from rcss_hat.hat.rule import Rule
from rcss_hat.hat.rule_rows import RULE_ROW, advise, deciding_row
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.decision import action_name
from rcss_hat.keepaway.state import n_state_variables, state_names

TASKS = st.sampled_from([(3, 2), (4, 3), (5, 4)])


@st.composite
def decision_lists(draw: st.DrawFn) -> DecisionList:
    keepers, takers = draw(TASKS)
    condition = st.builds(
        Condition,
        st.integers(0, n_state_variables(keepers, takers) - 1),
        st.sampled_from(["<=", ">="]),
        st.floats(allow_nan=False, allow_infinity=False) | st.integers(0, 20).map(float),
    )
    action = st.integers(0, keepers - 1)
    count = st.none() | st.lists(st.floats(0.0, 1e6), min_size=keepers, max_size=keepers).map(tuple)
    rule = st.builds(Rule, st.lists(condition, min_size=1, max_size=5).map(tuple), action, count)
    rules = draw(st.lists(rule, max_size=6).map(tuple))
    return DecisionList(rules, draw(action), keepers, takers, draw(count), title=draw(st.text(max_size=20)))


def states(decision_list: DecisionList, seed: int, n: int = 50) -> np.ndarray:
    """States around the thresholds of a list, many of them exactly on one, and some unknown."""
    rng = np.random.default_rng(seed)
    rows = rng.uniform(-5.0, 25.0, (n, len(decision_list.names)))
    bounds = [c.threshold for rule in decision_list.rules for c in rule.conditions]
    if bounds:
        exact = rng.random(rows.shape) < 0.5
        rows[exact] = rng.choice(bounds, exact.sum())
    rows[rng.random(rows.shape) < 0.05] = np.nan
    return rows


def naive(decision_list: DecisionList, state: np.ndarray) -> int:
    for rule in decision_list.rules:
        if all(
            state[c.feature] <= c.threshold if c.operator == "<=" else state[c.feature] >= c.threshold
            for c in rule.conditions
        ):
            return rule.action
    return decision_list.default_action


# --- the paper's rules ------------------------------------------------------------------------------------------


def paper_state(**values: float) -> list[float]:
    """A state in which no rule of the paper applies, but for the values given as ``s3=4.0``."""
    state = [5.0, 8.0, 12.0, 9.0, 9.0, 5.0, 5.0, 8.0, 8.0, 5.0, 5.0, 20.0, 20.0]
    for name, value in values.items():
        state[int(name[1:])] = value
    return state


@pytest.mark.parametrize(
    ("values", "action"),
    [
        ({}, 0),
        ({"s11": 75.0, "s3": 5.99}, 1),
        ({"s11": 74.84, "s3": 5.99}, 1),
        ({"s11": 76.26, "s3": 5.99}, 1),
        ({"s11": 76.27, "s3": 5.99}, 0),
        ({"s11": 75.0, "s3": 6.0}, 0),
        ({"s11": 53.97, "s4": 5.91, "s0": 8.45, "s8": 7.06}, 1),
        ({"s11": 53.97, "s4": 5.91, "s0": 8.44, "s8": 7.06}, 0),
        ({"s3": 4.84, "s0": 7.33, "s12": 43.66, "s8": 5.57}, 2),
        ({"s3": 4.84, "s0": 7.33, "s12": 43.66, "s8": 5.58}, 0),
        ({"s3": 4.84, "s0": 8.45, "s12": 43.66, "s8": 5.57, "s11": 60.0, "s4": 5.0}, 1),
    ],
)
def test_rules_of_the_paper(values: dict[str, float], action: int) -> None:
    state = paper_state(**values)
    assert PAPER_RULES(state) == action
    assert advise(PAPER_RULES.to_arrays(), np.array(state)) == action


def test_rules_of_the_paper_are_printed_as_in_the_paper() -> None:
    assert len(PAPER_RULES) == 4
    assert PAPER_RULES.format(comments=False).splitlines() == [
        "if (state_11 >= 74.84 and state_3 <= 5.99 and state_11 <= 76.26) -> Action = 1",
        "elseif (state_11 >= 53.97 and state_4 <= 5.91 and state_0 >= 8.45 and state_8 <= 7.06) -> Action = 1",
        "elseif (state_3 <= 4.84 and state_0 >= 7.33 and state_12 >= 43.66 and state_8 <= 5.57) -> Action = 2",
        "else -> Action = 0",
    ]


def test_comments_name_action_and_variables() -> None:
    first, *_, last = PAPER_RULES.format().splitlines()
    names = state_names(3, 2)
    assert first.endswith(f"# PASS1; state_11 = {names[11]}; state_3 = {names[3]}")
    assert last.endswith("# Hold")
    assert len({line.index("#") for line in PAPER_RULES.format().splitlines()}) == 1


# --- one meaning in all forms -----------------------------------------------------------------------------------


@given(decision_lists(), st.integers(0, 10**6))
def test_kernel_rows_and_calls_agree(decision_list: DecisionList, seed: int) -> None:
    rows = states(decision_list, seed)
    arrays = decision_list.to_arrays()
    assert arrays.dtype == RULE_ROW
    expected = [naive(decision_list, row) for row in rows]
    assert [decision_list(row) for row in rows] == expected
    assert [advise(arrays, row) for row in rows] == expected
    assert decision_list.predict(rows).tolist() == expected
    confidence = [arrays["confidence"][deciding_row(arrays, row)] for row in rows]
    assert confidence == [decision_list.match(row).confidence for row in rows]


def test_kernel_is_compiled_once_for_all_lists() -> None:
    for decision_list in (PAPER_RULES, DecisionList((), 2, 5, 4)):
        advise(decision_list.to_arrays(), np.zeros(len(decision_list.names)))
    signatures = getattr(advise, "signatures", None)
    if signatures is not None:
        assert len(signatures) == 1


@given(decision_lists())
def test_text_reads_back(decision_list: DecisionList) -> None:
    for comments in (True, False):
        again = DecisionList.parse(decision_list.format(comments), decision_list.keepers, decision_list.takers)
        assert again.default_action == decision_list.default_action
        assert [(rule.conditions, rule.action) for rule in again.rules] == [
            (each_bound_once(rule.conditions), rule.action) for rule in decision_list.rules
        ]


@given(decision_lists(), st.integers(0, 10**6))
def test_what_is_printed_decides_the_same(decision_list: DecisionList, seed: int) -> None:
    rows = states(decision_list, seed)
    again = DecisionList.parse(decision_list.format(), decision_list.keepers, decision_list.takers)
    assert again.predict(rows).tolist() == decision_list.predict(rows).tolist()


def test_each_bound_is_printed_once() -> None:
    rules = DecisionList.parse(
        "if (state_3 <= 5 and state_1 >= 2 and state_3 <= 4 and state_3 >= 1 and state_3 <= 4) -> Action = 1\n"
        "else -> Action = 0"
    )
    assert rules.format(comments=False).startswith("if (state_3 <= 4 and state_1 >= 2 and state_3 >= 1) -> Action = 1")
    assert len(rules.rules[0].conditions) == 5  # what was learned is kept


@pytest.mark.parametrize(
    ("operator", "threshold", "printed"),
    [
        ("<=", 4.999999999999999, "< 5"),
        (">=", 49.00000000000001, "> 49"),
        ("<=", 5.0, "<= 5"),
        ("<=", 4.98765, "<= 4.98765"),
        ("<=", 1.7976931348623157e308, "<= 1.7976931348623157e+308"),
    ],
)
def test_thresholds_are_as_short_as_they_can_be(operator: str, threshold: float, printed: str) -> None:
    rules = DecisionList((Rule((Condition(3, operator, threshold),), 1),))  # type: ignore[arg-type]
    assert rules.format(comments=False).startswith(f"if (state_3 {printed}) -> Action = 1")
    assert DecisionList.parse(rules.format()).rules[0].conditions[0].threshold == threshold


@given(decision_lists(), st.integers(0, 10**6))
def test_a_shortened_list_decides_the_states_alike(decision_list: DecisionList, seed: int) -> None:
    rows = states(decision_list, seed)
    short = decision_list.shortened(rows)
    assert short.predict(rows).tolist() == decision_list.predict(rows).tolist()


def test_shortened_thresholds_need_not_be_exact() -> None:
    rows = np.full((3, 13), 5.0)
    rows[:, 3] = [3.8034, 4.5, 6.0]
    rules = DecisionList((Rule((Condition(3, "<=", 3.803429424718979),), 1),))
    assert rules.shortened(rows).format(comments=False).startswith("if (state_3 <= 4) -> Action = 1")


@given(decision_lists())
def test_json_reads_back_to_the_last_bit(decision_list: DecisionList) -> None:
    assert DecisionList.from_json(decision_list.to_json()) == decision_list


def test_rounded_print() -> None:
    decision_list = DecisionList((Rule((Condition(3, "<=", 4.98765),), 1),))
    assert decision_list.format(comments=False, digits=2).startswith("if (state_3 <= 4.99) -> Action = 1")


def test_other_spellings_are_understood() -> None:
    text = """
    # from the paper's page
    IF (state_{11} ≥ 74.84 AND
        state3 ≤ 5.99)   → Action = PASS1
    else if (state_0 >= -1e-3) => action=2   # far
    elif (state_0 >= .5) -> Action = 1
    ELSE -> Action = Hold
    """
    assert DecisionList.parse(text) == DecisionList(
        (
            Rule((Condition(11, ">=", 74.84), Condition(3, "<=", 5.99)), 1),
            Rule((Condition(0, ">=", -0.001),), 2),
            Rule((Condition(0, ">=", 0.5),), 1),
        ),
        0,
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"line 1: expected 'if \(' or 'else ->', found the end of the text"),
        ("when (state_1 <= 2)", r"line 1: expected 'if \(' or 'else ->', found 'when'"),
        ("if state_1 <= 2", r"line 1: expected '\(', found 'state_1'"),
        ("if (state_1 & 2) -> Action = 1", "line 1: '&' has no meaning in rules"),
        ("if (dist <= 2)", "line 1: expected a state variable, for example state_3, found 'dist'"),
        ("if (state_1 <= x)", "line 1: expected a number, found 'x'"),
        ("if (state_1 = 3)", "line 1: expected '<=' or '>=', found '='"),
        ("if (state_1 <= 2 or state_2 >= 1)", r"line 1: expected 'and' or '\)', found 'or'"),
        ("if (state_1 <= 2)\nAction = 1", "line 2: expected '->', found 'Action'"),
        ("if (state_1 <= 2) -> Action = 1.5", "line 1: expected a whole number, Hold, PASS1, ..., found '1.5'"),
        ("if (state_1 <= 2) -> Action = shoot", "line 1: expected a whole number, Hold, PASS1, ..., found 'shoot'"),
        ("if (state_1 <= 2) -> Action = 1", "line 1: expected 'elseif .' or 'else ->', found the end of the text"),
        ("else -> Action = 0\nelse -> Action = 1", "line 2: expected nothing more after the default action"),
        ("if (state_13 <= 2) -> Action = 1 else -> Action = 0", "rule 1: 3v2 has state_0 to state_12, not state_13"),
        ("else -> Action = 3", "the default rule: 3v2 has the actions 0 to 2, not 3"),
        (f"else -> Action = {'9' * 5000}", "line 1: '9999.* does not exist"),
        (f"if (state_{'9' * 5000} <= 1) -> Action = 0", "line 1: 'state_9999.* does not exist"),
        ("if (state_1 <= 1e999) -> Action = 1 else -> Action = 0", "line 1: .* must be finite"),
    ],
)
def test_errors_of_the_text_name_line_and_expectation(text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        DecisionList.parse(text)


JRIP = """JRIP rules:
===========

(state_11 >= 74.84) and (state_3 <= 5.99) => Action=1 (30.0/2.0)
(state_12 >= 60) and (state_3 <= 4.1) => Action=2 (12.0/3.0)
 => Action=0 (400.0/12.0)

Number of Rules : 3
"""
"""As Weka 3 prints what JRip learned from the ARFF export."""


def test_jrip_text_is_read_with_its_weights() -> None:
    rules = DecisionList.parse(JRIP)
    assert rules.rules[0].conditions == (Condition(11, ">=", 74.84), Condition(3, "<=", 5.99))
    assert [rule.action for rule in rules] == [1, 2, 0]
    assert [sum(rule.counts) for rule in rules] == [30.0, 12.0, 400.0]
    assert [rule.precision for rule in rules] == [28 / 30, 9 / 12, 388 / 400]
    assert rules.rules[0].confidence == 29 / 33


@pytest.mark.parametrize(
    "text",
    [
        f"=== Run information ===\n\nScheme: weka.classifiers.rules.JRip\n\n{JRIP}\nTime taken: 0.1 s\n=== Summary",
        JRIP.partition("\n\n")[2].partition("\nNumber")[0],
        JRIP.replace("Action=", "class=").replace("state_", "s").replace("class=2", "class=PASS2"),
        JRIP.replace("\n", "\r\n").replace("\r\n", "\n"),
    ],
)
def test_jrip_text_with_more_or_less_around_it(text: str) -> None:
    assert DecisionList.parse(text) == DecisionList.parse(JRIP)


def test_what_our_own_classifier_prints_like_jrip_is_read() -> None:
    rng = np.random.default_rng(3)
    rows = rng.uniform(0.0, 20.0, (300, 13))
    classifier = RipperClassifier(random_state=1).fit(rows, (rows[:, 3] > 9.0).astype(int) + (rows[:, 5] > 15.0))
    read = DecisionList.parse(classifier.to_text())
    learned = DecisionList.from_classifier(classifier)
    assert [rule.action for rule in read] == [rule.action for rule in learned]
    for ours, theirs in zip(read, learned, strict=True):
        assert sum(ours.counts) == pytest.approx(sum(theirs.counts))
        assert ours.confidence == pytest.approx(theirs.confidence)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (": 3", ": 4", "it says that there are 4 rules, but has 3"),
        (" => Action=0 (400.0/12.0)", "", "line 8: expected .*as JRip prints rules, found the end of the text"),
        ("(12.0/3.0)", "(12.0/30.0)", "line 5: .12.0/30.0. must be the weight a rule covers"),
        ("Action=2", "Action=3", "rule 2: 3v2 has the actions 0 to 2, not 3"),
        ("(state_12 >= 60) and", "(state_12 = 60) and", "line 5: expected '<=' or '>=', found '='"),
        ("(state_12 >= 60)", "(state_12 >= 60", r"line 5: expected '\)', found 'and'"),
    ],
)
def test_errors_of_jrip_text_name_the_line(old: str, new: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        DecisionList.parse(JRIP.replace(old, new))


# --- files ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rules.json", "deeper/rules.txt"])
def test_save_and_load(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    PAPER_RULES.save(path)
    again = DecisionList.load(path)
    assert again.rules == PAPER_RULES.rules
    assert again.default_action == 0
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_json_is_open() -> None:
    content = json.loads(PAPER_RULES.to_json())
    assert content["format"] == "rcss-hat decision list"
    assert content["version"] == 1
    assert content["actions"] == ["Hold", "PASS1", "PASS2"]
    assert content["variables"] == list(state_names(3, 2))
    assert content["rules"][0] == {
        "if": [
            {"variable": 11, "operator": ">=", "threshold": 74.84},
            {"variable": 3, "operator": "<=", "threshold": 5.99},
            {"variable": 11, "operator": "<=", "threshold": 76.26},
        ],
        "action": 1,
        "counts": None,
    }


def edited(**changes: object) -> str:
    return json.dumps(json.loads(PAPER_RULES.to_json()) | changes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "line 1, column 2: not JSON"),
        (edited(format="other"), "\"format\" must be 'rcss-hat decision list', not 'other'"),
        (edited(version=2), '"version" must be 1 to 1 for this program, not 2'),
        (edited(rules={}), "'rules' must be list, not {}"),
        (edited(rules=[{}]), "rule 1: 'if' is missing"),
        (edited(rules=[{"if": [{"variable": True}], "action": 0}]), "rule 1: 'variable' must be int, not True"),
        (
            edited(rules=[{"if": [{"variable": 1, "operator": "<", "threshold": 1}], "action": 0}]),
            "rule 1: the operator of a condition must be '<=' or '>=', not '<'",
        ),
        (edited(rules=[{"if": [], "action": 0}]), "rule 1 has no condition"),
        (edited(default={"action": "Hold"}), "default: 'action' must be int, not 'Hold'"),
        (edited(default={"action": 7}), "the default rule: 3v2 has the actions 0 to 2, not 7"),
        (edited(default={"action": 0, "counts": [1]}), "the default rule: counts must be 3 numbers"),
        (edited(default={"action": 0, "counts": "many"}), "default: 'counts' must be a list of numbers or null"),
        (edited(variables=["a"]), "3v2 has 13 state variables, but 1 names were given"),
    ],
)
def test_errors_of_a_file_name_it_and_the_place(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "rules.json"
    path.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        DecisionList.load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


def test_missing_or_unreadable_file(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"none\.json: there is no such decision list"):
        DecisionList.load(tmp_path / "none.json")
    with pytest.raises(FileFormatError, match="is a folder, not a decision list"):
        DecisionList.load(tmp_path)
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileFormatError, match="is not UTF-8 text"):
        DecisionList.load(tmp_path / "binary")


def test_failed_save_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rules.json"
    PAPER_RULES.save(path)
    before = path.read_text()

    def full_disk(_: int) -> None:
        raise OSError("no space left")

    monkeypatch.setattr("rcss_hat.system.files.os.fsync", full_disk)
    with pytest.raises(OSError, match="no space left"):
        DecisionList((), 1).save(path)
    assert path.read_text() == before
    assert [p.name for p in tmp_path.iterdir()] == ["rules.json"]


# --- from the learner -------------------------------------------------------------------------------------------


def test_from_classifier_keeps_rules_counts_and_predictions() -> None:
    rng = np.random.default_rng(1)
    rows = rng.uniform(0.0, 20.0, (400, 13))
    actions = PAPER_RULES.predict(rows) * 0 + np.where(rows[:, 3] <= 4.0, np.where(rows[:, 11] >= 10, 2, 1), 0)
    learner = RipperClassifier(random_state=0).fit(rows, actions)
    decision_list = DecisionList.from_classifier(learner, title="test")
    assert (decision_list.predict(rows) == learner.predict(rows)).all()
    assert len(decision_list) == len(learner.rules_)
    assert sum(sum(rule.counts or ()) for rule in decision_list) == 400
    rule = decision_list.rules[0]
    assert rule.counts is not None
    assert rule.precision == rule.counts[rule.action] / sum(rule.counts)
    assert rule.confidence == (rule.counts[rule.action] + 1) / (sum(rule.counts) + 3)


def test_from_classifier_fills_in_actions_never_seen() -> None:
    rows = np.zeros((10, 13))
    rows[:5, 3] = 1.0
    learner = RipperClassifier(random_state=0).fit(rows, [2] * 5 + [0] * 5)
    decision_list = DecisionList.from_classifier(learner)
    assert {rule.action for rule in decision_list} <= {0, 2}
    assert all(len(rule.counts or ()) == 3 for rule in decision_list)
    assert decision_list(np.eye(13)[3]) == 2


def test_from_classifier_rejects_what_is_no_policy() -> None:
    rows = np.arange(39.0).reshape(3, 13)
    for labels in (["hold", "hold", "pass"], [0, 1, 3], [0.5, 0.5, 1.0]):
        learner = RipperClassifier()
        learner.classes_ = np.unique(labels)
        with pytest.raises(ValueError, match="the classes must be actions, whole numbers 0 to 2"):
            DecisionList.from_classifier(learner)
    with pytest.raises(ValueError, match="4v3 has 19 state variables, but the classifier was fitted to 13"):
        DecisionList.from_classifier(RipperClassifier().fit(rows, [0, 0, 1]), 4, 3)


# --- values -----------------------------------------------------------------------------------------------------


def test_state_of_the_wrong_length_is_an_error() -> None:
    with pytest.raises(ValueError, match="3v2 has 13 state variables, not 12"):
        PAPER_RULES(np.zeros(12))
    with pytest.raises(ValueError, match=r"states must be of shape \(n, 13\) for 3v2, not \(13,\)"):
        PAPER_RULES.predict(np.zeros(13))


def test_rule_without_counts() -> None:
    rule = Rule((), 0)
    assert rule.precision is None
    assert rule.confidence == 1.0
    assert Rule((), 0, (0.0, 0.0, 0.0)).precision is None
    assert math.isclose(Rule((), 0, (0.0, 0.0, 0.0)).confidence, 1 / 3)


def test_names_of_actions() -> None:
    assert [action_name(k) for k in range(3)] == ["Hold", "PASS1", "PASS2"]


def test_lists_are_immutable() -> None:
    with pytest.raises(AttributeError):
        PAPER_RULES.default_action = 1  # type: ignore[misc]
