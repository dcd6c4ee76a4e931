"""Clock, journal and progress: what is known of a participant, and that a crash takes nothing of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.clock import Clock, utc_seconds, utc_text
from rcss_hat.studies.journal import Journal, read_journal
from rcss_hat.studies.parts import PeopleStudy
from rcss_hat.studies.plan import plan_of
from rcss_hat.studies.progress import Progress


def event(kind: str, ms: int = 0, **fields: Any) -> dict[str, Any]:
    return {"ms": ms, "utc": utc_text(ms / 1000.0), "event": kind, **fields}


def game(step: str, number: int, cycles: int = 50) -> dict[str, Any]:
    about = {"start": 0, "end": cycles, "reason": "t", "idle": False, "keys": 2}
    return event("game", step=step, game=number, match=1, **about)


class TestClock:
    def test_goes_by_the_steady_clock(self) -> None:
        steady = [100.0]
        clock = Clock(1000.0, day=lambda: 1000.0, steady=lambda: steady[0])
        steady[0] = 101.5
        assert clock.ms() == 1500

    def test_never_goes_back_over_a_restart_with_a_clock_set_back(self) -> None:
        clock = Clock(1000.0, counted=60_000, day=lambda: 900.0, steady=lambda: 5.0)
        assert clock.ms() == 60_000

    def test_counts_the_time_a_restart_took(self) -> None:
        clock = Clock(1000.0, counted=60_000, day=lambda: 1090.0, steady=lambda: 5.0)
        assert clock.ms() == 90_000

    def test_times_of_day_are_read_as_they_were_written(self) -> None:
        assert utc_text(0.25) == "1970-01-01T00:00:00.250Z"
        assert utc_seconds(utc_text(1_800_000_000.125)) == 1_800_000_000.125


class TestJournal:
    def test_what_was_appended_is_there_again(self, tmp_path: Path) -> None:
        path = tmp_path / "journal.jsonl"
        journal = Journal(path)
        journal.append(event("begun", 1, step="ä"))
        journal.append(event("done", 2, step="ä", by="participant"))
        assert Journal(path).events == journal.events == read_journal(path)

    @pytest.mark.parametrize("cut", range(1, 40))
    def test_a_line_that_was_cut_off_never_happened(self, tmp_path: Path, cut: int) -> None:
        path = tmp_path / "journal.jsonl"
        journal = Journal(path)
        journal.append(event("begun", 1, step="a"))
        kept = list(journal.events)
        journal.append(event("begun", 2, step="b"))
        path.write_bytes(path.read_bytes()[:-cut])
        assert read_journal(path) == kept
        again = Journal(path)
        again.append(event("begun", 3, step="c"))
        assert [e["step"] for e in read_journal(path)] == ["a", "c"]

    def test_a_damaged_line_is_named(self, tmp_path: Path) -> None:
        path = tmp_path / "journal.jsonl"
        Journal(path).append(event("begun", 1, step="a"))
        path.write_text(path.read_text() + '{"ms": 1, "event": "begun"}\n')
        with pytest.raises(FileFormatError, match="line 2: an event 'begun' has ms, utc, event, step"):
            read_journal(path)

    def test_only_events_of_the_codebook_are_taken(self, tmp_path: Path) -> None:
        journal = Journal(tmp_path / "journal.jsonl")
        with pytest.raises(ValueError, match="there is no event 'address'"):
            journal.append(event("address", value="10.0.0.1"))
        with pytest.raises(ValueError):
            journal.append(event("begun", step="a", address="10.0.0.1"))
        assert not journal.path.exists()


class TestProgress:
    def test_goes_through_the_plan(self, small: PeopleStudy) -> None:
        plan = plan_of(small, 1)
        progress = Progress(plan)
        for planned in plan[:-1]:
            assert progress.current is planned and not progress.finished
            progress.take(event("begun", step=planned.name))
            assert progress.begun
            progress.take(event("done", step=planned.name, by="participant"))
        assert progress.finished

    def test_what_comes_twice_or_late_changes_nothing(self, small: PeopleStudy) -> None:
        progress = Progress(plan_of(small, 1))
        done = event("done", step="consent", by="participant")
        progress.take(done)
        progress.take(done)
        progress.take(event("done", step="thanks", by="participant"))
        assert progress.current.name == "practice"

    def test_counts_games_once(self, small: PeopleStudy) -> None:
        progress = Progress(plan_of(small, 1))
        for number in (1, 2, 2, 4):
            progress.take(game("practice", number))
        assert len(progress.played["practice"].games) == 2
        assert progress.played["practice"].seconds == [5.0, 5.0]

    def test_an_extension_adds_games(self, small: PeopleStudy) -> None:
        progress = Progress(plan_of(small, 1))
        assert progress.wanted("practice") == 2
        progress.take(event("extended", step="practice", games=5))
        assert progress.wanted("practice") == 7

    def test_who_is_stopped_is_at_the_end(self, small: PeopleStudy) -> None:
        progress = Progress(plan_of(small, 1), [event("stopped", by="experimenter")])
        assert progress.finished and progress.current.name == "thanks"
