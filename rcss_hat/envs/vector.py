"""Many matches of Keepaway as one Gymnasium vector environment: compiled, over threads, without Python per match."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from rcss_hat.arena.vector import VectorMatch
from rcss_hat.arena.vector_records import CUT_OFF, ENDED_OUT, ENDED_TAKEN, LANE, NOT_ENDED
from rcss_hat.envs.options import Options
from rcss_hat.envs.rewards import Rewards
from rcss_hat.envs.spaces import Observations, action_names, action_space
from rcss_hat.keepaway.agent import NO_DECISION
from rcss_hat.numeric.seeds import derived_seed

Lanes = NDArray[np.int32]
DT, ENDED, CYCLE, KEEPER, STATUS, NUMBER, START, SKIPPED = map(
    (LANE.names or ()).index, ("dt", "ended", "cycle", "keeper", "status", "episode", "start", "skipped")
)
LAST_NUMBER, DURATION, LAST_CYCLE, LAST_KEEPER, PERCEIVED = map(
    (LANE.names or ()).index, ("last_episode", "duration", "last_cycle", "last_keeper", "perceived")
)
"""Columns of the table of lanes, see `rcss_hat.arena.vector_records.LANE`."""
REASONS = np.array(["", "out", "taken", "max_cycles"], dtype=object)
"""How an episode ended, by what `rcss_hat.arena.vector_records` calls it."""

_NOT_HERE = {"stage", "takers", "per", "truth"}

TOLD = ("dt", "cycle", "keeper", "status", "number", "elapsed", "missed", "skipped")
"""What ``info`` holds of every match, as that of the single environment does."""


class KeepawayVectorEnv(VectorEnv[NDArray[np.float32], NDArray[np.int64], NDArray[Any]]):
    """Independent matches in the arena, each with one decision maker for whichever keeper has the ball.

    Match ``i`` of seed ``s`` is the one of `rcss_hat.envs.keepaway_env.KeepawayEnv` with the seed
    ``rcss_hat.numeric.seeds.derived_seed(s, i)``, however many matches and threads there are.

    Parameters
    ----------
    num_envs : int
    threads : int
        How many share the matches; results are the same for all.
    autoreset_mode : AutoresetMode
        NEXT_STEP: the step after an end begins the next episode, whatever the action. SAME_STEP: the step of the end
        does, and ``info["final_obs"]`` and ``info["final_info"]`` tell of the end.
    copy : bool
        Whether observations are the caller's own; False: they change with the next step.
    **options
        ``size, field, vision, profile, hold_cycles, max_cycles, normalize, reward, discount``, as those of
        `rcss_hat.envs.keepaway_env.KeepawayEnv`.

    Examples
    --------
    >>> import numpy as np
    >>> from rcss_hat import KeepawayVectorEnv
    >>> envs = KeepawayVectorEnv(4)
    >>> observations, infos = envs.reset(seed=1)
    >>> observations, rewards, *_ = envs.step(np.zeros(4, dtype=np.int64))
    >>> observations.shape, rewards.shape
    ((4, 13), (4,))
    """

    def __init__(
        self,
        num_envs: int = 8,
        *,
        threads: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        **options: Any,
    ) -> None:
        mode = AutoresetMode(autoreset_mode)
        if mode is AutoresetMode.DISABLED:
            raise ValueError("matches go on by themselves: autoreset_mode is NEXT_STEP or SAME_STEP")
        chosen = Options(**options)
        if foreign := sorted(_NOT_HERE & options.keys()):
            raise ValueError(f"{', '.join(foreign)}: only KeepawayEnv has that, not the vector")
        self.task, discount = chosen.task, chosen.discount
        self.num_envs, self.autoreset_mode, self.copy = num_envs, mode, copy
        self.metadata = {"autoreset_mode": mode, "render_modes": []}
        self.render_mode = None
        self.observations = Observations(self.task, chosen.normalize)
        self.rewards = Rewards(chosen.reward, 1.0 if discount is None else discount)
        self.discount = discount
        self.single_observation_space, self.single_action_space = self.observations.space, action_space(self.task)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        same_step, limit = mode is AutoresetMode.SAME_STEP, chosen.max_cycles or 0
        self.matches = VectorMatch(self.task, num_envs, threads, chosen.hold_cycles, limit, same_step, chosen.normalize)
        self._nothing, self._nobody = np.zeros(num_envs, dtype=np.int32), np.zeros(num_envs, dtype=np.bool_)
        everybody = ~self._nobody
        told = [*TOLD, "discount"] if discount is not None else TOLD
        self._masks = {f"_{name}": everybody for name in told}
        self._begun = False

    @property
    def state_names(self) -> list[str]:
        """Names of the variables of an observation."""
        return self.observations.names

    @property
    def action_names(self) -> list[str]:
        """Names of the actions."""
        return action_names(self.task)

    def reset(
        self, *, seed: int | Sequence[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin new matches, or with no seed the next episodes of those that run.

        Parameters
        ----------
        seed : int or sequence of int, optional
            Of all matches together, or of each. Without one the first matches have seeds drawn anew; later, the
            episodes at hand are left, which in the middle are played to their ends by Hold, and count for nothing.
        options : dict, optional
            None are known.

        Returns
        -------
        observations, info
        """
        if options:
            raise ValueError(f"no options are known here; these were given: {', '.join(options)}")
        if seed is None and self._begun:
            self.matches.discard()
        else:
            self.matches.begin(self._seeds(seed))
            self._begun = True
        lanes = self.matches.table.copy()
        return self._seen(), self._told(lanes)

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Take a decision in every match and play each on to its next.

        Raises
        ------
        ValueError
            When an action is none, or before `reset`.
        """
        if not self._begun:
            raise ValueError("reset comes before the first step")
        self.matches.step(self._checked(actions))
        lanes = self.matches.table.copy()
        info, seen, ended = self._told(lanes), self._seen(), lanes[:, ENDED]
        truncated, terminated = ended == CUT_OFF, self._nobody.copy()
        if np.count_nonzero(ended):
            terminated = (ended != NOT_ENDED) & ~truncated
            self._tell_ends(lanes, seen, info)
        rewards = np.asarray(self.rewards.reward(lanes[:, DT]), dtype=np.float64)
        return seen, rewards, terminated, truncated, info

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self.matches.close()

    def _seeds(self, seed: int | Sequence[int] | None) -> list[int]:
        if seed is None or isinstance(seed, int | np.integer):
            base = secrets.randbelow(2**31) if seed is None else int(seed)
            return [derived_seed(base, i) for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"there must be a seed for each of {self.num_envs} matches, not {len(seed)}")
        return [int(each) for each in seed]

    def _checked(self, actions: NDArray[np.int64]) -> NDArray[np.int64]:
        given = np.asarray(actions)
        if given.shape != (self.num_envs,) or given.dtype.kind not in "iu":
            raise ValueError(
                f"actions must be {self.num_envs} whole numbers, not an array of {given.dtype} of shape {given.shape}"
            )
        if given.astype(np.uint64).max() >= self.task.keepers:  # negative ones are huge then
            wrong = given[(given < 0) | (given >= self.task.keepers)][0]
            raise ValueError(f"action {wrong} is none; legal are 0 (Hold) to {self.task.keepers - 1}")
        return given

    def _seen(self) -> NDArray[np.float32]:
        seen = self.matches.batch.observations
        return seen.copy() if self.copy else seen

    def _told(self, lanes: Lanes) -> dict[str, Any]:
        """Return what is told of every match."""
        info = {
            "dt": lanes[:, DT],
            "cycle": lanes[:, CYCLE],
            "keeper": lanes[:, KEEPER] + 1,
            "status": lanes[:, STATUS],
            "number": lanes[:, NUMBER],
            "elapsed": lanes[:, CYCLE] - lanes[:, START],
            "missed": self._nothing,
            "skipped": lanes[:, SKIPPED],
        }
        if self.discount is not None:
            info["discount"] = self.rewards.discount(lanes[:, DT])
        return info | self._masks

    def _tell_ends(self, lanes: Lanes, seen: NDArray[np.float32], info: dict[str, Any]) -> None:
        """Tell of the episodes that ended; what was seen last takes its place where the end is the step's result."""
        over = lanes[:, ENDED] != NOT_ENDED
        last = self.matches.batch.final_observations
        end = {
            "dt": lanes[:, DT],
            "cycle": lanes[:, LAST_CYCLE],
            "keeper": lanes[:, LAST_KEEPER] + 1,
            "status": np.full(self.num_envs, NO_DECISION, dtype=np.int32),
            "number": lanes[:, LAST_NUMBER],
            "elapsed": lanes[:, DURATION],
            "duration": lanes[:, DURATION],
            "perceived": lanes[:, PERCEIVED].astype(np.bool_),
            "reason": REASONS[lanes[:, ENDED]],
        }
        if self.autoreset_mode is AutoresetMode.NEXT_STEP:
            seen[over] = last[over]
            for name, values in end.items():
                info[name] = np.where(over, values, info[name]) if name in info else values
            info |= {f"_{name}": over for name in ("duration", "perceived", "reason")}
            return
        end |= {name: info[name] for name in ("missed", "skipped", "discount") if name in info}
        finals = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(over):
            finals[i] = last[i].copy()
        told = end | {f"_{name}": over for name in end}
        info |= {"final_obs": finals, "_final_obs": over, "final_info": told, "_final_info": over}


assert list(range(len(REASONS))) == [NOT_ENDED, ENDED_OUT, ENDED_TAKEN, CUT_OFF]
