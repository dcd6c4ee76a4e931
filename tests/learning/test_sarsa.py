from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from plain_sarsa import PlainSarsa, cmac_features, rbf_features

from rcss_hat.learning import sarsa
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.learning.create import initial_traces, initial_weights, learner_record
from rcss_hat.learning.features import Approximator, cmac, rbf
from rcss_hat.numeric.rng import LEARNER, stream


class Keeper:
    """The arrays of one learner in the order the kernels take them."""

    def __init__(self, config: LearnerConfig, approximator: Approximator, n_actions: int = 3, seed: int = 0) -> None:
        self.learner = learner_record(config, approximator, n_actions)
        self.rng = stream(seed, LEARNER, 0)
        self.features, self.table = approximator.record, approximator.table
        self.weights = initial_weights(config, approximator, n_actions)
        self.traces = initial_traces(config, approximator, n_actions)
        self.approximator = approximator

    @property
    def arrays(self) -> sarsa.Learner:
        return sarsa.Learner(self.learner, self.rng, self.features, self.table, self.weights, self.traces)

    def observe(self, state: list[float]) -> np.ndarray:
        sarsa.observe(self.arrays, np.array(state))
        return self.learner["q"][0, : len(self.weights)].copy()

    def begin(self, action: int, bonus: float = 0.0) -> None:
        sarsa.begin(self.arrays, action, bonus)

    def advance(self, reward: float, action: int, bonus: float = 0.0) -> None:
        sarsa.advance(self.arrays, reward, action, bonus)

    def start(self, state: list[float]) -> int:
        self.observe(state)
        action = sarsa.select_epsilon_greedily(self.learner, self.rng)
        self.begin(action)
        return action

    def step(self, reward: float, state: list[float]) -> int:
        self.observe(state)
        action = sarsa.select_epsilon_greedily(self.learner, self.rng)
        self.advance(reward, action)
        return action

    def end(self, reward: float) -> None:
        sarsa.conclude(self.arrays, reward)
        sarsa.count_episode(self.learner)


def one_tile_keeper(**settings: float) -> Keeper:
    """One variable, one tiling of width 1: every integer is a state of a table."""
    return Keeper(LearnerConfig(tilings=1, alpha=0.5, **settings), cmac([1.0], [10.0], tilings=1))


def test_hand_computed_episode() -> None:
    keeper = one_tile_keeper()
    keeper.weights[:, :] = [[1.0, 2.0] + [0.0] * 9, [3.0, 4.0] + [0.0] * 9, [0.0] * 11]
    assert keeper.observe([0.5]).tolist() == [1.0, 3.0, 0.0]
    keeper.begin(0)
    assert keeper.observe([1.5]).tolist() == [2.0, 4.0, 0.0]
    keeper.advance(7.0, 1)  # Q(0, a0) += 0.5 (7 + 4 - 1) = 6
    assert keeper.weights[0, 0] == 6.0
    assert keeper.observe([1.2]).tolist() == [2.0, 4.0, 0.0]
    keeper.advance(1.0, 1)  # Q(1, a1) += 0.5 (1 + 4 - 4) = 4.5; the value remembered is the new one
    assert keeper.weights[1, 1] == keeper.learner["last_value"][0] == 4.5
    keeper.end(10.0)  # Q(1, a1) += 0.5 (10 - 4.5), no bootstrap
    assert keeper.weights[1, 1] == 7.25
    assert keeper.weights.sum() == 6.0 + 2.0 + 3.0 + 7.25
    assert keeper.learner["last_action"][0] == -1


def test_selection_precedes_the_update() -> None:
    keeper = one_tile_keeper(epsilon=0.0)
    keeper.weights[:, 0] = [5.0, 4.0, 0.0]
    assert keeper.start([0.0]) == 0
    # The update will bring Q(s, 0) to 5 + 0.5 (-100 + 5 - 5) = -45, but the choice is made from the old 5.
    assert keeper.step(-100.0, [0.0]) == 0
    assert keeper.weights[0, 0] == keeper.learner["last_value"][0] == -45.0
    assert keeper.step(0.0, [0.0]) == 1


def test_a_bonus_belongs_to_the_value_of_the_action() -> None:
    keeper = one_tile_keeper()
    keeper.observe([0.0])
    keeper.begin(0, bonus=10.0)
    assert keeper.learner["last_value"][0] == 10.0
    keeper.observe([1.0])
    keeper.advance(2.0, 1, bonus=6.0)
    assert keeper.weights[0, 0] == 0.5 * (2.0 + 6.0 - 10.0)
    assert keeper.learner["last_value"][0] == 6.0
    keeper.observe([1.0])
    keeper.advance(4.0, 1, bonus=6.0)
    assert keeper.weights[1, 1] == 0.5 * (4.0 + 6.0 - 6.0)
    assert keeper.learner["last_value"][0] == 2.0 + 6.0


def test_discount() -> None:
    keeper = one_tile_keeper(gamma=0.5)
    keeper.weights[1, 1] = 8.0
    keeper.observe([0.0])
    keeper.begin(0)
    keeper.observe([1.0])
    keeper.advance(2.0, 1)
    assert keeper.weights[0, 0] == 0.5 * (2.0 + 0.5 * 8.0)


def test_a_keeper_that_never_acted_learns_nothing_but_counts_the_episode() -> None:
    keeper = one_tile_keeper()
    keeper.end(123.0)
    keeper.end(123.0)
    assert not keeper.weights.any()
    assert keeper.learner["episodes"][0] == 2


def test_without_learning_nothing_moves_and_nothing_is_explored() -> None:
    keeper = one_tile_keeper(epsilon=1.0)
    keeper.weights[:, 0] = [1.0, 2.0, 3.0]
    before = keeper.weights.copy()
    keeper.learner["learning"] = keeper.learner["exploring"] = 0
    assert [keeper.start([0.0])] + [keeper.step(5.0, [0.0]) for _ in range(20)] == [2] * 21
    keeper.end(9.0)
    assert (keeper.weights == before).all()
    assert keeper.learner["episodes"][0] == keeper.learner["decisions"][0] == 0


def test_step_size_and_epsilon_decay_per_episode_to_their_ends() -> None:
    keeper = one_tile_keeper(alpha_decay=0.5, alpha_final=0.2, epsilon=0.4, epsilon_decay=0.5, epsilon_final=0.1)
    seen = []
    for _ in range(4):
        seen.append((float(keeper.learner["step"][0]), float(keeper.learner["epsilon"][0])))
        keeper.end(0.0)
    assert seen == [(0.5, 0.4), (0.25, 0.2), (0.2, 0.1), (0.2, 0.1)]


WIDTHS, RANGES = [2.0, 3.0, 10.0], [30.0, 30.0, 180.0]


def approximators() -> dict[str, tuple]:
    return {
        "cmac": (cmac(WIDTHS, RANGES), lambda s: cmac_features(s, WIDTHS, 32)),
        "rbf": (rbf(WIDTHS, RANGES), lambda s: rbf_features(s, WIDTHS, 32, 0.25, 0.75)),
        "rbf-1": (rbf(WIDTHS, RANGES, tilings=1), lambda s: rbf_features(s, WIDTHS, 1, 0.25, 0.75)),
    }


@pytest.mark.parametrize("lambda_", [0.0, 0.5, 0.95])
@pytest.mark.parametrize("kind", ["cmac", "rbf", "rbf-1"])
def test_learning_agrees_with_the_plain_equations(kind: str, lambda_: float) -> None:
    approximator, features_of = approximators()[kind]
    config = LearnerConfig(alpha=0.3, divisor="norm", lambda_=lambda_)
    keeper = Keeper(config, approximator)
    plain = PlainSarsa(3, config.alpha / approximator.norm, config.gamma, lambda_)
    random = np.random.default_rng(5)
    compared = 0
    for _ in range(6):
        state = random.uniform(0.0, RANGES)
        for decision in range(25):
            # A walk of small steps, so that features of neighbouring states overlap.
            state = np.clip(state + random.normal(0.0, [0.5, 0.5, 5.0]), 0.0, RANGES)
            action, reward = int(random.integers(3)), float(random.integers(1, 40))
            features = features_of(state.tolist())
            assert keeper.observe(state.tolist()) == pytest.approx(plain.values(features), rel=1e-9, abs=1e-9)
            if decision == 0:
                keeper.begin(action)
                plain.start(features, action)
            else:
                keeper.advance(reward, action)
                plain.step(reward, features, action)
            assert keeper.learner["last_value"][0] == pytest.approx(plain.last_value, rel=1e-9, abs=1e-9)
            compared += 1
        keeper.end(12.0)
        plain.end(12.0)
    assert compared == 150
    assert keeper.weights.sum() == pytest.approx(sum(plain.weights.values()), rel=1e-9)
    assert np.abs(keeper.weights).sum() == pytest.approx(sum(map(abs, plain.weights.values())), rel=1e-9)


def test_traces_carry_a_reward_back_over_several_decisions() -> None:
    keeper = one_tile_keeper(lambda_=0.5)
    for k, state in enumerate([0.0, 1.0, 2.0]):
        keeper.observe([state])
        keeper.begin(0) if k == 0 else keeper.advance(0.0, 0)
    keeper.end(8.0)
    assert keeper.weights[0, :3].tolist() == [1.0, 2.0, 4.0]
    keeper.observe([0.0])
    keeper.begin(0)
    keeper.end(keeper.weights[0, 0])
    assert keeper.weights[0, :3].tolist() == [1.0, 2.0, 4.0], "traces of the episode before are gone"


def test_taking_another_action_in_a_state_clears_the_first_one_s_trace() -> None:
    keeper = one_tile_keeper(lambda_=0.5)
    keeper.observe([0.0])
    keeper.begin(0)
    keeper.observe([0.0])
    keeper.advance(0.0, 1)
    keeper.end(8.0)
    assert keeper.weights[:, 0].tolist() == [0.0, 4.0, 0.0]


def test_initial_value() -> None:
    for kind in ("cmac", "rbf"):
        config = LearnerConfig(approximator=kind, initial_value=50.0)
        keeper = Keeper(config, config.build(3, 2))
        assert keeper.observe([5.0] * 13) == pytest.approx([50.0] * 3, rel=1e-3)


# --- a small semi-Markov decision process -------------------------------------------------------------------------
# Two states, two actions; per (state, action): reward and the probabilities of going on to state 0 and to state 1.
REWARDS = np.array([[1.0, 2.0], [1.0, 6.0]])
ONWARD = np.array([[[0.9, 0.0], [0.0, 0.5]], [[0.0, 0.5], [0.0, 0.0]]])
PLACES = [1.0, 9.0]


def values_of_the_greedy_policy(epsilon: float) -> tuple[np.ndarray, np.ndarray]:
    """Action values of the epsilon-greedy policy that is greedy for its own values, and its greedy actions."""
    greedy = np.array([0, 0])
    for _ in range(10):
        policy = np.full((2, 2), epsilon / 2)
        policy[[0, 1], greedy] += 1.0 - epsilon
        onward = np.einsum("sat,tb->satb", ONWARD, policy).reshape(4, 4)
        q = np.linalg.solve(np.eye(4) - onward, REWARDS.reshape(4)).reshape(2, 2)
        greedy = q.argmax(axis=1)
    return q, greedy


@pytest.mark.parametrize("kind", ["cmac", "rbf"])
def test_both_learners_solve_a_small_smdp(kind: str) -> None:
    expected, best = values_of_the_greedy_policy(epsilon=0.2)
    assert best.tolist() == [0, 1]
    make = {"cmac": cmac, "rbf": rbf}[kind]
    config = LearnerConfig(alpha=0.2, divisor="norm", epsilon=0.2, alpha_decay=0.9995, alpha_final=0.002)
    keeper = Keeper(config, make([1.0], [10.0]), n_actions=2, seed=4)
    random = np.random.default_rng(11)
    for _ in range(8_000):
        state = int(random.integers(2))
        action = keeper.start([PLACES[state]])
        while True:
            reward, chances = REWARDS[state, action], ONWARD[state, action]
            draw = random.random()
            if draw >= chances.sum():
                break
            state = 0 if draw < chances[0] else 1
            action = keeper.step(reward, [PLACES[state]])
        keeper.end(reward)
    learned = np.array([keeper.observe([place]) for place in PLACES])
    assert learned == pytest.approx(expected, rel=0.06)
    assert learned.argmax(axis=1).tolist() == best.tolist()


# --- repeatability ------------------------------------------------------------------------------------------------
def play(seed: int, kind: str = "rbf", lambda_: float = 0.0) -> tuple[list[int], bytes]:
    """Learn from made-up rewards; returns the actions and the bytes of the weights."""
    config = LearnerConfig(approximator=kind, epsilon=0.1, lambda_=lambda_)
    keeper = Keeper(config, config.build(3, 2), seed=seed)
    random = np.random.default_rng(1)
    actions = []
    for _ in range(3):
        actions.append(keeper.start(random.uniform(0.0, 20.0, 13)))
        actions += [keeper.step(float(random.integers(1, 30)), random.uniform(0.0, 20.0, 13)) for _ in range(6)]
        keeper.end(5.0)
    return actions, keeper.weights.tobytes()


def test_a_seed_decides_everything() -> None:
    assert play(1) == play(1)
    assert play(1)[0] != play(2)[0]


@pytest.mark.parametrize(("kind", "lambda_"), [("cmac", 0.0), ("rbf", 0.5)])
def test_the_plain_python_mode_learns_the_same_bits(kind: str, lambda_: float) -> None:
    program = (
        "import hashlib, test_sarsa\n"
        f"actions, weights = test_sarsa.play(1, {kind!r}, {lambda_})\n"
        "print(actions, hashlib.sha256(weights).hexdigest())"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "NUMBA_DISABLE_JIT": disabled, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for disabled in ("0", "1")
    }
    assert len(outputs) == 1


def test_too_many_actions_are_refused() -> None:
    with pytest.raises(ValueError, match="1 to 11 actions, not 12"):
        learner_record(LearnerConfig(), cmac([1.0], [1.0]), 12)
