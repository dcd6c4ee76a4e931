from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from rcss_hat.keepaway.report import Episode, RunReport, kwy_text, mean_and_ci95, read_kwy
from rcss_hat.keepaway.task import Task


def test_task_is_read_from_what_people_write() -> None:
    task = Task.parse("4v3", "25x30.5", 90, "11.1")
    assert (task.keepers, task.takers, task.length, task.width, task.vision) == (4, 3, 25.0, 30.5, 90)
    assert (task.size, task.field) == ("4v3", "25x30.5")


@pytest.mark.parametrize(("size", "field"), [("3v2", "20x20"), ("4v3", "30x30"), ("5v4", "35x35")])
def test_usual_regions(size: str, field: str) -> None:
    assert Task.parse(size).field == field


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("3x2",), "KEEPERSvTAKERS, for example 3v2"),
        (("2v2",), "3 to 11 keepers"),
        (("3v2", "20"), "LENGTHxWIDTH in metres, for example 20x20"),
        (("3v2", "200x20"), "8 to 100 m long"),
        (("3v2", "20x20", 0), "1 to 360 degrees"),
        (("3v2", "20x20", 360, "9.4"), "known are 19.0, 11.1"),
    ],
)
def test_wrong_tasks_say_what_would_be_right(arguments: tuple[str, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Task.parse(*arguments)  # type: ignore[arg-type]


def test_task_parameters_are_those_of_the_start_script() -> None:
    params = Task.parse("3v2", "20x25").params()
    assert params["stamina_inc_max"] == 3500.0
    assert params["keepaway"] is True
    assert params["keepaway_width"] == 25.0
    assert params["synch_offset"] == 80


def test_kwy_round_trip(tmp_path: Path) -> None:
    episodes = [Episode(1, 0, 31, "o"), Episode(2, 31, 90, "t")]
    path = tmp_path / "x.kwy"
    path.write_text(kwy_text(episodes, 3, 2, 20.0, 20.0))
    assert read_kwy(path) == episodes
    assert path.read_text().startswith("# Keepers: 3\n# Takers:  2\n# Region:  20 x 20\n#\n")


def test_damaged_kwy_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "x.kwy"
    path.write_text("# Keepers: 3\n1\t0\t31\to\n")
    with pytest.raises(ValueError, match=r"line 2: expected 'episode start end duration o\|t'"):
        read_kwy(path)


def test_interval_of_a_mean() -> None:
    assert mean_and_ci95([1.0, 2.0, 3.0]) == (2.0, pytest.approx(1.96 / math.sqrt(3.0)))
    assert all(math.isnan(value) for value in mean_and_ci95([]))


def test_report_counts_prints_and_decides_the_exit_code() -> None:
    report = RunReport("fake", "hand", "hand", "3v2", "20x20", 360, seed=7)
    report.episodes = [Episode(1, 0, 30, "o"), Episode(2, 30, 80, "t")]
    report.cycles, report.wall_s = 80, 0.5
    summary = json.loads(report.to_json())
    assert summary["episodes"] == 2
    assert summary["mean_s"] == 4.0
    assert (summary["out"], summary["taken"]) == (1, 1)
    assert summary["cycles_per_s"] == 160.0
    assert report.exit_code == 0
    assert "2 episodes, mean 4.00" in report.to_text()
    report.failure = "keeper 2: the server is gone"
    assert report.exit_code == 1
    assert "ended early: keeper 2" in report.to_text()


def test_report_without_episodes_is_still_valid_json() -> None:
    summary = json.loads(RunReport("fake", "hand", "hand", "3v2", "20x20", 360).to_json())
    assert summary["mean_s"] is None
    assert summary["cycles_per_s"] is None
