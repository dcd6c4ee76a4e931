"""A person as the policy of an environment: keys pressed on the page in the browser."""

from __future__ import annotations

import time
from typing import Any

from rcss_hat.envs.keepaway_env import KeepawayEnv
from rcss_hat.envs.rendering import HUMAN
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator

PEEK = 0.05
"""Seconds between two looks whether the person has come."""


class ManualPolicy:
    """Decides by the keys pressed on the page: numbers and arrows pass, as in `rcss-hat demonstrate`; no key holds.

    Parameters
    ----------
    env : gymnasium.Env
        A `KeepawayEnv` with ``render_mode="human"``, wrapped or not, which has not been reset yet.
    waits : bool
        Whether the game stands still while nobody has the page open; otherwise the keepers hold.

    Raises
    ------
    ValueError
        For another environment, or one whose page is open already.
    """

    def __init__(self, env: Any, waits: bool = True) -> None:
        inner = env.unwrapped
        shown = inner.renderer if isinstance(inner, KeepawayEnv) else None
        if shown is None or shown.mode != HUMAN:
            raise ValueError("a person plays a KeepawayEnv with render_mode='human'")
        if shown.is_open:
            raise ValueError("the page is open already: make the policy before the first reset")
        self._env: KeepawayEnv = inner
        self.keys = KeyChannel(range(int(inner.action_space.n)))
        self._person, self._waits = Demonstrator(self.keys), waits
        shown.controls = self._person

    def __call__(self, observation: Any, info: dict[str, Any]) -> int:
        """Return what the person asked for, or Hold."""
        while self._waits and self._person.standing:
            time.sleep(PEEK)
        return self._person.answer(self._env.state, info)
