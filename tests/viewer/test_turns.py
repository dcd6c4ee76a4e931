"""A person and a learner take turns, and the person says afterwards what would have been right."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.policy import load_policy, python_policy
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.turns import Companion

from .audience import FIELD, PATIENCE, SETUP, STATE, snapshot


class Session:
    """Episodes of ten cycles; keeper 1 always has the ball, and the learner always passes to the second."""

    def __init__(self, path: Path, terms: Terms, learns: bool = True) -> None:
        self.path, self.cycle = path, 0
        self.shown = list[Mapping[str, Any] | None]()
        self.writer = DemonstrationWriter(path, DemonstrationInfo("person", "arena", marked=True))
        learner = Companion(python_policy(lambda state, info: 2, 3, 2, "second")) if learns else None
        self.demonstrator = Demonstrator(KeyChannel(), self.writer, terms, learner)
        self.demonstrator.on_replay = self.shown.append
        self.see()

    def see(self) -> None:
        self.demonstrator.observe(make_frame(snapshot(self.cycle, (0.5, 0.0), **FIELD), SETUP, 1, 0))

    def decide(self) -> int:
        self.see()
        info = {"keeper": 1, "cycle": self.cycle, "status": 1, "reward": 1.0}
        action = self.demonstrator.answer(STATE, info)
        self.demonstrator.decided(Decision(self.cycle, 1, tuple(STATE.tolist()), action))
        self.cycle += 1
        return action

    def end(self) -> None:
        start, self.cycle = (self.cycle - 1) // 10 * 10, -(-self.cycle // 10) * 10
        self.demonstrator.ended([Episode(start // 10 + 1, start, self.cycle, OUT)], self.cycle)

    def read(self) -> DemonstrationSet:
        self.demonstrator.close()
        return DemonstrationSet.load(self.path)


def test_a_key_takes_over_and_another_gives_back(tmp_path: Path) -> None:
    session = Session(tmp_path / "x.csv", Terms())
    person = session.demonstrator
    assert session.decide() == 2 and person.status()["by"] == "learner" and person.status()["turns"]
    person.press(1)
    assert [session.decide(), session.decide()] == [1, 0] and person.status()["by"] == "person"
    person.press(1)
    assert person.command("give")
    assert session.decide() == 2, "the key that was not played yet is forgotten"
    assert person.command("take")
    assert session.decide() == 0
    session.end()
    (episode,) = session.read().episodes
    assert episode.by == ("learner", "person", "person", "learner", "person")
    assert episode.actions.tolist() == [2, 1, 0, 2, 0]
    assert session.read().lessons.y.tolist() == [1, 0, 0]


def test_nobody_need_be_there_for_the_learner_to_play(tmp_path: Path) -> None:
    session = Session(tmp_path / "x.csv", Terms())
    for _ in range(2 * PATIENCE):
        session.decide()
    assert not session.demonstrator.asking
    session.end()
    session.demonstrator.command("take")
    for _ in range(PATIENCE + 1):
        session.decide()
    assert session.demonstrator.asking
    assert not session.demonstrator.command("seen")


def test_without_a_learner_there_is_nothing_to_give(tmp_path: Path) -> None:
    session = Session(tmp_path / "x.csv", Terms(), learns=False)
    assert not session.demonstrator.command("give") and not session.demonstrator.command("take")
    assert session.decide() == 0 and not session.demonstrator.status()["turns"]


@pytest.mark.parametrize("at_once", [False, True])
def test_what_would_have_been_right_goes_into_the_file(tmp_path: Path, at_once: bool) -> None:
    session = Session(tmp_path / "x.csv", Terms(2, correct=True, at_once=at_once))
    person = session.demonstrator
    for _ in range(3):
        session.decide()
    session.end()
    assert person.replaying and person.standing and person.status()["replaying"]
    shown = session.shown[-1]
    assert shown is not None and [d["cycle"] for d in shown["decisions"]] == [0, 1, 2]
    assert [f["time"] for f in shown["frames"]] == [0, 0, 1, 2] and shown["actions"] == [0, 1, 2]
    assert person.correct(1, 0) and person.correct(2, 1) and person.correct(2, None)
    assert not person.correct(7, 1) and not person.correct(1, 3)
    assert shown["decisions"][1]["right"] == 0, "who comes back sees it"
    assert person.command("seen") and session.shown[-1] is None and not person.standing
    assert not person.correct(1, 1), "too late"
    assert len(session.writer.entries) == int(at_once)
    session.decide()
    session.end()
    assert not person.finished, "the last one is looked at, too"
    assert person.correct(10, 1) and person.command("seen") and person.finished
    first, second = session.read().episodes
    assert (first.right, second.right) == ((None, 0, None), (1,)) and first.actions.tolist() == [2, 2, 2]
    assert session.read().lessons.y.tolist() == [0, 1]


def test_ones_own_decisions_can_be_corrected(tmp_path: Path) -> None:
    session = Session(tmp_path / "x.csv", Terms(correct=True), learns=False)
    session.demonstrator.press(1)
    session.decide()
    session.end()
    session.demonstrator.correct(0, 2)
    session.demonstrator.command("seen")
    (episode,) = session.read().episodes
    assert (episode.by, episode.right, episode.actions.tolist()) == (("person",), (2,), [1])


def test_a_companion_decides_as_its_policy_does() -> None:
    companion = Companion(load_policy("hand", 3, 2, 1))
    near, far = STATE.copy(), STATE.copy()
    near[3:5], far[3:5] = 1.0, 12.0
    info = {"keeper": 2, "cycle": 3, "status": 1, "reward": 1.0}
    assert companion.name == "hand"
    assert companion.answer(far, info) == 0 and companion.answer(near, info) != 0
    assert np.array_equal(near[3:5], [1.0, 1.0])
