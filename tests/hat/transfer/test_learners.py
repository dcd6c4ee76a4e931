from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import config

from rcss_hat.hat.transfer import (
    METHODS,
    NO_ADVICE,
    PPR,
    Decisions,
    ExtraAction,
    Learners,
    NoPrior,
    Replay,
    make_method,
    warm_up,
)
from rcss_hat.hat.transfer.kernels import decide_first, decide_step
from rcss_hat.learning import CheckpointError, LearnerConfig, load_checkpoint, sarsa, save_checkpoint


def play(team: Learners, episodes: int, seed: int = 0) -> list[int]:
    """Play made-up episodes with all keepers; returns their actions."""
    random = np.random.default_rng(seed)
    actions = []
    for _ in range(episodes):
        for k in range(team.n_keepers - 1):  # the last keeper never acts
            keeper = team.keeper(k)
            for _ in range(5):
                state = random.uniform(0.0, 20.0, team.approximator.n_variables)
                actions.append(keeper.decide(state, float(random.integers(1, 30)), int(random.integers(-1, 3)), 0.8))
        for k in range(team.n_keepers):
            team.keeper(k).finish_episode(float(random.integers(1, 30)))
    return actions


CONFIG = LearnerConfig(epsilon=0.2)


def test_no_prior_is_plain_sarsa() -> None:
    team, same = (Learners.create(CONFIG, NoPrior(), seed=3) for _ in range(2))
    random = np.random.default_rng(1)
    plain = same.learner(0)
    for _ in range(30):
        for k in range(6):
            state, reward = random.uniform(0.0, 20.0, 13), float(random.integers(1, 9))
            sarsa.observe(plain, state)
            expected = sarsa.select_epsilon_greedily(plain.record, plain.rng)
            if k:
                sarsa.advance(plain, reward, expected, 0.0)
            else:
                sarsa.begin(plain, expected, 0.0)
            assert team.keeper(0).decide(state, reward, advice=1) == expected
        team.keeper(0).finish_episode(4.0)
        sarsa.conclude(plain, 4.0)
    assert (team.weights == same.weights).all() and team.weights.any()


def test_keepers_learn_apart_and_explore_differently() -> None:
    team = Learners.create(CONFIG, NoPrior())
    assert len({tuple(stream) for stream in team.streams.tolist()}) == 3
    play(team, 2)
    assert team.weights[0].any() and team.weights[1].any() and not team.weights[2].any()
    assert not (team.weights[0] == team.weights[1]).all()
    assert team.records["episodes"].tolist() == [2, 2, 2]


@pytest.mark.parametrize("size", [(3, 2), (4, 3), (5, 4)])
def test_sizes(size: tuple[int, int]) -> None:
    team = Learners.create(CONFIG, ExtraAction(), *size)
    assert team.weights.shape[:2] == (size[0], size[0] + 1)
    assert len(play(team, 1)) == 5 * (size[0] - 1)
    assert team.keeper(0).q.shape == (size[0] + 1,)


@pytest.mark.parametrize("name", METHODS)
def test_a_seed_decides_everything(name: str) -> None:
    results = []
    for seed in (1, 1, 2):
        team = Learners.create(CONFIG, make_method(name), seed=seed)
        results.append((play(team, 120), team.weights.tobytes()))
    assert results[0] == results[1]
    assert results[0] != results[2]


def test_evaluation_changes_nothing_and_ends() -> None:
    team = Learners.create(CONFIG, PPR())
    play(team, 3)
    before = team.weights.copy()
    team.set_mode(learning=False, exploring=False)
    assert not team.learning
    play(team, 3)
    assert (team.weights == before).all() and team.episodes == 3
    team.set_mode(learning=True, exploring=True)
    assert team.learning and team.records["exploring"].all()
    play(team, 3)
    assert team.episodes == 6
    team.set_mode(learning=False, exploring=True)
    assert team.records["exploring"].all() and not team.learning


@pytest.mark.parametrize(("name", "lambda_"), [("ppr", 0.0), ("extra-action", 0.5), ("chat", 0.0)])
def test_a_saved_team_goes_on_as_if_nothing_had_happened(tmp_path: Path, name: str, lambda_: float) -> None:
    team = Learners.create(LearnerConfig(epsilon=0.2, lambda_=lambda_), make_method(name), seed=5)
    play(team, 110)
    team.save(tmp_path / "team.npz", {"hour": 0.5}, {"server_streams": np.arange(4, dtype=np.uint64)})
    loaded = Learners.load(tmp_path / "team.npz")
    assert (loaded.config, loaded.method, loaded.seed, loaded.episodes) == (team.config, team.method, 5, 110)
    assert play(team, 20, seed=9) == play(loaded, 20, seed=9)
    assert (team.weights == loaded.weights).all()
    assert (team.records == loaded.records).all() and (team.streams == loaded.streams).all()
    extra = load_checkpoint(tmp_path / "team.npz")
    assert extra.header["hour"] == 0.5 and extra.arrays["server_streams"].tolist() == [0, 1, 2, 3]


def test_a_team_can_be_saved_in_the_middle_of_an_episode(tmp_path: Path) -> None:
    team = Learners.create(LearnerConfig(lambda_=0.5), PPR())
    state = np.linspace(1.0, 13.0, 13)
    team.keeper(0).decide(state, advice=1)
    team.save(tmp_path / "team.npz")
    loaded = Learners.load(tmp_path / "team.npz")
    for each in (team, loaded):
        assert each.keeper(0).has_acted
        each.keeper(0).finish_episode(7.0)
    assert (team.weights == loaded.weights).all() and team.weights.any()


def test_names_of_its_own_cannot_be_saved_over(tmp_path: Path) -> None:
    team = Learners.create(CONFIG, PPR())
    for header, arrays in (({"seed": 1}, {}), ({}, {"weights": np.zeros(1)})):
        with pytest.raises(ValueError, match="is taken"):
            team.save(tmp_path / "team.npz", header, arrays)


def test_files_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "team.npz"
    Learners.create(CONFIG, PPR()).save(path)
    good = load_checkpoint(path)

    def rewrite(header: dict[str, object], arrays: dict[str, np.ndarray]) -> None:
        save_checkpoint(path, {**good.header, **header}, {**good.arrays, **arrays})

    rewrite({"kind": "demonstrations"}, {})
    with pytest.raises(CheckpointError, match="holds 'demonstrations', not 'learners'"):
        Learners.load(path)
    rewrite({"n_keepers": 4, "n_takers": 3}, {})
    with pytest.raises(CheckpointError, match=r"records has shape \(3,\), this learner needs \(4,\)"):
        Learners.load(path)
    rewrite({"method": "extra-action", "method_settings": {}}, {})
    with pytest.raises(CheckpointError, match="method's record does not agree"):
        Learners.load(path)
    rewrite({"config": {**good.header["config"], "alpha": -1.0}}, {})
    with pytest.raises(CheckpointError, match="settings in the file are not valid: alpha must be a positive number"):
        Learners.load(path)
    rewrite({}, {"weights": good.arrays["weights"][:, :, :-1]})
    with pytest.raises(CheckpointError, match="weights has shape"):
        Learners.load(path)


def test_wrong_input_is_named() -> None:
    team = Learners.create(CONFIG, PPR())
    with pytest.raises(ValueError, match=r"shape \(13,\), not \(12,\)"):
        team.keeper(0).decide(np.zeros(12))
    with pytest.raises(ValueError, match="advice must be an action from 0 to 2 or -1, not 3"):
        team.keeper(0).decide(np.zeros(13), advice=3)
    with pytest.raises(ValueError, match="numbered 0 to 2, not 3"):
        team.keeper(3)


# --- replay of demonstrations -----------------------------------------------------------------------------------------
NEAR, FAR = np.full(13, 2.0), np.full(13, 40.0)
DEMONSTRATION = Decisions.of([NEAR, FAR, NEAR], [0, 1, 2], [4.0, 20.0, 6.0], [False, True, True])


def test_replay_is_sarsa_on_the_recorded_decisions() -> None:
    team = Learners.create(LearnerConfig(), Replay(passes=2))
    expected = Learners.create(LearnerConfig(), NoPrior())
    team.method.prepare(team, DEMONSTRATION)
    plain = expected.learner(0)
    for _ in range(2):
        sarsa.observe(plain, NEAR)
        sarsa.begin(plain, 0, 0.0)
        sarsa.observe(plain, FAR)
        sarsa.advance(plain, 4.0, 1, 0.0)
        sarsa.conclude(plain, 20.0)
        sarsa.observe(plain, NEAR)
        sarsa.begin(plain, 2, 0.0)
        sarsa.conclude(plain, 6.0)
    for k in range(3):
        assert (team.weights[k] == plain.weights).all()
    assert plain.weights.any()


def test_replay_makes_the_demonstrated_actions_greedy_and_counts_nothing() -> None:
    team = Learners.create(LearnerConfig(), Replay())
    team.method.prepare(team, DEMONSTRATION)
    assert team.episodes == 0 and team.records["decisions"].sum() == 0
    assert not team.keeper(0).has_acted
    team.set_mode(learning=False, exploring=False)
    assert team.keeper(0).decide(FAR) == 1
    assert team.keeper(0).decide(NEAR, 1.0) in (0, 2)


def test_methods_that_do_not_replay_stay_as_they_are() -> None:
    team = Learners.create(LearnerConfig(), PPR())
    team.method.prepare(team, DEMONSTRATION)
    assert not team.weights.any()
    team.replay(DEMONSTRATION, passes=1)
    assert team.weights.any()


def test_decisions_that_do_not_fit_are_refused() -> None:
    team = Learners.create(LearnerConfig(), Replay())
    with pytest.raises(ValueError, match="have 2 state variables, 3v2 has 13"):
        team.method.prepare(team, Decisions.of([[1.0, 2.0]], [0], [1.0], [True]))
    with pytest.raises(ValueError, match="action 3 does not exist with 3 keepers"):
        team.method.prepare(team, Decisions.of([NEAR], [3], [1.0], [True]))
    for arguments, message in (
        (([NEAR], [0, 1], [1.0], [True]), "decisions need states"),
        (([NEAR], [0], [np.nan], [True]), "must be finite"),
        (([NEAR], [0], [1.0], [False]), "must be marked as the last"),
        (([NEAR], [-1], [1.0], [True]), "numbered from 0, not -1"),
    ):
        with pytest.raises(ValueError, match=message):
            Decisions.of(*arguments)


# --- compiled and not -------------------------------------------------------------------------------------------------
@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_one_specialisation_serves_all_sizes_methods_and_approximators() -> None:
    warm_up()
    before = len(decide_first.signatures), len(decide_step.signatures)
    for name in METHODS:
        for kind in ("cmac", "rbf"):
            for lambda_ in (0.0, 0.5):
                settings = LearnerConfig(approximator=kind, lambda_=lambda_, tilings=4)
                play(Learners.create(settings, make_method(name), 4, 3), 1)
    assert (len(decide_first.signatures), len(decide_step.signatures)) == before == (1, 1)


def test_the_plain_python_mode_gives_the_same_bits() -> None:
    program = (
        "import hashlib, json, test_learners as t\n"
        "from rcss_hat.hat.transfer import *\n"
        "found = {}\n"
        "for name in METHODS:\n"
        "    settings = {'forced': 1} if name in ('value-bonus', 'extra-action') else {}\n"
        "    config = t.CONFIG.with_changes(approximator='rbf', tilings=4)\n"
        "    team = Learners.create(config, make_method(name, settings))\n"
        "    actions = t.play(team, 2)\n"
        "    found[name] = [actions, hashlib.sha256(team.weights.tobytes()).hexdigest()]\n"
        "print(json.dumps(found))"
    )
    outputs = []
    for disabled in ("0", "1"):
        path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
        run = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "NUMBA_DISABLE_JIT": disabled, "PYTHONPATH": path},
            check=True,
            capture_output=True,
            text=True,
        )
        outputs.append(json.loads(run.stdout))
    assert outputs[0] == outputs[1]
    assert outputs[0].keys() == METHODS.keys()


def test_no_advice_is_minus_one() -> None:
    assert NO_ADVICE == -1
