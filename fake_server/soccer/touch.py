"""The referee of goals and of the ball beyond the lines: goal, kick-in, corner kick, goal kick.

Source: 19.0.0, src/referee.cpp (TouchRef, and of FreeKickRef and CatchRef what the
ball's place decides). Matches in Keepaway mode do without, so that this is plain Python after the
compiled step; set plays and the stoppage after a goal then run in `fake_server.soccer.referee`.
"""

from __future__ import annotations

import math

import numpy as np

from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS, PLAY_MODES
from rcss_hat.protocol.records import COLLIDED_BALL, LEFT, NO_SIDE, RIGHT
from rcss_hat.simulation.pitch import (
    GOAL_AREA_LENGTH,
    GOAL_AREA_WIDTH,
    HALF_LENGTH,
    HALF_WIDTH,
    in_penalty_area,
    move_out_of_penalty_area,
    truncate_to_pitch,
)
from rcss_hat.simulation.placement import place_ball
from rcss_hat.simulation.posts import POST_RADIUS
from rcss_hat.simulation.referee import change_play_mode, drop_ball
from rcss_hat.simulation.state import (
    CATCH_FAULT_LEFT,
    CATCH_FAULT_RIGHT,
    CORNER_KICK_LEFT,
    CORNER_KICK_RIGHT,
    DROP_BALL,
    E_DROP_BALL,
    GOAL_KICK_LEFT,
    GOAL_KICK_RIGHT,
    GOAL_LEFT,
    GOAL_RIGHT,
    INDIRECT_FREE_KICK_LEFT,
    INDIRECT_FREE_KICK_RIGHT,
    KICK_IN_LEFT,
    KICK_IN_RIGHT,
    PLAY_ON,
    TIME_OVER,
    side_of,
)
from rcss_hat.simulation.world import World

_INDIRECT = (INDIRECT_FREE_KICK_LEFT, INDIRECT_FREE_KICK_RIGHT)
SHOOT_OUT = frozenset(
    PLAY_MODE_IDS[f"penalty_{phase}_{side}"] for phase in ("setup", "ready", "taken", "miss", "score") for side in "lr"
)
_NOT_JUDGED = frozenset({GOAL_LEFT, GOAL_RIGHT, TIME_OVER, *SHOOT_OUT})
_KICK_IN = {LEFT: KICK_IN_LEFT, RIGHT: KICK_IN_RIGHT}
_CORNER_KICK = {LEFT: CORNER_KICK_LEFT, RIGHT: CORNER_KICK_RIGHT}
_GOAL_KICK = {LEFT: GOAL_KICK_LEFT, RIGHT: GOAL_KICK_RIGHT}
GOAL_KICK_OF = {mode: side for side, mode in _GOAL_KICK.items()}


class TouchReferee:
    """Remembers who touched the ball last, and judges where it goes.

    Parameters
    ----------
    params : ServerParams
    world : World
    """

    def __init__(self, params: ServerParams, world: World) -> None:
        self._params, self._world, self._match = params, world, world.match
        self._ball_size = params.number("ball_size")
        self._half_goal = 0.5 * params.number("goal_width") + POST_RADIUS
        self._ball_before = self._ball()
        self._mode = int(self._match["mode"][0])
        self._toucher: int | None = None
        self._touched_at, self._strength = -1, 0.0
        self._indirect = False
        self._indirect_kicker: int | None = None

    # --- who touches the ball -----------------------------------------------------------------------------------
    def touched(self, i: int, strength: float) -> None:
        """Note that a player kicked or tackled the ball with an acceleration (m/cycle²); of one cycle the strongest."""
        self.notice_mode()
        self._touch(i, strength, int(self._match["time"][0]))

    def _touch(self, i: int, strength: float, time: int) -> None:
        if abs(self._ball()[0]) > HALF_LENGTH + self._ball_size:
            return
        if self._mode == PLAY_ON and self._indirect_kicker not in (None, i):
            self._indirect, self._indirect_kicker = False, None
        if self._indirect:
            self._indirect_kicker = i
        if self._touched_at < time or self._strength <= strength:
            self._toucher, self._touched_at, self._strength = i, time, strength

    def notice_mode(self) -> None:
        """Forget what a change of the play mode ends."""
        mode = int(self._match["mode"][0])
        if mode == self._mode:
            return
        self._mode = mode
        if mode == PLAY_ON:
            return
        self._toucher = None
        if mode in _INDIRECT:
            self._indirect, self._indirect_kicker = True, None
        elif mode != DROP_BALL:
            self._indirect, self._indirect_kicker = False, None

    # --- where the ball is --------------------------------------------------------------------------------------
    def look(self, time: int) -> list[str]:
        """Judge the ball after a step that began at a cycle; returns what the referee announces."""
        match = self._match
        for i in np.flatnonzero(match["collided"][0] & COLLIDED_BALL).tolist():
            self._touch(i, 0.0, time)
        self.notice_mode()
        if match["events"][0] & E_DROP_BALL:
            self._toucher = None
        announced = self._touched_goal_kick() if self._mode in GOAL_KICK_OF else []
        if self._mode not in _NOT_JUDGED:
            announced += self._judge() or self._carried_out_of_area()
        self.notice_mode()
        self._ball_before = self._ball()
        return announced

    def _touched_goal_kick(self) -> list[str]:
        """Repeat a goal kick when an opponent has run into the ball before it was in play."""
        kicker = GOAL_KICK_OF[self._mode]
        touching = np.flatnonzero(self._match["collided"][0] & COLLIDED_BALL)
        if all(side_of(i) == kicker for i in touching.tolist()):
            return []
        return award_goal_kick(self._world, kicker, self._ball()[1])

    def _carried_out_of_area(self) -> list[str]:
        """Call a fault when a goalie has left his penalty area with the ball he caught."""
        catcher = int(self._match["catcher"][0])
        if catcher < 0 or in_penalty_area(side_of(catcher), *self._ball(), self._ball_size):
            return []
        return call_catch_fault(self._world, int(side_of(catcher)))

    def _ball(self) -> tuple[float, float]:
        x, y = self._match["ball_pos"][0].tolist()
        return x, y

    def _judge(self) -> list[str]:
        x, y = self._ball()
        toucher = NO_SIDE if self._toucher is None else int(side_of(self._toucher))
        if abs(x) > HALF_LENGTH + self._ball_size:
            return self._goal(x) or self._beyond_goal_line(x, y, toucher)
        if abs(y) > HALF_WIDTH + self._ball_size:
            return self._beyond_side_line(x, y, toucher)
        return []

    def _goal(self, x: float) -> list[str]:
        """Count a goal if the ball has passed between the posts."""
        match, number = self._match, self._params.number
        conceding = LEFT if x < 0.0 else RIGHT
        catcher = int(match["catcher"][0])
        if self._indirect or (catcher >= 0 and side_of(catcher) != conceding) or not self._passed_between_posts():
            return []
        scorer = 1 if conceding == LEFT else 0
        match["score"][0, scorer] += 1
        place_ball(match, *self._ball(), 0.0, 0.0)
        match["kick_off_side"][0] = conceding
        announced = [f"goal_{'lr'[scorer]}_{match['score'][0, scorer]}"]
        half = number("half_time") * 1000.0 / number("simulator_step")
        if self._world.params["golden_goal"][0] and 0.0 <= half * number("nr_normal_halfs") <= match["time"][0]:
            return announced + _change_mode(self._world, TIME_OVER)
        _change_mode(self._world, GOAL_RIGHT if scorer else GOAL_LEFT)
        return announced

    def _passed_between_posts(self) -> bool:
        (x0, y0), (x1, y1) = self._ball_before, self._ball()
        line = math.copysign(HALF_LENGTH + self._ball_size, x1)
        if x0 == x1 or abs(x0) > abs(line) or (abs(y0) > self._half_goal and abs(x0) > HALF_LENGTH):
            return False
        return abs(y0 + (y1 - y0) / (x1 - x0) * (line - x0)) <= self._half_goal

    def _beyond_goal_line(self, x: float, y: float, toucher: int) -> list[str]:
        end, attackers = (LEFT, RIGHT) if x < 0.0 else (RIGHT, LEFT)
        if toucher == end:
            margin = self._params.number("ckick_margin")
            corner = (HALF_LENGTH - margin, HALF_WIDTH - margin)
            return _award(self._world, _CORNER_KICK[attackers], math.copysign(corner[0], x), _with_sign(corner[1], y))
        if self._match["catcher"][0] >= 0:  # a goalie has walked there with the ball
            return []
        return award_goal_kick(self._world, end, y)

    def _beyond_side_line(self, x: float, y: float, toucher: int) -> list[str]:
        x, y = truncate_to_pitch(x, y)
        if toucher != NO_SIDE:
            return _award(self._world, _KICK_IN[RIGHT if toucher == LEFT else LEFT], x, y)
        x, y = move_out_of_penalty_area(NO_SIDE, x, y)
        drop_ball(self._world, x, y)
        return ["drop_ball", "play_on"]


def award_goal_kick(world: World, side: int, y: float) -> list[str]:
    """Give a side a goal kick, at the corner of the goal area where the ball (y) was; returns what is announced."""
    x = (HALF_LENGTH - GOAL_AREA_LENGTH) * (-1.0 if side == LEFT else 1.0)
    return _award(world, _GOAL_KICK[side], x, _with_sign(0.5 * GOAL_AREA_WIDTH, y))


def call_catch_fault(world: World, side: int) -> list[str]:
    """Stop the play as a goalie of a side has caught the ball outside of his area; returns what is announced."""
    x, y = truncate_to_pitch(*world.match["ball_pos"][0].tolist())
    x, y = move_out_of_penalty_area(side, x, y)
    world.match["kick_off_side"] = RIGHT if side == LEFT else LEFT
    return _award(world, CATCH_FAULT_LEFT if side == LEFT else CATCH_FAULT_RIGHT, x, y)


def _award(world: World, mode: int, x: float, y: float) -> list[str]:
    world.match["catcher"] = -1
    place_ball(world.match, x, y, 0.0, 0.0)
    return _change_mode(world, mode)


def _change_mode(world: World, mode: int) -> list[str]:
    change_play_mode(world, mode)
    return [PLAY_MODES[mode]]


def _with_sign(size: float, y: float) -> float:
    """Return ``size`` on the side of ``y``, on the negative one for 0."""
    return size if y > 0.0 else -size
