"""The recorder of decisions."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.recorder import Recorder
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.system.files import NotWritten


def decision(cycle: int, keeper: int = 1) -> Decision:
    return Decision(cycle, keeper, (0.0,) * 13, 0)


def test_decisions_are_sorted_into_their_episode() -> None:
    """Keepers hear of an end one after another, so decisions of the next episode can come first."""
    recorder = Recorder()
    for d in (decision(3, 2), decision(3, 1), decision(1), decision(9, 3), decision(10, 1)):
        recorder.decided(d)
    first = recorder.take(Episode(1, 1, 10, OUT))
    assert [(d.cycle, d.keeper) for d in first] == [(1, 1), (3, 1), (3, 2), (9, 3)]
    assert recorder.take(Episode(2, 10, 20, OUT)) == [decision(10)]
    assert recorder.take(Episode(3, 20, 30, OUT)) == []


def test_what_was_forgotten_is_in_no_episode() -> None:
    recorder = Recorder()
    recorder.decided(decision(1))
    recorder.forget()
    assert recorder.take(Episode(1, 0, 10, OUT)) == []


def test_an_episode_that_could_not_be_written_is_kept_once_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise NotWritten("no space left")

    info = DemonstrationInfo("person", "arena", Task(), {}, 1)
    with DemonstrationWriter(tmp_path / "demo.csv", info) as writer:
        recorder = Recorder(writer)
        for d in (decision(1), decision(3), decision(12)):
            recorder.decided(d)
        with monkeypatch.context() as patch, pytest.raises(NotWritten):
            patch.setattr("rcss_hat.hat.demonstration_writer.append", full)
            recorder.keep(Episode(1, 0, 10, OUT))
        recorder.keep(Episode(1, 0, 10, OUT))
        recorder.keep(Episode(2, 10, 20, OUT))
    kept = DemonstrationSet.load(tmp_path / "demo.csv").episodes
    assert [list(episode.cycles) for episode in kept] == [[1, 3], [12]]
