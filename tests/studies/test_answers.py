"""Answers: what is taken, what is refused, and in what words it is kept."""

from __future__ import annotations

import pytest
from multidict import MultiDict

from rcss_hat.studies.answers import read_answers
from rcss_hat.studies.parts import PeopleStudy, QuestionsStep


@pytest.fixture
def about(small: PeopleStudy) -> QuestionsStep:
    step = next(s for s in small.steps if s.name == "about")
    assert isinstance(step, QuestionsStep)
    return step


def test_options_are_kept_in_the_first_language(about: QuestionsStep) -> None:
    form = MultiDict(
        [("often", "0"), ("age", "30"), ("which", "2"), ("which", "0"), ("which", "2"), ("words", " ä\r\nb ")]
    )
    answers, wrong = read_answers(about, form, "en")
    assert answers == {"often": "never", "age": 30, "which": ["c", "a"], "words": "ä\nb"}
    assert not wrong


def test_what_may_be_left_out_is_none(about: QuestionsStep) -> None:
    answers, wrong = read_answers(about, MultiDict([("often", "1"), ("age", "  ")]), "en")
    assert answers == {"often": "often", "age": None, "which": [], "words": None}
    assert not wrong


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("often", "2", "missing"), ("often", "-1", "missing"), ("often", "never", "missing"), ("often", "", "missing"),
        ("often", "9" * 5000, "missing"), ("age", "17", "out_of_range"), ("age", "nan", "no_number"),
        ("age", "inf", "no_number"), ("age", "1e400", "no_number"), ("age", "old", "no_number"),
        ("words", "x" * 11, "too_long"), ("which", "7", "missing"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(about: QuestionsStep, name: str, value: str, code: str) -> None:
    form = MultiDict({"often": "1", name: value})
    answers, wrong = read_answers(about, form, "en")
    assert wrong[name].code == code and name not in answers


def test_scales_take_their_points_only(small: PeopleStudy) -> None:
    step = next(s for s in small.steps if s.name == "load")
    assert isinstance(step, QuestionsStep)
    form = MultiDict({q.name: "55" for q in step.question})
    answers, wrong = read_answers(step, form, "en")
    assert set(answers.values()) == {55} and not wrong
    _, wrong = read_answers(step, MultiDict({**form, "tlx-mental": "53"}), "en")
    assert list(wrong) == ["tlx-mental"]
