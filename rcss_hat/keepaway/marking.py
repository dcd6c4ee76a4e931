"""Marking: what the takers do who are neither first nor second at the ball."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.geometry import direction_to, in_cone, in_interval, sign
from rcss_hat.player.motion import turn_body_moment
from rcss_hat.player.moving import move_to
from rcss_hat.player.objects import is_known
from rcss_hat.player.records import NOBODY, OPPONENTS
from rcss_hat.protocol.landmarks import PITCH_LENGTH
from rcss_hat.protocol.records import MAX_PLAYERS, TURN

Record = NDArray[np.void]

LANE = 0.3
"""Half-width of a pass lane, metres per metre."""
MARK_DISTANCE = 4.0
"""Distance from the marked player towards the ball (m)."""
THERE = 2.0
PRECISION, BACK = 25.0, 3.0
"""Heading error (degrees) and distance (m) for moving there, see `move_to`."""
SIDEWAYS = 80.0
"""Standing there, the body is turned so far off the marked player (degrees)."""


@kernel
def most_open_opponent(agent: Record, holder: int) -> int:
    """Opponent whose pass lane from the holder has the fewest takers in it: slot or NOBODY.

    The holder is one of them; his own lane, without length, is empty: only those with higher numbers come before him.
    """
    from_x, from_y = -1000.0, -1000.0
    pos = agent["player_pos"]
    if holder != NOBODY:
        from_x, from_y = pos[0, holder, 0], pos[0, holder, 1]
    best, fewest = holder, MAX_PLAYERS
    for o in range(agent["top_other"][0] - 1, OPPONENTS - 1, -1):
        if not is_known(agent, o):
            continue
        takers = 0
        for t in range(agent["top_own"][0]):
            if is_known(agent, t):
                if in_cone(pos[0, t, 0], pos[0, t, 1], from_x, from_y, pos[0, o, 0], pos[0, o, 1], LANE):
                    takers += 1
        if takers < fewest:
            best, fewest = o, takers
    return best


@kernel
def mark(agent: Record, params: Record, opponent: int) -> tuple[int, float]:
    """Stand between an opponent and the ball.

    Returns
    -------
    (int, float)
        TURN and moment (degrees), or DASH and power.
    """
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    bx, by = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    ox, oy = -1000.0, -1000.0
    if opponent != NOBODY:
        ox, oy = agent["player_pos"][0, opponent, 0], agent["player_pos"][0, opponent, 1]
    # Marked players are taken to be 1 m nearer to the own goal line than they are.
    marked_x = ox - 1.0 if ox > 4.0 - 0.5 * PITCH_LENGTH else ox
    way = direction_to(bx - marked_x, by - oy) * DEG
    x, y = marked_x + MARK_DISTANCE * math.cos(way), oy + MARK_DISTANCE * math.sin(way)
    if abs(x) > 0.5 * PITCH_LENGTH - 2.0:
        x = sign(x) * (0.5 * PITCH_LENGTH - 2.0)
    if (px - x) ** 2 + (py - y) ** 2 < THERE * THERE:
        to_opponent = direction_to(ox - px, oy - py)
        ball = direction_to(bx - px, by - py)
        turned = SIDEWAYS if in_interval(ball, to_opponent, to_opponent + 180.0) else -SIDEWAYS
        facing = (to_opponent + turned) * DEG
        return TURN, turn_body_moment(agent, params, px + math.cos(facing), py + math.sin(facing), 1)
    return move_to(agent, params, x, y, PRECISION, BACK)
