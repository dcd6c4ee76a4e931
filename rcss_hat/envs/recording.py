"""A wrapper that records what is played as demonstrations, which `rcss-hat summarize` and ``sets`` read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from rcss_hat.envs.keepaway_env import OVER, KeepawayEnv, Observation
from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo

_REASONS = {word: letter for letter, word in OVER.items()}
_Step = tuple[Observation, Any, bool, bool, dict[str, Any]]


class RecordDemonstrations(gymnasium.Wrapper[Observation, np.int64, Observation, np.int64]):
    """Records every episode that is played to its end; one that is truncated or given up is left out.

    Parameters
    ----------
    env : gymnasium.Env
        A `KeepawayEnv`, wrapped or not, whose steps are decisions.
    path : str or Path
        The table, ``x.csv``; its header is ``x.json``.
    teacher : str
        Who decides, for the header.
    resume : bool
        Go on with an existing file.

    Raises
    ------
    ValueError
        For another environment.
    FileFormatError
        When the file exists and is not to be resumed, or was made in another way.
    """

    def __init__(self, env: Any, path: str | Path, teacher: str = "policy", resume: bool = False) -> None:
        super().__init__(env)
        inner = env.unwrapped
        if not isinstance(inner, KeepawayEnv) or inner.setting.every_cycle:
            raise ValueError("demonstrations are recorded of a KeepawayEnv whose steps are decisions")
        task = inner.options.task
        info = DemonstrationInfo(teacher, str(inner.setting.place), task, dict(task.server_values()))
        self._inner: KeepawayEnv = inner
        self.writer = DemonstrationWriter(path, info, resume)
        self._before: dict[str, Any] = {}

    def reset(self, **options: Any) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; what was recorded of one that has not ended is dropped."""
        self.writer.drop_episode()
        seen, self._before = self.env.reset(**options)
        return seen, self._before

    def step(self, action: Any) -> _Step:
        """Take a decision, and write the episode when it has ended."""
        state, before = self._inner.state, self._before
        seen, reward, terminated, truncated, info = self.env.step(action)
        self.writer.add(before["cycle"], before["keeper"], state, int(action))
        self._before = info
        if terminated:
            reason = _REASONS.get(info["reason"], "?")
            final = self._inner.state.tolist() if info["perceived"] else None
            self.writer.end_episode(info["cycle"] - info["duration"], info["cycle"], reason, final=final)
        elif truncated:
            self.writer.drop_episode()
        return seen, reward, terminated, truncated, info

    def close(self) -> None:
        """Put the file down, and close the environment."""
        self.writer.__exit__(None, None, None)
        super().close()
