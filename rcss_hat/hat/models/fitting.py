"""Objects with a ``predict`` as policies: what they were made for must be the task they are to play."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.decision import PolicyError, PolicyFailed
from rcss_hat.keepaway.state import n_state_variables, state_names
from rcss_hat.keepaway.task import Task

Predict = Callable[[NDArray[np.float64], dict[str, Any]], int]


def predicting(model: Any, spec: str, task: Task) -> Predict:
    """Return the policy that a model with ``predict`` is: of Stable-Baselines3, of scikit-learn, or anybody's.

    Parameters
    ----------
    model : object
        With ``observation_space`` and ``action_space``: as Stable-Baselines3's, asked for its best action. Otherwise
        as scikit-learn's: ``predict`` takes a table of one row.
    spec : str
        What messages call it.
    task : Task

    Raises
    ------
    PolicyError
        When it was made for something else.
    """
    if hasattr(model, "observation_space") and hasattr(model, "action_space"):
        from rcss_hat.hat.models.sb3 import acting

        return acting(model, spec, task)
    return classifying(model, spec, task)


def classifying(model: Any, spec: str, task: Task) -> Predict:
    """Return the policy of a classifier of states, with what it tells of its inputs and classes checked.

    Raises
    ------
    PolicyError
        When it takes another number of variables, or others, or answers with something that is no action.
    """
    n, wanted = n_state_variables(task.keepers, task.takers), getattr(model, "n_features_in_", None)
    if wanted is not None and wanted != n:
        raise PolicyError(f"{spec} takes {wanted} variables; a state of {task.size} has {n}")
    classes = getattr(model, "classes_", None)
    if classes is not None and not set(np.asarray(classes).tolist()) <= set(range(task.keepers)):
        raise PolicyError(
            f"{spec} tells classes {list(np.asarray(classes).tolist())} apart; the actions of {task.size} are 0 to "
            f"{task.keepers - 1}"
        )
    named = getattr(model, "feature_names_in_", None)
    if named is not None:
        _check_names(list(map(str, named)), spec, task)

    def predict(state: NDArray[np.float64], info: dict[str, Any]) -> int:
        with warnings.catch_warnings():
            if named is not None:  # they are ours, in our order
                warnings.filterwarnings("ignore", message="X does not have valid feature names")
            return only(model.predict(state[np.newaxis]))

    return predict


def only(answer: Any) -> int:
    """Return the one action that a model answers for one state.

    Raises
    ------
    PolicyFailed
        When these are several, or something else.
    """
    values = np.asarray(answer)
    if values.size != 1:
        raise PolicyFailed(
            f"the model answered with an array of shape {values.shape} for one state, not with an action"
        )
    action: int = values.reshape(-1)[0]
    return action


def _check_names(named: Sequence[str], spec: str, task: Task) -> None:
    n = len(named)
    known = [state_names(task.keepers, task.takers), [f"s{k}" for k in range(n)], [f"state_{k}" for k in range(n)]]
    if list(named) not in known:
        wrong = next((a for a, b in zip(named, known[1], strict=True) if a != b), named[0])
        raise PolicyError(
            f"{spec} was trained on a table with a column {wrong!r}; the columns must be s0, s1 ... (or state_0 ..., "
            "or the names of the state variables), in this order"
        )
