"""Keepaway for PettingZoo, turn by turn: whoever has to decide, decides, and play goes on to the next decision."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Space
from numpy.typing import NDArray
from pettingzoo import AECEnv

from rcss_hat.envs.agents import Agents
from rcss_hat.envs.keepaway_env import MatchFailed
from rcss_hat.envs.rendering import FPS, RENDER_MODES
from rcss_hat.envs.stepping import DECISION, ENDED, GONE


class KeepawayTurnsEnv(AECEnv[str, NDArray[np.float32], int]):
    """See `rcss_hat.envs.keepaway_v0.env` with ``per="decision"``."""

    metadata: dict[str, Any] = {  # noqa: RUF012 (PettingZoo's)
        "name": "keepaway_v0",
        "render_modes": RENDER_MODES,
        "render_fps": FPS,
        "is_parallelizable": False,
    }

    def __init__(self, agents: Agents) -> None:
        super().__init__()
        self._all = agents
        self.render_mode = None if agents.renderer is None else agents.renderer.mode
        self.possible_agents, self.agents = list(agents.names), list[str]()
        self.observation_spaces, self.action_spaces = agents.observation_spaces, agents.action_spaces
        self._index = {name: k for k, name in enumerate(agents.names)}
        self._actions = [int(space.n) for space in agents.action_spaces.values()]
        self._mark = 0

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        """Return the space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Go to the first decision of an episode; see `KeepawayEnv.reset`."""
        everybody = self._all
        everybody.begin(seed)
        while True:
            if options and "positions" in options:
                everybody.steps.place(options["positions"])
            what = everybody.steps.go_on()
            if what == DECISION:
                break
            if what == GONE:
                raise MatchFailed(everybody.over(what)["failure"])
            if what != ENDED:
                everybody.steps.discard()
            everybody.skipped += 1
        names = self.possible_agents
        self.agents = list(names)
        self.rewards, self._cumulative_rewards = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
        self.terminations, self.truncations = dict.fromkeys(names, False), dict.fromkeys(names, False)
        self._mark = everybody.steps.cycle if everybody.own else everybody.steps.start
        self.infos = {name: everybody.info(k, what) for k, name in enumerate(names)}
        self._give_turn()

    def observe(self, agent: str) -> NDArray[np.float32]:
        """Return what an agent saw when it decided last, or at the end of the episode."""
        return self._all.seen[self._index[agent]].copy()

    def last(self, observe: bool = True) -> tuple[NDArray[np.float32] | None, float, bool, bool, dict[str, Any]]:
        """Return observation, reward since its last turn, and so on, of the agent whose turn it is."""
        name = self._whose_turn()
        seen = self._all.seen[self._index[name]].copy() if observe else None
        cumulative = self._cumulative_rewards[name]
        return seen, cumulative, self.terminations[name], self.truncations[name], self.infos[name]

    def step(self, action: int | None) -> None:
        """Let the agent decide whose turn it is; None once the episode is over."""
        name = self._whose_turn()
        if self.terminations[name] or self.truncations[name]:
            self._was_dead_step(action)
            return
        everybody, steps = self._all, self._all.steps
        k = self._index[name]
        if action is None or not 0 <= action < self._actions[k]:
            raise ValueError(f"{name} has the actions 0 to {self._actions[k] - 1}, not {action!r}")
        everybody.decided[k] = True
        what = steps.go_on(int(action))
        dt = steps.cycle - self._mark if what != GONE else 0
        self._mark, cumulative = steps.cycle, self._cumulative_rewards
        cumulative[name] = 0.0
        for k, agent in enumerate(self.possible_agents):
            self.rewards[agent] = reward = everybody.due(k, dt)
            cumulative[agent] += reward
        if what == DECISION:
            self._give_turn()
        else:
            self._end(what)

    def _whose_turn(self) -> str:
        if not self.agents:
            raise ResetNeeded("no episode is being played: call reset()")
        return self.agent_selection

    def _give_turn(self) -> None:
        k, info = self._all.turn()
        self.agent_selection = name = self.possible_agents[k]
        self.infos[name] = info

    def _end(self, what: int) -> None:
        """End the episode for all."""
        told = self._all.over(what)
        for k, name in enumerate(self.possible_agents):
            self.terminations[name], self.truncations[name] = what == ENDED, what != ENDED
            self.infos[name] = self._all.info(k, what) | told
        self.agent_selection = self.agents[0]

    def render(self) -> Any:
        """Return a picture of the last cycle; see `KeepawayEnv.render`."""
        return self._all.picture()

    def close(self) -> None:
        """End the match."""
        self._all.close()
