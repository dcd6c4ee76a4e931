"""The names of the environments in Gymnasium's registry."""

from __future__ import annotations

import gymnasium

NAMESPACE = "rcss_hat"
ENV, VECTOR = "rcss_hat.envs.keepaway_env:KeepawayEnv", "rcss_hat.envs.vector:KeepawayVectorEnv"
SIZES = ("3v2", "4v3", "5v4")
IDS = {"Keepaway-v0": {}, **{f"Keepaway-{size}-v0": {"size": size} for size in SIZES}}


def register_envs() -> None:
    """Register ``rcss_hat/Keepaway-v0``, and ``-3v2-v0``, ``-4v3-v0`` and ``-5v4-v0``, unless they are registered.

    Gymnasium calls this by itself where the package is installed (entry point ``gymnasium.envs``).
    """
    for name, options in IDS.items():
        env_id = f"{NAMESPACE}/{name}"
        if env_id not in gymnasium.registry:
            gymnasium.register(env_id, ENV, vector_entry_point=VECTOR, kwargs=dict(options))
