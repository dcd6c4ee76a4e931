"""TOML with mistakes at random places: refused in one line, or still valid; never another exception."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from pathlib import Path

import click
import pytest

from rcss_hat.cli.train import Settings
from rcss_hat.experiments.study import StudyError
from rcss_hat.experiments.study_file import parse_study, study_text
from rcss_hat.hat.transfer import METHODS, make_method
from rcss_hat.learning.config import LearnerConfig, load_config

SMALL = (Path(__file__).parent / "small.toml").read_text()
LEARNER = "\n".join(f"{key} = {json.dumps(value)}" for key, value in LearnerConfig().to_dict().items())
TOKENS = (
    *("nan", "-inf", "1e309", "-1", "0", "1.5", "true", "''", "'x'", "'../../x'", "[]", "[[1]]", "{}", "{a = 1}"),
    *("1979-05-27", "07:32:00", "9" * 25, "0x" + "F" * 4000, "9" * 5000, "[" * 2000, "'\\u0000'", '"\\u202e"', "1_0"),
    *('"""', "[", "]", "}", "=", ".", "\n", "#", "\\", "\0", "é", "[[condition]]\n", "[sampling]\n", "name = 'x'\n"),
)


def damaged(text: str, chance: random.Random) -> str:
    """Make one to three mistakes, as typing errors and bad disks do."""
    for _ in range(chance.randint(1, 3)):
        place = chance.randrange(len(text) + 1)
        end = min(len(text), place + chance.choice((1, 1, 2, 5, 40)))
        lines = text.splitlines(keepends=True) or [""]
        kind = chance.randrange(6)
        if kind == 0:
            text = text[:place] + chance.choice(TOKENS) + text[end:]
        elif kind == 1:
            text = text[:place] + text[end:]
        elif kind == 2:
            text = (
                text[:place] + chr(chance.choice((chance.randrange(128), chance.randrange(0xD800)))) + text[place + 1 :]
            )
        elif kind == 3:
            lines.insert(chance.randrange(len(lines)), chance.choice(lines))
            text = "".join(lines)
        else:  # most: another value where there is one
            values = list(re.finditer(r"(?<== )[^,}\n]+", text))
            if values:
                value = chance.choice(values)
                text = text[: value.start()] + chance.choice(TOKENS) + text[value.end() :]
    return text


def study(text: str, chance: random.Random) -> None:
    parse_study(damaged(text, chance), Path()).scaled(hours=chance.choice((None, 1.0, 1e300)))


@pytest.mark.parametrize("name", ["small", "rounds"])
def test_damaged_studies_are_refused_in_one_line(name: str) -> None:
    chance = random.Random(name)
    text = SMALL if name == "small" else study_text(name)[0]
    assert 100 < refusals(700, StudyError, lambda: study(text, chance)) < 700


def test_damaged_learners_are_refused_in_one_line(tmp_path: Path) -> None:
    chance = random.Random(3)
    path = tmp_path / "mine.toml"

    def learner() -> None:
        path.write_text(damaged(LEARNER, chance), encoding="utf-8")
        load_config(path).build(3, 2)

    assert 100 < refusals(600, ValueError, learner) < 600


def test_damaged_settings_on_the_command_line_are_refused_in_one_line() -> None:
    chance = random.Random(4)

    def setting() -> None:
        item = f"{chance.choice(('learner.epsilon', 'method.decay', 'method.forced'))}={chance.choice(TOKENS)}"
        settings = Settings.parse((item,))
        LearnerConfig.from_dict(settings.learner)
        make_method(chance.choice(list(METHODS)), settings.method)

    assert 100 < refusals(1000, (ValueError, click.UsageError), setting) < 1000


def refusals(tries: int, kind: type[Exception] | tuple[type[Exception], ...], attempt: Callable[[], None]) -> int:
    """Count refusals; what is refused otherwise fails the test."""
    count = 0
    for _ in range(tries):
        try:
            attempt()
        except kind as problem:
            count += 1
            assert "\n" not in str(problem)
    return count
