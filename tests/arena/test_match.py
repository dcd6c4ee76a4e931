from __future__ import annotations

import os
import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rcss_hat.arena.bounds import AGENT_BOUNDS, CONTROL_BOUNDS, MATCH_BOUNDS, SEE_BOUNDS
from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.policy import learners_policy, load_policy
from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.hat.transfer.making import make_method
from rcss_hat.keepaway.decision import legal_action
from rcss_hat.keepaway.policies import hand
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Part, open_stage

COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
EPISODES = 40 if COMPILED else 1


def make(policy: str = "hand", seed: int = 1, task: Task | None = None, **options: Any) -> ArenaMatch:
    task = task or Task()
    return ArenaMatch(task, seed, load_policy(policy, task.keepers, task.takers, seed), **options)


def episodes(match: ArenaMatch, n: int = EPISODES) -> list[Episode]:
    return [episode for finished in match.advance(episodes=n) for episode in finished]


def test_episodes_follow_each_other_without_a_gap() -> None:
    played = episodes(make())
    assert [e.number for e in played] == list(range(1, EPISODES + 1))
    assert played[0].start == 0
    assert all(a.end == b.start for a, b in pairwise(played))
    assert all(e.cycles > 5 and e.reason in "ot" for e in played)


def test_the_seed_decides_everything() -> None:
    assert episodes(make("random", 7)) == episodes(make("random", 7))
    assert episodes(make("random", 7)) != episodes(make("random", 8))


@pytest.mark.parametrize("size", ["4v3", "5v4"])
def test_other_sizes(size: str) -> None:
    task = Task.parse(size)
    match = make("hand", task=task, log_decisions=True)
    played = episodes(match, min(EPISODES, 5))
    assert len(played) == min(EPISODES, 5)
    assert match.take_decisions()["state"].shape[1] == 4 * (task.keepers - 1) + 2 * task.takers + 1


def test_a_policy_in_python_plays_as_the_compiled_one() -> None:
    asked = []

    def policy(state: NDArray[np.float64], info: dict[str, Any]) -> int:
        asked.append((info["episode"], info["cycle"], info["keeper"]))
        return int(hand(state, 3, 2))

    match = make(external=policy)
    assert episodes(match) == episodes(make())
    assert len(set(asked)) == len(asked)


def test_an_illegal_action_says_what_is_legal() -> None:
    with pytest.raises(ValueError, match=r"action 3; legal are 0 \(Hold\) to 2"):
        episodes(make(external=lambda state, info: 3), 1)


@pytest.mark.parametrize(
    "answer", [1.7, None, np.nan, np.inf, "1", np.array([True, False]), np.array([1]), np.array(True), -1, 10**400]
)
def test_what_is_no_action_is_refused_like_an_illegal_one(answer: object) -> None:
    with pytest.raises(ValueError, match=r"the policy returned .*; legal are 0 \(Hold\) to 2"):
        episodes(make(external=lambda state, info: answer), 1)


@pytest.mark.parametrize("answer", [2, 2.0, np.int8(2), np.float32(2.0), np.array(2)])
def test_whole_numbers_of_every_type_are_actions(answer: object) -> None:
    assert legal_action(answer, 3) == 2


def test_every_field_of_the_saved_records_has_bounds() -> None:
    tables = {"match": MATCH_BOUNDS, "agents": AGENT_BOUNDS, "sees": SEE_BOUNDS, "control": CONTROL_BOUNDS}
    for name, bounds in tables.items():
        assert set(bounds) == set(make().arrays()[name].dtype.names), name


@pytest.mark.parametrize(
    ("name", "field", "value", "message"),
    [
        ("match", "n_players", 23, "'match': 'n_players' is not that of these settings"),
        ("match", "n_said", 61, "'match': 'n_said' is 61; it must be 0 to 60"),
        ("match", "ball_pos", np.nan, "'match': 'ball_pos' is nan"),
        ("match", "time", 2**31 - 1, "'match': 'time' is 2147483647"),
        ("agents", "fast_own", 22, "'agents': 'fast_own' is 22"),
        ("agents", "player_time", 1, "age of 'player_time' is"),
        ("agents", "ball_seen", 10**6, "'agents': 'ball_seen' is 1000000"),
        ("sees", "n", 97, "'sees': 'n' is 97; it must be 0 to 96"),
        ("control", "decided", 64, "'control': 'decided' is 64"),
        ("control", "phase", 7, "'control': 'phase' is not that of these settings"),
        ("streams", None, 0, "a random stream of zeros"),
    ],
)
def test_a_saved_match_with_wrong_numbers_is_refused(name: str, field: str | None, value: float, message: str) -> None:
    match = make()
    list(match.advance(cycles=300))
    saved = {key: array.copy() for key, array in match.arrays().items()}
    make().restore(saved)
    if field is None:
        saved[name][0] = value
    else:
        saved[name][field] = value
    with pytest.raises(ValueError, match=re.escape(message)):
        make().restore(saved)


def test_decisions_are_those_of_the_policy() -> None:
    match = make(log_decisions=True)
    episodes(match, min(EPISODES, 5))
    decisions = match.take_decisions()
    assert len(decisions) > 10
    assert all(d["action"] == hand(d["state"], 3, 2) for d in decisions)
    assert set(decisions["keeper"]) <= {1, 2, 3}
    assert np.all(decisions["state"][:, 1] <= decisions["state"][:, 2])


def test_frames_show_every_cycle() -> None:
    match = make(log_frames=True)
    played = episodes(match, 1)
    frames = match.take_frames()
    assert list(frames["time"]) == list(range(1, played[0].end + 1))
    assert frames["enabled"].sum(axis=1).tolist() == [5] * len(frames)


def test_a_restored_match_goes_on_as_if_nothing_had_happened() -> None:
    n = max(2, EPISODES // 4)
    whole = episodes(make("random", 3), 2 * n)
    first = make("random", 3)
    begin = episodes(first, n)
    saved = {name: array.copy() for name, array in first.arrays().items()}
    policy_streams = first.policy.brains.streams.copy()
    second = make("random", 99)
    second.restore(saved)
    second.policy.brains.streams[...] = policy_streams
    assert begin + episodes(second, 2 * n) == whole


def test_restoring_another_task_is_refused() -> None:
    with pytest.raises(ValueError, match="not that of a 3v2 match"):
        make().restore(make(task=Task.parse("4v3")).arrays())


@pytest.mark.parametrize("approximator", ["cmac", "rbf"])
def test_learners_learn_inside_the_loop(approximator: str) -> None:
    config = LearnerConfig(approximator=approximator)
    learners = Learners.create(config, make_method("no-prior"), seed=5)
    match = ArenaMatch(Task(), 5, learners_policy(learners, None))
    played = episodes(match)
    assert learners.episodes in (len(played) - 1, len(played))
    assert np.abs(learners.weights).max(axis=(1, 2)).min() > 0.0 or not COMPILED


def test_means_are_those_of_the_original_players() -> None:
    # Reference: 2.95, 5.26 and 10.94 s (rcssserver 19 with the UT Austin players).
    if not COMPILED:
        pytest.skip("hundreds of episodes need the compiled loop")
    for policy, mean in (("hold", 2.95), ("random", 5.26), ("hand", 10.94)):
        with open_stage(Place(ARENA), Task(), 11, load_policy(policy, 3, 2, 11)) as stage:
            report = stage.play(Part(600))
        assert abs(np.mean(report.durations_s) - mean) < 0.1 * mean


def test_a_policy_for_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="the policy is for 4v3, the task is 3v2"):
        ArenaMatch(Task(), 1, load_policy("hand", 4, 3, 1))


def test_decisions_and_frames_that_nobody_takes_are_kept() -> None:
    cycles = 400 if COMPILED else 20
    taken, kept = (make("hold", log_decisions=True, log_frames=True) for _ in range(2))
    room = 8
    for match in (taken, kept):
        logs = match.logs
        small = {name: getattr(logs, name)[:room] for name in ("decisions", "states", "frames")}
        match.logs = logs._replace(**small)
    rows, frames = [], []
    for _ in taken.advance(cycles=cycles):
        rows.append(taken.take_decisions())
        frames.append(taken.take_frames())
    ended = [episode for part in kept.advance(cycles=cycles) for episode in part]
    assert len(frames) > 1  # the logs were full, and taken, several times
    assert np.array_equal(np.concatenate(frames), kept.take_frames())
    assert np.array_equal(np.concatenate(rows), kept.take_decisions())
    assert not COMPILED or ended
