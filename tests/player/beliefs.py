"""Players put into situations by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.agent import new_agent
from rcss_hat.player.motion import face
from rcss_hat.player.records import OPPONENTS
from rcss_hat.protocol.landmarks import LANDMARK_POSITIONS
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import BALL, HAS_CHANGE, HAS_DISTANCE, HAS_FACING, LEFT, LINE, PLAYER, SEE, empty

Record = NDArray[np.void]
NOW = 100


def parameters(**changes: Any) -> Record:
    values: dict[str, Any] = {
        "keepaway": True,
        "keepaway_length": 20.0,
        "keepaway_width": 20.0,
        "visible_angle": 360.0,
        "stamina_inc_max": 3500.0,
        "synch_mode": True,
        **changes,
    }
    return ServerParams("19.0", **values).record()


PARAMS = parameters()


def player(
    pos: tuple[float, float] = (0.0, 0.0),
    body: float = 0.0,
    vel: tuple[float, float] = (0.0, 0.0),
    side: int = LEFT,
    unum: int = 1,
    n: int = 3,
    m: int = 2,
    params: Record = PARAMS,
) -> Record:
    """A player who knows where it is in cycle NOW, and nothing else."""
    agent = new_agent(side, unum, n, m, params, 0)
    agent["now"][0] = agent["see_time"][0] = NOW
    agent["pos"][0] = pos
    agent["vel"][0] = vel
    face(agent, body)
    know(agent, int(agent["me"][0]), pos, vel, body)
    return agent


def know(
    agent: Record,
    slot: int,
    pos: tuple[float, float],
    vel: tuple[float, float] = (0.0, 0.0),
    body: float = 0.0,
    age: int = 0,
) -> None:
    """Let the player know another one, seen ``age`` cycles ago."""
    time = int(agent["now"][0]) - age
    for name, value in (("pos", pos), ("vel", vel), ("see_pos", pos), ("see_vel", vel)):
        agent[f"player_{name}"][0, slot] = value
    agent["player_body"][0, slot] = agent["player_see_body"][0, slot] = body
    for name in ("seen", "time", "change", "angles", "see_time"):
        agent[f"player_{name}"][0, slot] = time


def ball(agent: Record, pos: tuple[float, float], vel: tuple[float, float] = (0.0, 0.0), age: int = 0) -> None:
    time = int(agent["now"][0]) - age
    agent["ball_pos"][0] = agent["ball_see_pos"][0] = pos
    agent["ball_vel"][0] = vel
    for name in ("ball_seen", "ball_change", "ball_see_time"):
        agent[name][0] = time


def scattered(rng: np.random.Generator, side: int = LEFT, unum: int = 1) -> Record:
    """Everybody somewhere in the region, moving somehow; the ball rolls or lies still."""

    def point(size: float) -> tuple[float, float]:
        return tuple(rng.uniform(-size, size, 2))

    agent = player(point(9.0), rng.uniform(-180, 180), point(0.28), side, unum)
    for slot in (0, 1, 2, OPPONENTS, OPPONENTS + 1, OPPONENTS + 2)[: 5 if side == LEFT else 6]:
        if slot != agent["me"][0] and not (side != LEFT and slot == 2):
            know(agent, slot, point(9.0), point(0.28), rng.uniform(-180, 180), int(rng.integers(0, 6)))
    speed = rng.choice([0.0, 0.3, 1.0, 2.0])
    way = rng.uniform(-math.pi, math.pi)
    ball(agent, point(9.0), (speed * math.cos(way), speed * math.sin(way)))
    return agent


class Sight:
    """A see message, written object by object as a server would."""

    def __init__(self, time: int = NOW) -> None:
        self.see = empty(SEE)
        self.see["time"][0] = time

    def add(self, code: int, distance: float, direction: float, fields: int = HAS_DISTANCE, **more: float) -> Sight:
        i = int(self.see["n"][0])
        self.see["code"][0, i] = code
        self.see["fields"][0, i] = fields
        self.see["distance"][0, i] = distance
        self.see["direction"][0, i] = direction
        for name, value in more.items():
            self.see[name][0, i] = value
        self.see["n"][0] = i + 1
        return self

    def player(self, team: int, unum: int, distance: float, direction: float, **more: float) -> Sight:
        fields = HAS_DISTANCE | HAS_CHANGE | HAS_FACING if unum else HAS_DISTANCE
        return self.add(PLAYER, distance, direction, fields, team=team, unum=unum, **more)

    def ball(self, distance: float, direction: float, **more: float) -> Sight:
        return self.add(BALL, distance, direction, HAS_DISTANCE | HAS_CHANGE, **more)

    def landmarks(self, pose: tuple[float, float, float], wanted: NDArray[Any], half_view: float = 180.0) -> Sight:
        """All wanted landmarks in view from a pose (m, m, degrees of the face), rounded as the server rounds."""
        x, y, face_direction = pose
        for code, (lx, ly) in enumerate(LANDMARK_POSITIONS):
            direction = math.degrees(math.atan2(ly - y, lx - x)) - face_direction
            direction = (direction + 180.0) % 360.0 - 180.0
            if wanted[code] and abs(direction) < half_view:
                self.add(code, rounded(math.hypot(lx - x, ly - y), 0.01), float(round(direction)))
        return self

    def line(self, pose: tuple[float, float, float]) -> Sight:
        """The line in the line of sight."""
        x, y, face_direction = pose
        hits = []
        for k, (normal, gap) in enumerate(((180.0, 52.5 + x), (0.0, 52.5 - x), (-90.0, 34.0 + y), (90.0, 34.0 - y))):
            angle = (normal - face_direction + 180.0) % 360.0 - 180.0
            if abs(angle) < 90.0:
                hits.append((gap / math.cos(math.radians(angle)), k, angle))
        distance, k, angle = min(hits)
        return self.add(LINE + k, rounded(distance, 0.01), float(round(angle - 90.0 if angle > 0 else angle + 90.0)))


def rounded(distance: float, step: float) -> float:
    """Distance as the server tells it."""
    return round(math.exp(round(math.log(distance + 1e-10) / step) * step), 1)
