"""Observations: names, and bounds that hold, in metres and degrees or scaled."""

import numpy as np
import pytest

from rcss_hat.envs.rewards import Rewards
from rcss_hat.envs.spaces import PITCH_DIAGONAL, Observations, action_names, action_space
from rcss_hat.keepaway.task import Task


def test_an_observation_has_the_names_of_the_state_variables() -> None:
    seen = Observations(Task())
    assert len(seen.names) == 13
    assert seen.names[0] == "dist(K1,C)"
    assert seen.names[-1] == "min_ang(K3,K1,T)"
    assert seen.space.shape == (13,)
    assert seen.space.dtype == np.float32
    assert seen.space.high[0] == np.float32(PITCH_DIAGONAL)
    assert seen.space.high[-1] == 180.0
    assert not seen.space.low.any()


def test_metres_and_degrees_stay_what_they_are() -> None:
    state = np.linspace(0.0, 30.0, 13)
    np.testing.assert_array_equal(Observations(Task()).of(state), state.astype(np.float32))


@pytest.mark.parametrize("normalize", [False, True])
def test_whatever_a_keeper_believes_is_within_the_bounds(normalize: bool) -> None:
    seen = Observations(Task.parse("4v3"), normalize)
    assert seen.space.contains(seen.of(np.full(19, 1e9)))
    assert seen.space.contains(seen.of(np.nextafter(seen.high, np.inf) / seen.scale))
    assert seen.space.contains(seen.of(np.zeros(19)))


def test_scaled_distances_count_by_the_diagonal_of_the_region() -> None:
    seen = Observations(Task.parse("3v2", "30x40"), normalize=True)
    state = np.full(13, 25.0)
    state[-2:] = 90.0
    np.testing.assert_allclose(seen.of(state), 0.5)


def test_many_states_are_written_at_once_where_they_are_wanted() -> None:
    seen = Observations(Task(), normalize=True)
    states = np.linspace(0.0, 200.0, 26).reshape(2, 13)
    out = np.empty((2, 13), dtype=np.float32)
    seen.write(states, out)
    np.testing.assert_array_equal(out, [seen.of(state) for state in states])


def test_actions_are_hold_and_passes() -> None:
    assert action_space(Task.parse("5v4")).n == 5
    assert action_names(Task()) == ["Hold", "PASS1", "PASS2"]


def test_discounted_rewards_of_an_episode_are_its_discounted_duration() -> None:
    rewards, steps = Rewards(gamma=0.9), [7, 1, 1, 12]
    value = 0.0
    for dt in reversed(steps):
        value = rewards.reward(dt) + rewards.discount(dt) * value
    assert value == pytest.approx(sum(0.9**i for i in range(sum(steps))))
    np.testing.assert_allclose(rewards.reward(np.array(steps)), [rewards.reward(dt) for dt in steps])


def test_plain_rewards_are_cycles_or_seconds() -> None:
    assert Rewards().reward(12) == 12
    assert Rewards("seconds").reward(12) == pytest.approx(1.2)
    assert Rewards().discount(12) == 1.0


@pytest.mark.parametrize(
    ("unit", "gamma"), [("minutes", 1.0), ("cycles", 0.0), ("cycles", 1.1), ("cycles", float("nan"))]
)
def test_other_rewards_are_refused(unit: str, gamma: float) -> None:
    with pytest.raises(ValueError, match=r"^(reward|discount) is "):
        Rewards(unit, gamma)
