"""The vector environment: Gymnasium's interface, and every match as it is alone."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from rcss_hat.arena.vector import VectorMatch
from rcss_hat.envs.keepaway_env import KeepawayEnv
from rcss_hat.envs.spaces import Observations
from rcss_hat.envs.vector import KeepawayVectorEnv
from rcss_hat.keepaway.observation import observation_scale
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.seeds import derived_seed

pytestmark = pytest.mark.compiled
Steps = list[tuple[bytes, float, bool, int]]


def actions_of(seen: np.ndarray) -> np.ndarray:
    return (seen[:, 3] < 6.0).astype(np.int64)


def played(mode: AutoresetMode, steps: int, **settings: Any) -> list[Steps]:
    """What each match went through: observation, reward, end, number of the episode; without mere resets."""
    envs = KeepawayVectorEnv(3, autoreset_mode=mode, **settings)
    seen, _ = envs.reset(seed=4)
    told: list[Steps] = [[] for _ in range(3)]
    over = np.zeros(3, dtype=bool)
    for _ in range(steps):
        new, rewards, terminated, truncated, info = envs.step(actions_of(seen))
        ended = terminated | truncated
        for i in np.flatnonzero(~over):
            last = new[i]
            number = info["number"][i]
            if ended[i] and mode is AutoresetMode.SAME_STEP:
                last, number = info["final_obs"][i], info["final_info"]["number"][i]
            told[i].append((last.tobytes(), float(rewards[i]), bool(ended[i]), int(number)))
        over = ended if mode is AutoresetMode.NEXT_STEP else np.zeros(3, dtype=bool)
        seen = new
        assert envs.observation_space.contains(seen)
    envs.close()
    return told


@pytest.mark.parametrize("settings", [{}, {"normalize": True, "discount": 0.99, "threads": 2}, {"max_cycles": 20}])
def test_both_ways_to_go_on_after_an_end_tell_the_same(settings: dict[str, Any]) -> None:
    one, other = (played(mode, 100, **settings) for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP))
    for a, b in zip(one, other, strict=True):
        assert a == b[: len(a)] and sum(step[2] for step in a) > 1


def test_a_match_has_the_seed_of_its_place() -> None:
    envs = KeepawayVectorEnv(3)
    seen, info = envs.reset(seed=9)
    matches = VectorMatch(Task(), 3)
    matches.begin([derived_seed(9, i) for i in range(3)])
    np.testing.assert_array_equal(seen, matches.batch.observations)
    again, _ = KeepawayVectorEnv(3).reset(seed=[derived_seed(9, i) for i in range(3)])
    np.testing.assert_array_equal(seen, again)
    assert (info["keeper"] >= 1).all() and (info["dt"] == 0).all() and info["_dt"].all()


def test_rewards_sum_up_to_the_duration_in_seconds() -> None:
    envs = KeepawayVectorEnv(2, reward="seconds", autoreset_mode="SameStep")
    seen, _ = envs.reset(seed=1)
    returns, ends = np.zeros(2), 0
    while ends < 3:
        seen, rewards, terminated, _, info = envs.step(actions_of(seen))
        returns += rewards
        for i in np.flatnonzero(terminated):
            assert returns[i] == pytest.approx(info["final_info"]["duration"][i] / 10.0)
            assert info["final_info"]["reason"][i] in ("out", "taken")
            returns[i], ends = 0.0, ends + 1


def test_discounted_rewards_are_those_of_a_semi_markov_decision_process() -> None:
    envs = KeepawayVectorEnv(2, discount=0.9)
    envs.reset(seed=1)
    _, rewards, _, _, info = envs.step(np.array([1, 0]))
    np.testing.assert_allclose(rewards, [sum(0.9**i for i in range(dt)) for dt in info["dt"]])
    np.testing.assert_allclose(info["discount"], 0.9 ** info["dt"])


def test_a_reset_without_a_seed_goes_on_with_the_next_episode() -> None:
    envs = KeepawayVectorEnv(2)
    envs.reset(seed=1)
    envs.step(np.array([0, 0]))
    _, info = envs.reset()
    assert (info["number"] == 2 + info["skipped"]).all()


def test_observations_are_the_callers_own_unless_asked_for_otherwise() -> None:
    for copy in (True, False):
        envs = KeepawayVectorEnv(2, copy=copy)
        seen, _ = envs.reset(seed=1)
        before = seen.copy()
        envs.step(np.array([1, 1]))
        assert np.array_equal(seen, before) == copy


@pytest.mark.parametrize("normalize", [False, True])
def test_observations_are_scaled_as_those_of_the_single_environment(normalize: bool) -> None:
    task = Task.parse("4v3")
    scale, high = observation_scale(task, normalize)
    single = Observations(task, normalize)
    np.testing.assert_array_equal(scale, single.scale)
    np.testing.assert_array_equal(high, single.high)


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([0, 3], r"action 3 is none; legal are 0 \(Hold\) to 2"),
        ([0], r"actions must be 2 whole numbers, not an array of int64 of shape \(1,\)"),
        ([0.5, 1.0], "actions must be 2 whole numbers, not an array of float64"),
    ],
)
def test_what_is_no_action_is_refused(actions: list[Any], message: str) -> None:
    envs = KeepawayVectorEnv(2)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match=message):
        envs.step(np.array(actions))


def test_gymnasium_makes_vectors_by_name() -> None:
    envs = gymnasium.make_vec("rcss_hat/Keepaway-4v3-v0", num_envs=3, normalize=True)
    assert isinstance(envs.unwrapped, KeepawayVectorEnv)
    seen, _ = envs.reset(seed=1)
    assert seen.shape == (3, 19) and envs.observation_space.contains(seen)
    envs.close()


def test_wrong_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="autoreset_mode is NEXT_STEP or SAME_STEP"):
        KeepawayVectorEnv(2, autoreset_mode="Disabled")
    with pytest.raises(ValueError, match="max_cycles must be 1 or more"):
        KeepawayVectorEnv(2, max_cycles=0)
    with pytest.raises(ValueError, match="stage: only KeepawayEnv has that"):
        KeepawayVectorEnv(2, stage="fake")
    envs = KeepawayVectorEnv(2)
    with pytest.raises(ValueError, match="reset comes before the first step"):
        envs.step(np.zeros(2, dtype=int))
    with pytest.raises(ValueError, match="a seed for each of 2 matches, not 1"):
        envs.reset(seed=[1])
    with pytest.raises(ValueError, match="no options are known here; these were given: positions"):
        envs.reset(options={"positions": 1})


@pytest.mark.parametrize("settings", [{}, {"size": "4v3", "normalize": True, "max_cycles": 25, "discount": 0.95}])
def test_a_match_goes_as_in_the_single_environment(settings: dict[str, Any]) -> None:
    envs, single = KeepawayVectorEnv(2, **settings), KeepawayEnv(**settings)
    seen, told = envs.reset(seed=6)
    alone, info = single.reset(seed=derived_seed(6, 1))
    over, ends = False, 0
    for _ in range(150):
        np.testing.assert_array_equal(seen[1], alone)
        assert {name: told[name][1] for name in info} == info
        actions = actions_of(seen)
        seen, rewards, terminated, truncated, told = envs.step(actions)
        if over:
            alone, info = single.reset()
            reward, ended, cut = 0.0, False, False
        else:
            alone, reward, ended, cut, info = single.step(int(actions[1]))
        assert (rewards[1], terminated[1], truncated[1]) == (reward, ended, cut)
        over = ended or cut
        ends += over
    assert ends > 2
