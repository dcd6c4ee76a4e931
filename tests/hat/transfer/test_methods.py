from __future__ import annotations

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from rcss_hat.hat.transfer import (
    CHAT,
    METHODS,
    NO_ADVICE,
    PPR,
    ExtraAction,
    Learners,
    NoPrior,
    Replay,
    TransferMethod,
    ValueBonus,
    make_method,
    parameters,
)
from rcss_hat.hat.transfer.kernels import executed_action, select
from rcss_hat.hat.transfer.reuse import reuse_probability
from rcss_hat.learning import LearnerConfig

STATE = np.linspace(1.0, 13.0, 13)
DRAWS = 12_000


def team_of(method: TransferMethod, epsilon: float = 0.0, **settings: float) -> Learners:
    return Learners.create(LearnerConfig(epsilon=epsilon, **settings), method, seed=1)


def selected(
    method: TransferMethod,
    q: list[float],
    advice: int,
    episodes: int = 0,
    confidence: float = 1.0,
    epsilon: float = 0.0,
    learning: bool = True,
) -> list[float]:
    """Share of decisions in which each index is selected."""
    team = team_of(method, epsilon)
    team.records["q"][0, : len(q)] = q
    team.records["episodes"] = episodes
    team.records["learning"] = team.records["exploring"] = learning
    chosen = [select(team.method_record, team.records[:1], team.streams[0], advice, confidence) for _ in range(DRAWS)]
    return (np.bincount(chosen, minlength=len(q)) / DRAWS).tolist()


def about(*shares: float) -> object:
    return pytest.approx(list(shares), abs=0.02)


# --- the published hyper-parameters ---------------------------------------------------------------------------------
def test_defaults_are_those_of_the_papers() -> None:
    assert parameters(NoPrior()) == {}
    assert parameters(ValueBonus()) == {"bonus": 10.0, "forced": 100, "in_targets": True}
    assert parameters(ExtraAction()) == {"forced": 100}
    assert parameters(PPR()) == {"decay": 0.999, "schedule": "episode"}
    assert parameters(CHAT())["decay"] == 0.999
    assert list(METHODS) == ["no-prior", "value-bonus", "extra-action", "ppr", "chat", "replay"]


@pytest.mark.parametrize("name", METHODS)
def test_methods_are_made_by_name_and_describe_themselves(name: str) -> None:
    method = make_method(name)
    assert type(method) is METHODS[name]
    assert make_method(name, parameters(method)) == method
    assert method.to_record().shape == (1,)
    assert len(method.describe()) > 10 and "\n" not in method.describe()
    with pytest.raises((FrozenInstanceError, TypeError, AttributeError)):
        method.anything = 1  # type: ignore[attr-defined]


def test_every_method_has_a_kind_of_its_own() -> None:
    assert len({METHODS[name] for name in METHODS}) == len(METHODS)


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("pr", {}, "no transfer method 'pr'; there are no-prior, value-bonus"),
        ("ppr", {"psi": 1.0}, "transfer method ppr has no setting 'psi'; it has decay, schedule"),
        ("no-prior", {"psi": 1.0}, "it has none"),
        ("ppr", {"decay": 1.1}, "decay must be a number from 0 to 1, not 1.1"),
        ("ppr", {"schedule": "hour"}, "schedule must be one of episode, decision, within-episode, not 'hour'"),
        ("value-bonus", {"bonus": math.nan}, "bonus must be a number"),
        ("value-bonus", {"forced": -1}, "forced must be a whole number of at least 0, not -1"),
        ("extra-action", {"forced": 1.5}, "forced must be a whole number of at least 0, not 1.5"),
        ("chat", {"threshold": "high"}, "threshold must be a number from 0 to 1, not 'high'"),
        ("replay", {"passes": True}, "passes must be a whole number of at least 0, not True"),
    ],
)
def test_mistakes_in_settings_are_named(name: str, settings: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_method(name, settings)


# --- No Prior -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", [NoPrior(), Replay()])
def test_no_prior_ignores_advice(method: TransferMethod) -> None:
    assert selected(method, [1.0, 2.0, 0.0], advice=2) == [0.0, 1.0, 0.0]
    assert selected(method, [1.0, 2.0, 0.0], advice=2, epsilon=0.3) == about(0.1, 0.8, 0.1)


def test_no_prior_without_learning_is_the_random_policy() -> None:
    assert selected(NoPrior(), [0.0, 0.0, 0.0], advice=2, learning=False) == about(1 / 3, 1 / 3, 1 / 3)


# --- Value Bonus ----------------------------------------------------------------------------------------------------
def test_value_bonus_forces_the_advice_for_c_episodes_without_exploring() -> None:
    for episodes, shares in ((0, [0, 0, 1]), (99, [0, 0, 1]), (100, [0, 1, 0])):
        assert selected(ValueBonus(), [0.0, 50.0, 0.0], advice=2, episodes=episodes) == shares
    assert selected(ValueBonus(), [0.0, 50.0, 0.0], advice=2, episodes=99, epsilon=1.0) == [0, 0, 1]


def test_value_bonus_then_adds_b_to_the_advised_action() -> None:
    assert selected(ValueBonus(), [5.0, 9.0, 0.0], advice=2, episodes=100) == [0, 0, 1]
    assert selected(ValueBonus(), [5.0, 11.0, 0.0], advice=2, episodes=100) == [0, 1, 0]
    assert selected(ValueBonus(), [5.0, 10.0, 0.0], advice=2, episodes=100) == about(0.0, 0.5, 0.5)
    assert selected(ValueBonus(), [5.0, 9.0, 0.0], advice=2, episodes=100, epsilon=0.3) == about(0.1, 0.1, 0.8)


def test_value_bonus_without_advice_is_no_prior() -> None:
    assert selected(ValueBonus(), [5.0, 9.0, 0.0], advice=NO_ADVICE) == [0, 1, 0]


@pytest.mark.parametrize(("in_targets", "expected"), [(True, 0.125 * (3.0 + 10.0 - 10.0)), (False, 0.125 * 3.0)])
def test_value_bonus_counts_in_targets_unless_told_otherwise(in_targets: bool, expected: float) -> None:
    team = team_of(ValueBonus(in_targets=in_targets))
    keeper = team.keeper(0)
    far = STATE + 30.0  # shares no tile with STATE
    assert keeper.decide(STATE, advice=1) == 1
    assert keeper.decide(far, reward=3.0, advice=2) == 2
    # delta = r + Qb(s', a') - Qb(s, a)
    assert value(team, STATE, 1) == pytest.approx(expected)


def test_the_bonus_can_be_unlearned() -> None:
    # With Q = 0 and Qb = B at first, a terminal reward of 4 makes Qb(s, a) approach 4, not 14.
    team = team_of(ValueBonus())
    keeper = team.keeper(0)
    for _ in range(80):
        keeper.decide(STATE, advice=1)
        keeper.finish_episode(4.0)
    assert value(team, STATE, 1) == pytest.approx(4.0 - 10.0, rel=1e-3)


# --- Extra Action ---------------------------------------------------------------------------------------------------
def test_extra_action_forces_the_pseudo_action_for_c_episodes() -> None:
    for episodes, shares in ((0, [0, 0, 0, 1]), (99, [0, 0, 0, 1]), (100, [0, 1, 0, 0])):
        assert selected(ExtraAction(), [0.0, 50.0, 0.0, 1.0], advice=2, episodes=episodes) == shares
    assert selected(ExtraAction(), [0.0, 50.0, 0.0, 1.0], advice=2, episodes=99, epsilon=1.0) == [0, 0, 0, 1]


def test_extra_action_is_then_one_action_more() -> None:
    assert selected(ExtraAction(), [0.0, 1.0, 0.0, 2.0], advice=2, episodes=100) == [0, 0, 0, 1]
    assert selected(ExtraAction(), [0.0] * 4, advice=2, episodes=100) == about(0.25, 0.25, 0.25, 0.25)
    assert selected(ExtraAction(), [0.0, 0.0, 0.0, 2.0], advice=2, episodes=100, epsilon=0.4) == about(
        0.1, 0.1, 0.1, 0.7
    )


def test_the_pseudo_action_cannot_be_selected_without_advice() -> None:
    assert selected(ExtraAction(), [0.0, 1.0, 0.0, 2.0], advice=NO_ADVICE) == [0, 1, 0, 0]
    assert selected(ExtraAction(), [0.0] * 4, advice=NO_ADVICE, epsilon=1.0) == about(1 / 3, 1 / 3, 1 / 3, 0.0)


def test_the_pseudo_action_executes_the_advice() -> None:
    record = team_of(ExtraAction()).records[:1]
    assert [executed_action(record, 3, advice) for advice in range(3)] == [0, 1, 2]
    assert [executed_action(record, index, 2) for index in range(3)] == [0, 1, 2]


def test_the_pseudo_action_gets_the_credit_alone() -> None:
    team = team_of(ExtraAction())
    keeper = team.keeper(0)
    assert keeper.decide(STATE, advice=1) == 1
    keeper.finish_episode(8.0)
    assert [value(team, STATE, row) for row in range(4)] == pytest.approx([0.0, 0.0, 0.0, 1.0])


def test_an_action_chosen_for_itself_leaves_the_pseudo_action_alone() -> None:
    team = team_of(ExtraAction(forced=0))
    team.weights[0, 1] = 1.0
    keeper = team.keeper(0)
    assert keeper.decide(STATE, advice=1) == 1
    keeper.finish_episode(8.0)
    assert value(team, STATE, 3) == 0.0
    assert value(team, STATE, 1) != pytest.approx(416.0)


# --- Probabilistic Policy Reuse -------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", [PPR(), CHAT()])
def test_psi_after_k_episodes_is_exactly_the_power(method: TransferMethod) -> None:
    team = team_of(method)
    for k in range(3000):
        assert reuse_probability(team.method_record, team.records[1:2]) == 0.999**k
        for index in range(3):
            team.keeper(index).finish_episode()
    assert team.psi == 0.999**3000
    assert math.isnan(team_of(NoPrior()).psi)


def test_psi_does_not_move_while_not_learning() -> None:
    team = team_of(PPR())
    team.set_mode(learning=False, exploring=False)
    for _ in range(50):
        team.keeper(0).decide(STATE, advice=1)
        team.keeper(0).finish_episode(5.0)
    assert team.psi == 1.0


@pytest.mark.parametrize(("schedule", "expected"), [("decision", 0.9**10), ("within-episode", 0.9**2)])
def test_psi_by_decisions(schedule: str, expected: float) -> None:
    team = team_of(PPR(decay=0.9, schedule=schedule))
    keeper = team.keeper(0)
    for _ in range(2):
        for _ in range(4):
            keeper.decide(STATE, 1.0, advice=1)
        keeper.finish_episode(1.0)
    keeper.decide(STATE, advice=1)
    keeper.decide(STATE, 1.0, advice=1)
    assert reuse_probability(team.method_record, team.records[:1]) == expected


def test_ppr_follows_the_advice_with_psi_and_is_epsilon_greedy_otherwise() -> None:
    k = 700
    psi = 0.999**k
    assert 0.4 < psi < 0.6
    assert selected(PPR(), [0.0, 5.0, 0.0], advice=2, episodes=0, epsilon=1.0) == [0, 0, 1]
    assert selected(PPR(), [0.0, 5.0, 0.0], advice=2, episodes=k) == about(0.0, 1 - psi, psi)
    rest = (1 - psi) * 0.3 / 3
    expected = about(rest, (1 - psi) * 0.7 + rest, psi + rest)
    assert selected(PPR(), [0.0, 5.0, 0.0], advice=2, episodes=k, epsilon=0.3) == expected
    assert selected(PPR(), [0.0, 5.0, 0.0], advice=NO_ADVICE) == [0, 1, 0]


def test_ppr_learns_the_value_of_what_it_did() -> None:
    team = team_of(PPR())
    keeper = team.keeper(0)
    team.weights[0, 0] = 1.0  # Q(., 0) = 416 is greedy, but psi = 1
    assert keeper.decide(STATE, advice=2) == 2
    assert keeper.decide(STATE + 30.0, reward=8.0, advice=1) == 1
    assert value(team, STATE, 2) == pytest.approx(0.125 * 8.0), "the target is Q(s', 1) = 0, not Q(s', 0)"


# --- CHAT -----------------------------------------------------------------------------------------------------------
def test_chat_follows_advice_from_the_threshold_on() -> None:
    method = CHAT(threshold=0.7)
    q = [0.0, 5.0, 0.0]
    assert selected(method, q, advice=2, confidence=0.7) == [0, 0, 1]
    assert selected(method, q, advice=2, confidence=0.69) == [0, 1, 0]
    assert selected(method, q, advice=NO_ADVICE, confidence=1.0) == [0, 1, 0]
    psi = 0.999**700
    assert selected(method, q, advice=2, episodes=700, confidence=0.9) == about(0.0, 1 - psi, psi)


# --- evaluation -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", [ValueBonus(), ExtraAction(), PPR(), CHAT()])
def test_the_initial_policy_of_every_method_with_advice_is_the_advice(method: TransferMethod) -> None:
    team = team_of(method, epsilon=0.5)
    random = np.random.default_rng(0)
    team.set_mode(learning=False, exploring=False)
    for _ in range(150):
        advice = int(random.integers(3))
        assert team.keeper(0).decide(random.uniform(0, 20, 13), 1.0, advice) == advice
        team.keeper(0).finish_episode(1.0)
    assert not team.weights.any() and team.episodes == 0


def value(team: Learners, state: np.ndarray, row: int) -> float:
    indices, values = team.approximator.active_features(state)
    return float((team.weights[0, row][indices] * values).sum())
