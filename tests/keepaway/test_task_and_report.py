from __future__ import annotations

import json
import math
from array import array
from pathlib import Path

import pytest

from rcss_hat.keepaway.decision import DecisionTimes
from rcss_hat.keepaway.report import Episode, RunReport, mean_and_ci95, read_kwy, shifted
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
    report = RunReport.of("fake", "hand", Task(), 7)
    report.played(episodes, 90, 1.0)
    path.write_text(report.kwy_text())
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
    assert "2 episodes, mean 4.00" in report.to_text() and "1 taken away (as the players saw it)" in report.to_text()
    report.failure = "keeper 2: the server is gone"
    assert report.exit_code == 1
    assert "ended early: keeper 2" in report.to_text()


def test_report_without_episodes_is_still_valid_json() -> None:
    summary = json.loads(RunReport("fake", "hand", "hand", "3v2", "20x20", 360).to_json())
    assert summary["mean_s"] is None
    assert summary["cycles_per_s"] is None


def test_a_report_says_what_was_played() -> None:
    report = RunReport.of("localhost:6000", "hand", Task(), 7, referee="trainer")
    report.told(Task.parse("3v2", "25x20", 90), "other (kick_rand 0.05)", "real time")
    report.played([Episode(1, 100, 130, "o")], 35, 3.5, 2)
    summary = json.loads(report.to_json())
    assert (summary["field"], summary["vision"]) == ("25x20", 90)
    assert (summary["profile"], summary["speed"]) == ("other (kick_rand 0.05)", "real time")
    assert (summary["referee"], summary["taken_over"]) == ("trainer", ["field", "vision"])
    assert (summary["cycles_per_s"], summary["missed"]) == (10.0, 2)
    assert "physics of other (kick_rand 0.05); real time; referee: trainer" in report.to_text()
    assert report.kwy_text().splitlines()[2] == "# Region:  25 x 20"


def test_a_report_says_when_decisions_take_longer_than_a_cycle() -> None:
    report = RunReport.of("real", "model.zip", Task(), 1)
    report.decided(DecisionTimes(), 0.1)
    assert "decision" not in report.to_text() and json.loads(report.to_json())["decision_ms"] is None
    report.decided(DecisionTimes(array("d", [0.02, 0.25, 0.03])), 0.1)
    summary = json.loads(report.to_json())
    assert (summary["decision_ms"], summary["slowest_decision_ms"], summary["late_decisions"]) == (100.0, 250.0, 1)
    assert "a decision took 100.00 ms, at most 250.00 ms" in report.to_text()
    assert "1 decision took longer than the 100 ms that the server gives them" in report.to_text()


def test_the_first_reason_for_an_end_stays_and_stopping_on_purpose_is_none() -> None:
    report = RunReport.of("fake", "hand", Task(), 7)
    report.end_early("the server is gone")
    report.end_early("interrupted")
    report.stopped_on_purpose()
    assert report.failure == "the server is gone"
    stopped = RunReport.of("fake", "hand", Task(), 7)
    stopped.end_early("interrupted")
    assert stopped.exit_code == 1
    stopped.stopped_on_purpose()
    assert stopped.exit_code == 0


def test_episodes_of_a_match_that_began_late_can_be_counted_from_its_begin() -> None:
    report = RunReport.of("localhost:6000", "hand", Task(), 7)
    report.played([Episode(1, 5000, 5030, "o"), Episode(2, 5030, 5041, "t")], 60, 1.0)
    begin = report.episodes[0].start
    assert shifted(report.episodes, 0, -begin) == [Episode(1, 0, 30, "o"), Episode(2, 30, 41, "t")]
