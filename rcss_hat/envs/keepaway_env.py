"""Keepaway for Gymnasium: one decision maker for whichever keeper has the ball."""

from __future__ import annotations

import operator
import warnings
from collections.abc import Callable
from typing import Any, SupportsIndex

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from rcss_hat.envs.options import Options
from rcss_hat.envs.rendering import FPS, RENDER_MODES, changes_for, check_render_mode, renderer
from rcss_hat.envs.rewards import Rewards
from rcss_hat.envs.spaces import Observations, action_space
from rcss_hat.envs.stepping import DECISION, ENDED, GONE, Setting, open_steps
from rcss_hat.keepaway.agent import NO_DECISION
from rcss_hat.keepaway.decision import legal_action
from rcss_hat.keepaway.report import OUT, TAKEN
from rcss_hat.simulation.world import World
from rcss_hat.stage.place import ARENA, FAKE

Observation = NDArray[np.float32]
OVER = {OUT: "out", TAKEN: "taken"}
"""Why an episode has ended, in ``info["reason"]``; beside these: ``"max_cycles"``, ``"server"`` and ``"?"``."""


MAX_SEED = 2**31


class MatchFailed(RuntimeError):
    """No match could be begun; says why."""


class KeepawayEnv(gymnasium.Env[Observation, np.int64]):
    """Keepaway as one decision maker sees it: the keeper that has the ball, whichever it is.

    A step is one decision and lasts until the next one, or to the end of the episode. Observations are the state
    variables of the keeper that decides, as it perceives them (13 in 3v2, metres and degrees); actions are 0: Hold,
    a: pass to the a-th nearest team mate.

    Parameters
    ----------
    size, field : str
        Such as ``"3v2"`` and ``"20x20"`` (m); None: the usual field of that size.
    vision : int
        View angle, degrees: 360 or 90.
    profile : str
        Whose physics: ``"19.0"`` or ``"11.1"``.
    stage : str
        Where matches are played: ``"arena"``, ``"fake"``, ``"real"`` or ``HOST:PORT``.
    takers : str or callable
        ``"hand"``, ``"module:object"``, or a policy of the takers: (state variables, info) -> macro-action, see
        `rcss_hat.keepaway.taker_state` and `rcss_hat.keepaway.taker`; asked in every cycle.
    hold_cycles : int
        Cycles from a Hold to the next decision.
    max_cycles : int, optional
        After so many cycles an episode is truncated.
    normalize : bool
        Observations in [0, 1], see `rcss_hat.envs.spaces.Observations`.
    reward : {"cycles", "seconds"}
        Unit of the reward, which is the time that a step took; the first step is counted from the episode's start.
        So the return is the duration of the episode.
    discount : float, optional
        Per cycle. The reward of a step of dt cycles is then the sum of ``discount**i`` for i < dt, and
        ``info["discount"]`` is ``discount**dt``.
    per : {"decision", "cycle"}
        ``"cycle"``: a step is one cycle. Where nobody has to decide, ``info["action_mask"]`` allows only 0; no
        action does anything then. (Should two keepers reach the ball in one cycle, the second decides in a step of its
        own, of no cycles.)
    truth : bool
        Whether ``info`` holds where everybody is, see `rcss_hat.envs.stepping.Steps.truth`; a server shows it to a
        monitor, for which it waits a little.
    render_mode : {"human", "rgb_array", "ansi"}, optional
        In the arena every cycle on a page in the browser, in real time; or what `render` returns, pixels or text: of
        the last cycle, on servers of that in which play stands.

    Raises
    ------
    ValueError
        Naming what would be right.

    Examples
    --------
    >>> from rcss_hat import KeepawayEnv
    >>> env = KeepawayEnv()
    >>> observation, info = env.reset(seed=1)
    >>> over, total = False, 0.0
    >>> while not over:
    ...     observation, reward, over, truncated, info = env.step(0)
    ...     total += reward
    >>> total == info["duration"]
    True
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": FPS}  # noqa: RUF012 (Gymnasium's)

    def __init__(self, render_mode: str | None = None, **options: Any) -> None:
        self.options = chosen = Options(**options)
        check_render_mode(render_mode, chosen.stage)
        self.render_mode = render_mode
        self.renderer = renderer(render_mode, f"environment, {chosen.stage}", chosen.task.params())
        self._seen = Observations(chosen.task, chosen.normalize)
        self._rewards = Rewards(chosen.reward, 1.0 if chosen.discount is None else chosen.discount)
        self.observation_space = self._seen.space
        self.action_space = action_space(chosen.task)
        self.state_names = self._seen.names
        self.setting: Setting = chosen.setting(self._seen, **changes_for(self.renderer, chosen.stage))
        self._steps = open_steps(self.setting)
        self._go_on = self._steps.go_on
        self._actions, self._mark, self.skipped = chosen.task.keepers, 0, 0
        self._plain = (
            self._rewards == Rewards() and not chosen.truth and not self.setting.every_cycle and chosen.discount is None
        )
        self._begun = self._playing = self._ended = False
        self._last = np.zeros(len(self.state_names), dtype=np.float32)

    @property
    def state(self) -> NDArray[np.float64]:
        """State variables of the last observation, metres and degrees, not scaled."""
        return self._steps.state.copy()

    # -- the interface ------------------------------------------------------------------------------------------------
    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Go to the first decision of an episode.

        Parameters
        ----------
        seed : int, optional
            Begin a new match, which it decides: in the arena and on the fake server the same seed is the same match,
            that of ``rcss-hat play --seed``. Without one the match goes on with its next episode; in the middle of an
            episode it is played on, keepers holding, and nothing of it counts.
        options : dict, optional
            ``positions``: where the episode begins, see `rcss_hat.envs.positions.check_positions`. By default the
            keepers are in three corners, the takers in the fourth.

        Raises
        ------
        MatchFailed
            When there is no match: the server cannot be started, plays something else, or is gone.
        """
        super().reset(seed=seed)
        positions = self._positions(options)
        if seed is not None or not self._begun:
            self._begin(seed)
        elif not self._ended and self._steps.discard() == GONE:
            self._begin(None)
        self._ended = False
        while True:
            if positions is not None:
                self._steps.place(positions)
            what = self._first_decision()
            if what == DECISION:
                break
            if what == GONE:
                self._begun = False
                raise MatchFailed(self._steps.failure)
            self.skipped += 1
        self._playing, self._mark = True, self._steps.start
        return self._observation(), self._info(0)

    def step(self, action: SupportsIndex) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Let the keeper that has the ball do something.

        Parameters
        ----------
        action : int
            0: Hold, a: pass to the a-th nearest team mate.

        Returns
        -------
        observation, reward, terminated, truncated, info
            The final observation is what the keeper that decided last believes in the last cycle in which anything
            was perceived of the episode: the referee has moved everybody by the time of the next.

        Raises
        ------
        ValueError
            For an action that is none.
        ResetNeeded
            When the episode has ended.
        """
        if not self._playing:
            raise ResetNeeded("the episode has ended, or none has begun: call reset()")
        try:
            choice = operator.index(action)
        except TypeError:
            choice = -1
        if not 0 <= choice < self._actions:
            choice = legal_action(action, self._actions)
        steps = self._steps
        what = self._go_on(choice)
        cycle = steps.cycle
        dt, self._mark = cycle - self._mark, cycle
        if what != DECISION or not self._plain:
            return self._came_back(what, dt)
        info = {
            "dt": dt, "cycle": cycle, "keeper": steps.player + 1, "status": steps.status, "number": steps.number,
            "elapsed": cycle - steps.start, "missed": steps.missed, "skipped": self.skipped,
        }  # fmt: skip
        self._last = steps.seen.copy()
        return self._last, float(dt), False, False, info

    def watch(self, on_match: Callable[[NDArray[np.void], World], object]) -> None:
        """Tell somebody what there is to see in every cycle of the matches that begin from now on; in the arena.

        Parameters
        ----------
        on_match : callable
            See `rcss_hat.envs.stepping.Steps`.
        """
        self._steps.on_match = on_match

    def render(self) -> Any:
        """Return a picture of the last cycle: pixels (height, width, 3), or text; None for people, who see the page."""
        return None if self.renderer is None else self.renderer.picture()

    def close(self) -> None:
        """End the match, and whatever plays or shows it."""
        self._steps.close()
        if self.renderer is not None:
            self.renderer.close()
        self._begun = self._playing = False

    # -- inside -------------------------------------------------------------------------------------------------------
    def _begin(self, seed: int | None) -> None:
        if seed is not None and self.setting.place.name not in (ARENA, FAKE):
            warnings.warn(
                f"a seed decides what our players do, not what the server at {self.setting.place} plays", stacklevel=3
            )
        self._steps.begin(int(self.np_random.integers(MAX_SEED)) if seed is None else seed)
        self._begun, self._ended = True, True

    def _positions(self, options: dict[str, Any] | None) -> Any:
        options = options or {}
        if unknown := set(options) - {"positions"}:
            raise ValueError(f"reset knows the option 'positions', not {', '.join(map(repr, sorted(unknown)))}")
        return options.get("positions")

    def _first_decision(self) -> int:
        """Play on to a decision, or to the end of an episode without one."""
        what = self._go_on()
        while what not in (DECISION, ENDED, GONE):
            what = self._steps.discard() if self._capped() else self._go_on()
        return what

    def _capped(self) -> bool:
        most = self.setting.max_cycles
        return most is not None and self._steps.cycle - self._steps.start >= most

    def _came_back(self, what: int, dt: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Return the step that does not end as most do."""
        capped = what not in (ENDED, GONE) and self._capped()
        over = what in (ENDED, GONE) or capped
        info = self._info(dt)
        if over:
            self._playing, self._ended = False, what == ENDED
            info |= self._end(what)
            self._begun &= what != GONE
        elif what != DECISION:
            info |= {"keeper": self._steps.last + 1, "status": NO_DECISION}
        if self.setting.every_cycle:
            info["action_mask"] = self._mask(what == DECISION and not over)
        return self._observation(), self._rewards.reward(dt), what == ENDED, over and what != ENDED, info

    def _end(self, what: int) -> dict[str, Any]:
        steps = self._steps
        info = {"keeper": steps.last + 1, "status": NO_DECISION, "perceived": steps.perceived}
        if what == ENDED:
            episode = steps.episode
            info |= {"number": episode.number, "elapsed": episode.cycles, "duration": episode.cycles}
            return info | {"reason": OVER.get(episode.reason, episode.reason)}
        info["duration"] = steps.cycle - steps.start
        return info | ({"reason": "server", "failure": steps.failure} if what == GONE else {"reason": "max_cycles"})

    def _observation(self) -> Observation:
        """Return the state at hand as learners see it; the last one, where nobody knows where everybody is."""
        steps = self._steps
        if steps.perceived:
            self._last = self._seen.of(steps.state)
            return self._last
        return self._last.copy()

    def _info(self, dt: int) -> dict[str, Any]:
        steps = self._steps
        info: dict[str, Any] = {
            "dt": dt, "cycle": steps.cycle, "keeper": steps.player + 1, "status": steps.status, "number": steps.number,
            "elapsed": steps.cycle - steps.start, "missed": steps.missed, "skipped": self.skipped,
        }  # fmt: skip
        if self.options.discount is not None:
            info["discount"] = self._rewards.discount(dt)
        if self.options.truth:
            info |= steps.truth()
        if self.setting.every_cycle:
            info["action_mask"] = self._mask(True)
        return info

    def _mask(self, decides: bool) -> NDArray[np.int8]:
        mask = np.ones(self._actions, dtype=np.int8)
        mask[1:] = decides
        return mask
