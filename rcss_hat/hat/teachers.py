"""Scripted teachers: stand-ins for people where none are present.

A scripted teacher sees what a person sees in the viewer, the true positions of ball and players, not the 13 state
variables. It looks at a picture some cycles old (reaction time), misjudges distances and angles, now and then does
not attend or presses the wrong key, and otherwise follows a simple strategy: hold until a taker is near or a lane is
wide open, then pass into the best lane. When no key is pressed the keeper with the ball holds.

One teacher plays whichever keeper has the ball. Once per cycle it is shown the picture and answers with the key it
presses (`teach`); every keeper that takes a decision in this cycle acts by that key.

What is asked of a person is drawn once per possession, not once per cycle: a misjudged lane stays misjudged until the
ball goes to another keeper.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.numeric import rng as random_streams
from rcss_hat.numeric.angles import RAD
from rcss_hat.numeric.jit import njit
from rcss_hat.numeric.rng import bernoulli, integer, normal, uniform
from rcss_hat.protocol.records import MAX_PLAYERS

HISTORY = 64
"""Pictures kept; the longest reaction time is one cycle shorter."""
REACH = 1.3
"""A keeper has the ball, to the eye, when it is this near (m); a little more than the kickable distance."""
NOBODY = -1
HOLD = 0

TEACHER = np.dtype(
    [
        ("delay", "f8"),
        ("delay_spread", "f8"),
        ("pass_distance", "f8"),
        ("panic_distance", "f8"),
        ("open_lane", "f8"),
        ("wide_lane", "f8"),
        ("space_weight", "f8"),
        ("far_bonus", "f8"),
        ("misjudgement", "f8"),
        ("lapse", "f8"),
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
        ("lane_error", "f8", (MAX_PLAYERS,)),  # factor on each keeper's lane,
        ("slips", "u1"),  # whether the wrong key will be pressed,
        ("slip_draw", "f8"),  # and which, in [0, 1)
        ("ball", "f8", (HISTORY, 2)),
        ("keepers", "f8", (HISTORY, MAX_PLAYERS, 2)),
        ("takers", "f8", (HISTORY, MAX_PLAYERS, 2)),
    ]
)
"""What a teacher has in mind: the last pictures, and what was drawn for the running possession."""


@dataclass(frozen=True, slots=True)
class Teacher:
    """Habits of a scripted teacher.

    Attributes
    ----------
    delay : float
        Mean reaction time in cycles of 100 ms: the teacher acts on the picture of so long ago. People take 3 to 5.
    delay_spread : float
        Largest deviation of the reaction time from its mean, drawn per possession (cycles).
    pass_distance : float
        Wants to pass when the nearest taker is this near to the keeper with the ball (m).
    panic_distance : float
        At this distance (m) passes even if no lane is open.
    open_lane : float
        Smallest angle between a team mate and any taker, at the keeper with the ball, at which the lane counts as
        open (degrees).
    wide_lane : float
        A lane this wide (degrees) is used at once, however far the takers are; above 180 never.
    space_weight : float
        Worth of a metre between team mate and nearest taker, in degrees of lane.
    far_bonus : float
        Worth of being farther away than the nearest team mate, in degrees of lane; negative prefers near ones.
    misjudgement : float
        Standard deviation of the relative error of judged distances and angles.
    lapse : float
        Probability of not attending at the beginning of a possession.
    lapse_cycles : float
        How long a lapse lasts at most (cycles).
    slip : float
        Probability of a wrong key per possession.
    max_action : int
        Highest action the teacher may use: 1 allows Hold and PASS1 only.
    """

    delay: float = 4.0
    delay_spread: float = 1.0
    pass_distance: float = 5.0
    panic_distance: float = 2.0
    open_lane: float = 20.0
    wide_lane: float = 181.0
    space_weight: float = 4.0
    far_bonus: float = 0.0
    misjudgement: float = 0.1
    lapse: float = 0.0
    lapse_cycles: float = 15.0
    slip: float = 0.0
    max_action: int = MAX_PLAYERS - 1

    def __post_init__(self) -> None:
        if not 0.0 <= self.delay_spread <= self.delay or self.delay + self.delay_spread > HISTORY - 1:
            raise ValueError(
                f"delay - delay_spread must be 0 or more and delay + delay_spread at most {HISTORY - 1} cycles, not "
                f"{self.delay:g} and {self.delay_spread:g}"
            )
        for name in ("lapse", "slip"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} is a probability from 0 to 1, not {getattr(self, name):g}")
        for name in ("pass_distance", "panic_distance", "open_lane", "wide_lane", "misjudgement", "lapse_cycles"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be 0 or more, not {getattr(self, name):g}")
        if not 1 <= self.max_action < MAX_PLAYERS:
            raise ValueError(f"max_action must be 1 (Hold and PASS1) to {MAX_PLAYERS - 1}, not {self.max_action}")

    def fast(self, factor: float = 5.0) -> Teacher:
        """Return the same teacher at a simulator that runs ``factor`` times faster than real time."""
        return replace(
            self,
            delay=self.delay * factor,
            delay_spread=self.delay_spread * factor,
            lapse_cycles=self.lapse_cycles * factor,
        )

    def limited(self) -> Teacher:
        """Return the same teacher restricted to Hold and PASS1."""
        return replace(self, max_action=1)

    def to_record(self) -> NDArray[np.void]:
        """Return the TEACHER record, shape (1,)."""
        record = np.zeros(1, dtype=TEACHER)
        for field in fields(self):
            record[field.name] = getattr(self, field.name)
        return record


_B = Teacher(pass_distance=6.0, open_lane=25.0, wide_lane=60.0, misjudgement=0.08, lapse=0.05, slip=0.02)

STYLES: Mapping[str, Teacher] = MappingProxyType(
    {
        "A": Teacher(delay=3.0, pass_distance=4.0, open_lane=15.0, far_bonus=10.0, lapse=0.1, slip=0.02),
        "B": _B,
        "C": Teacher(delay=5.0, pass_distance=5.0, misjudgement=0.2, lapse=0.15, slip=0.06, far_bonus=-10.0),
        "B-fast": _B.fast(),
        "B-limited": _B.limited(),
    }
)
"""Teachers in the manner of the HAT paper's subjects (section 5): A, long experience, holds long and passes late; B,
practised, passes early and well; C, a novice; and B handicapped by a simulator five times as fast, or by having Hold
and PASS1 only."""


class ScriptedTeacher:
    """A teacher with its memory and random stream, for use from Python.

    Parameters
    ----------
    teacher : Teacher or str
        Habits, or a name from `STYLES`.
    seed : int

    Attributes
    ----------
    record, memory : ndarray of TEACHER and MEMORY, shape (1,)
    stream : ndarray of uint64, shape (4,)
        These three are what `teach` needs in a compiled loop.
    """

    def __init__(self, teacher: Teacher | str, seed: int) -> None:
        self.teacher = style(teacher) if isinstance(teacher, str) else teacher
        self.record = self.teacher.to_record()
        self.memory = new_memory()
        self.stream = random_streams.stream(seed, random_streams.TEACHER)

    def new_episode(self) -> None:
        """Forget the pictures of the last episode."""
        forget(self.memory)

    def __call__(self, cycle: int, ball: ArrayLike, keepers: ArrayLike, takers: ArrayLike) -> int:
        """Show the picture of a cycle and return the key pressed; see `teach`."""
        return int(
            teach(self.record, self.memory, cycle, _points(ball), _points(keepers), _points(takers), self.stream)
        )


def style(name: str) -> Teacher:
    """Return a teacher of `STYLES`; upper and lower case are the same.

    Raises
    ------
    ValueError
        Listing the names there are.
    """
    for known, teacher in STYLES.items():
        if known.lower() == name.lower():
            return teacher
    raise ValueError(f"there is no scripted teacher {name!r}; known are {', '.join(STYLES)}")


def new_memory() -> NDArray[np.void]:
    """Make the memory of a teacher that has seen nothing; MEMORY, shape (1,)."""
    memory = np.zeros(1, dtype=MEMORY)
    forget(memory)
    return memory


def _points(positions: ArrayLike) -> NDArray[np.float64]:
    return np.ascontiguousarray(positions, dtype=np.float64)


# --- kernels ----------------------------------------------------------------------------------------------------


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
    _remember(memory, cycle, ball, keepers, takers)
    holder = _holder(ball, keepers)
    if holder != NOBODY and holder != memory["holder"][0]:
        _begin_possession(teacher, memory, holder, keepers.shape[0], rng)
    key = HOLD
    if memory["pictures"][0] > memory["delay"][0] and memory["pictures"][0] >= memory["awake"][0]:
        key = _choose(teacher, memory, keepers.shape[0], takers.shape[0])
    memory["key"][0] = key
    return key


@njit
def _remember(
    memory: NDArray[np.void],
    cycle: int,
    ball: NDArray[np.float64],
    keepers: NDArray[np.float64],
    takers: NDArray[np.float64],
) -> None:
    at = memory["pictures"][0] % HISTORY
    for axis in range(2):
        memory["ball"][0, at, axis] = ball[axis]
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
    memory["holder"][0] = holder
    spread = teacher["delay_spread"][0]
    memory["delay"][0] = int(round(teacher["delay"][0] + uniform(rng, -spread, spread)))
    awake = memory["pictures"][0]
    if bernoulli(rng, teacher["lapse"][0]):
        awake += integer(rng, int(teacher["lapse_cycles"][0]) + 1)
    memory["awake"][0] = awake
    error = teacher["misjudgement"][0]
    memory["distance_error"][0] = math.exp(error * normal(rng))
    for i in range(n_keepers):
        memory["lane_error"][0, i] = math.exp(error * normal(rng))
    memory["slips"][0] = 1 if bernoulli(rng, teacher["slip"][0]) else 0
    memory["slip_draw"][0] = uniform(rng, 0.0, 1.0)


@njit
def _choose(teacher: NDArray[np.void], memory: NDArray[np.void], n_keepers: int, n_takers: int) -> int:
    """Decide by the picture of ``delay`` cycles ago."""
    at = (memory["pictures"][0] - 1 - memory["delay"][0]) % HISTORY
    keepers, takers = memory["keepers"][0, at], memory["takers"][0, at]
    holder = _holder(memory["ball"][0, at], keepers[:n_keepers])
    if holder != memory["holder"][0]:
        return HOLD  # the picture still shows the ball with another keeper, or on its way
    x, y = keepers[holder, 0], keepers[holder, 1]
    pressure = 1e12
    for j in range(n_takers):
        pressure = min(pressure, math.hypot(takers[j, 0] - x, takers[j, 1] - y))
    pressure *= memory["distance_error"][0]

    best, best_lane, best_worth = NOBODY, 0.0, -1e12
    for i in range(n_keepers):
        rank = _rank(keepers, n_keepers, holder, i)
        if i == holder or rank > teacher["max_action"][0]:
            continue
        lane, space = _opening(keepers, takers, n_takers, holder, i)
        lane *= memory["lane_error"][0, i]
        worth = lane + teacher["space_weight"][0] * space
        if rank > 1:
            worth += teacher["far_bonus"][0]
        if worth > best_worth:
            best, best_lane, best_worth = i, lane, worth
    if best == NOBODY:
        return HOLD
    invited = best_lane >= teacher["wide_lane"][0]
    pressed = pressure <= teacher["pass_distance"][0] and best_lane >= teacher["open_lane"][0]
    if not (invited or pressed or pressure <= teacher["panic_distance"][0]):
        return HOLD
    key = _rank(keepers, n_keepers, holder, best)
    return _slipped(teacher, memory, key, n_keepers) if memory["slips"][0] else key


@njit
def _rank(keepers: NDArray[np.float64], n_keepers: int, holder: int, mate: int) -> int:
    """Place of a team mate by distance to the keeper with the ball: 1 nearest; the earlier of equals first."""
    x, y = keepers[holder, 0], keepers[holder, 1]
    own = math.hypot(keepers[mate, 0] - x, keepers[mate, 1] - y)
    rank = 1
    for i in range(n_keepers):
        if i in (holder, mate):
            continue
        other = math.hypot(keepers[i, 0] - x, keepers[i, 1] - y)
        if other < own or (other == own and i < mate):
            rank += 1
    return rank


@njit
def _opening(
    keepers: NDArray[np.float64], takers: NDArray[np.float64], n_takers: int, holder: int, mate: int
) -> tuple[float, float]:
    """Lane to a team mate: smallest angle to a taker (degrees), and room around the mate (m)."""
    x, y = keepers[holder, 0], keepers[holder, 1]
    ux, uy = keepers[mate, 0] - x, keepers[mate, 1] - y
    lane, space = 180.0, 1e12
    for j in range(n_takers):
        wx, wy = takers[j, 0] - x, takers[j, 1] - y
        lane = min(lane, math.atan2(abs(ux * wy - uy * wx), ux * wx + uy * wy) * RAD)
        space = min(space, math.hypot(takers[j, 0] - keepers[mate, 0], takers[j, 1] - keepers[mate, 1]))
    return lane, space


@njit
def _slipped(teacher: NDArray[np.void], memory: NDArray[np.void], key: int, n_keepers: int) -> int:
    """Another pass key than the one meant; the same when there is no other."""
    n_keys = min(teacher["max_action"][0], n_keepers - 1)
    if n_keys < 2:
        return key
    wrong = 1 + int(memory["slip_draw"][0] * (n_keys - 1))
    return wrong if wrong < key else wrong + 1
