"""Scripted teachers: stand-ins for people where none are present.

A scripted teacher sees what a person sees in the viewer, the true positions of ball and players, not the 13 state
variables. It acts on a picture some cycles old (reaction time), moved on in its mind as far as it anticipates;
it knows who will get the ball, because a pass can be seen coming. It misjudges distances and angles, now and then does
not attend or presses the wrong key, and otherwise follows a simple strategy: hold until a taker is near or a team mate
is wide open, then pass to the one most open. When no key is pressed the keeper with the ball holds.

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


@dataclass(frozen=True, slots=True)
class Teacher:
    """Habits of a scripted teacher.

    Attributes
    ----------
    delay : float
        Mean reaction time in cycles of 100 ms: the teacher acts on the picture of so long ago. People take 3 to 5.
    delay_spread : float
        Largest deviation of the reaction time from its mean, drawn per possession (cycles).
    anticipation : float
        Share of the reaction time that the teacher makes up for by seeing how players move: 0 takes the old picture
        for the present, 1 moves everybody on by the whole reaction time.
    pass_distance : float
        Wants to pass when the nearest taker is this near to the keeper with the ball (m).
    panic_distance : float
        At this distance (m) passes even if nobody is open.
    open : float
        How open a team mate must be (degrees). Openness is the smallest angle between team mate and any taker, seen
        from the keeper with the ball, plus ``space_weight`` times the metres between team mate and nearest taker.
    wide_open : float
        To a team mate this open (degrees) the teacher passes at once, however far the takers are.
    space_weight : float
        Worth of a metre of room around a team mate (degrees).
    far_bonus : float
        Preference for others than the nearest team mate (degrees); negative prefers the nearest.
    misjudgement : float
        Standard deviation of the relative error of judged distances and angles.
    lapse : float
        Probability of not attending at the beginning of a possession.
    unready : float
        The same for the first possession of an episode: not ready when play begins again.
    lapse_cycles : float
        How long a lapse lasts at most (cycles).
    slip : float
        Probability of a wrong key per possession.
    max_action : int
        Highest action the teacher may use: 1 allows Hold and PASS1 only.
    """

    delay: float = 4.0
    delay_spread: float = 1.0
    anticipation: float = 0.5
    pass_distance: float = 5.0
    panic_distance: float = 1.0
    open: float = 80.0
    wide_open: float = 1000.0
    space_weight: float = 4.0
    far_bonus: float = 0.0
    misjudgement: float = 0.1
    lapse: float = 0.0
    unready: float = 0.0
    lapse_cycles: float = 15.0
    slip: float = 0.0
    max_action: int = MAX_PLAYERS - 1

    def __post_init__(self) -> None:
        if not 0.0 <= self.delay_spread <= self.delay or self.delay + self.delay_spread > MAX_DELAY:
            raise ValueError(
                f"delay - delay_spread must be 0 or more and delay + delay_spread at most {MAX_DELAY} cycles, not "
                f"{self.delay:g} and {self.delay_spread:g}"
            )
        for name in ("anticipation", "lapse", "unready", "slip"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                kind = "share" if name == "anticipation" else "probability"
                raise ValueError(f"{name} is a {kind} from 0 to 1, not {getattr(self, name):g}")
        for name in ("pass_distance", "panic_distance", "open", "wide_open", "misjudgement", "lapse_cycles"):
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
            anticipation=self.anticipation / factor,
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


_B = Teacher(
    delay=2.5, delay_spread=1.0, anticipation=0.6, pass_distance=6.5, panic_distance=1.5, open=72.0, space_weight=3.0,
    far_bonus=46.0, misjudgement=0.03, lapse=0.01, unready=0.01, slip=0.005,
)  # fmt: skip

STYLES: Mapping[str, Teacher] = MappingProxyType(
    {
        "A": Teacher(
            delay=4.0, delay_spread=1.0, anticipation=0.75, pass_distance=4.0, panic_distance=0.8, open=70.0,
            space_weight=3.0, far_bonus=0.0, misjudgement=0.03, lapse=0.01, unready=0.2, lapse_cycles=30.0,
            slip=0.005,
        ),
        "B": _B,
        "C": Teacher(
            delay=3.0, delay_spread=1.0, anticipation=0.8, pass_distance=4.4, panic_distance=0.5, open=66.0,
            space_weight=2.0, far_bonus=-10.0, misjudgement=0.06, lapse=0.02, unready=0.2, lapse_cycles=30.0, slip=0.01,
        ),
        "B-fast": _B.fast(),
        "B-limited": _B.limited(),
    }
)  # fmt: skip
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
