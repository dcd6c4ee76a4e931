"""Keepaway for PettingZoo, turn by turn and in parallel, in the arena and over UDP."""

from __future__ import annotations

import contextlib
import random
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest
from pettingzoo.test import api_test, max_cycles_test, parallel_api_test, parallel_seed_test, seed_test
from quick_servers import QuickServer

from rcss_hat.envs import KeepawayEnv, keepaway_v0

Turn = tuple[Any, ...]
STAGES = pytest.mark.parametrize("stage", ["arena", "fake"])


@contextlib.contextmanager
def without_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def turns(episodes: int, seed: int = 3, **options: Any) -> list[Turn]:
    """Play at random, turn by turn: who saw and did what when, with what reward; ends included."""
    env, draw, told = keepaway_v0.env(**options), random.Random(1), []
    for episode in range(episodes):
        env.reset(seed=seed if episode == 0 else None)
        for agent in env.agent_iter():
            seen, reward, terminated, truncated, info = env.last()
            over = terminated or truncated
            action = None if over else draw.randrange(int(info["action_mask"].sum()))
            rest = {name: value for name, value in info.items() if name != "action_mask"}
            told.append((agent, seen.tolist(), reward, terminated, truncated, rest, action))
            env.step(action)
    env.close()
    return told


def cycles_in_parallel(episodes: int, seed: int = 3, **options: Any) -> list[Turn]:
    env, draw, told = keepaway_v0.parallel_env(**options), random.Random(1), []
    for episode in range(episodes):
        seen, infos = env.reset(seed=seed if episode == 0 else None)
        while env.agents:
            actions = {a: draw.randrange(int(infos[a]["action_mask"].sum())) for a in env.agents}
            seen, rewards, terminations, truncations, infos = env.step(actions)
            rest = {a: (info["cycle"], info["number"], info["action_mask"].tolist()) for a, info in infos.items()}
            told.append(({a: s.tolist() for a, s in seen.items()}, rewards, terminations, truncations, rest))
    env.close()
    return told


def test_turns_are_the_decisions_of_the_single_environment() -> None:
    one, told = KeepawayEnv(), turns(3, per="decision")
    _, info = one.reset(seed=3)
    for agent, _seen, _, terminated, _, there, action in told:
        if terminated:
            continue
        assert agent == f"keeper_{info['keeper']}"
        assert (there["cycle"], there["number"]) == (info["cycle"], info["number"])
        _, _, over, _, info = one.step(action)
        if over:
            _, info = one.reset()


@pytest.mark.parametrize("options", [{"per": "decision"}, {}])
def test_a_team_gets_the_duration_of_the_episode(options: dict[str, Any]) -> None:
    env = keepaway_v0.env(taker_agents=True, **options)
    for episode in range(3):
        env.reset(seed=5 if episode == 0 else None)
        total = dict.fromkeys(env.possible_agents, 0.0)
        for agent in env.agent_iter():
            _, reward, over, _, info = env.last()
            total[agent] += reward
            env.step(None if over else 0)
        for agent, sum_ in total.items():
            assert sum_ == (info["duration"] if agent.startswith("keeper") else -info["duration"])


def test_a_keepers_own_reward_is_the_cycles_to_its_next_decision() -> None:
    last: dict[str, int] = {}
    for agent, _, reward, terminated, _, info, _ in turns(4, per="decision", reward="own"):
        assert reward == (info["cycle"] - last[agent] if agent in last else 0.0)
        last[agent] = info["cycle"]
        if terminated:
            last.pop(agent)


def test_takers_that_go_by_their_own_mind_play_the_same_game() -> None:
    def ends(**options: Any) -> list[tuple[int, str]]:
        env, found = keepaway_v0.env(per="decision", **options), []
        for episode in range(5):
            env.reset(seed=5 if episode == 0 else None)
            for _ in env.agent_iter():
                _, _, over, _, info = env.last()
                env.step(None if over else 0)
            found.append((info["duration"], info["reason"]))
        return found

    assert ends(taker_agents=True) == ends() == ends(taker_agents=True, taker_cycles=1)


def test_an_agent_that_decides_sees_what_it_sees_turn_by_turn() -> None:
    env, at = keepaway_v0.parallel_env(), dict[tuple[int, str], list[float]]()
    told = turns(3, per="decision")
    for agent, seen, _, over, _, info, _ in told:
        if not over:
            at[info["cycle"], agent] = seen
    actions = {(info["cycle"], agent): action for agent, _, _, over, _, info, action in told if not over}
    found = 0
    for episode in range(3):
        seen, infos = env.reset(seed=3 if episode == 0 else None)
        while env.agents:
            cycle = infos["keeper_1"]["cycle"]
            for agent in env.agents:
                if infos[agent]["action_mask"].sum() > 1:
                    assert seen[agent].tolist() == at[cycle, agent]
                    found += 1
            seen, _, _, _, infos = env.step({agent: actions.get((cycle, agent), 0) for agent in env.agents})
    assert found == len(actions)


def test_what_differs_is_refused() -> None:
    for options in ({"reward": "mine"}, {"taker_cycles": 0}, {"taker_agents": True, "takers": lambda *_: 0}):
        with pytest.raises(ValueError, match=r"reward is|taker_cycles must|not both"):
            keepaway_v0.parallel_env(**options)
    with pytest.raises(ValueError, match="per='decision'"):
        keepaway_v0.parallel_env(stage="fake", taker_agents=True)
    env = keepaway_v0.env(per="decision")
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r"keeper_\d has the actions 0 to 2, not 3"):
        env.step(3)


def test_over_udp_it_is_the_same(quick_servers: list[QuickServer]) -> None:
    assert turns(3, per="decision", stage="fake") == turns(3, per="decision")
    assert cycles_in_parallel(2, stage="fake", max_cycles=40) == cycles_in_parallel(2, max_cycles=40)


def test_takers_can_be_agents_over_udp(quick_servers: list[QuickServer]) -> None:
    told = turns(1, per="decision", stage="fake", taker_agents=True)
    assert {agent for agent, *_ in told} >= {"taker_1", "taker_2"}


@STAGES
@pytest.mark.parametrize("per", ["cycle", "decision"])
def test_pettingzoo_checks_its_turns(quick_servers: list[QuickServer], stage: str, per: str) -> None:
    with without_warnings():
        api_test(keepaway_v0.env(stage=stage, per=per), num_cycles=60)
        seed_test(lambda: keepaway_v0.env(stage=stage, per=per), num_cycles=15)


@STAGES
def test_pettingzoo_checks_what_goes_in_parallel(quick_servers: list[QuickServer], stage: str) -> None:
    with without_warnings():
        env = keepaway_v0.parallel_env(stage=stage)
        parallel_api_test(env, num_cycles=60)
        env.close()
        parallel_seed_test(lambda: keepaway_v0.parallel_env(stage=stage), num_cycles=15)


@STAGES
def test_pettingzoo_counts_its_cycles(quick_servers: list[QuickServer], stage: str) -> None:
    made: list[Any] = []

    def of(make: Callable[..., Any], **options: Any) -> Any:
        made.append(make(stage=stage, **options))
        return made[-1]

    both = SimpleNamespace(parallel_env=partial(of, keepaway_v0.parallel_env), env=partial(of, keepaway_v0.env))
    with without_warnings():
        max_cycles_test(both)
    for env in made:
        env.close()


def test_takers_see_something_else_and_pettingzoo_says_only_that() -> None:
    with pytest.warns(UserWarning, match="different observation space sizes") as said:
        api_test(keepaway_v0.env(taker_agents=True, per="decision"), num_cycles=60)
        parallel_api_test(keepaway_v0.parallel_env(taker_agents=True), num_cycles=60)
    assert {str(w.message) for w in said} == {"Agents have different observation space sizes"}
