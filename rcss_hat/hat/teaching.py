"""What goes on in a scripted teacher's mind, cycle by cycle: the kernels behind `rcss_hat.hat.teachers`.

Once per cycle the teacher is shown the picture and answers with the key it presses (`teach`). What is asked of a person
is drawn once per possession, not once per cycle: a misjudged lane stays misjudged until the ball is another keeper's.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import njit
from rcss_hat.numeric.rng import bernoulli, integer, normal, uniform
from rcss_hat.protocol.records import MAX_PLAYERS

HISTORY = 64
"""Pictures kept."""
MOTION_SPAN = 2
"""Motion is judged from two pictures so many cycles apart."""
MAX_DELAY = HISTORY - 1 - MOTION_SPAN
"""Longest reaction time (cycles)."""
REACH = 1.3
"""A keeper has the ball, to the eye, when it is this near (m); a little more than the kickable distance."""
NOBODY = -1
HOLD = 0

TEACHER = np.dtype(
    [
        ("delay", "f8"),
        ("delay_spread", "f8"),
        ("anticipation", "f8"),
        ("pass_distance", "f8"),
        ("panic_distance", "f8"),
        ("open", "f8"),
        ("wide_open", "f8"),
        ("space_weight", "f8"),
        ("far_bonus", "f8"),
        ("misjudgement", "f8"),
        ("lapse", "f8"),
        ("unready", "f8"),
        ("lapse_cycles", "f8"),
        ("slip", "f8"),
        ("max_action", "i4"),
    ]
)
"""A teacher's habits, as kernels read them; see `Teacher`."""

MEMORY = np.dtype(
    [
        ("cycle", "i4"),  # of the last picture
        ("pictures", "i4"),  # shown in this episode
        ("key", "i4"),  # pressed in that cycle
        ("holder", "i4"),  # keeper whose possession the drawn values belong to, or NOBODY
        ("delay", "i4"),  # drawn per possession: reaction time,
        ("awake", "i4"),  # number of the picture from which the teacher attends,
        ("distance_error", "f8"),  # factor on distances of takers,
        ("opening_error", "f8", (MAX_PLAYERS,)),  # factor on how open each keeper is,
        ("slips", "u1"),  # whether the wrong key will be pressed,
        ("slip_draw", "f8"),  # and which, in [0, 1)
        ("keepers", "f8", (HISTORY, MAX_PLAYERS, 2)),
        ("takers", "f8", (HISTORY, MAX_PLAYERS, 2)),
        ("present_keepers", "f8", (MAX_PLAYERS, 2)),  # where the teacher believes everybody to be now
        ("present_takers", "f8", (MAX_PLAYERS, 2)),
    ]
)
"""What a teacher has in mind: the last pictures, and what was drawn for the running possession."""


@njit
def forget(memory: NDArray[np.void]) -> None:
    """Forget everything at the beginning of an episode: the pictures before it show another game."""
    memory["cycle"][0] = -1
    memory["pictures"][0] = 0
    memory["key"][0] = HOLD
    memory["holder"][0] = NOBODY


@njit
def teach(
    teacher: NDArray[np.void],
    memory: NDArray[np.void],
    cycle: int,
    ball: NDArray[np.float64],
    keepers: NDArray[np.float64],
    takers: NDArray[np.float64],
    rng: NDArray[np.uint64],
) -> int:
    """Show a teacher the picture of a cycle and return the key it presses.

    Parameters
    ----------
    teacher : ndarray of TEACHER, shape (1,)
    memory : ndarray of MEMORY, shape (1,)
        Updated. Call `forget` when an episode begins.
    cycle : int
        A second call for the same cycle gives the same key and changes nothing.
    ball : ndarray, shape (2,)
    keepers, takers : ndarray, shapes (n, 2) and (m, 2)
        True positions, metres.
    rng : ndarray of uint64, shape (4,)

    Returns
    -------
    int
        0: no key, so Hold; k: pass to the k-th nearest team mate of the keeper with the ball.
    """
    if memory["pictures"][0] > 0 and memory["cycle"][0] == cycle:
        return memory["key"][0]
    _remember(memory, cycle, keepers, takers)
    holder = _holder(ball, keepers)
    if holder != NOBODY and holder != memory["holder"][0]:
        _begin_possession(teacher, memory, holder, keepers.shape[0], rng)
    key = HOLD
    if (
        memory["holder"][0] != NOBODY
        and memory["pictures"][0] > memory["delay"][0]
        and memory["pictures"][0] >= memory["awake"][0]
    ):
        key = _choose(teacher, memory, keepers.shape[0], takers.shape[0])
    memory["key"][0] = key
    return key


@njit
def _remember(
    memory: NDArray[np.void],
    cycle: int,
    keepers: NDArray[np.float64],
    takers: NDArray[np.float64],
) -> None:
    at = memory["pictures"][0] % HISTORY
    for axis in range(2):
        for i in range(keepers.shape[0]):
            memory["keepers"][0, at, i, axis] = keepers[i, axis]
        for j in range(takers.shape[0]):
            memory["takers"][0, at, j, axis] = takers[j, axis]
    memory["cycle"][0] = cycle
    memory["pictures"][0] += 1


@njit
def _holder(ball: NDArray[np.float64], keepers: NDArray[np.float64]) -> int:
    """The keeper nearest to the ball, if it is within his reach."""
    holder, least = NOBODY, REACH
    for i in range(keepers.shape[0]):
        distance = math.hypot(keepers[i, 0] - ball[0], keepers[i, 1] - ball[1])
        if distance < least:
            holder, least = i, distance
    return holder


@njit
def _begin_possession(
    teacher: NDArray[np.void], memory: NDArray[np.void], holder: int, n_keepers: int, rng: NDArray[np.uint64]
) -> None:
    """Draw what a person brings to a possession: reaction time, attention, errors."""
    inattention = teacher["unready"][0] if memory["holder"][0] == NOBODY else teacher["lapse"][0]
    memory["holder"][0] = holder
    spread = teacher["delay_spread"][0]
    memory["delay"][0] = int(round(teacher["delay"][0] + uniform(rng, -spread, spread)))
    awake = memory["pictures"][0]
    if bernoulli(rng, inattention):
        awake += integer(rng, int(teacher["lapse_cycles"][0]) + 1)
    memory["awake"][0] = awake
    error = teacher["misjudgement"][0]
    memory["distance_error"][0] = math.exp(error * normal(rng))
    for i in range(n_keepers):
        memory["opening_error"][0, i] = math.exp(error * normal(rng))
    memory["slips"][0] = 1 if bernoulli(rng, teacher["slip"][0]) else 0
    memory["slip_draw"][0] = uniform(rng, 0.0, 1.0)


@njit
def _imagine(teacher: NDArray[np.void], memory: NDArray[np.void], n_keepers: int, n_takers: int) -> None:
    """Make up the present: the picture of ``delay`` cycles ago, moved on as far as the teacher anticipates."""
    past = memory["pictures"][0] - 1 - memory["delay"][0]
    earlier = max(past - MOTION_SPAN, 0)
    ahead = 0.0
    if past > earlier:
        ahead = teacher["anticipation"][0] * memory["delay"][0] / (past - earlier)
    at, before = past % HISTORY, earlier % HISTORY
    keepers, takers = memory["keepers"], memory["takers"]
    for axis in range(2):
        for i in range(n_keepers):
            x = keepers[0, at, i, axis]
            memory["present_keepers"][0, i, axis] = x + ahead * (x - keepers[0, before, i, axis])
        for j in range(n_takers):
            x = takers[0, at, j, axis]
            memory["present_takers"][0, j, axis] = x + ahead * (x - takers[0, before, j, axis])


@njit
def _choose(teacher: NDArray[np.void], memory: NDArray[np.void], n_keepers: int, n_takers: int) -> int:
    """Decide by what the teacher believes to be the present."""
    _imagine(teacher, memory, n_keepers, n_takers)
    holder = memory["holder"][0]
    keepers, takers = memory["present_keepers"][0], memory["present_takers"][0]
    x, y = keepers[holder, 0], keepers[holder, 1]
    pressure = 1e12
    for j in range(n_takers):
        pressure = min(pressure, math.hypot(takers[j, 0] - x, takers[j, 1] - y))
    pressure *= memory["distance_error"][0]

    best_key, most_open, best_worth = HOLD, 0.0, -1e12
    for i in range(n_keepers):
        key = _rank(keepers, n_keepers, holder, i)
        if i == holder:
            continue
        opening = _opening(keepers, takers, n_takers, holder, i, teacher["space_weight"][0])
        opening *= memory["opening_error"][0, i]
        worth = opening + (teacher["far_bonus"][0] if key > 1 else 0.0)
        if worth > best_worth:
            best_key, most_open, best_worth = key, opening, worth
    invited = most_open >= teacher["wide_open"][0]
    pressed = pressure <= teacher["pass_distance"][0] and most_open >= teacher["open"][0]
    if (
        best_key == HOLD
        or best_key > teacher["max_action"][0]
        or not (invited or pressed or pressure <= teacher["panic_distance"][0])
    ):
        return HOLD
    return _slipped(teacher, memory, best_key, n_keepers) if memory["slips"][0] else best_key


@njit
def _rank(keepers: NDArray[np.float64], n_keepers: int, holder: int, mate: int) -> int:
    """Place of a team mate by distance to the keeper with the ball: 1 nearest; the earlier of equals first."""
    x, y = keepers[holder, 0], keepers[holder, 1]
    own = math.hypot(keepers[mate, 0] - x, keepers[mate, 1] - y)
    rank = 1
    for i in range(n_keepers):
        if i != holder and i != mate:
            other = math.hypot(keepers[i, 0] - x, keepers[i, 1] - y)
            if other < own or (other == own and i < mate):
                rank += 1
    return rank


@njit
def _opening(
    keepers: NDArray[np.float64],
    takers: NDArray[np.float64],
    n_takers: int,
    holder: int,
    mate: int,
    space_weight: float,
) -> float:
    """How open a team mate is: smallest angle to a taker, plus the weighted distance to the nearest one (degrees)."""
    x, y = keepers[holder, 0], keepers[holder, 1]
    ux, uy = keepers[mate, 0] - x, keepers[mate, 1] - y
    lane, space = 180.0, 1e12
    for j in range(n_takers):
        wx, wy = takers[j, 0] - x, takers[j, 1] - y
        lane = min(lane, math.atan2(abs(ux * wy - uy * wx), ux * wx + uy * wy) * RAD)
        space = min(space, math.hypot(takers[j, 0] - keepers[mate, 0], takers[j, 1] - keepers[mate, 1]))
    return lane + space_weight * space


@njit
def _slipped(teacher: NDArray[np.void], memory: NDArray[np.void], key: int, n_keepers: int) -> int:
    """Another pass key than the one meant; the same when there is no other."""
    n_keys = min(teacher["max_action"][0], n_keepers - 1)
    if n_keys < 2:
        return key
    wrong = 1 + int(memory["slip_draw"][0] * (n_keys - 1))
    return wrong if wrong < key else wrong + 1
