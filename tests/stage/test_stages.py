"""One stage: the same play, decisions and report wherever it is."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence

import numpy as np
import pytest

from rcss_hat.hat.policy import load_policy, python_policy
from rcss_hat.hat.teachers import teacher_policy
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import INTERRUPTED, Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, FAKE, Place
from rcss_hat.stage.stages import Part, open_stage
from rcss_hat.stage.terms import Terms

TASK = Task()


def test_places_are_read_and_written() -> None:
    for text in ("arena", "fake", "real", "localhost:6000", "10.0.0.1:6001"):
        assert str(Place.parse(text)) == text
    assert Place.parse("localhost:6000").address == ("localhost", 6000)
    assert Place.parse("real", "./rcssserver").executable == "./rcssserver"
    for text in ("moon", ":6000", "host:", "host:0", "host:65536", "host:six", ""):
        with pytest.raises(ValueError, match="not HOST:PORT, for example localhost:6000"):
            Place.parse(text)


@pytest.mark.compiled
def test_a_function_in_python_plays_the_same_match_in_the_arena_and_on_a_server() -> None:
    told: dict[str, list[object]] = {}
    for name in (ARENA, FAKE):
        seen: list[tuple[int, int, int]] = []
        decisions: list[Decision] = []
        ended: list[Episode] = []

        def decide(state: np.ndarray, info: dict[str, float], seen: list[tuple[int, int, int]] = seen) -> int:
            seen.append((info["episode"], info["cycle"], info["keeper"]))  # type: ignore[arg-type]
            return int(state[0] > 5.0)

        def over(
            episodes: Sequence[Episode],
            cycle: int,
            ended: list[Episode] = ended,
            decisions: list[Decision] = decisions,
        ) -> None:
            ended += episodes
            assert not episodes or decisions[-1].cycle >= episodes[-1].start  # an episode's decisions come before it

        policy = python_policy(decide, TASK.keepers, TASK.takers, "distant")
        with open_stage(Place(name), TASK, 3, policy) as stage:
            report = stage.play(Part(2, on_episodes=over, on_decision=decisions.append))
        assert report is stage.report and report.failure is None
        assert (report.stage, report.keepers, report.episodes) == (name, "distant", ended)
        end = ended[-1].end
        told[name] = [
            ended,
            sorted(s for s in seen if s[1] < end),
            sorted((d.cycle, d.keeper, d.state, d.action) for d in decisions if d.cycle < end),
            [episode.final for episode in ended],
        ]
    assert len(told[ARENA][2]) > 5  # type: ignore[arg-type]
    assert all(told[ARENA][3])  # type: ignore[call-overload]
    assert told[ARENA] == told[FAKE]


@pytest.mark.compiled
@pytest.mark.parametrize("name", [ARENA, FAKE])
def test_a_policy_that_fails_ends_the_match_and_what_was_finished_is_kept(name: str) -> None:
    asked = []

    def tired(state: np.ndarray, info: dict[str, float]) -> float:
        asked.append(info["episode"])
        return 0 if info["episode"] < 3 else 1.7

    with open_stage(Place(name), TASK, 3, python_policy(tired, 3, 2, "tired")) as stage:  # type: ignore[arg-type]
        report = stage.play(Part(5))
    assert report.failure == "the policy returned 1.7; legal are 0 (Hold) to 2 (pass to the farthest team mate)"
    assert report.exit_code == 1 and len(report.episodes) == 2
    assert (report.decision_ms is None) == (name == ARENA)  # the arena waits, a server does not
    if name == FAKE:
        assert report.slowest_decision_ms is not None and report.patience_ms == 1250.0


@pytest.mark.compiled
@pytest.mark.parametrize("name", [ARENA, FAKE])
def test_who_is_told_can_end_a_match_and_so_can_cycles(name: str) -> None:
    policy = load_policy("hold", 3, 2, 1)
    with open_stage(Place(name), TASK, 1, policy) as stage:
        report = stage.play(Part(on_episodes=lambda episodes, cycle: bool(episodes)))
    assert report.failure is None and report.episodes
    assert report.ends_judged_by == ("referee" if name == ARENA else "players")
    with open_stage(Place(name), TASK, 1, load_policy("hold", 3, 2, 1)) as stage:
        report = stage.play(Part(cycles=50))
    assert report.failure is None and report.cycles >= 50


@pytest.mark.compiled
@pytest.mark.parametrize("name", [ARENA, FAKE])
def test_ctrl_c_ends_a_match_with_what_was_played(name: str) -> None:
    def press(episodes: Sequence[Episode], cycle: int) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    with open_stage(Place(name), TASK, 1, load_policy("hold", 3, 2, 1)) as stage:
        report = stage.play(Part(100_000 if name == ARENA else 100, on_episodes=press))
    assert report.failure == INTERRUPTED
    assert 0 < len(report.episodes) < 100_000


def test_terms_that_make_no_sense_in_the_arena_are_refused() -> None:
    policy = load_policy("hold", 3, 2, 1)
    with pytest.raises(ValueError, match="a trainer referees on a server, not in the arena"):
        open_stage(Place(ARENA), TASK, 1, policy, Terms(trainer=0))
    with pytest.raises(ValueError, match="in the arena both teams are ours"):
        open_stage(Place(ARENA), TASK, 1, None)


@pytest.mark.compiled
def test_a_match_is_the_same_played_at_once_and_part_by_part() -> None:
    reports = []
    for cycles in (range(400, 401), range(1, 401)):
        with open_stage(Place(ARENA), TASK, 4, load_policy("random", 3, 2, 4)) as stage:
            for cycle in cycles:
                stage.play(Part(cycles=cycle))
        reports.append((stage.report.episodes, stage.report.cycles, stage.report.failure))
    assert reports[0] == reports[1]
    assert reports[0][0] and reports[0][1] == 400


@pytest.mark.compiled
def test_what_there_is_to_see_is_told_before_it_is_decided() -> None:
    """To the policy, too, before it is asked."""
    order: list[tuple[str, int]] = []

    def decide(state: np.ndarray, info: dict[str, float]) -> int:
        order.append(("asked", int(info["cycle"])))
        return 0

    def see(frame: np.void) -> None:
        order.append(("seen", int(frame["time"])))

    policy = python_policy(decide, 3, 2, "seer", see)
    with open_stage(Place(ARENA), TASK, 3, policy) as stage:
        stage.play(Part(cycles=60, on_decision=lambda d: order.append(("decided", d.cycle))))
    seen = [cycle for what, cycle in order if what == "seen"]
    assert seen == list(range(1, 61))
    for place, (what, cycle) in enumerate(order):
        if what != "seen":
            assert [c for w, c in order[:place] if w == "seen"][-1] == cycle
    assert sum(what == "asked" for what, _ in order) == sum(what == "decided" for what, _ in order) > 10


def test_servers_refuse_who_must_see_the_whole_field_and_many_matches() -> None:
    with pytest.raises(ValueError, match="A sees the whole field, as only the arena shows it: use --on arena"):
        open_stage(Place(FAKE), TASK, 1, teacher_policy("A", 3, 2, 1))
    with open_stage(Place(FAKE), TASK, 1, load_policy("hold", 3, 2, 1)) as stage:
        with pytest.raises(ValueError, match="connects to it as a monitor"):
            stage.play(Part(1, on_frame=print))
        with pytest.raises(ValueError, match="many matches are played in the arena, not on fake"):
            stage.play_matches(2, 1, 1, print)
