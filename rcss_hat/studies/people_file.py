"""Studies with people in TOML files that are copied and changed, and those of the package.

The file has these parts; `load_people` checks every name and value, and `rcss_hat/studies/conditions/people.toml` is
the model to copy. `rcss_hat.studies.parts` says what each may hold.

``title``, ``description``, ``seed``, ``participants``, ``design``, ``languages``
    ``seed`` decides who is assigned to what, and all matches.
``[game]``
    What is played where nothing else is said, see `GameOptions`.
``[[condition]]``
    What participants are assigned to in balanced blocks, see `Condition`. Without any there is one, "all".
``[[step]]``
    What every participant goes through, in this order; ``kind`` says what it is, see `STEPS`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.policy import FIXED
from rcss_hat.inputs import FileFormatError, check_name, excerpt, read_text
from rcss_hat.keepaway.decision import PERSON
from rcss_hat.schema import MAX_TOML, did_you_mean, parse_toml, read, toml_text
from rcss_hat.studies.parts import (
    STEPS,
    Condition,
    EndStep,
    GameOptions,
    PeopleFile,
    PeopleStudy,
    Question,
    QuestionsStep,
    Text,
    TextStep,
)
from rcss_hat.studies.plan import plan_of

EVERYBODY = "all"
"""Name of the condition of a study that names none."""


class PeopleError(ValueError):
    """A study with people that is not valid; the message names the place and what would be right."""


def people_names() -> list[str]:
    """Names of the studies in the package."""
    return _names("conditions")


def people_text(name_or_path: str) -> tuple[str, Path]:
    """Return the text of a study of the package, or of a file, and the folder its file names are relative to.

    Raises
    ------
    PeopleError
        When there is none.
    """
    try:
        return toml_text(name_or_path, "rcss_hat.studies", people_names())
    except FileFormatError as problem:
        raise PeopleError(str(problem)) from problem


def load_people(name_or_path: str) -> PeopleStudy:
    """Read a study with people, of the package or from a TOML file.

    Raises
    ------
    PeopleError
        Naming the place and what would be right.
    """
    text, folder = people_text(name_or_path)
    try:
        return parse_people(text, folder)
    except PeopleError as problem:
        raise PeopleError(f"{name_or_path}: {problem}") from problem


def parse_people(text: str, folder: Path) -> PeopleStudy:
    """Read a study with people from the text of its file; ``folder``: what file names in it are relative to.

    Raises
    ------
    PeopleError
    """
    try:
        data = parse_toml(text)
    except FileFormatError as problem:
        raise PeopleError(f"not valid TOML: {problem}") from problem
    try:
        study = _study(read(PeopleFile, data, "the study"), folder)
    except FileFormatError as problem:
        raise PeopleError(str(problem)) from problem
    _check(study)
    return study


def _study(file: PeopleFile, folder: Path) -> PeopleStudy:
    if not file.languages or len(set(file.languages)) != len(file.languages):
        raise PeopleError("languages: name each language once, the first one first")
    conditions = tuple(
        read(Condition, _with_rules(entry, where, folder), where)
        for where, entry in ((_where(entry, "condition", k), entry) for k, entry in enumerate(file.condition, 1))
    )
    _check_names((c.name for c in conditions), "conditions")
    steps = tuple(_step(entry, k, folder) for k, entry in enumerate(file.step, 1))
    return PeopleStudy(
        title=file.title,
        description=file.description,
        seed=file.seed,
        participants=file.participants,
        design=file.design,
        languages=file.languages,
        game=read(GameOptions, _with_rules(file.game, "[game]", folder), "[game]"),
        conditions=conditions or (Condition(name=EVERYBODY),),
        steps=steps,
    )


def _where(entry: Any, what: str, number: int) -> str:
    if isinstance(entry, dict) and "name" in entry:
        return f"{what} {check_name(entry['name'], f'{what} {number}: name')!r}"
    return f"{what} {number}"


def _step(entry: Any, number: int, folder: Path) -> Any:
    where = _where(entry, "step", number)
    if not isinstance(entry, dict):
        raise PeopleError(f"{where} must be a table, not {excerpt(entry)}")
    kind = entry.get("kind")
    if not isinstance(kind, str) or kind not in STEPS:
        suggestion = did_you_mean(str(kind), STEPS)
        raise PeopleError(f"{where}: kind must be one of {', '.join(STEPS)}, not {excerpt(kind)}{suggestion}")
    entry = _with_rules(_with_files(entry, where, folder), where, folder)
    if kind == "questions":
        return _questions(entry, where)
    return read(STEPS[kind], entry, where)


def _with_files(entry: dict[str, Any], where: str, folder: Path) -> dict[str, Any]:
    """Put the texts of files, named by ``file`` alone or by language, where texts belong."""
    if "file" not in entry:
        return entry
    if "text" in entry:
        raise PeopleError(f"{where} has both text and file: give one")
    named = entry["file"]
    try:
        if isinstance(named, dict):
            text: Any = {language: _file_text(folder, name, where) for language, name in named.items()}
        else:
            text = _file_text(folder, named, where)
    except FileFormatError as problem:
        raise PeopleError(f"{where}: {problem}") from problem
    return {**{name: value for name, value in entry.items() if name != "file"}, "text": text}


def _with_rules(entry: Any, where: str, folder: Path) -> Any:
    """Put the decision list of a file, named by ``keepers``, where its name is: a study keeps all that it needs."""
    named = entry.get("keepers") if isinstance(entry, dict) else None
    if not isinstance(named, str) or named in (PERSON, *FIXED) or named.startswith("{"):
        return entry
    try:
        return {**entry, "keepers": DecisionList.load(folder / named).to_json()}
    except (OSError, ValueError) as problem:
        known = [PERSON, *FIXED]
        raise PeopleError(
            f"{where}: keepers must be one of {', '.join(known)} or the file of a decision list, not "
            f"{excerpt(named)}{did_you_mean(named, known)} ({problem})"
        ) from problem


def _file_text(folder: Path, name: Any, where: str) -> str:
    if not isinstance(name, str):
        raise PeopleError(f"{where}: file must be the name of a file, not {excerpt(name)}")
    return read_text(folder / name, "text", MAX_TOML)


def _questions(entry: dict[str, Any], where: str) -> QuestionsStep:
    own = entry.get("question", ())
    if not isinstance(own, list | tuple):
        raise PeopleError(f"{where}: question must be a list of tables, [[step.question]]")
    entries = [*_questionnaire(entry.get("use", ""), where), *own]
    asked = tuple(read(Question, q, f"{where}, {_where(q, 'question', k)}") for k, q in enumerate(entries, 1))
    if not asked:
        raise PeopleError(f"{where} needs questions: [[step.question]], or use")
    _check_names((q.name for q in asked), f"questions in {where}")
    rest = {name: value for name, value in entry.items() if name != "question"}
    step: QuestionsStep = read(QuestionsStep, rest, where)
    return QuestionsStep(
        name=step.name, title=step.title, per_condition=step.per_condition, text=step.text, use=step.use, question=asked
    )


def _questionnaire(name: Any, where: str) -> list[Any]:
    if name == "":
        return []
    known = _names("questions")
    if name not in known:
        raise PeopleError(f"{where}: use must be one of {', '.join(known)}, not {excerpt(name)}")
    text = (files("rcss_hat.studies") / "questions" / f"{name}.toml").read_text(encoding="utf-8")
    found: list[Any] = parse_toml(text)["question"]
    return found


def _names(folder: str) -> list[str]:
    entries = (files("rcss_hat.studies") / folder).iterdir()
    return sorted(entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml"))


# -- what belongs together -----------------------------------------------------------------------------------------


def _check_names(names: Iterable[str], what: str) -> None:
    seen = set()
    for name in names:
        if name.lower() in seen:  # they become files, and some file systems do not tell case apart
            raise PeopleError(f"there are two {what} {name!r}")
        seen.add(name.lower())


def _check(study: PeopleStudy) -> None:
    if not study.steps or not isinstance(study.steps[-1], EndStep):
        raise PeopleError("the last step must be of kind end: what participants see when they are done")
    for step in study.steps[:-1]:
        if isinstance(step, EndStep):
            raise PeopleError(f"step {step.name!r}: only the last step is of kind end")
    _check_names((step.name for step in study.steps), "steps")
    if study.steps[-1].per_condition:
        raise PeopleError("the last step comes once: it cannot be per_condition")
    for what, text in _texts(study):
        _check_text(what, text, study)
    with _as_error():
        for place in range(1, 1 + len(study.conditions)):
            names = [planned.name for planned in plan_of(study, place)]
            _check_names(names, "steps of a participant")
            for name in names:
                if name.startswith(("participant", "journal")):
                    raise PeopleError(f"step {name!r}: names that begin with participant or journal are files of ours")


@contextmanager
def _as_error() -> Iterator[None]:
    try:
        yield
    except PeopleError:
        raise
    except ValueError as problem:
        raise PeopleError(str(problem)) from problem


def _texts(study: PeopleStudy) -> Iterator[tuple[str, Text]]:
    yield "title", study.title
    for step in study.steps:
        where = f"step {step.name!r}"
        yield f"{where}: title", step.title
        if isinstance(step, TextStep | EndStep | QuestionsStep):
            yield f"{where}: text", step.text
        if isinstance(step, TextStep):
            yield f"{where}: agree", step.agree
        for question in step.question if isinstance(step, QuestionsStep) else ():
            for name in ("text", "hint", "low", "high"):
                yield f"{where}, question {question.name!r}: {name}", getattr(question, name)
            for option in question.options:
                yield f"{where}, question {question.name!r}: options", option


def _check_text(what: str, text: Text, study: PeopleStudy) -> None:
    if isinstance(text, dict) and study.language not in text:
        there = ", ".join(text) or "none"
        raise PeopleError(f"{what} has no text in {study.language!r}, the study's first language; there are {there}")
