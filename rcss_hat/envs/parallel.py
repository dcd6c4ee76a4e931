"""Keepaway for PettingZoo's parallel API: a step is a cycle, in which all agents act who have to."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Space
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from rcss_hat.envs.agents import Agents
from rcss_hat.envs.rendering import FPS, RENDER_MODES
from rcss_hat.envs.stepping import DECISION, ENDED, GONE, NO_CHOICE

Told = dict[str, Any]


class KeepawayParallelEnv(ParallelEnv[str, NDArray[np.float32], int]):
    """See `rcss_hat.envs.keepaway_v0.parallel_env`."""

    metadata: dict[str, Any] = {  # noqa: RUF012 (PettingZoo's)
        "name": "keepaway_v0",
        "render_modes": RENDER_MODES,
        "render_fps": FPS,
        "is_parallelizable": True,
    }

    def __init__(self, agents: Agents) -> None:
        self._all = agents
        self.render_mode = None if agents.renderer is None else agents.renderer.mode
        self.possible_agents, self.agents = list(agents.names), list[str]()
        self.observation_spaces, self.action_spaces = agents.observation_spaces, agents.action_spaces
        self._what, self._cycle = NO_CHOICE, 0

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        """Return the space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Told, Told]:
        """Go to the start of an episode: nobody has seen anything yet. See `KeepawayEnv.reset`."""
        everybody = self._all
        everybody.begin(seed)
        if options and "positions" in options:
            everybody.steps.place(options["positions"])
        self.agents, self._what, self._cycle = list(self.possible_agents), NO_CHOICE, everybody.steps.start
        return self._observations(), self._infos()

    def step(self, actions: dict[str, int]) -> tuple[Told, Told, Told, Told, Told]:
        """Play one cycle.

        Parameters
        ----------
        actions : dict of str to int
            Of every agent; that of one who has nothing to decide (``info["action_mask"]``) does nothing.
        """
        everybody, steps, names = self._all, self._all.steps, self._all.names
        begun, what = self._cycle, self._what
        choice = self._choice(actions) if what == DECISION else NO_CHOICE
        what = steps.go_on(choice)
        while what == DECISION and steps.cycle == begun:
            what = steps.go_on(self._choice(actions))
        over = what in (ENDED, GONE) or everybody.capped(what)
        dt, self._cycle, self._what = max(steps.cycle - begun, 0), steps.cycle, what
        if what == GONE:
            dt = 0
        rewards = {name: everybody.due(k, dt) for k, name in enumerate(names)}
        if over:
            told = everybody.over(what)
        else:
            self._look(what)
            told = {}
        infos = {name: info | told for name, info in self._infos().items()}
        terminations, truncations = dict.fromkeys(names, what == ENDED), dict.fromkeys(names, over and what != ENDED)
        self.agents = [] if over else self.agents
        return self._observations(), rewards, terminations, truncations, infos

    def _choice(self, actions: dict[str, int]) -> int:
        """Return what the agent does who is asked."""
        asked = self._all.steps.player
        self._all.decided[asked] = True
        name = self._all.names[asked]
        if not self.action_spaces[name].contains(np.int64(actions[name])):
            raise ValueError(f"{name} has the actions 0 to {self.action_spaces[name].n - 1}, not {actions[name]!r}")
        return int(actions[name])

    def _look(self, what: int) -> None:
        self._all.look_around()
        if what == DECISION:
            self._all.look(self._all.steps.player, self._all.steps.state)

    def _observations(self) -> Told:
        return {name: seen.copy() for name, seen in zip(self._all.names, self._all.seen, strict=True)}

    def _infos(self) -> Told:
        return {name: self._all.info(k, self._what) for k, name in enumerate(self._all.names)}

    def render(self) -> Any:
        """Return a picture of the last cycle; see `KeepawayEnv.render`."""
        return self._all.picture()

    def close(self) -> None:
        """End the match."""
        self._all.close()
