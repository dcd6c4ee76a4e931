"""What a sense_body message changes: own motion, the confirmed commands, and everybody else's next cycle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_degrees
from rcss_hat.numeric.jit import kernel
from rcss_hat.player.fastest import current_fastest_opponent
from rcss_hat.player.geometry import direction_to, sign
from rcss_hat.player.kicking import ball_after_kick
from rcss_hat.player.motion import face, limited, sensed_velocity
from rcss_hat.player.objects import closest_opponent, closest_other, is_known
from rcss_hat.player.records import NEVER, OPPONENTS
from rcss_hat.protocol.records import COUNT_DASH, COUNT_KICK, COUNT_TURN, COUNT_TURN_NECK, DASH, KICK, N_COUNTS, TURN

Record = NDArray[np.void]

_STILL = 1e-4
_SEEN_STILL = 0.08
"""A speed component that may be rounding only (m/cycle)."""


@kernel
def feel(agent: Record, params: Record, sense: Record, others: bool) -> None:
    """Apply a sense_body message.

    Parameters
    ----------
    agent, params, sense : record
    others : bool
        False when the see message that follows shows every known player anyway: their motion is then not predicted.
    """
    agent["now"][0] = sense["time"][0]
    fresh, kind = agent["now"][0] - agent["sent_time"][0] == 1, agent["sent_kind"][0]
    dashed, turned, kicked, neck_turned = _confirmed(agent, sense)
    missed = (kind == DASH and not dashed) or (kind == TURN and not turned) or (kind == KICK and not kicked)
    if kicked:
        agent["fast_see"][0] = NEVER
        _roll_kicked_ball(agent, params)
    else:
        roll_ball(agent, params)
    agent["kicked"][0] = kicked
    agent["head"][0] = sense["head_angle"][0]
    agent["effort"][0] = sense["effort"][0]
    agent["speed"][0] = sense["speed"][0]
    agent["speed_direction"][0] = sense["speed_direction"][0]
    hit = _move_self(agent, params, dashed, turned, neck_turned)
    agent["withheld"][0] = hit and missed and fresh
    me = agent["me"][0]
    agent["player_pos"][0, me, 0] = agent["pos"][0, 0]
    agent["player_pos"][0, me, 1] = agent["pos"][0, 1]
    if others:
        move_opponents(agent, params)
        move_teammates(agent, params)


@kernel
def _confirmed(agent: Record, sense: Record) -> tuple[bool, bool, bool, bool]:
    """Which of the commands last given the server has executed: dash, turn, kick, turn_neck."""
    counts, new = agent["counts"], sense["counts"]
    dashed = new[0, COUNT_DASH] != counts[0, COUNT_DASH]
    turned = new[0, COUNT_TURN] != counts[0, COUNT_TURN]
    kicked = new[0, COUNT_KICK] != counts[0, COUNT_KICK]
    neck_turned = new[0, COUNT_TURN_NECK] != counts[0, COUNT_TURN_NECK]
    for i in range(N_COUNTS):
        counts[0, i] = new[0, i]
    age = sense["time"][0] - agent["sent_time"][0]
    recent = age == 1 or age == 2
    agent["sent_time"][0] = NEVER
    kind = agent["sent_kind"][0]
    return (
        recent and dashed and kind == DASH,
        recent and turned and kind == TURN,
        recent and kicked and kind == KICK,
        recent and neck_turned,
    )


@kernel
def roll_ball(agent: Record, params: Record) -> None:
    """Let the ball roll one cycle; it stops next to an opponent who can kick it."""
    x, y = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    vx, vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
    opponent, _ = closest_opponent(agent, x, y)
    x += vx
    y += vy
    decay = params["ball_decay"][0]
    vx *= decay
    vy *= decay
    if opponent >= 0:
        dx, dy = x - agent["player_pos"][0, opponent, 0], y - agent["player_pos"][0, opponent, 1]
        if dx * dx + dy * dy < agent["kick_dist"][0] ** 2:
            vx, vy = 0.0, 0.0
    set_ball(agent, x, y, vx, vy)


@kernel
def set_ball(agent: Record, x: float, y: float, vx: float, vy: float) -> None:
    """Believe in a position (m) and velocity (m/cycle) of the ball; slower than 0.1 mm/cycle is at rest."""
    if vx * vx + vy * vy < _STILL * _STILL:
        vx, vy = 0.0, 0.0
    agent["ball_pos"][0, 0] = x
    agent["ball_pos"][0, 1] = y
    agent["ball_vel"][0, 0] = vx
    agent["ball_vel"][0, 1] = vy


@kernel
def _roll_kicked_ball(agent: Record, params: Record) -> None:
    dx, dy = agent["ball_pos"][0, 0] - agent["pos"][0, 0], agent["ball_pos"][0, 1] - agent["pos"][0, 1]
    if dx * dx + dy * dy >= agent["kick_dist"][0] ** 2:
        roll_ball(agent, params)
        return
    x, y, vx, vy = ball_after_kick(agent, params, agent["sent_a"][0], agent["sent_b"][0])
    set_ball(agent, x, y, vx, vy)


@kernel
def _move_self(agent: Record, params: Record, dashed: bool, turned: bool, neck_turned: bool) -> bool:
    """Own pose one cycle on: from the sensed speed, or after a collision (then True) from the command given."""
    decay = params["player_decay"][0]
    neck = agent["neck"][0]
    if neck_turned:
        neck += agent["sent_neck"][0]
    speed = agent["speed"][0]
    before = neck
    if turned:
        # While turning the player rolls: its speed before decay is the one it turned with.
        neck += agent["sent_a"][0] / (1.0 + params["inertia_moment"][0] * speed / decay)
    if _collided(agent, params, dashed, turned, before):
        return True
    face(agent, neck)
    vx, vy = sensed_velocity(agent)
    rolled_x, rolled_y = limited(vx / decay, vy / decay, params["player_speed_max"][0])
    agent["pos"][0, 0] += rolled_x
    agent["pos"][0, 1] += rolled_y
    agent["vel"][0, 0] = rolled_x * decay
    agent["vel"][0, 1] = rolled_y * decay
    return False


@kernel
def _collided(agent: Record, params: Record, dashed: bool, turned: bool, neck: float) -> bool:
    """Find out whether the player ran into something; if so set pose and ball accordingly.

    A collision shows as a speed that is (nearly) gone, or reversed, though the command should have led to another
    (updateAgentAndBallAfterSense of the UT Austin players).
    """
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    vx, vy = agent["vel"][0, 0], agent["vel"][0, 1]
    moves = dashed or turned
    decay = params["player_decay"][0]
    if turned:
        neck += agent["sent_a"][0] / (1.0 + params["inertia_moment"][0] * math.sqrt(vx * vx + vy * vy))
    if dashed:
        acceleration = agent["sent_a"][0] * params["dash_power_rate"][0] * agent["effort"][0]
        vx += acceleration * agent["body_cos"][0]
        vy += acceleration * agent["body_sin"][0]
    if moves:
        vx, vy = limited(vx, vy, params["player_speed_max"][0])
        px += vx
        py += vy
        vx *= decay
        vy *= decay
    bx, by = agent["ball_pos"][0, 0] - px, agent["ball_pos"][0, 1] - py
    ball = math.sqrt(bx * bx + by * by)
    speed, expected = agent["speed"][0], math.sqrt(vx * vx + vy * vy)
    way = (neck + agent["speed_direction"][0]) * DEG
    if speed < _STILL:
        hit = (expected > 0.01 and ball < 0.8) or ball < params["player_size"][0] + params["ball_size"][0]
    else:
        hit = False
        if ball < agent["kick_dist"][0] + 0.5 and speed < 0.25 * expected:
            other_x = sign(vx) != sign(speed * math.cos(way)) or abs(vx) < _SEEN_STILL
            other_y = sign(vy) != sign(speed * math.sin(way)) or abs(vy) < _SEEN_STILL
            hit = other_x and other_y
    agent["collided"][0] = hit
    if not hit:
        return False
    agent["collision_time"][0] = agent["now"][0]
    if ball < closest_other(agent, agent["pos"][0, 0], agent["pos"][0, 1]):
        away = 0.2 / ball if ball > 0.0 else 0.0
        set_ball(agent, px + bx * away, py + by * away, -0.1 * agent["ball_vel"][0, 0], -0.1 * agent["ball_vel"][0, 1])
    vx, vy = speed * math.cos(way), speed * math.sin(way)
    agent["pos"][0, 0] = px
    agent["pos"][0, 1] = py
    agent["vel"][0, 0] = vx
    agent["vel"][0, 1] = vy
    face(agent, normalize_degrees(neck))
    return True


@kernel
def move_opponents(agent: Record, params: Record) -> None:
    """Guess where the opponents went: the fastest to the ball towards it, the others along with the ball's x."""
    # Rules of thumb from eleven a side; the next see overwrites what they did, mostly after a single cycle.
    now = agent["now"][0]
    drift = -0.5 if agent["ball_vel"][0, 0] < -1.0 else -0.25
    if agent["ball_vel"][0, 0] > 0.0:
        drift = 0.5 if agent["ball_vel"][0, 0] > 1.0 else 0.25
    for o in range(agent["top_other"][0] - 1, OPPONENTS - 1, -1):
        cycles = now - agent["player_time"][0, o]
        if not is_known(agent, o) or agent["player_time"][0, o] <= 0:
            continue
        step_x, step_y = drift, 0.0
        if o == current_fastest_opponent(agent, params):
            dx = agent["ball_pos"][0, 0] - agent["player_pos"][0, o, 0]
            dy = agent["ball_pos"][0, 1] - agent["player_pos"][0, o, 1]
            way = direction_to(dx, dy) * DEG
            step_x, step_y = 0.3 * math.cos(way), 0.3 * math.sin(way)
        decay = params["player_decay"][0]
        for _ in range(cycles):
            agent["player_pos"][0, o, 0] += step_x
            agent["player_pos"][0, o, 1] += step_y
            agent["player_vel"][0, o, 0] *= decay
            agent["player_vel"][0, o, 1] *= decay
        agent["player_time"][0, o] = now


@kernel
def move_teammates(agent: Record, params: Record) -> None:
    """Let team mates roll. Number 1 stays where it is: the UT Austin base code takes it for the goalkeeper."""
    now = agent["now"][0]
    decay = params["player_decay"][0]
    for o in range(agent["top_own"][0]):
        cycles = now - agent["player_time"][0, o]
        if o == agent["me"][0] or not is_known(agent, o) or agent["player_time"][0, o] <= 0:
            continue
        if o != 0:
            for _ in range(cycles):
                agent["player_pos"][0, o, 0] += agent["player_vel"][0, o, 0]
                agent["player_pos"][0, o, 1] += agent["player_vel"][0, o, 1]
                agent["player_vel"][0, o, 0] *= decay
                agent["player_vel"][0, o, 1] *= decay
        agent["player_time"][0, o] = now
