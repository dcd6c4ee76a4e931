from __future__ import annotations

from pathlib import Path

import pytest

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.narrator import make_frame

from .audience import PATIENCE, SETUP, STATE, nobody_decides, snapshot

FIELD = {"l1": (0.0, 0.0), "l2": (5.0, 0.0), "l3": (0.0, 6.0), "r1": (-5.0, 0.0), "r2": (-6.0, 0.0)}


def asked(demonstration: Demonstrator, keeper: int, cycle: int) -> int:
    action = demonstration.answer(STATE, {"keeper": keeper, "cycle": cycle})
    demonstration.decided(Decision(cycle, keeper, tuple(STATE.tolist()), action))
    return action


class Session:
    """A demonstration written to a file, whose episodes last 20 cycles."""

    def __init__(self, path: Path, episodes: Terms | int | None = None, resume: bool = False) -> None:
        self.path = path
        self.writer = DemonstrationWriter(path, DemonstrationInfo("person", "arena"), resume)
        self.demonstration = Demonstrator(KeyChannel(), self.writer, episodes)
        self.number = 0

    def see(self, cycle: int) -> None:
        self.demonstration.observe(make_frame(snapshot(cycle, (0.5, 0.0), **FIELD), SETUP, 1, 0))

    def ask(self, keeper: int, cycle: int) -> int:
        """A keeper's decision, as a stage asks for it and tells it."""
        return asked(self.demonstration, keeper, cycle)

    def decide(self, action: int = 0, cycle: int | None = None) -> int:
        cycle = 20 * self.number + 5 if cycle is None else cycle
        self.see(cycle)
        self.demonstration.keys.press(action)
        return self.ask(1, cycle)

    def end(self, reason: str = OUT) -> None:
        self.number += 1
        end = 20 * self.number
        self.demonstration.ended([Episode(self.number, end - 20, end, reason)], end)

    def play(self, action: int = 1) -> None:
        self.decide(action)
        self.end()

    def read(self) -> DemonstrationSet:
        self.demonstration.close()
        return DemonstrationSet.load(self.path)


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return Session(tmp_path / "demo.csv")


def test_decisions_go_to_the_episode_of_their_cycle(session: Session) -> None:
    session.see(19)
    session.demonstration.keys.press_mate("l3")
    assert session.ask(2, 19) == 0
    assert session.ask(1, 19) == 2
    assert session.decide(0, cycle=3) == 0
    session.decide(1, cycle=20)
    session.end(TAKEN)
    session.end()
    first, second = session.read()
    assert (first.episode.start, first.episode.end, first.episode.reason) == (0, 20, TAKEN)
    assert (first.cycles.tolist(), first.keepers.tolist(), first.actions.tolist()) == (
        [3, 19, 19],
        [1, 1, 2],
        [0, 2, 0],
    )
    assert first.states.tolist() == [STATE.tolist()] * 3
    assert (second.cycles.tolist(), second.actions.tolist()) == ([20], [1])


def test_an_episode_is_on_the_disk_when_the_next_one_ends(session: Session) -> None:
    session.play()
    assert (session.demonstration.kept, len(session.writer.entries)) == (1, 0)
    session.play()
    assert len(DemonstrationSet.load(session.path)) == 1
    assert len(session.read()) == 2


def test_a_running_episode_can_be_dropped_and_kept_after_all(session: Session) -> None:
    demonstration = session.demonstration
    for command, status in (("drop", True), ("drop", False), ("drop", True)):
        assert demonstration.command(command)
        assert demonstration.status()["dropping"] is status
    session.play(1)
    session.play(2)
    assert (demonstration.kept, demonstration.status()["dropped"]) == (1, 1)
    assert [e.actions.tolist() for e in session.read()] == [[2]]


def test_the_last_episode_can_be_dropped_until_the_next_one_ends(session: Session) -> None:
    demonstration = session.demonstration
    assert not demonstration.command("drop_last")
    session.play(1)
    assert demonstration.command("drop_last")
    assert (demonstration.kept, demonstration.status()["dropped"]) == (0, 1)
    demonstration.command("drop_last")
    assert demonstration.kept == 1
    demonstration.command("drop_last")
    session.play(2)
    session.play(1)
    assert demonstration.status()["dropped"] == 1
    demonstration.command("drop_last")
    assert [e.actions.tolist() for e in session.read()] == [[2]]


def test_while_paused_keepers_hold_and_the_episode_is_not_kept(session: Session) -> None:
    demonstration = session.demonstration
    session.decide(1)
    demonstration.command("pause")
    assert session.decide(2, cycle=6) == 0
    session.end()
    session.play()
    assert demonstration.kept == 0
    demonstration.command("resume")
    assert demonstration.status()["spoiled"]
    session.play()
    assert demonstration.kept == 0
    session.play(2)
    assert [e.episode.start for e in session.read()] == [60]
    assert demonstration.dropped == 0


def test_with_nobody_there_keepers_hold_and_the_episode_is_not_kept(session: Session) -> None:
    demonstration, came = session.demonstration, []
    demonstration.on_arrival = lambda: came.append(True)
    demonstration.person(False)
    assert session.decide(2) == 0 and not came
    session.end()
    assert demonstration.kept == 0
    demonstration.person(True)
    session.play(1)
    demonstration.person(False)  # gone, and back before a keeper had to decide
    demonstration.person(True)
    session.play(2)
    assert len(came) == 2
    assert [e.actions.tolist() for e in session.read()] == [[1], [2]]


def test_it_finishes_with_the_last_episode_wanted(tmp_path: Path) -> None:
    session, told = Session(tmp_path / "x.csv", episodes=2), []
    session.demonstration.on_finished = lambda: told.append(True)
    session.play()
    assert not session.demonstration.finished
    session.play()
    session.play()
    assert session.demonstration.finished and told == [True]
    assert not session.demonstration.command("drop_last")
    assert len(session.read()) == 2


def test_a_stopped_demonstration_is_gone_on_with(tmp_path: Path) -> None:
    first = Session(tmp_path / "x.csv", episodes=3)
    first.play(1)
    first.demonstration.command("stop")
    assert first.demonstration.finished
    assert len(first.read()) == 1
    second = Session(tmp_path / "x.csv", episodes=3, resume=True)
    second.play(2)
    assert not second.demonstration.finished
    second.play(2)
    assert second.demonstration.finished
    assert [e.actions.tolist() for e in second.read()] == [[1], [2], [2]]


def test_practice_counts_and_writes_nothing() -> None:
    demonstration = Demonstrator(KeyChannel(), None, 2)
    for number in (1, 2):
        demonstration.keys.press(0)
        asked(demonstration, 1, 20 * number)
        demonstration.ended([Episode(number, 20 * number, 20 * number + 20, OUT)], 20 * number + 20)
    assert demonstration.finished and demonstration.kept == 2
    assert not demonstration.status()["recording"]


def test_unknown_commands_change_nothing(session: Session) -> None:
    before = session.demonstration.status()
    assert not session.demonstration.command("explode")
    assert session.demonstration.status() == before


def test_insight_knows_what_was_chosen(session: Session) -> None:
    session.decide(2, cycle=7)
    thought = session.demonstration.insight.thought(1, 8)
    assert thought is not None and (thought.cycle, thought.action, len(thought.state)) == (7, 2, 13)


def idle(session: Session, action: int = 0) -> None:
    """Play an episode without a key."""
    cycle = 20 * session.number + 5
    session.see(cycle)
    assert session.ask(1, cycle) == action
    session.end()


def test_episodes_without_a_key_are_marked(session: Session) -> None:
    session.play(0)  # taking back nothing is a sign of life, too
    idle(session)
    session.demonstration.command("drop")
    session.demonstration.command("drop")
    idle(session)
    idle(session)
    recorded = session.read()
    assert [d.idle for d in recorded] == [False, True, False, True]
    assert "2 of them without a single key" in recorded.describe().to_text()
    assert session.path.with_suffix(".json").read_text().count('"idle": true') == 2
    recorded.save(session.path)
    assert DemonstrationSet.load(session.path) == recorded


def test_without_a_key_for_seconds_of_ones_own_decisions_one_is_asked(session: Session) -> None:
    demonstration = session.demonstration
    nobody_decides(demonstration, PATIENCE - 1)
    session.play()  # a key: counted anew
    nobody_decides(demonstration, PATIENCE - 1)
    assert not demonstration.asking
    nobody_decides(demonstration, 1)
    assert demonstration.asking and demonstration.standing and demonstration.status()["asking"]
    assert session.decide(2) == 0, "what is asked meanwhile is not played"
    session.end()
    assert demonstration.kept == 1, "what is played while it asks, where the game cannot stand still, is not kept"
    assert demonstration.command("here") and not demonstration.standing
    session.play(2)
    assert session.read().episodes[-1].actions.tolist() == [2]


def test_at_a_faster_pace_there_are_more_decisions_in_a_second(tmp_path: Path) -> None:
    session = Session(tmp_path / "x.csv", Terms(speed=5.0))
    nobody_decides(session.demonstration, 5 * PATIENCE - 1)
    assert not session.demonstration.asking
    nobody_decides(session.demonstration, 1)
    assert session.demonstration.asking


def test_idle_episodes_are_written_only_when_the_person_goes_on(session: Session) -> None:
    session.play(1)
    idle(session)
    idle(session)
    assert len(session.writer.entries) == 1 and session.demonstration.kept == 3
    session.play(2)
    session.play(2)
    assert [e.idle for e in session.writer.entries] == [False, True, True, False]
    idle(session)
    nobody_decides(session.demonstration)
    assert session.demonstration.asking
    assert [d.idle for d in session.read()] == [False, True, True, False, False], "gone for good: not kept"


def test_one_who_has_gone_before_the_last_episode_does_not_finish(tmp_path: Path) -> None:
    session = Session(tmp_path / "x.csv", episodes=3)
    session.play(1)
    idle(session)
    idle(session)
    assert session.demonstration.asking and not session.demonstration.finished
    session.demonstration.command("here")
    assert session.demonstration.finished and len(session.read()) == 3


def test_the_game_waits_for_the_start_key(tmp_path: Path) -> None:
    session, came = Session(tmp_path / "x.csv", Terms(start=True)), []
    demonstration = session.demonstration
    demonstration.on_arrival = lambda: came.append(True)
    demonstration.person(True)
    assert demonstration.standing and not demonstration.status()["started"] and not came
    assert demonstration.command("start")
    assert not demonstration.standing and came == [True]


def test_at_once_means_at_the_end_of_the_episode(tmp_path: Path) -> None:
    """For studies: nothing is lost but the running episode, and nothing can be dropped."""
    commands, kept = ("start", "here", "pause", "resume"), []
    session = Session(tmp_path / "x.csv", Terms(2, at_once=True, commands=commands))
    session.demonstration.on_kept = lambda episode: kept.append(episode.number)
    session.play(1)
    assert len(session.writer.entries) == 1 and kept == [1]
    for command in ("drop", "drop_last", "stop"):
        assert not session.demonstration.command(command)
    assert session.demonstration.command("pause") and session.demonstration.command("resume")


def test_who_does_not_look_decides_nothing(session: Session) -> None:
    demonstration = session.demonstration
    demonstration.look(False)
    assert demonstration.standing and session.decide(2) == 0
    demonstration.look(True)
    session.end()
    session.play(1)
    assert [e.actions.tolist() for e in session.read()] == [[1]]


def test_the_farewell_names_file_and_command(session: Session, tmp_path: Path) -> None:
    assert session.demonstration.farewell() == {"kept": 0, "episodes": None, "file": None, "next": None}
    session.play()
    told = session.demonstration.farewell()
    assert (told["kept"], told["file"]) == (1, str(session.path))
    assert told["next"] == f"rcss-hat summarize {session.path} --out rules.json"
