"""What the loop leaves to others: a pause at the end of every episode, and takers who are told what to do."""

from __future__ import annotations

from itertools import pairwise

import pytest

from rcss_hat.arena.loop import run
from rcss_hat.arena.match import NEVER, ArenaMatch, prepare
from rcss_hat.arena.records import BALL_STUCK, EPISODE_OVER, NEEDS_ACTION, PERCEIVE
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.taker import GO_TO_BALL, HAND_CODED, n_macro_actions
from rcss_hat.keepaway.taker_state import n_taker_variables, taker_state_names
from rcss_hat.keepaway.task import Task
from rcss_hat.simulation import keepaway
from rcss_hat.simulation.referee import award_drop_ball

pytestmark = pytest.mark.compiled

EPISODES = 6
Asked = list[tuple[int, int]]


def begun(task: Task, policy: str = "hand") -> ArenaMatch:
    prepare()
    match = ArenaMatch(task, 5, load_policy(policy, task.keepers, task.takers, 5))
    keepaway.kick_off(match.world)
    match.control["stop_cycle"] = match.control["stop_episode"] = NEVER
    match.team.pauses[0] = 1
    return match


def played(task: Task, order: int | None, lasts: int = 1) -> tuple[list[Episode], Asked]:
    """Play with all takers told the same from outside; None: nobody asks."""
    match, asked, episodes = begun(task), Asked(), list[Episode]()
    match.team.orders["outside"][task.keepers :] = order is not None
    match.team.orders["lasts"] = lasts
    while len(episodes) < EPISODES:
        reason = run(match.world, match.team, match.brains, match.control, match.logs)
        if reason == NEEDS_ACTION:
            assert order is not None
            asked.append((match.cycle, int(match.control["player"][0])))
            match.control["choice"], match.control["has_choice"] = order, 1
        elif reason == BALL_STUCK:
            award_drop_ball(match.world)
        else:
            assert reason == EPISODE_OVER
            assert match.control["phase"][0] == PERCEIVE
            episodes += match._take_episodes()
    return episodes, asked


@pytest.fixture(scope="module")
def usual() -> list[Episode]:
    return [
        e for ended in ArenaMatch(Task(), 5, load_policy("hand", 3, 2, 5)).advance(episodes=EPISODES) for e in ended
    ]


def test_a_pause_at_every_end_changes_nothing(usual: list[Episode]) -> None:
    assert played(Task(), None) == (usual, [])


def test_takers_who_are_told_to_go_by_their_own_mind_do(usual: list[Episode]) -> None:
    episodes, asked = played(Task(), HAND_CODED)
    assert episodes == usual
    assert {player for _, player in asked} == {3, 4}


def test_an_order_holds_for_as_many_cycles_as_it_lasts(usual: list[Episode]) -> None:
    episodes, asked = played(Task(), HAND_CODED, lasts=5)
    assert episodes == usual
    ends = {episode.end for episode in episodes}
    for player in (3, 4):
        cycles = [cycle for cycle, p in asked if p == player]
        pauses = [(a, b) for a, b in pairwise(cycles) if b - a < 5]
        assert all(any(a < end <= b for end in ends) for a, b in pauses), "only a new episode asks earlier"


def test_what_takers_are_told_makes_a_difference(usual: list[Episode]) -> None:
    block = n_macro_actions(3) - 1
    assert played(Task(), block)[0] != usual
    four = Task.parse("4v3")
    assert played(four, GO_TO_BALL)[0] != played(four, None)[0]


def test_a_taker_sees_by_name_what_its_record_holds() -> None:
    for n, m in ((3, 2), (4, 3), (5, 4)):
        names = taker_state_names(n, m)
        assert len(names) == len(set(names)) == n_taker_variables(n, m)


def test_a_takers_state_agrees_with_where_everybody_is() -> None:
    match = begun(Task(), "hold")
    match.team.orders["outside"][3:] = 1
    match.team.orders["lasts"] = 1
    for _ in range(40):
        assert run(match.world, match.team, match.brains, match.control, match.logs) == NEEDS_ACTION
        match.control["choice"], match.control["has_choice"] = HAND_CODED, 1
    names = taker_state_names(3, 2)
    state = dict(zip(names, match.team.taker_state, strict=True))
    pos, ball = match.world.match["pos"][0], match.world.match["ball_pos"][0]
    me = int(match.team.seats[match.control["player"][0]])
    assert state["dist(T,B)"] == pytest.approx(((pos[me] - ball) ** 2).sum() ** 0.5, abs=1.0)
    near = min(range(3), key=lambda k: ((pos[k] - ball) ** 2).sum())
    assert state["dist(T,K1)"] == pytest.approx(((pos[me] - pos[near]) ** 2).sum() ** 0.5, abs=1.0)
    assert state["dist(K1,K2)"] <= state["dist(K1,K3)"]
    assert state["min_ang(K2,K1,T)"] <= state["ang(K2,K1,T)"] <= 180.0
