"""Keepaway for Gymnasium, in the arena."""

from __future__ import annotations

import random
import tomllib
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordEpisodeStatistics

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.envs import KeepawayEnv
from rcss_hat.envs.registration import IDS
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.policies import hand

SIZES = pytest.mark.parametrize("size", ["3v2", "4v3"])
Choose = Callable[[KeepawayEnv], int]


def by_hand(env: KeepawayEnv) -> int:
    task = env.options.task
    return int(hand(env.state, task.keepers, task.takers))


def at_random(seed: int) -> Choose:
    draw = random.Random(seed)
    return lambda env: draw.randrange(int(env.action_space.n))  # type: ignore[attr-defined]


def played(env: KeepawayEnv, choose: Choose) -> tuple[float, int, dict[str, Any]]:
    """Play an episode that was reset to its end: return, steps, last info."""
    total, steps, over, info = 0.0, 0, False, dict[str, Any]()
    while not over:
        seen, reward, terminated, truncated, info = env.step(choose(env))
        assert env.observation_space.contains(seen)
        total, steps, over = total + reward, steps + 1, terminated or truncated
    return total, steps, info


@SIZES
@pytest.mark.parametrize("vision", [360, 90])
def test_the_same_seed_is_the_match_that_play_logs(size: str, vision: int) -> None:
    env = KeepawayEnv(size=size, vision=vision)
    match = ArenaMatch(env.options.task, 5, load_policy("hand", *map(int, size.split("v")), 5), log_decisions=True)
    episodes = {e.number: e for ended in match.advance(episodes=8) for e in ended}
    logged = [(d["cycle"], d["keeper"], d["action"], *d["state"]) for d in match.take_decisions()]
    _, info = env.reset(seed=5)
    mine = list[tuple[Any, ...]]()
    while info["number"] <= 6:
        mine.append((info["cycle"], info["keeper"], by_hand(env), *env.state))
        _, _, over, _, info = env.step(mine[-1][2])
        if over:
            episode = episodes[info["number"]]
            assert (info["duration"], info["cycle"]) == (episode.cycles, episode.end)
            assert info["reason"] == {"o": "out", "t": "taken"}[episode.reason]
            _, info = env.reset()
    assert mine == logged[: len(mine)]
    assert len(mine) > 40


@SIZES
@pytest.mark.parametrize("normalize", [False, True])
def test_a_return_is_the_duration_of_the_episode_in_cycles(size: str, normalize: bool) -> None:
    env = KeepawayEnv(size=size, vision=90, normalize=normalize)
    choose = at_random(1)
    for episode in range(30):
        seen, info = env.reset(seed=3 if episode == 0 else None)
        assert env.observation_space.contains(seen)
        assert info["elapsed"] > 0
        total, _, last = played(env, choose)
        assert total == last["duration"] == last["elapsed"] > 0
        assert last["status"] == 0
    assert last["number"] == 30 + env.skipped


def test_episodes_without_a_decision_are_skipped_and_counted() -> None:
    env = KeepawayEnv()
    match = ArenaMatch(env.options.task, 1, load_policy("hold", 3, 2, 1), log_decisions=True)
    ended = [e for episodes in match.advance(episodes=20) for e in episodes]
    decided = {int(d["episode"]) for d in match.take_decisions()}
    without = [e.number for e in ended if e.number not in decided]
    assert without, "the seed is chosen for it"
    _, info = env.reset(seed=1)
    while info["number"] < 20:
        *_, info = played(env, lambda env: 0)
        assert info["number"] not in without
        assert info["skipped"] == sum(number < info["number"] for number in without)
        env.reset()


def test_the_final_observation_is_from_the_end_of_the_episode() -> None:
    env, taken = KeepawayEnv(), 0
    for episode in range(10):
        env.reset(seed=4 if episode == 0 else None)
        _, _, last = played(env, lambda env: 0)
        assert last["perceived"]
        if last["reason"] == "taken":
            taken += 1
            assert env.state[3] < 4.0, "the nearest taker is at the ball, not in his corner again"
    assert taken > 3


def test_a_discounted_return_is_the_discounted_duration() -> None:
    env, rewards, discounts = KeepawayEnv(discount=0.95), list[float](), list[float]()
    _, info = env.reset(seed=2)
    assert info["discount"] == 1.0
    over = False
    while not over:
        _, reward, over, _, info = env.step(1)
        assert reward == pytest.approx(sum(0.95**i for i in range(info["dt"])))
        assert info["discount"] == pytest.approx(0.95 ** info["dt"])
        rewards.append(reward)
        discounts.append(info["discount"])
    value = 0.0
    for reward, discount in zip(reversed(rewards), reversed(discounts), strict=True):
        value = reward + discount * value
    assert value == pytest.approx((1.0 - 0.95 ** info["duration"]) / 0.05)


def test_a_step_can_be_a_cycle_with_a_mask() -> None:
    env, choose = KeepawayEnv(per="cycle"), at_random(3)
    usual = KeepawayEnv()
    for episode in range(6):
        seed = 6 if episode == 0 else None
        _, info = env.reset(seed=seed)
        _, there = usual.reset(seed=seed)
        over, first, total = False, True, 0.0
        while not over:
            decides = info["action_mask"].sum() > 1
            action = choose(env) if decides else 0
            _, reward, over, _, info = env.step(action)
            assert first or reward == 1.0
            first, total = False, total + reward
            if decides:
                *_, there = usual.step(action)
        assert total == info["duration"] == there["duration"]
        assert info["action_mask"].tolist() == [1, 0, 0]


@pytest.mark.parametrize("per", ["decision", "cycle"])
def test_long_episodes_are_cut_off_in_their_cycle(per: str) -> None:
    env = KeepawayEnv(max_cycles=25, per=per)
    numbers = []
    for episode in range(8):
        env.reset(seed=6 if episode == 0 else None)
        over = False
        while not over:
            seen, _, terminated, truncated, info = env.step(0)
            over = terminated or truncated
        assert env.observation_space.contains(seen)
        numbers.append(info["number"])
        assert truncated == (info["reason"] == "max_cycles")
        assert info["duration"] == 25 if truncated else info["duration"] <= 25
    assert numbers == sorted(set(numbers)), "every reset goes to another episode"
    assert truncated


def test_a_reset_in_the_middle_discards_what_was_played() -> None:
    env = KeepawayEnv()
    env.reset(seed=9)
    env.step(1)
    _, info = env.reset()
    assert info["number"] == 2
    assert info["dt"] == 0
    total, _, last = played(env, by_hand)
    assert total == last["duration"]


def test_an_episode_begins_where_one_says() -> None:
    env = KeepawayEnv(truth=True)
    keepers = [[0.0, 0.0], [8.0, 0.0], [-8.0, 0.0]]
    where = {"keepers": keepers, "takers": [[0.0, 9.0], [1.0, 9.0]], "ball": [0.4, 0.0]}
    for seed in (1, None, None):
        _, info = env.reset(seed=seed, options={"positions": where})
        assert info["keeper"] == 1
        assert info["elapsed"] <= 6
        np.testing.assert_allclose(info["keepers"][:, :2], keepers, atol=3.0)
        total, _, last = played(env, lambda env: 0)
        assert total == last["duration"]


@pytest.mark.parametrize(
    "positions",
    [
        {"keeper": [[0, 0]]},
        {"keepers": [[0, 0], [1, 1]]},
        {"takers": [[0, 0], [1, float("nan")]]},
        {"ball": [10.0, 0.0]},
        {"ball": "here"},
        [[0, 0]],
    ],
)
def test_places_that_cannot_be_are_refused(positions: Any) -> None:
    with pytest.raises(ValueError, match="positions"):
        KeepawayEnv().reset(seed=1, options={"positions": positions})


def test_what_is_no_action_is_refused() -> None:
    env = KeepawayEnv()
    env.reset(seed=1)
    for action in (-1, 3, 0.5, "1", None):
        with pytest.raises(ValueError, match="legal are 0"):
            env.step(action)  # type: ignore[arg-type]
    env.step(np.int64(1))
    env.step(np.array(1))


def test_an_episode_that_is_over_takes_no_step() -> None:
    env = KeepawayEnv()
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(0)
    env.reset(seed=1)
    played(env, lambda env: 0)
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(0)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("size", "3x2"), ("field", "20"), ("vision", 0), ("profile", "18"), ("stage", "nowhere"), ("takers", "eager"),
        ("hold_cycles", 0), ("max_cycles", 0), ("reward", "goals"), ("discount", 1.5), ("per", "hour"),
    ],
)  # fmt: skip
def test_other_options_are_refused(option: str, value: Any) -> None:
    with pytest.raises(ValueError, match=str(value)):
        KeepawayEnv(**{option: value})


def test_takers_can_be_a_function() -> None:
    asked = []

    def always_the_ball(state: Any, info: dict[str, Any]) -> int:
        asked.append(info["taker"])
        return 1

    env = KeepawayEnv(takers=always_the_ball)
    env.reset(seed=1)
    played(env, by_hand)
    assert set(asked) == {1, 2}


def test_takers_can_be_named_as_on_the_command_line(tmp_path: Path) -> None:
    file = tmp_path / "takers.py"
    file.write_text("def ball(state, info):\n    return 1\n")
    named, given = KeepawayEnv(takers=f"{file}:ball"), KeepawayEnv(takers=lambda state, info: 1)
    named.reset(seed=1)
    given.reset(seed=1)
    assert played(named, by_hand) == played(given, by_hand)


def test_names_and_durations_do_not_depend_on_observations() -> None:
    plain, scaled = KeepawayEnv(), KeepawayEnv(normalize=True)
    assert plain.state_names == scaled.state_names
    plain.reset(seed=3)
    scaled.reset(seed=3)
    assert played(plain, by_hand) == played(scaled, by_hand)


# -- others' code -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", IDS)
def test_gymnasium_makes_and_checks_it_without_a_warning(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(f"rcss_hat/{name}")
        check_env(env.unwrapped, skip_render_check=True)


def test_the_package_names_its_entry_point() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    points = project["entry-points"]["gymnasium.envs"]
    assert list(points) == ["rcss_hat"]
    module, function = points["rcss_hat"].split(":")
    getattr(import_module(module), function)()
    assert {f"rcss_hat/{name}" for name in IDS} <= set(gymnasium.registry)


def test_gymnasium_counts_its_episodes() -> None:
    env = RecordEpisodeStatistics(gymnasium.make("rcss_hat/Keepaway-v0"))
    env.reset(seed=1)
    over = False
    while not over:
        _, _, over, _, info = env.step(0)
    assert info["episode"]["r"] == info["duration"]


def test_stable_baselines_checks_and_monitors_it() -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    monitor = pytest.importorskip("stable_baselines3.common.monitor")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(KeepawayEnv(normalize=True))
    env = monitor.Monitor(KeepawayEnv())
    env.reset(seed=1)
    over = False
    while not over:
        _, _, over, _, info = env.step(0)
    assert info["episode"]["r"] == info["duration"]
