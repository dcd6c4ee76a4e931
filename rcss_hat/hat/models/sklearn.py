"""Classifiers of scikit-learn, saved by joblib, pickle or skops.

A pickle is a program: who loads one runs it. skops' files hold only data, and are refused when they ask for more than
NumPy's types and scikit-learn's own classes.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from rcss_hat.hat.foreign import Policy, told
from rcss_hat.hat.models.fitting import classifying
from rcss_hat.keepaway.decision import PolicyError
from rcss_hat.keepaway.task import Task


def load(path: Path, task: Task) -> Policy:
    """Make a policy of a classifier that joblib or pickle has saved.

    Raises
    ------
    PolicyError
        When it cannot be read, is no classifier, or one for something else.
    """
    import joblib

    try:
        model = joblib.load(path)
    except Exception as error:  # a pickle can do, and raise, anything
        raise PolicyError(f"{path} cannot be read as a model saved by joblib or pickle: {told(error)}") from error
    return _policy(model, path, task)


def load_skops(path: Path, task: Task) -> Policy:
    """Make a policy of a classifier that skops has saved, from types that skops trusts and classes of scikit-learn.

    Of the latter skops trusts neither the trees' nor the neighbours' storage, for a forged one can crash the program;
    it cannot make it run anything.

    Raises
    ------
    PolicyError
        As `load`, and when skops is not installed.
    """
    try:
        import skops.io as skops
    except ImportError as error:
        raise PolicyError(f"{path} needs skops: pip install skops") from error
    try:
        unknown = skops.get_untrusted_types(file=path)
        model = skops.load(path, trusted=[name for name in unknown if _is_class_of_sklearn(name)])
    except Exception as error:  # whatever the file holds
        raise PolicyError(f"{path} cannot be read as a model saved by skops: {told(error)}") from error
    return _policy(model, path, task)


def _is_class_of_sklearn(name: str) -> bool:
    module, _, own = name.rpartition(".")
    if module.split(".")[0] != "sklearn":
        return False
    return isinstance(getattr(importlib.import_module(module), own, None), type)


def _policy(model: Any, path: Path, task: Task) -> Policy:
    if not hasattr(model, "predict"):
        raise PolicyError(f"{path} holds an object of type {type(model).__name__}, which has no 'predict'")
    return classifying(model, str(path), task)
