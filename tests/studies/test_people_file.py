"""The file of a study with people: what it may hold, and what is said of mistakes."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from rcss_hat.studies.parts import PeopleStudy, QuestionsStep
from rcss_hat.studies.people_file import PeopleError, load_people, parse_people, people_names

from .conftest import SMALL

TEXT = SMALL.read_text()


def changed(old: str, new: str) -> str:
    assert TEXT.count(old) >= 1
    return TEXT.replace(old, new, 1)


def test_the_packages_study_is_the_papers_design() -> None:
    assert "people" in people_names()
    study = load_people("people")
    assert [c.name for c in study.conditions] == ["normal", "fast", "limited"]
    assert study.game.episodes == 20


def test_a_study_survives_its_own_file(small: PeopleStudy) -> None:
    assert msgspec.json.decode(msgspec.json.encode(small), type=PeopleStudy) == small


def test_a_questionnaire_of_the_package_comes_with_its_questions(small: PeopleStudy) -> None:
    step = next(s for s in small.steps if s.name == "load")
    assert isinstance(step, QuestionsStep)
    assert [len(q.points) for q in step.question] == [21] * 6


def test_texts_may_be_files(tmp_path: Path) -> None:
    (tmp_path / "consent.md").write_text("From a file")
    old = 'text = { en = "We keep *keys*. <b>x</b>", de = "Wir behalten *Tasten*." }'
    study = parse_people(changed(old, 'file = "consent.md"'), tmp_path)
    assert study.steps[0].text == "From a file"  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("participants = 12", "participants = 0", "participants must be at least 1 and at most 10,000, not 0"),
        ("speed = 5", "speed = 50", "condition 'fast': speed must be a number from 0.1 to 20, not 50"),
        ("speed = 5", "sped = 5", "did you mean 'speed'?"),
        ('kind = "text"\nname', 'kind = "txt"\nname', "step 'consent': kind must be one of text, practice"),
        ('actions = ["hold", "pass1"]', 'actions = ["hold", "pass3"]', "there is no action 'pass3'; with 3 keepers"),
        ('actions = ["hold", "pass1"]', 'actions = ["hold"]', "actions need at least one pass"),
        ('use = "nasa-tlx"', 'use = "tlx"', "use must be one of nasa-tlx, not 'tlx'"),
        ('kind = "end"\nname = "thanks"\n', 'kind = "text"\nname = "thanks"\n', "has no entry 'code'"),
        ('name = "about"', 'name = "Play"', "there are two steps 'Play'"),
        ('name = "about"', 'name = "../x"', "name must consist of letters"),
        ("min = 18\nmax = 99", "min = 99\nmax = 18", "min must be less than max"),
        ('de = "Halten"', 'de = "Halten", fr = "Tenir"', ""),
        ('title = { en = "Keep it", de', "title = { fr", "title has no text in 'en', the study's first language"),
        ("episodes = 3\n", "", "needs episodes: how many games are played"),
        ('options = ["a", "b", "c"]', 'options = ["a"]', "a choice needs 2 to 50 options, not 1"),
        ('agree = "I agree"', 'agree = "I agree"\nfile = "x.md"', "step 'consent' has both text and file"),
        ("seed = 5", "seed = -5", "seed must be a whole number from 0"),
        ('title = { en', "title = [", "not valid TOML"),
    ],
)  # fmt: skip
def test_mistakes_are_named(old: str, new: str, said: str) -> None:
    if not said:
        parse_people(changed(old, new), Path())
        return
    with pytest.raises(PeopleError) as error:
        parse_people(changed(old, new), Path())
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_what_is_no_study_is_named() -> None:
    with pytest.raises(PeopleError, match="no study 'nothing': there are people, or give a TOML file"):
        load_people("nothing")
