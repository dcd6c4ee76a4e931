"""Many matches in one call: each as it would be alone, whoever its neighbours and however many the threads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.arena.vector import VectorMatch
from rcss_hat.arena.vector_records import CUT_OFF, ENDED_TAKEN, NOT_ENDED
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.seeds import derived_seed

pytestmark = pytest.mark.compiled
TASK = Task()
Rows = list[tuple[Any, ...]]


def seeds(n: int) -> list[int]:
    return [derived_seed(5, i) for i in range(n)]


def decided(states: np.ndarray) -> np.ndarray:
    """A policy: sometimes each action."""
    return np.where(states[:, 3] > 6.0, 0, 1 + (states[:, 11] < states[:, 12])).astype(np.int64)


def alone(task: Task, seed: int, cycles: int, stuck_at: int | None = None) -> tuple[Rows, Rows]:
    """Play a single match: its decisions and its episodes."""
    decisions: Rows = []

    def external(state: np.ndarray, info: dict[str, Any]) -> int:
        action = int(decided(state[np.newaxis])[0])
        decisions.append((info["episode"], info["cycle"], info["keeper"], info["status"], *state, action))
        return action

    policy = load_policy("hold", task.keepers, task.takers, 0)
    match = ArenaMatch(task, seed, policy, external=external)
    episodes = []
    if stuck_at is not None:
        episodes += [e for part in match.advance(cycles=stuck_at) for e in part]
        stick(match.world.match)
    episodes += [e for part in match.advance(cycles=cycles) for e in part]
    return decisions, [(e.number, e.cycles, e.end, e.reason) for e in episodes]


def stick(match: np.ndarray) -> None:
    """Let the ball count as stuck in the next cycle, wherever it goes."""
    match["stuck_cycles"], match["stuck_pos"] = 10**6, match["ball_pos"]


def together(matches: VectorMatch, steps: int) -> tuple[list[Rows], list[Rows]]:
    """Play many: decisions and episodes of each."""
    decisions: list[Rows] = [[] for _ in range(matches.matches)]
    episodes: list[Rows] = [[] for _ in range(matches.matches)]
    for _ in range(steps):
        lanes, states = matches.batch.lanes, matches.batch.states
        actions = decided(states)
        for i, lane in enumerate(lanes):
            if matches.goes_on or lane["ended"] == NOT_ENDED:
                who = (lane["episode"], lane["cycle"], lane["keeper"] + 1, lane["status"])
                decisions[i].append((*who, *states[i], actions[i]))
        matches.step(actions)
        for i in np.flatnonzero(matches.batch.lanes["ended"]):
            lane = matches.batch.lanes[i]
            reason = "t" if lane["ended"] == ENDED_TAKEN else "o"
            episodes[i].append((lane["last_episode"], lane["duration"], lane["last_cycle"], reason))
    return decisions, episodes


@pytest.mark.parametrize("goes_on", [True, False])
@pytest.mark.parametrize("size", ["3v2", "4v3"])
def test_every_match_is_the_one_it_would_be_alone(size: str, goes_on: bool) -> None:
    task = Task.parse(size)
    matches = VectorMatch(task, 3, goes_on=goes_on)
    matches.begin(seeds(3))
    decisions, episodes = together(matches, 120)
    for i, seed in enumerate(seeds(3)):
        expected, ends = alone(task, seed, int(matches.batch.match["time"][i]) + 1)
        n, k = len(decisions[i]), len(episodes[i])
        assert n > 100 and k > 1
        assert decisions[i] == expected[:n]
        assert episodes[i] == ends[:k]


def test_threads_change_nothing() -> None:
    results = []
    for threads in (1, 2, 3):
        matches = VectorMatch(TASK, 5, threads)
        matches.begin(seeds(5))
        results.append((together(matches, 60), matches.batch.observations.tobytes(), matches.batch.lanes.tolist()))
        matches.close()
    assert results[0] == results[1] == results[2]


def test_the_cycles_of_all_steps_are_those_of_the_episodes() -> None:
    matches = VectorMatch(TASK, 4)
    matches.begin(seeds(4))
    played, ended = np.zeros(4, dtype=int), 0
    for _ in range(150):
        matches.step(decided(matches.batch.states))
        lanes = matches.batch.lanes
        played += lanes["dt"]
        for i in np.flatnonzero(lanes["ended"]):
            assert played[i] == lanes["duration"][i]
            played[i], ended = 0, ended + 1
    assert ended > 4


def test_a_ball_that_is_stuck_is_dropped_as_in_a_single_match() -> None:
    matches = VectorMatch(TASK, 3, threads=2)
    matches.begin(seeds(3))
    at = int(matches.batch.match["time"][1])
    stick(matches.batch.match[1:2])
    decisions, _ = together(matches, 40)
    dropped, _ = alone(TASK, seeds(3)[1], int(matches.batch.match["time"][1]) + 1, stuck_at=at)
    usual, _ = alone(TASK, seeds(3)[1], int(matches.batch.match["time"][1]) + 1)
    assert decisions[1] == dropped[: len(decisions[1])]
    assert decisions[1] != usual[: len(decisions[1])]
    assert decisions[0] == alone(TASK, seeds(3)[0], int(matches.batch.match["time"][0]) + 1)[0][: len(decisions[0])]


@pytest.mark.parametrize("goes_on", [True, False])
def test_an_episode_is_cut_off_after_so_many_cycles(goes_on: bool) -> None:
    matches = VectorMatch(TASK, 2, max_cycles=15, goes_on=goes_on)
    matches.begin(seeds(2))
    cuts = 0
    for _ in range(120):
        matches.step(np.zeros(2, dtype=np.int64))
        lanes = matches.batch.lanes
        for i in np.flatnonzero(lanes["ended"] == CUT_OFF):
            cuts += 1
            assert lanes["duration"][i] == 15
            assert (lanes["episode"][i] == lanes["last_episode"][i]) == (not goes_on)
    assert cuts > 6


def test_to_discard_is_to_begin_with_the_next_episode() -> None:
    matches = VectorMatch(TASK, 2)
    matches.begin(seeds(2))
    for _ in range(3):
        matches.step(np.zeros(2, dtype=np.int64))
    matches.discard()
    lanes = matches.batch.lanes
    assert lanes["episode"].tolist() == [2, 2]
    assert not lanes["ended"].any() and not lanes["dt"].any()
    matches.step(np.zeros(2, dtype=np.int64))
    assert (lanes["dt"] == lanes["cycle"] - lanes["start"]).all()


def test_an_end_is_seen_by_who_decided_last() -> None:
    """The last belief differs from that of the last decision: the ball has left since."""
    matches = VectorMatch(TASK, 4, goes_on=False)
    matches.begin(seeds(4))
    seen = 0
    for _ in range(60):
        before = matches.batch.observations.copy()
        matches.step(np.ones(4, dtype=np.int64))
        for i in np.flatnonzero(matches.batch.lanes["ended"]):
            final = matches.batch.final_observations[i]
            assert np.isfinite(final).all() and (final >= 0.0).all()
            seen += not np.array_equal(final, before[i])
    assert seen > 3


@pytest.mark.parametrize(("matches", "threads"), [(0, 1), (1, 0)])
def test_nothing_is_played_without_a_match_or_a_thread(matches: int, threads: int) -> None:
    with pytest.raises(ValueError, match="there must be a match and a thread"):
        VectorMatch(TASK, matches, threads)
