"""Policies from everywhere: objects of Python modules, and models that other libraries have trained and saved.

All become one thing: a function of (state, info) that returns an action. What they need is imported when they are asked
for, and their faults are told in one line.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import re
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.inputs import excerpt
from rcss_hat.keepaway.decision import PolicyError, PolicyFailed
from rcss_hat.keepaway.task import Task

Policy = Callable[[NDArray[np.float64], dict[str, Any]], int]
"""A policy in Python: (state variables, info) -> action. ``info`` holds ``episode`` (from 1; over UDP the keeper's own
count), ``cycle``, ``keeper`` (from 1), ``status`` and ``reward`` (cycles since this keeper's last decision)."""

_OBJECT = re.compile(r"(?P<module>[A-Za-z_][\w.]*|.*\.py):(?P<name>[A-Za-z_][\w.]*)")
_MODELS = {
    ".zip": "rcss_hat.hat.models.sb3:load",
    ".joblib": "rcss_hat.hat.models.sklearn:load",
    ".pkl": "rcss_hat.hat.models.sklearn:load",
    ".pickle": "rcss_hat.hat.models.sklearn:load",
    ".skops": "rcss_hat.hat.models.sklearn:load_skops",
}
"""Suffix of a saved model to the function that makes a policy of it."""


def is_foreign(spec: str) -> bool:
    """Tell whether a policy's name is that of an object in Python or of a saved model."""
    return Path(spec).suffix in _MODELS or is_object(spec)


def is_object(spec: str) -> bool:
    """Tell whether a name is that of an object in Python."""
    return _OBJECT.fullmatch(spec) is not None and not Path(spec).exists()


def foreign_policy(spec: str, task: Task, seed: int) -> Policy:
    """Make a policy of an object in Python, or of a saved model.

    Parameters
    ----------
    spec : str
        ``module:object``, ``file.py:object``, or a file ``.zip`` (Stable-Baselines3), ``.joblib``, ``.pkl`` or
        ``.skops`` (scikit-learn).
    task : Task
        What it must fit; for classes and factories that take one.
    seed : int
        For those, too.

    Raises
    ------
    PolicyError
        Saying what is wrong with it.
    """
    suffix = Path(spec).suffix
    if suffix in _MODELS:
        path = Path(spec)
        if not path.is_file():
            raise PolicyError(f"there is no file {spec!r}")
        module, _, name = _MODELS[suffix].partition(":")
        load = getattr(importlib.import_module(module), name)
        return guarded(load(path, task), spec)
    return object_policy(spec, task, seed)


def object_policy(spec: str, task: Task, seed: int, models: bool = True) -> Policy:
    """Make a policy of an object in Python; ``models``: whether it may be one with ``predict``, of keepers' states.

    Raises
    ------
    PolicyError
        Saying what is wrong with it.
    """
    found = _OBJECT.fullmatch(spec)
    assert found is not None, "is_object"
    thing = _object(spec, *found.group("module", "name"))
    return guarded(_policy_of(thing, spec, task, seed, models), spec)


def guarded(function: Policy, spec: str) -> Policy:
    """Return a policy whose faults are told in one line, with the place where they happened.

    Raises
    ------
    PolicyFailed
        By what is returned, whatever the function raises.
    """

    def ask(state: NDArray[np.float64], info: dict[str, Any]) -> int:
        try:
            return function(state, info)
        except Exception as error:  # whatever a stranger's function does
            raise PolicyFailed(f"the policy {spec} failed: {told(error)}") from error

    return ask


def told(error: BaseException) -> str:
    """Tell an exception of somebody else's code in one line: what it was, and in which file and line."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    if isinstance(error, SyntaxError) and error.filename:
        return f"{type(error).__name__}: {error.msg} ({error.filename}, line {error.lineno})"
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not _is_ours(frame.filename)]
    theirs = [frame for frame in frames if "site-packages" not in frame.filename] or frames
    return f"{text} ({theirs[-1].filename}, line {theirs[-1].lineno})" if theirs else text


def _is_ours(filename: str) -> bool:
    return filename.startswith("<") or Path(filename).is_relative_to(Path(__file__).parents[1])


# --- objects ------------------------------------------------------------------------------------------------------


def _object(spec: str, module_name: str, name: str) -> Any:
    found: Any = _module(spec, module_name)
    for part in name.split("."):
        try:
            found = getattr(found, part)
        except AttributeError:
            there = [n for n, thing in vars(found).items() if callable(thing) and not n.startswith("_")]
            raise PolicyError(f"{module_name} has no {name!r}; it has {', '.join(there[:10]) or 'nothing'}") from None
    return found


def _module(spec: str, name: str) -> ModuleType:
    """Import a module by name, from the working folder as well, or by its file."""
    try:
        if name.endswith(".py"):
            return _module_of_file(Path(name))
        if "" not in sys.path and str(Path.cwd()) not in sys.path:
            sys.path.insert(0, str(Path.cwd()))  # and leave it there: the policy may import later what lies beside it
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and (name == error.name or name.startswith(f"{error.name}.")):
            raise PolicyError(f"there is no module {error.name!r} here or among the installed, for {spec!r}") from error
        raise PolicyError(f"{name} cannot be imported: {told(error)}") from error
    except PolicyError:  # there is no such file
        raise
    except Exception as error:
        raise PolicyError(f"{name} cannot be imported: {told(error)}") from error
    except SystemExit as error:
        raise PolicyError(f"{name} is a program that ends when it is imported") from error


def _module_of_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise PolicyError(f"there is no file {str(path)!r}")
    name = f"_policy_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None, "its name ends in .py"
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # classes in it may be looked up by their module
    folder = str(path.parent.resolve())
    if folder not in sys.path:
        sys.path.insert(0, folder)
    spec.loader.exec_module(module)
    return module


def _policy_of(thing: Any, spec: str, task: Task, seed: int, models: bool) -> Policy:
    """Return the policy that an object is, or makes."""
    if _is_maker(thing):
        thing = _made(thing, spec, task, seed)
    if models and hasattr(thing, "predict"):
        from rcss_hat.hat.models.fitting import predicting

        return predicting(thing, spec, task)
    if not callable(thing):
        raise PolicyError(
            f"{spec} is {excerpt(thing)}; a policy is a function of (state, info), an object with 'predict' or "
            "'__call__', a class of such objects, or a function of (task) that returns one"
        )
    if not _takes(thing, 2):
        raise PolicyError(f"{spec} cannot be called with (state, info): its parameters are {_parameters(thing)}")
    function: Policy = thing
    return function


_GIVEN = {"task", "seed", "keepers", "takers"}
"""What makers of policies can ask for, by the names of their parameters."""


def _is_maker(thing: Any) -> bool:
    """Tell a class, or a factory: a function that asks for nothing but what makers are given."""
    if inspect.isclass(thing):
        return True
    names = set(_signature(thing))
    return inspect.isroutine(thing) and bool(names) and names <= _GIVEN


def _made(maker: Any, spec: str, task: Task, seed: int) -> Any:
    given = {"task": task, "seed": seed, "keepers": task.keepers, "takers": task.takers}
    try:
        parameters = _signature(maker)
        return maker(**{name: given[name] for name in parameters if name in given})
    except Exception as error:
        raise PolicyError(f"{spec} cannot be made for {task.size}: {told(error)}") from error


def _signature(thing: Any) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(thing).parameters
    except (TypeError, ValueError):  # written in C
        return {}


def _takes(thing: Any, n: int) -> bool:
    try:
        inspect.signature(thing).bind(*range(n))
    except TypeError:
        return False
    except ValueError:  # written in C: it will be seen
        return True
    return True


def _parameters(thing: Any) -> str:
    return f"({', '.join(_signature(thing))})"
