"""Those who should have been in view but were not: moved out of sight, or forgotten.

The cone in which something "should have been seen" is the one of a view angle of 90 degrees, narrowed by 35 percent,
whatever the server's view angle is (removeGhosts of the UT Austin players).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_degrees
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.geometry import direction_to
from rcss_hat.player.objects import ball_distance, closest_opponent, is_known
from rcss_hat.player.records import NEVER, OPPONENTS

Record = NDArray[np.void]

HALF_VIEW = 45.0
SURE_VIEW = 0.65 * HALF_VIEW
"""Half-angle of the cone in which everything counts as seen (degrees)."""
_EDGE = 20.0
"""An opponent expected within so many degrees of that cone's edge is moved past it instead of being forgotten."""
_CENTRE, _FRESH = 10.0, 4
"""One expected within so many degrees of the centre, and whose body was seen less than so many cycles ago, is taken
to have gone on ..."""
_AHEAD = 2.0
"""... so many metres."""
_NOTICED = 0.9
"""Part of visible_distance within which a ball would have been noticed."""
_TAKES = 2.0
"""An opponent within so many metres of where the ball should be may have it ..."""
_HIDES = 4.5
"""... and hides it when he was not seen either and is within so many metres of the player."""


@kernel
def remove_ghosts(agent: Record, params: Record) -> None:
    """Correct the beliefs about ball and players that the see message just applied did not show."""
    time = agent["see_time"][0]
    if agent["ball_seen"][0] != time:
        _ball(agent, params)
    for o in range(agent["top_other"][0] - 1, OPPONENTS - 1, -1):
        if agent["player_seen"][0, o] != time and is_known(agent, o):
            _opponent(agent, params, o)
    for o in range(agent["top_own"][0]):
        if agent["player_seen"][0, o] != time and o != agent["me"][0] and is_known(agent, o):
            if abs(_view_angle(agent, agent["player_pos"][0, o, 0], agent["player_pos"][0, o, 1])) < SURE_VIEW:
                agent["player_seen"][0, o] = NEVER


@kernel
def _view_angle(agent: Record, x: float, y: float) -> float:
    """Direction of a point relative to the face (degrees)."""
    return normalize_degrees(direction_to(x - agent["pos"][0, 0], y - agent["pos"][0, 1]) - agent["neck"][0])


@kernel
def _ball(agent: Record, params: Record) -> None:
    x, y = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    near = ball_distance(agent) < _NOTICED * params["visible_distance"][0]
    if abs(_view_angle(agent, x, y)) < SURE_VIEW:
        opponent, distance = closest_opponent(agent, x, y)
        hidden = False
        if distance < _TAKES:
            dx = agent["player_pos"][0, opponent, 0] - agent["pos"][0, 0]
            dy = agent["player_pos"][0, opponent, 1] - agent["pos"][0, 1]
            unseen = agent["player_seen"][0, opponent] != agent["see_time"][0]
            hidden = unseen and dx * dx + dy * dy < _HIDES * _HIDES
        if hidden:
            _ball_to(agent, opponent)
        else:
            agent["ball_seen"][0] = NEVER
    if near:
        opponent, distance = closest_opponent(agent, agent["ball_pos"][0, 0], agent["ball_pos"][0, 1])
        if distance < _TAKES:
            _ball_to(agent, opponent)
        else:
            agent["ball_seen"][0] = NEVER


@kernel
def _ball_to(agent: Record, slot: int) -> None:
    agent["ball_pos"][0, 0] = agent["player_pos"][0, slot, 0]
    agent["ball_pos"][0, 1] = agent["player_pos"][0, slot, 1]


@kernel
def _opponent(agent: Record, params: Record, o: int) -> None:
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    x, y = agent["player_pos"][0, o, 0], agent["player_pos"][0, o, 1]
    distance = math.sqrt((x - px) ** 2 + (y - py) ** 2)
    angle = _view_angle(agent, x, y)
    if abs(angle) < SURE_VIEW:
        if abs(angle) + _EDGE > SURE_VIEW:
            distance = _step_aside(agent, params, o, angle, distance)
        else:
            agent["player_seen"][0, o] = NEVER
    if distance < params["visible_distance"][0]:
        way = direction_to(agent["player_pos"][0, o, 0] - px, agent["player_pos"][0, o, 1] - py) * DEG
        _put(agent, o, params["visible_distance"][0], way)


@kernel
def _step_aside(agent: Record, params: Record, o: int, angle: float, distance: float) -> float:
    """Put an opponent to that edge of the view to which it is nearer, if it can have come there; its distance (m)."""
    x, y = agent["player_pos"][0, o, 0], agent["player_pos"][0, o, 1]
    if abs(angle) < _CENTRE and agent["now"][0] - agent["player_angles"][0, o] < _FRESH:
        body = agent["player_body"][0, o] * DEG
        angle = _view_angle(agent, x + _AHEAD * math.cos(body), y + _AHEAD * math.sin(body))
    way = (agent["neck"][0] + (HALF_VIEW if angle > 0.0 else -HALF_VIEW)) * DEG
    dx = agent["pos"][0, 0] + distance * math.cos(way) - x
    dy = agent["pos"][0, 1] + distance * math.sin(way) - y
    most = (agent["now"][0] - agent["player_seen"][0, o]) * params["player_speed_max"][0]
    if dx * dx + dy * dy < most * most:
        _put(agent, o, distance, way)
    return distance


@kernel
def _put(agent: Record, o: int, distance: float, way: float) -> None:
    agent["player_pos"][0, o, 0] = agent["pos"][0, 0] + distance * math.cos(way)
    agent["player_pos"][0, o, 1] = agent["pos"][0, 1] + distance * math.sin(way)
    agent["player_time"][0, o] = agent["now"][0]
