"""RoboCup Keepaway and Human-Agent Transfer in Python.

The names in `__all__` are the public face of the package: typed, documented, and changed only with a word in
CHANGELOG.md. They are imported when they are asked for, so that ``import rcss_hat`` takes milliseconds. Everything else
may change without notice, but for what the documentation's pages name.

>>> import rcss_hat
>>> rcss_hat.play("hand", episodes=20, seed=1).mean_s > rcss_hat.play("hold", episodes=20, seed=1).mean_s
True
"""

from __future__ import annotations

import importlib

__version__ = "0.1.0"

_HOME = {
    # playing
    "Task": "rcss_hat.keepaway.task",
    "play": "rcss_hat.everyday",
    "EndedEarly": "rcss_hat.everyday",
    "RunReport": "rcss_hat.keepaway.report",
    "open_stage": "rcss_hat.stage.stages",
    "Place": "rcss_hat.stage.place",
    "Part": "rcss_hat.stage.stages",
    "load_policy": "rcss_hat.hat.policy",
    # teaching
    "demonstrate": "rcss_hat.everyday",
    "package_demonstrations": "rcss_hat.experiments.sets",
    "Demonstration": "rcss_hat.hat.demonstrations",
    "DemonstrationSet": "rcss_hat.hat.demonstrations",
    "summarize": "rcss_hat.hat.summarize",
    "DecisionList": "rcss_hat.hat.decision_list",
    "RipperClassifier": "rcss_hat.hat.ripper",
    # learning
    "learn": "rcss_hat.everyday",
    "TrainingRun": "rcss_hat.experiments.training",
    "RunConfig": "rcss_hat.experiments.run_folder",
    "LearnerConfig": "rcss_hat.learning.config",
    "load_config": "rcss_hat.learning.config",
    "METHODS": "rcss_hat.hat.registry",
    "TransferMethod": "rcss_hat.hat.transfer.method",
    "read_episode_log": "rcss_hat.experiments.episode_log",
    "learning_curve": "rcss_hat.experiments.metrics",
    # environments
    "KeepawayEnv": "rcss_hat.envs.keepaway_env",
    "KeepawayVectorEnv": "rcss_hat.envs.vector",
}
"""Public name to the module it is in; __init__.pyi says the same to type checkers."""

__all__ = [
    "__version__",
    "Task",
    "play",
    "EndedEarly",
    "RunReport",
    "open_stage",
    "Place",
    "Part",
    "load_policy",
    "demonstrate",
    "package_demonstrations",
    "Demonstration",
    "DemonstrationSet",
    "summarize",
    "DecisionList",
    "RipperClassifier",
    "learn",
    "TrainingRun",
    "RunConfig",
    "LearnerConfig",
    "load_config",
    "METHODS",
    "TransferMethod",
    "read_episode_log",
    "learning_curve",
    "KeepawayEnv",
    "KeepawayVectorEnv",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = found  # the next time it is found at once
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
