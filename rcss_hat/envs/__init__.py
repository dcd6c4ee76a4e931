"""Keepaway as an environment for learners of other people: Gymnasium, PettingZoo.

To import it registers ``rcss_hat/Keepaway-v0`` and its sizes with Gymnasium.
"""

from rcss_hat.envs.keepaway_env import KeepawayEnv, MatchFailed
from rcss_hat.envs.registration import register_envs

__all__ = ["KeepawayEnv", "MatchFailed", "register_envs"]

register_envs()
