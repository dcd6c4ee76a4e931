from __future__ import annotations

from pathlib import Path

import pytest

from rcss_hat.learning.config import LearnerConfig, load_config, preset_names


def _effective_step(config: LearnerConfig) -> float:
    """Share of the error by which an update moves Q(s, a), on average over places."""
    approximator = config.build(3, 2)
    return config.alpha * approximator.norm / config.divisor_for(approximator)


def test_every_preset_of_the_package_builds_a_learner() -> None:
    assert {"best", "cmac", "paper", "printed"} <= set(preset_names())
    for name in preset_names():
        config = load_config(name)
        assert config.name == name
        assert config.description
        assert config.build(3, 2).n_variables == 13
        assert 0.0 < _effective_step(config) < 1.0


def test_the_players_learner() -> None:
    config = load_config("cmac")
    approximator = config.build(3, 2)
    assert config == LearnerConfig(name="cmac", description=config.description), "the defaults are the players'"
    assert (config.alpha, config.epsilon, config.gamma, config.lambda_) == (0.125, 0.01, 1.0, 0.0)
    assert config.divisor_for(approximator) == 416.0
    assert _effective_step(config) == 0.125


def test_the_paper_s_learner() -> None:
    config = load_config("paper")
    assert (config.approximator, config.epsilon, config.gamma, config.lambda_) == ("rbf", 0.01, 1.0, 0.0)
    assert config.epsilon == load_config("cmac").epsilon, "the players' own exploration, not the printed one"
    printed = load_config("printed")
    assert printed == config.with_changes(name="printed", description=printed.description, epsilon=0.10)


def test_the_literal_step_of_the_paper_is_small() -> None:
    config = load_config("paper").with_changes(alpha=0.05, divisor="tiles")
    assert _effective_step(config) == pytest.approx(0.0222, abs=1e-4)


def test_a_file_of_one_s_own(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('approximator = "rbf"\ntilings = 8\nlambda = 0.5\n')
    config = load_config(path)
    assert (config.name, config.approximator, config.tilings, config.lambda_) == ("mine", "rbf", 8, 0.5)
    assert LearnerConfig.from_dict(config.to_dict()) == config


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("alfa = 0.1", "unknown learner setting 'alfa'; known are name, description"),
        ('approximator = "net"', "approximator must be one of cmac, rbf, not 'net'"),
        ('divisor = "active"', "divisor must be one of tiles, norm, one, not 'active'"),
        ('widths = "wide"', "widths must be one of players, article, not 'wide'"),
        ("alpha = -0.1", "alpha must be a positive number, not -0.1"),
        ("alpha = nan", "alpha must be a positive number, not nan"),
        ('alpha = "big"', "alpha must be a positive number, not 'big'"),
        ("epsilon = 1.5", "epsilon must be 0.0 to 1.0, not 1.5"),
        ("lambda = 2.0", "lambda must be 0.0 to 1.0, not 2.0"),
        ("epsilon_decay = 0.0", "epsilon_decay must be greater than 0.0 and at most 1.0, not 0.0"),
        ("epsilon = 0.1\nepsilon_final = 0.2", r"epsilon_final \(0.2\) must not exceed epsilon \(0.1\)"),
        ("alpha = 0.1\nalpha_final = 0.2", "alpha_final must be 0.0 to 0.1, not 0.2"),
        ("tilings = 0", "tilings must be 1 to 256, not 0"),
        ("tilings = 3.5", "tilings must be an integer, not 3.5"),
        ("normalise = 1", "normalise must be true or false, not 1"),
        ("initial_value = inf", "initial_value must be a number of cycles, not inf"),
        ("alpha = ", "Invalid value"),
    ],
)
def test_mistakes_are_named_with_the_file(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=f"mine.toml: {message}"):
        load_config(path)


def test_unknown_presets_are_refused_with_what_there_is() -> None:
    with pytest.raises(ValueError, match="no learner preset 'bst'; there are best, cmac"):
        load_config("bst")
    with pytest.raises(FileNotFoundError):
        load_config("nowhere.toml")
