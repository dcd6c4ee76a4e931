"""Keepers and takers as agents of PettingZoo: names, spaces, what each has seen, what each is due."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray

from rcss_hat.envs.keepaway_env import MAX_SEED, OVER
from rcss_hat.envs.options import HAND, Options
from rcss_hat.envs.rendering import changes_for, check_render_mode, renderer
from rcss_hat.envs.spaces import Observations, action_space
from rcss_hat.envs.stepping import DECISION, ENDED, GONE, Setting, State, Steps, open_steps
from rcss_hat.keepaway.taker import n_macro_actions

TEAM, OWN = "team", "own"
TAKER_CYCLES = 5


class Agents:
    """The agents of a match, whichever way they are stepped.

    Parameters
    ----------
    options : Options
    reward : {"team", "own"}
        ``"team"``: every keeper gets the cycles that go by, from the start of the episode on. ``"own"``: those from
        its own first decision on, so that between two decisions of its own it gets the cycles between them. Takers get
        the negative.
    taker_agents : bool
        Whether the takers are agents, too.
    taker_cycles : int
        Cycles from one decision of a taker to its next.
    every_cycle : bool
        Whether a step is a cycle.
    render_mode : str, optional
        See `KeepawayEnv`.

    Raises
    ------
    ValueError
        Naming what would be right.
    """

    def __init__(
        self,
        options: Options,
        reward: str = TEAM,
        taker_agents: bool = False,
        taker_cycles: int = TAKER_CYCLES,
        every_cycle: bool = False,
        render_mode: str | None = None,
    ) -> None:
        if reward not in (TEAM, OWN):
            raise ValueError(f"reward is {TEAM!r} or {OWN!r}, not {reward!r}")
        if taker_cycles < 1:
            raise ValueError(f"taker_cycles must be 1 or more, not {taker_cycles}")
        if taker_agents and options.takers != HAND:
            raise ValueError("takers are agents, or have a policy: not both")
        check_render_mode(render_mode, options.stage)
        task = options.task
        self.renderer = renderer(render_mode, f"environment, {options.stage}", task.params())
        self.keepers, self.own = task.keepers, reward == OWN
        self.names = [f"keeper_{k + 1}" for k in range(task.keepers)]
        self.names += [f"taker_{k + 1}" for k in range(task.takers)] if taker_agents else []
        self._of_keepers = Observations(task, options.normalize)
        self._of_takers = Observations(task, options.normalize, taker=True)
        changes: dict[str, Any] = {"every_cycle": every_cycle, "every_view": every_cycle}
        changes |= changes_for(self.renderer, options.stage)
        if taker_agents:
            changes["taker_cycles"] = taker_cycles
        self.setting: Setting = options.setting(self._of_keepers, **changes)
        self.steps: Steps = open_steps(self.setting)
        self.observation_spaces: dict[str, Box] = {
            n: _copy(self.observations(k).space) for k, n in enumerate(self.names)
        }
        self.action_spaces: dict[str, Discrete] = {
            n: action_space(task) if k < task.keepers else Discrete(n_macro_actions(task.keepers))
            for k, n in enumerate(self.names)
        }
        self._everything = [np.ones(int(space.n), dtype=np.int8) for space in self.action_spaces.values()]
        self.seen: list[NDArray[np.float32]] = []
        self.decided = [False] * len(self.names)
        self.skipped, self._begun, self._over = 0, False, True
        self._random = np_random(None)[0]

    def observations(self, k: int) -> Observations:
        """Return how agent k (keepers first) observes."""
        return self._of_keepers if k < self.keepers else self._of_takers

    def begin(self, seed: int | None) -> None:
        """Begin a match, or go on with it after the end of the running episode."""
        if seed is not None:
            self._random = np_random(seed)[0]
        if seed is not None or not self._begun:
            self.steps.begin(int(self._random.integers(MAX_SEED)) if seed is None else seed)
            self._begun = True
        elif not self._over and self.steps.discard() == GONE:
            self.steps.begin(int(self._random.integers(MAX_SEED)))
        self._over = False
        self.forget()

    def forget(self) -> None:
        """Begin an episode: nobody has seen or decided anything. What is unknown is as far as can be."""
        self.seen = [self.observations(k).high.astype(np.float32) for k in range(len(self.names))]
        self.decided = [False] * len(self.names)

    def look(self, k: int, state: State | None) -> None:
        """Let an agent see, if it knows where everybody is."""
        if state is not None:
            self.seen[k] = self.observations(k).of(state)

    def turn(self) -> tuple[int, dict[str, Any]]:
        """Let the agent see whose decision it is; returns it, and its ``info``."""
        steps = self.steps
        k = steps.player
        self.seen[k] = steps.seen.copy() if k < self.keepers else self._of_takers.of(steps.state)
        return k, {
            "cycle": steps.cycle, "number": steps.number, "missed": steps.missed, "skipped": self.skipped,
            "action_mask": self._everything[k].copy(),
        }  # fmt: skip

    def look_around(self) -> None:
        """Let all see what they believed last."""
        for k in range(len(self.names)):
            self.look(k, self.steps.views[k])

    def capped(self, what: int) -> bool:
        """Tell whether the episode is cut off."""
        most = self.setting.max_cycles
        return what not in (ENDED, GONE) and most is not None and self.steps.cycle - self.steps.start >= most

    def over(self, what: int) -> dict[str, Any]:
        """File the end of an episode; return what ``info`` tells of it."""
        steps, self._over = self.steps, what == ENDED
        if what == GONE:
            self._begun = False
            return {"reason": "server", "failure": steps.failure, "duration": steps.cycle - steps.start}
        self.look_around()
        if what == ENDED:
            episode = steps.episode
            reason = OVER.get(episode.reason, episode.reason)
            return {"number": episode.number, "duration": episode.cycles, "reason": reason}
        return {"number": steps.number, "duration": steps.cycle - steps.start, "reason": "max_cycles"}

    def info(self, k: int, what: int) -> dict[str, Any]:
        """Return the ``info`` of agent k: the cycle, the episode's number, and what it may do."""
        steps = self.steps
        mask = np.zeros(int(self.action_spaces[self.names[k]].n), dtype=np.int8)
        mask[: None if what == DECISION and k == steps.player else 1] = 1
        return {
            "cycle": steps.cycle, "number": steps.number, "missed": steps.missed, "skipped": self.skipped,
            "action_mask": mask,
        }  # fmt: skip

    def picture(self) -> Any:
        """Return what ``render`` returns."""
        return None if self.renderer is None else self.renderer.picture()

    def close(self) -> None:
        """End the match, and whatever plays or shows it."""
        self.steps.close()
        if self.renderer is not None:
            self.renderer.close()

    def due(self, k: int, dt: int) -> float:
        """Return the reward of agent k for so many cycles."""
        if self.own and not self.decided[k]:
            return 0.0
        return float(dt if k < self.keepers else -dt)


def _copy(space: Box) -> Box:
    """Return a space that is sampled by itself."""
    return Box(space.low, space.high, dtype=space.dtype.type)
