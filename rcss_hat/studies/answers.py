"""What participants answer: read from a form, checked against the questions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

from rcss_hat.studies.parts import Question, QuestionsStep, said


class Form(Protocol):
    """A form that was sent: fields by name, some of them more than once."""

    def getall(self, key: str, default: list[Any]) -> list[Any]:
        """Return all values of a field."""


class NotAnswered(ValueError):
    """An answer that cannot be taken.

    Attributes
    ----------
    code : str
        Of the text that says so, see ``texts/en.toml``.
    values : dict
        What belongs into that text.
    """

    def __init__(self, code: str, **values: Any) -> None:
        super().__init__(code)
        self.code, self.values = code, values


def read_answers(step: QuestionsStep, form: Form, first: str) -> tuple[dict[str, Any], dict[str, NotAnswered]]:
    """Read the answers of a form; ``first``: the study's first language, in which options are kept.

    Returns
    -------
    dict
        Answers by the questions' names; None: not answered.
    dict
        What is wrong, by the names of the questions concerned.
    """
    answers: dict[str, Any] = {}
    wrong: dict[str, NotAnswered] = {}
    for question in step.question:
        given = [value for value in form.getall(question.name, []) if isinstance(value, str) and value.strip()]
        try:
            answers[question.name] = _answer(question, given, first)
        except NotAnswered as problem:
            wrong[question.name] = problem
    return answers, wrong


def options(question: Question, first: str) -> list[str]:
    """Return the options of a choice as they are kept."""
    return [said(option, first, first) for option in question.options]


def _answer(question: Question, given: Sequence[str], first: str) -> Any:
    if question.kind == "choice" and question.several:
        return [_option(question, value, first) for value in dict.fromkeys(given)]
    if not given:
        if question.required:
            raise NotAnswered("missing")
        return None
    if question.kind == "choice":
        return _option(question, given[0], first)
    if question.kind == "text":
        text = given[0].replace("\r\n", "\n").strip()
        if len(text) > question.longest:
            raise NotAnswered("too_long", longest=question.longest)
        return text.encode("utf-8", "replace").decode()
    return _number(question, given[0])


def _option(question: Question, value: str, first: str) -> str:
    known = options(question, first)
    if not value.isdecimal() or len(value) > 4 or int(value) >= len(known):
        raise NotAnswered("missing")
    return known[int(value)]


def _number(question: Question, text: str) -> float | int:
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        raise NotAnswered("no_number") from None
    low = -1e12 if question.min is None else question.min
    high = 1e12 if question.max is None else question.max
    if not math.isfinite(value):
        raise NotAnswered("no_number")
    if not low <= value <= high:
        raise NotAnswered("out_of_range", low=f"{low:g}", high=f"{high:g}")
    if question.kind == "scale":
        nearest = min(question.points, key=lambda point: abs(point - value))
        if abs(nearest - value) > 1e-6:
            raise NotAnswered("missing")
        value = nearest
    return int(value) if value == int(value) else value
