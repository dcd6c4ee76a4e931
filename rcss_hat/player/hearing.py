"""The players' language: what they say, and what they believe of what they hear.

A message is a row of units of fixed length, written with 73 symbols; numbers are cut off to a symbol and come back as
the lower edge of its cell. BallInfo: id, x, y, velocity x, velocity y, age. OppPos: id (8 + number - 1), x, y, age.
OurPos: id, x, y. OurPos is said but never believed: the UT Austin players file it under the listener's own number.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel
from rcss_hat.player.bodily import set_ball
from rcss_hat.player.kicking import ball_after_kick
from rcss_hat.player.motion import own_state_after, roll_out
from rcss_hat.player.objects import ball_distance, distance2_to, is_known
from rcss_hat.player.records import NEVER, NOBODY, OPPONENTS
from rcss_hat.protocol.records import KICK, SAY_SIZE

Record = NDArray[np.void]

ALPHABET = b"0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ().+-*/?<>_"
N_SYMBOLS = len(ALPHABET)
_SYMBOLS = np.frombuffer(ALPHABET, dtype=np.uint8).copy()
_VALUES = np.full(256, -1, dtype=np.int64)
_VALUES[_SYMBOLS] = np.arange(N_SYMBOLS)

OUR_POS, BALL_INFO, OPP_POS, TEAMMATE_POS = 0, 1, 8, 19
"""Unit ids; OPP_POS and TEAMMATE_POS plus number - 1. The ids 3 to 7 stand for units nobody sends."""
X_SPAN, Y_SPAN, V_SPAN = 106.0, 68.0, 5.4
_SIZES = np.array([3, 6, 0, 2, 2, 2, 3, 1] + [4] * 22, dtype=np.int64)

SEEN_WELL = 20.0
"""Ball distance below which its velocity, if seen, is worth telling (m)."""
OWN_POSITION_MEMORY = 7
"""Cycles for which the own position is worth telling (confidence above 0.92)."""


@kernel
def encode(value: float, span: float) -> int:
    """Symbol of a value in [-span/2, span/2); values beyond get the first or last symbol."""
    return _SYMBOLS[min(max(int((value + 0.5 * span) / span * N_SYMBOLS), 0), N_SYMBOLS - 1)]


@kernel
def decode(symbol: int, span: float) -> float:
    """Value of a symbol: the lower edge of its cell."""
    return _VALUES[symbol] / N_SYMBOLS * span - 0.5 * span


@kernel
def speak(agent: Record, params: Record, kind: int, a: float, b: float, action: Record) -> None:
    """Write what there is to say into an action, given the body command of this cycle."""
    action["say_n"][0] = 0
    now = agent["now"][0]
    if now - agent["say_time"][0] < params["hear_decay"][0] or now <= 0:
        return
    agent["say_time"][0] = now
    n = _tell_ball(agent, params, kind, a, b, action["say"][0])
    n = _tell_opponent(agent, params, action["say"][0], n)
    age = now - agent["player_seen"][0, agent["me"][0]]
    if n <= SAY_SIZE - 3 and 0 <= age <= OWN_POSITION_MEMORY:
        x, y, _, _, _ = own_state_after(agent, params, kind, a)
        say = action["say"][0]
        say[n] = _SYMBOLS[OUR_POS]
        say[n + 1] = encode(x, X_SPAN)
        say[n + 2] = encode(y, Y_SPAN)
        n += 3
    action["say_n"][0] = n


@kernel
def _tell_ball(agent: Record, params: Record, kind: int, a: float, b: float, say: NDArray[np.uint8]) -> int:
    """Write a BallInfo if the ball is seen well or just kicked away; returns the length written."""
    now, distance, reach = agent["now"][0], ball_distance(agent), agent["kick_dist"][0]
    seen = agent["ball_seen"][0] == now
    worth = seen and distance < params["visible_distance"][0]
    worth = worth or (seen and agent["ball_change"][0] == now and distance < SEEN_WELL)
    if not worth and distance >= reach:
        return 0
    x, y = agent["ball_pos"][0, 0], agent["ball_pos"][0, 1]
    vx, vy = agent["ball_vel"][0, 0], agent["ball_vel"][0, 1]
    age = 1
    if distance < reach:
        next_x, next_y, next_vx, next_vy = x + vx, y + vy, vx, vy
        if kind == KICK:
            next_x, next_y, next_vx, next_vy = ball_after_kick(agent, params, a, b)
        if not worth:
            px, py, _, _, _ = own_state_after(agent, params, kind, a)
            if math.sqrt((next_x - px) ** 2 + (next_y - py) ** 2) <= reach:
                return 0
        vx, vy = 0.0, 0.0
        if kind == KICK:
            px, py = roll_out(agent, 1)
            if math.sqrt((next_x - px) ** 2 + (next_y - py) ** 2) > reach + 0.2:
                x, y, vx, vy, age = next_x, next_y, next_vx, next_vy, 0
    say[0] = _SYMBOLS[BALL_INFO]
    say[1] = encode(x, X_SPAN)
    say[2] = encode(y, Y_SPAN)
    say[3] = encode(vx, V_SPAN)
    say[4] = encode(vy, V_SPAN)
    say[5] = _SYMBOLS[age]
    return 6


@kernel
def _tell_opponent(agent: Record, params: Record, say: NDArray[np.uint8], n: int) -> int:
    """Write an OppPos for the nearest opponent seen in this cycle close by; returns the length of the message."""
    px, py = agent["pos"][0, 0], agent["pos"][0, 1]
    best, best2 = NOBODY, params["visible_distance"][0] ** 2
    for o in range(OPPONENTS, OPPONENTS + agent["n_takers"][0]):
        if agent["player_seen"][0, o] == agent["now"][0]:
            d2 = distance2_to(agent, o, px, py)
            if d2 < best2:
                best, best2 = o, d2
    if best == NOBODY:
        return n
    say[n] = _SYMBOLS[OPP_POS + best - OPPONENTS]
    say[n + 1] = encode(agent["player_pos"][0, best, 0], X_SPAN)
    say[n + 2] = encode(agent["player_pos"][0, best, 1], Y_SPAN)
    say[n + 3] = _SYMBOLS[1]
    return n + 4


@kernel
def listen(agent: Record, params: Record, heard: Record) -> None:
    """Take over what a team mate said; a message that does not parse to its end is ignored."""
    text, n = heard["text"][0], heard["n"][0]
    if not _is_language(text, n):
        return
    i = 0
    while i < n:
        unit = _VALUES[text[i]]
        if unit == BALL_INFO:
            _hear_ball(agent, text, i)
        elif OPP_POS <= unit < TEAMMATE_POS:
            _hear_player(agent, OPPONENTS + unit - OPP_POS, text, i, 1)
        elif unit >= TEAMMATE_POS:
            _hear_player(agent, unit - TEAMMATE_POS, text, i, 0)
        i += _SIZES[unit]


@kernel
def _is_language(text: NDArray[np.uint8], n: int) -> bool:
    i = 0
    while i < n:
        unit = _VALUES[text[i]]
        if unit < 0 or unit >= TEAMMATE_POS + 11 or unit == 2:
            return False
        if i + _SIZES[unit] > n:
            return False
        for j in range(i, i + _SIZES[unit]):
            if _VALUES[text[j]] < 0:
                return False
        i += _SIZES[unit]
    return True


@kernel
def _hear_ball(agent: Record, text: NDArray[np.uint8], i: int) -> None:
    """Believe a BallInfo when the own information is old, or when the ball was kicked far away since."""
    x, y = decode(text[i + 1], X_SPAN), decode(text[i + 2], Y_SPAN)
    vx, vy = decode(text[i + 3], V_SPAN), decode(text[i + 4], V_SPAN)
    age, now = _VALUES[text[i + 5]], agent["now"][0]
    for _ in range(age):
        x += vx
        y += vy
        vx *= 0.94
        vy *= 0.94
    change = agent["ball_change"][0]
    differs = math.sqrt((vx - agent["ball_vel"][0, 0]) ** 2 + (vy - agent["ball_vel"][0, 1]) ** 2) > 0.3
    far = ball_distance(agent) > 3.0
    lost = agent["ball_seen"][0] == NEVER
    if not lost and not (far and (change < now - 3 or (change < now - age and differs))):
        return
    own_age = now - agent["ball_seen"][0]
    if lost or own_age > age + 1 or differs:
        set_ball(agent, x, y, vx, vy)
        agent["ball_seen"][0] = now - age - 1
        agent["hear_time"][0] = now


@kernel
def _hear_player(agent: Record, slot: int, text: NDArray[np.uint8], i: int, delay: int) -> None:
    """Believe where a player is if that is newer than the own information.

    ``delay`` cycles are added to the age told.
    """
    if slot == agent["me"][0]:
        return
    now = agent["now"][0]
    age = _VALUES[text[i + 3]] + delay
    if is_known(agent, slot) and agent["player_known"][0, slot] and now - agent["player_seen"][0, slot] <= age:
        return
    agent["player_pos"][0, slot, 0] = decode(text[i + 1], X_SPAN)
    agent["player_pos"][0, slot, 1] = decode(text[i + 2], Y_SPAN)
    agent["player_vel"][0, slot, 0] = 0.0
    agent["player_vel"][0, slot, 1] = 0.0
    agent["player_time"][0, slot] = now - age
    agent["player_seen"][0, slot] = now - age
    agent["player_known"][0, slot] = 1
    agent["hear_time"][0] = now
    if slot >= OPPONENTS:
        agent["top_other"][0] = max(agent["top_other"][0], slot + 1)
    else:
        agent["top_own"][0] = max(agent["top_own"][0], slot + 1)
