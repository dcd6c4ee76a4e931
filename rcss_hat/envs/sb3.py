"""Many matches of Keepaway as the vector environment that Stable-Baselines3's algorithms learn from."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from rcss_hat.envs.vector import KeepawayVectorEnv


class KeepawayVecEnv(VecEnv):
    """A `VecEnv` of Stable-Baselines3 around `KeepawayVectorEnv`, as if every match had a ``Monitor``.

    ``infos[i]`` holds ``dt``, and where an episode ended ``terminal_observation``, ``TimeLimit.truncated``, ``episode``
    (``r``: its return, ``l``: its steps, ``t``: seconds since the begin), ``duration`` and ``reason``.

    Parameters
    ----------
    num_envs : int
    **settings
        Of `KeepawayVectorEnv`; its ``autoreset_mode`` is SAME_STEP.
    """

    def __init__(self, num_envs: int = 8, **settings: Any) -> None:
        self.env = KeepawayVectorEnv(num_envs, **settings, autoreset_mode=AutoresetMode.SAME_STEP)
        super().__init__(num_envs, self.env.single_observation_space, self.env.single_action_space)
        self._seed: int | None = None
        self._actions: NDArray[np.int64] = np.zeros(num_envs, dtype=np.int64)
        self._returns, self._lengths = np.zeros(num_envs), np.zeros(num_envs, dtype=np.int64)
        self._started = time.monotonic()

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Let the next `reset` begin new matches of this seed."""
        self._seed = int(np.random.randint(2**31 - 1)) if seed is None else seed  # noqa: NPY002 (SB3 seeds this one)
        return [self._seed] * self.num_envs

    def reset(self) -> NDArray[np.float32]:
        """Begin episodes; see `KeepawayVectorEnv.reset`."""
        observations, info = self.env.reset(seed=self._seed)
        self._seed = None
        self._returns[:], self._lengths[:] = 0.0, 0
        self.reset_infos = [{"cycle": int(cycle)} for cycle in info["cycle"]]
        return observations

    def step_async(self, actions: NDArray[np.int64]) -> None:
        """Take the actions."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Play on to the next decisions."""
        observations, rewards, terminated, truncated, told = self.env.step(self._actions)
        dones = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = [{"dt": dt} for dt in told["dt"].tolist()]
        if "discount" in told:
            for info, discount in zip(infos, told["discount"].tolist(), strict=True):
                info["discount"] = discount
        for i in np.flatnonzero(dones):
            infos[i] |= self._ended(int(i), bool(truncated[i]), told)
        return observations, rewards.astype(np.float32), dones, infos

    def _ended(self, i: int, truncated: bool, told: dict[str, Any]) -> dict[str, Any]:
        """Return what the info of an episode's last step holds beside the usual, and count the next from 0."""
        passed = round(time.monotonic() - self._started, 6)
        info = {
            "terminal_observation": told["final_obs"][i],
            "TimeLimit.truncated": truncated,
            "episode": {"r": round(float(self._returns[i]), 6), "l": int(self._lengths[i]), "t": passed},
            "duration": int(told["final_info"]["duration"][i]),
            "reason": told["final_info"]["reason"][i],
        }
        self._returns[i], self._lengths[i] = 0.0, 0
        return info

    def close(self) -> None:
        """End the threads."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute, which is the same for all matches, as often as asked for."""
        return [getattr(self.env, attr_name)] * len(self._chosen(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: matches are not changed one by one."""
        raise AttributeError(f"{attr_name!r} cannot be set: the matches are one environment")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Refuse: the matches have no methods of their own."""
        raise AttributeError(f"{method_name!r} cannot be called: the matches are one environment")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """Tell that there is no wrapper; episodes are told all the same, as a ``Monitor`` would."""
        return [False] * len(self._chosen(indices))

    def _chosen(self, indices: Any) -> Sequence[int]:
        chosen: Sequence[int] = list(self._get_indices(indices))
        return chosen
