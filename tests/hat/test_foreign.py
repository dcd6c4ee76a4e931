"""Policies that others have written or trained: found by name or file, checked, and their faults told in one line."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import warnings
import zipfile
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pytest
import skops.io as skops
from sklearn.ensemble import HistGradientBoostingClassifier, RandomForestClassifier
from sklearn.linear_model import LinearRegression
from sklearn.model_selection import train_test_split
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler
from sklearn.tree import DecisionTreeClassifier

from rcss_hat.experiments.sets import package_demonstrations
from rcss_hat.hat.foreign import foreign_policy, is_foreign
from rcss_hat.hat.models.fitting import predicting
from rcss_hat.hat.models.sb3 import acting
from rcss_hat.hat.policy import PolicyError, load_policy
from rcss_hat.keepaway.decision import PolicyFailed
from rcss_hat.keepaway.observation import observation_scale
from rcss_hat.keepaway.task import Task

TASK = Task()
STATE = np.array([4.0, 8.0, 9.0, 3.0, 5.0, 6.0, 6.0, 2.0, 3.0, 4.0, 5.0, 40.0, 70.0])
INFO: dict[str, Any] = {"episode": 1, "cycle": 1, "keeper": 1, "status": 0, "reward": 0.0}
MODULE = """
import numpy as np

def act(state, info):
    return int(state[3] < 4.0)

class Remembering:
    def __init__(self, task, seed=7):
        self.task, self.seed = task, seed
    def __call__(self, state, info):
        return {20.0: 2}[self.task.length] + 0 * self.seed

class Model:
    def predict(self, table):
        assert table.shape == (1, 13)
        return np.array([2])

def made(task):
    return lambda state, info: task.keepers - 1

def by_size(keepers, takers, seed):
    return lambda state, info: seed

def one(state):
    return 0

def broken(state, info):
    return [0, 1][int(state[0])]

class Nest:
    act = staticmethod(act)

number = 3
"""

FAILING = "class Policy:\n    def __init__(self, task):\n        raise RuntimeError('no weights')\n"


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    path = tmp_path / "strangers.py"
    path.write_text(MODULE)
    monkeypatch.delitem(sys.modules, "strangers", raising=False)
    return path


@pytest.mark.parametrize(
    ("spec", "action"),
    [
        ("strangers:act", 1),
        ("strangers.py:act", 1),
        ("strangers:Nest.act", 1),
        ("strangers:Remembering", 2),
        ("strangers:Model", 2),
        ("strangers:made", 2),
        ("strangers:by_size", 1),
    ],
)
def test_objects_of_a_module_play(module: Path, spec: str, action: int) -> None:
    assert is_foreign(spec)
    assert foreign_policy(spec, TASK, 1)(STATE, INFO) == action


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("nowhere:act", "there is no module 'nowhere' here or among the installed"),
        ("nowhere.py:act", "there is no file 'nowhere.py'"),
        ("strangers:play", "strangers has no 'play'; it has act, Remembering"),
        ("strangers:number", "strangers:number is 3; a policy is a function of"),
        ("strangers:one", r"strangers:one cannot be called with \(state, info\): its parameters are \(state\)"),
        (
            "needs.py:act",
            r"imported: ModuleNotFoundError: No module named 'no_such_library' \(.*needs.py, line",
        ),
        ("wrong.py:act", r"cannot be imported: SyntaxError: .*wrong.py, line 2\)"),
        ("quits.py:act", "is a program that ends when it is imported"),
        ("failing.py:Policy", r"cannot be made for 3v2: RuntimeError: no weights \(.*failing.py, line 3\)"),
        ("missing.zip", "there is no file 'missing.zip'"),
    ],
)
def test_what_is_no_policy_is_refused_in_one_line(module: Path, spec: str, message: str) -> None:
    Path("needs.py").write_text("import no_such_library\n")
    Path("wrong.py").write_text("x = 1\ndef act(state, info) return 0\n")
    Path("quits.py").write_text("raise SystemExit(3)\n")
    Path("failing.py").write_text(FAILING)
    with pytest.raises(PolicyError, match=message) as refused:
        load_policy(spec, 3, 2, 1)
    assert "\n" not in str(refused.value)


def test_a_fault_while_playing_is_told_with_its_line(module: Path) -> None:
    line = MODULE.splitlines().index("    return [0, 1][int(state[0])]") + 1
    with pytest.raises(PolicyFailed, match=rf"strangers:broken failed: IndexError: .*strangers.py, line {line}\)"):
        foreign_policy("strangers:broken", TASK, 1)(STATE, INFO)


def test_nothing_is_imported_before_its_need(module: Path) -> None:
    assert is_foreign("strangers:act") and "strangers" not in sys.modules
    assert not is_foreign("hand") and not is_foreign("rules.json") and not is_foreign("runs/ppr")


# --- scikit-learn -------------------------------------------------------------------------------------------------


def classifier(columns: list[str] | None = None) -> Any:
    demonstrations = package_demonstrations("A")
    table: Any = demonstrations.X
    if columns is not None:
        table = demonstrations.to_frame()[[f"s{k}" for k in range(13)]].set_axis(columns, axis=1)
    return make_pipeline(StandardScaler(), DecisionTreeClassifier(max_depth=3)).fit(table, demonstrations.y)


@pytest.mark.parametrize(("name", "named"), [("tree.joblib", False), ("tree.pkl", True), ("tree.skops", True)])
def test_a_classifier_plays(tmp_path: Path, name: str, named: bool) -> None:
    model, path = classifier([f"s{k}" for k in range(13)] if named else None), tmp_path / name
    if name.endswith(".pkl"):
        path.write_bytes(pickle.dumps(model))
    elif name.endswith(".skops"):
        skops.dump(model, path)
    else:
        joblib.dump(model, path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load_policy(str(path), 3, 2, 1).function(STATE, INFO) in (0, 1, 2)  # type: ignore[misc]
    with pytest.raises(PolicyError, match="takes 13 variables; a state of 4v3 has 19"):
        load_policy(str(path), 4, 3, 1)


def test_a_classifier_of_something_else_is_refused(tmp_path: Path) -> None:
    swapped = ["s1", "s0", *(f"s{k}" for k in range(2, 13))]
    with pytest.raises(PolicyError, match="trained on a table with a column 's1'; the columns must be s0, s1"):
        predicting(classifier(swapped), "swapped", TASK)
    labels = DecisionTreeClassifier().fit(np.eye(13), ["hold"] * 13)
    with pytest.raises(PolicyError, match=r"tells classes \['hold'\] apart; the actions of 3v2 are 0 to 2"):
        predicting(labels, "labels", TASK)
    (tmp_path / "junk.joblib").write_bytes(b"no pickle")
    with pytest.raises(PolicyError, match=r"junk.joblib cannot be read as a model saved by joblib or pickle"):
        load_policy(str(tmp_path / "junk.joblib"), 3, 2, 1)
    joblib.dump([1, 2], tmp_path / "list.joblib")
    with pytest.raises(PolicyError, match="holds an object of type list, which has no 'predict'"):
        load_policy(str(tmp_path / "list.joblib"), 3, 2, 1)


def test_other_classifiers_come_from_skops_but_no_functions_and_nobody_elses_classes(tmp_path: Path) -> None:
    demonstrations: Any = package_demonstrations("A")
    for model in (RandomForestClassifier(3), KNeighborsClassifier(3), HistGradientBoostingClassifier(max_iter=3)):
        skops.dump(model.fit(demonstrations.X, demonstrations.y), tmp_path / "model.skops")
        policy = load_policy(str(tmp_path / "model.skops"), 3, 2, 1)
        assert policy.function is not None and policy.function(STATE, INFO) in (0, 1, 2)
    for stranger in (Task, train_test_split, subprocess.check_output):
        model = FunctionTransformer(stranger)
        skops.dump(model, tmp_path / "stranger.skops")
        with pytest.raises(
            PolicyError, match=r"cannot be read as a model saved by skops: UntrustedTypesFoundException"
        ):
            load_policy(str(tmp_path / "stranger.skops"), 3, 2, 1)
    (tmp_path / "junk.skops").write_bytes(b"no archive")
    with pytest.raises(PolicyError, match=r"junk.skops cannot be read as a model saved by skops: BadZipFile"):
        load_policy(str(tmp_path / "junk.skops"), 3, 2, 1)


def test_a_regression_plays_fractions_that_are_refused(tmp_path: Path) -> None:
    model = LinearRegression().fit(np.eye(13), np.linspace(0.3, 1.7, 13))
    policy = load_policy("hold", 3, 2, 1)
    policy.function = predicting(model, "line", TASK)
    with pytest.raises(PolicyFailed, match=r"the policy returned .*; legal are 0 \(Hold\) to 2"):
        policy(0)[0](1, 0, 0.0, STATE)
    assert len(policy.times.seconds) == 1


# --- Stable-Baselines3 --------------------------------------------------------------------------------------------


class Space:
    def __init__(self, low: Any, high: Any) -> None:
        self.low, self.high, self.shape = np.asarray(low), np.asarray(high), np.shape(low)


class Discrete:
    def __init__(self, n: int) -> None:
        self.n = n

    def __repr__(self) -> str:
        return f"Discrete({self.n})"


class Model:
    """What a model of Stable-Baselines3 shows to who plays it."""

    def __init__(self, space: Space, actions: int = 3) -> None:
        self.observation_space, self.action_space = space, Discrete(actions)
        self.seen = np.zeros(0)

    def predict(self, observation: np.ndarray, deterministic: bool) -> tuple[np.ndarray, None]:
        assert deterministic and observation.dtype == np.float32
        self.seen = observation
        return np.array(2), None


def test_a_model_sees_what_its_space_says() -> None:
    high, scale = observation_scale(TASK, False)[1], observation_scale(TASK, True)[0]
    low = np.zeros(13)
    for space, seen in (
        (Space(low, high), STATE),
        (Space(low - np.inf, high + np.inf), STATE),
        (Space(np.zeros(13), np.ones(13)), STATE * scale),
    ):
        model = Model(space)
        assert predicting(model, "model", TASK)(STATE, INFO) == 2
        np.testing.assert_allclose(model.seen, seen, rtol=1e-6)


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (Model(Space(np.zeros(19), np.ones(19))), "a state of 3v2 has 13 variables"),
        (Model(Space(np.zeros(13), np.ones(13)), 4), r"chooses from Discrete\(4\); 3v2 has Discrete\(3\)"),
        (Model(Space(-np.ones(13), np.ones(13))), "sees numbers from -1 to 1, which are neither metres"),
    ],
)
def test_a_model_for_something_else_is_refused(model: Model, message: str) -> None:
    with pytest.raises(PolicyError, match=message):
        acting(model, "model", TASK)


def test_a_zip_that_holds_no_model_is_refused(tmp_path: Path) -> None:
    (tmp_path / "junk.zip").write_bytes(b"no zip")
    with pytest.raises(PolicyError, match="is no model saved by Stable-Baselines3"):
        load_policy(str(tmp_path / "junk.zip"), 3, 2, 1)
    with zipfile.ZipFile(tmp_path / "sac.zip", "w") as file:
        file.writestr("data", json.dumps({"policy_class": {"__module__": "stable_baselines3.sac.policies"}}))
    with pytest.raises(PolicyError, match=r"policies of stable_baselines3.sac.policies; read are PPO, A2C, DQN"):
        load_policy(str(tmp_path / "sac.zip"), 3, 2, 1)


def test_a_model_without_its_library_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with zipfile.ZipFile(tmp_path / "dqn.zip", "w") as file:
        file.writestr("data", json.dumps({"policy_class": {"__module__": "stable_baselines3.dqn.policies"}}))
    with pytest.raises(PolicyError, match=r"dqn.zip needs stable-baselines3, .*: pip install stable-baselines3"):
        load_policy(str(tmp_path / "dqn.zip"), 3, 2, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["PPO", "DQN", "A2C"])
def test_a_saved_model_is_found_and_plays(tmp_path: Path, name: str) -> None:
    sb3, gymnasium = pytest.importorskip("stable_baselines3"), pytest.importorskip("gymnasium")

    class Still(gymnasium.Env):  # type: ignore[misc, name-defined]
        observation_space = gymnasium.spaces.Box(0.0, 1.0, (13,), np.float32)
        action_space = gymnasium.spaces.Discrete(3)

    model = getattr(sb3, name)("MlpPolicy", Still(), device="cpu", seed=1)
    model.save(tmp_path / "model.zip")
    policy = load_policy(str(tmp_path / "model.zip"), 3, 2, 1).function
    assert policy is not None
    seen = (STATE * observation_scale(TASK, True)[0]).astype(np.float32)
    assert policy(STATE, INFO) == int(model.predict(seen, deterministic=True)[0])
