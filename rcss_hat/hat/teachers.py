"""Scripted teachers: stand-ins for people where none are present.

A scripted teacher sees what a person sees in the viewer, the true positions of ball and players, not the 13 state
variables. It acts on a picture some cycles old (reaction time), moved on in its mind as far as it anticipates;
it knows who will get the ball, because a pass can be seen coming. It misjudges distances and angles, now and then does
not attend or presses the wrong key, and otherwise follows a simple strategy: hold until a taker is near or a team mate
is wide open, then pass to the one most open. When no key is pressed the keeper with the ball holds.

One teacher plays whichever keeper has the ball: every keeper that takes a decision in a cycle acts by the key that the
teacher presses in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.hat.policy import TeamPolicy, python_policy
from rcss_hat.hat.teaching import HOLD, MAX_DELAY, MEMORY, TEACHER, forget, teach
from rcss_hat.numeric import rng as random_streams
from rcss_hat.protocol.records import MAX_PLAYERS


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


class Onlooker:
    """A scripted teacher who watches a match.

    Parameters
    ----------
    teacher : ScriptedTeacher
    keepers, takers : int

    Attributes
    ----------
    key : int
        What the teacher presses in the newest cycle.
    """

    def __init__(self, teacher: ScriptedTeacher, keepers: int, takers: int) -> None:
        self.teacher, self.key = teacher, HOLD
        self._keepers, self._takers = slice(0, keepers), slice(MAX_PLAYERS, MAX_PLAYERS + takers)
        self._episode = -1

    def look(self, frame: np.void) -> None:
        """Take what there is to see in a cycle, see `rcss_hat.keepaway.decision.OnFrame`."""
        if frame["episode"] != self._episode:
            self.teacher.new_episode()
            self._episode = int(frame["episode"])
        positions = frame["pos"]
        self.key = self.teacher(
            int(frame["time"]), frame["ball"][:2], positions[self._keepers], positions[self._takers]
        )


def teacher_policy(name: str, keepers: int, takers: int, seed: int) -> TeamPolicy:
    """Let a teacher of `STYLES` play the keepers; it must be shown the whole field."""
    onlooker = Onlooker(ScriptedTeacher(name, seed), keepers, takers)
    return python_policy(lambda state, info: onlooker.key, keepers, takers, name, onlooker.look)


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
