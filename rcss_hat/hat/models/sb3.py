"""Models of Stable-Baselines3 as policies: ``model.zip``, the algorithm found from the file.

Such a file holds pickles: who loads one runs it.
"""

from __future__ import annotations

import importlib
import json
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.foreign import Policy, told
from rcss_hat.hat.models.fitting import only
from rcss_hat.keepaway.decision import PolicyError
from rcss_hat.keepaway.observation import observation_scale
from rcss_hat.keepaway.task import Task

_ALGORITHMS = {
    "stable_baselines3.dqn.policies": (("", "stable_baselines3:DQN"),),
    "stable_baselines3.common.policies": (("clip_range", "stable_baselines3:PPO"), ("", "stable_baselines3:A2C")),
    "sb3_contrib.qrdqn.policies": (("", "sb3_contrib:QRDQN"),),
    "sb3_contrib.common.maskable.policies": (("", "sb3_contrib:MaskablePPO"),),
}
"""Module of a model's policy class to the algorithms that have such: a setting that only they have, and where they are.
(TRPO of sb3_contrib has the policies of PPO, and plays as A2C does: learning apart, they are one.)"""
_TOLERANCE = 1e-3
"""Metres or degrees by which bounds in float32 may differ from ours."""


def load(path: Path, task: Task) -> Policy:
    """Make a policy of a model that Stable-Baselines3 has saved; it plays its best action.

    Raises
    ------
    PolicyError
        When the file is none, Stable-Baselines3 is not installed, or the model was made for something else.
    """
    where = _algorithm(path)
    package, _, name = where.partition(":")
    try:
        algorithm = getattr(importlib.import_module(package), name)
    except ImportError as error:
        pip = package.replace("_", "-")
        raise PolicyError(f"{path} needs {pip}, which cannot be imported ({error}): pip install {pip}") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of other versions, which the check of the spaces answers for
            model = algorithm.load(path, device="cpu")
    except Exception as error:  # whatever the pickles in it do
        raise PolicyError(f"{path} cannot be read by {name}.load: {told(error)}") from error
    return acting(model, str(path), task)


def _algorithm(path: Path) -> str:
    """Find out which class loads a file."""
    try:
        with zipfile.ZipFile(path) as file:
            data = json.loads(file.read("data"))
        module = data["policy_class"]["__module__"]
    except (OSError, zipfile.BadZipFile, KeyError, TypeError, ValueError) as error:
        raise PolicyError(f"{path} is no model saved by Stable-Baselines3 ({told(error)})") from error
    for setting, where in _ALGORITHMS.get(module, ()):
        if not setting or setting in data:
            return where
    raise PolicyError(
        f"{path} holds a model with policies of {module}; read are PPO, A2C, DQN, QRDQN and MaskablePPO. Let others "
        "play by a function of yours: module:object"
    )


def acting(model: Any, spec: str, task: Task) -> Policy:
    """Return the policy of a model in memory, its spaces checked against those of the task.

    Raises
    ------
    PolicyError
        When they differ.
    """
    scale, high = observation_scale(task, _is_normalized(model.observation_space, spec, task))
    actions = getattr(model.action_space, "n", None)
    if actions != task.keepers:
        raise PolicyError(f"{spec} chooses from {model.action_space}; {task.size} has Discrete({task.keepers})")

    def act(state: NDArray[np.float64], info: dict[str, Any]) -> int:
        seen = np.minimum(state * scale, high).astype(np.float32)
        return only(model.predict(seen, deterministic=True)[0])

    return act


def _is_normalized(space: Any, spec: str, task: Task) -> bool:
    """Find out whether a model sees numbers from 0 to 1, or metres and degrees."""
    _, high = observation_scale(task, normalize=False)
    if getattr(space, "shape", None) != high.shape:
        raise PolicyError(f"{spec} sees {space}; a state of {task.size} has {len(high)} variables")
    low, top = np.asarray(space.low, dtype=np.float64), np.asarray(space.high, dtype=np.float64)
    if (low == 0.0).all() and (top == 1.0).all():
        return True
    unbounded = np.isinf(low).all() and np.isinf(top).all()
    if unbounded or ((low == 0.0).all() and np.allclose(top, high, atol=_TOLERANCE)):
        return False
    raise PolicyError(
        f"{spec} sees numbers from {low.min():g} to {top.max():g}, which are neither metres and degrees nor scaled to "
        "0 to 1 as in rcss_hat.envs; let it play by a function of yours that scales them: module:object"
    )
