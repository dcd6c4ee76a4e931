"""Matches in the arena, step by step: the compiled loop comes back at every decision, without thread or callback."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.handle import Handle
from rcss_hat.arena.match import ArenaMatch, prepare
from rcss_hat.arena.records import BALL_STUCK, DECIDE, EPISODE_OVER, FINISHED, LOG_FULL, NEEDS_ACTION
from rcss_hat.envs.positions import check_positions
from rcss_hat.envs.stepping import DECISION, ENDED, HOLD, NEVER, NO_CHOICE, REACHED, Setting, State, Steps
from rcss_hat.keepaway.decision import legal_order
from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.simulation import keepaway
from rcss_hat.simulation.placement import place_player
from rcss_hat.simulation.referee import award_drop_ball


def _never(state: State, info: dict[str, Any]) -> int:
    raise AssertionError("the loop comes back instead")


class ArenaSteps(Steps):
    """See `Steps`."""

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._match: ArenaMatch | None = None
        self._cap = NEVER
        self._keepers, self._every_cycle = setting.task.keepers, setting.every_cycle
        self._frames: list[np.void] = []

    def begin(self, seed: int) -> None:
        """See `Steps.begin`."""
        prepare()
        task, observations = self.setting.task, self.setting.observations
        match = ArenaMatch(task, seed, self.setting.policy(_never), log_frames=self._is_seen)
        match.team.pauses[0] = 1
        match.team.orders["lasts"] = self.setting.taker_cycles or 1
        match.control["stop_cycle"] = match.control["stop_episode"] = NEVER
        keepaway.kick_off(match.world)
        self._handle = Handle(match, observations.scale, observations.high)
        self._match, self._told = match, self._handle.told
        self._resume = self._resume_seen if self._is_seen else self._handle.resume
        self.seen = self._handle.seen
        self.cycle, self.number, self.start = 0, 1, 0
        self._ask_takers(self.setting.asks_takers)
        self._cut(0)

    def go_on(self, choice: int = NO_CHOICE) -> int:
        """See `Steps.go_on`."""
        if self._every_cycle:
            choice = choice if self._is_asked() else NO_CHOICE
            if self.setting.every_view and self._is_asked():
                return self._end_cycle(choice)
            self._stop(self.cycle + 1)
        reason = self._resume(choice)
        self.cycle, self.player, self.status, self.number, self.start = self._told.tolist()
        if reason == NEEDS_ACTION and self.cycle < self._cap and self.player < self._keepers:
            self.last = self.player
            self.perceived, self.state = True, self._match.team.state  # type: ignore[union-attr]
            return DECISION
        return self._came_back(reason)

    def _end_cycle(self, choice: int) -> int:
        """Play to the end of the running cycle and take down what everybody believes then, before going on."""
        self._stop(self.cycle)
        reason = self._resumed(choice)
        if reason == FINISHED:
            assert self._match is not None
            self._look_around(self._match)
            self._stop(self.cycle + 1)
            reason = self._resumed(NO_CHOICE)
        return self._came_back(reason)

    def _resumed(self, choice: int) -> int:
        """Let the loop go on, and take down where it came back; inline in `go_on`, the hot path."""
        reason = self._resume(choice)
        self.cycle, self.player, self.status, self.number, self.start = self._told.tolist()
        return reason

    def _is_asked(self) -> bool:
        """Tell whether the loop waits for an answer."""
        assert self._match is not None
        return bool(self._match.control["phase"][0] == DECIDE)

    def _came_back(self, reason: int) -> int:
        match = self._match
        assert match is not None
        while True:
            if reason == EPISODE_OVER:
                return self._ended(match)
            if self.cycle >= self._cap or (reason not in (NEEDS_ACTION, BALL_STUCK, LOG_FULL)):
                self._look_back(match)
                return REACHED
            choice = NO_CHOICE
            if reason == NEEDS_ACTION:
                self.perceived = True
                if self.player < self._keepers:
                    self.last, self.state = self.player, match.team.state
                    return DECISION
                if self.setting.takers is None:
                    self.state = match.team.taker_state
                    return DECISION
                choice = self._taker_answers(match)
            elif reason == BALL_STUCK:
                award_drop_ball(match.world)
            else:
                self._show()
            reason = self._resumed(choice)

    def _ended(self, match: ArenaMatch) -> int:
        """File the end of an episode; nobody has perceived the next one yet."""
        logged = match.logs.episodes[0]
        reason = TAKEN if logged["taken"] else OUT
        self.episode = Episode(int(logged["episode"]), int(logged["start"]), int(logged["end"]), reason)
        self._look_back(match)
        self._cut(self.start)
        return ENDED

    def _look_back(self, match: ArenaMatch) -> None:
        """Compute the state variables of the keeper that decided last, or of one that knows where everybody is."""
        self._look_around(match)
        found = [k for k in (self.last, *range(self._keepers)) if self.views[k] is not None]
        self.perceived = bool(found)
        if found:
            self.state = self.views[found[0]]

    def _look_around(self, match: ArenaMatch) -> None:
        """Compute what everybody believes."""
        self._handle.look_around()
        views, sizes = self._handle.views.copy(), (len(match.team.state), len(match.team.taker_state))
        self.views = [
            view[: sizes[p >= self._keepers]] if known else None
            for p, (view, known) in enumerate(zip(views, self._handle.known.tolist(), strict=True))
        ]

    def _taker_answers(self, match: ArenaMatch) -> int:
        """Ask the policy of the takers."""
        assert self.setting.takers is not None
        taker = self.player - self._keepers + 1
        info = {"episode": self.number, "cycle": self.cycle, "taker": taker}
        return legal_order(self.setting.takers(match.team.taker_state.copy(), info), self._keepers)

    def _cut(self, start: int) -> None:
        """Stop where an episode that begins now would be cut off."""
        self._cap = self.setting.cap(start)
        self._stop(self._cap)

    def _stop(self, cycle: int) -> None:
        assert self._match is not None
        self._wanted = self._match.control["stop_cycle"][0] = min(cycle, self._cap)

    def _ask_takers(self, wanted: bool) -> None:
        assert self._match is not None
        self._match.team.orders["outside"][self._keepers :] = wanted

    def discard(self) -> int:
        """See `Steps.discard`."""
        assert self._match is not None
        self._cap, every_cycle, self._every_cycle = NEVER, self._every_cycle, False
        self._stop(NEVER)
        self._ask_takers(False)
        what = self.go_on(HOLD if self._is_asked() and self.player < self._keepers else NO_CHOICE)
        while what != ENDED:
            what = self.go_on(HOLD)
        self._every_cycle = every_cycle
        self._ask_takers(self.setting.asks_takers)
        return what

    def place(self, positions: Mapping[str, Any]) -> None:
        """See `Steps.place`."""
        assert self._match is not None
        match, task = self._match.world.match, self.setting.task
        where = check_positions(task, positions)
        for seat, (x, y) in zip(self._match.team.seats, where.players, strict=True):
            if np.isfinite(x):
                place_player(match, int(seat), x, y)
        if where.ball is not None:
            match["ball_pos"][0] = where.ball
            match["ball_vel"][0] = match["ball_acc"][0] = 0.0

    def truth(self) -> dict[str, NDArray[np.float64]]:
        """See `Steps.truth`."""
        assert self._match is not None
        match, seats = self._match.world.match, self._match.team.seats
        players = np.hstack([match["pos"][0, seats], match["vel"][0, seats]])
        ball = np.concatenate([match["ball_pos"][0], match["ball_vel"][0]])
        return {"ball": ball, "keepers": players[: self._keepers], "takers": players[self._keepers :]}

    @property
    def _is_seen(self) -> bool:
        return self.setting.on_frame is not None or self.on_match is not None

    def _resume_seen(self, choice: int) -> int:
        """Let the loop go on, and show what there was to see until it came back; whole matches cycle by cycle."""
        assert self._match is not None
        while True:
            if self.on_match is not None:
                self._match.control["stop_cycle"][0] = min(self._wanted, int(self._told[0]) + 1)
            reason = self._handle.resume(choice)
            self._show()
            if reason != FINISHED or self._told[0] >= self._wanted:
                return reason
            choice = NO_CHOICE

    def _show(self) -> None:
        assert self._match is not None
        for frame in self._match.take_frames():
            if self.setting.on_frame is not None:
                self.setting.on_frame(frame)
            if self.on_match is not None:
                self.on_match(_as_it_was(self._match.world.match, frame), self._match.world)

    def close(self) -> None:
        """See `Steps.close`."""
        self._match = None


def _as_it_was(match: NDArray[np.void], frame: np.void) -> NDArray[np.void]:
    """Return a match as it was when a step was done; since then the players may have commanded, and no more."""
    before = match.copy()
    for name in ("time", "mode", "pos", "vel", "body", "neck", "flags", "stamina", "counts"):
        before[name][0] = frame[name]
    before["ball_pos"][0], before["ball_vel"][0] = frame["ball"][:2], frame["ball"][2:]
    return before
