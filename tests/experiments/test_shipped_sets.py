"""The demonstration sets that ship with the package: what they are, what makes them, and that wheels contain them."""

from __future__ import annotations

import json
import platform
import re
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from hatchling.builders.wheel import WheelBuilder

from rcss_hat.cli.main import cli
from rcss_hat.experiments.demonstrating import demonstrate
from rcss_hat.experiments.sets import SetStore, package_demonstrations
from rcss_hat.experiments.study import StudyError
from rcss_hat.experiments.study_file import load_study
from rcss_hat.hat.teachers import STYLES
from rcss_hat.keepaway.task import Task

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "rcss_hat" / "hat" / "data" / "demonstrations"
PAPER = {
    "A": (10.4, 17.2, 4.6),
    "B": (10.5, None, None),
    "C": (11.3, 18.0, 4.6),
    "B-fast": (4.3, None, None),
    "B-limited": (5.2, None, None),
}
"""The paper's mean durations (s): 20 episodes, the ten longest, the ten shortest."""

same_rounding = pytest.mark.skipif(
    platform.machine() != "x86_64" or sys.platform != "linux", reason="another C library may round otherwise"
)


@pytest.mark.parametrize("name", STYLES)
def test_every_teacher_has_a_set_like_the_papers(name: str) -> None:
    found = package_demonstrations(name)
    assert (found.info.teacher, found.info.task, len(found)) == (name, Task(profile="11.1"), 20)
    measured = (found.durations.mean(), found.best(10).durations.mean(), found.worst(10).durations.mean())
    for seconds, paper in zip(measured, PAPER[name], strict=True):
        assert paper is None or seconds == pytest.approx(paper, rel=0.07)
    assert {0, 1} <= set(found.y) <= ({0, 1} if name == "B-limited" else {0, 1, 2})


def test_the_readme_says_what_the_sets_are() -> None:
    rows = dict(re.findall(r"^\| ([ABC][a-z-]*) \| (.*) \|$", (FOLDER / "README.md").read_text(), re.MULTILINE))
    assert rows.keys() == STYLES.keys()
    for name, row in rows.items():
        found = package_demonstrations(name)
        halves = found.best(10).durations.mean(), found.worst(10).durations.mean()
        shares = ", ".join(f"{100 * share:.1f}" for share in found.describe().action_shares)
        told = [str(found.info.seed), *(f"{seconds:.2f}" for seconds in (found.durations.mean(), *halves))]
        assert row.split(" | ")[:6] == [*told, str(found.n_decisions), shares], name


@same_rounding
@pytest.mark.compiled
@pytest.mark.parametrize("name", STYLES)
def test_the_recipe_in_the_header_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
    info = package_demonstrations(name).info
    assert info.seed is not None
    again = demonstrate(info.task, info.teacher, 20, info.seed)
    replace(again, info=replace(again.info, date=info.date)).save(tmp_path / f"{name}.csv")
    for ending in ("csv", "json"):
        assert (tmp_path / f"{name}.{ending}").read_bytes() == (FOLDER / f"{name}.{ending}").read_bytes()


@same_rounding
@pytest.mark.compiled
def test_the_command_in_the_readme_gives_the_same_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    line = re.search(r"^rcss-hat (demonstrate .*)$", (FOLDER / "README.md").read_text(), re.MULTILINE)
    assert line is not None
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(cli, line[1].split())
    assert result.exit_code == 0, result.output
    assert Path("A.csv").read_bytes() == (FOLDER / "A.csv").read_bytes()
    made, shipped = (json.loads(path.read_text()) for path in (Path("A.json"), FOLDER / "A.json"))
    assert {**made, "date": None} == {**shipped, "date": None}


def test_unknown_sets_are_named_with_those_there_are() -> None:
    with pytest.raises(StudyError, match=r"no demonstration set 'D' ships .*; there are A, B, B-fast, B-limited, C"):
        package_demonstrations("D")


def test_the_papers_study_uses_them(tmp_path: Path) -> None:
    store = SetStore(load_study("paper"), tmp_path)
    for name in STYLES:
        assert store.demonstrations(name) == package_demonstrations(name)
    assert store.demonstrations("A10").durations.mean() == pytest.approx(7.5, abs=0.1)
    assert len(store.demonstrations("AC-best")) == len(store.demonstrations("AC-worst")) == 20


def test_wheels_contain_them(tmp_path: Path) -> None:
    [wheel] = WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    inside = {name for name in zipfile.ZipFile(wheel).namelist() if "/data/demonstrations/" in name}
    assert inside == {str(path.relative_to(ROOT)) for path in FOLDER.iterdir()}
    assert len(inside) == 1 + 2 * len(STYLES)
