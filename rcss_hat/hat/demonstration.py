"""One demonstrated episode: who decided what, and what would have been right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat._demonstration_file import check_episode
from rcss_hat.keepaway.decision import LEARNER, Decision
from rcss_hat.keepaway.report import Episode


@dataclass(frozen=True, slots=True, eq=False)
class Demonstration:
    """One demonstrated episode.

    Attributes
    ----------
    episode : Episode
        Number, first and last cycle, how it ended.
    teacher : str
    cycles : ndarray of int64, shape (n,)
        Cycle of each decision.
    keepers : ndarray of int64, shape (n,)
        Uniform number of the keeper with the ball.
    states : ndarray of float64, shape (n, n_variables)
        Metres and degrees; order of ``rcss_hat.keepaway.state``.
    actions : ndarray of int64, shape (n,)
        0 = Hold, 1 = PASS1 and so on.
    idle : bool
        A person pressed no key in it.
    by : tuple of str
        Who took each decision, where a person and a learner took turns; empty strings: the teacher.
    right : tuple of int or None
        What would have been right, as somebody said afterwards.

    Notes
    -----
    The arrays are copies that cannot be written to.

    Examples
    --------
    >>> import rcss_hat
    >>> first = rcss_hat.package_demonstrations("A").episodes[0]
    >>> first.teacher, len(first) == len(first.states)
    ('A', True)
    """

    episode: Episode
    teacher: str
    cycles: NDArray[np.int64]
    keepers: NDArray[np.int64]
    states: NDArray[np.float64]
    actions: NDArray[np.int64]
    idle: bool = False
    by: tuple[str, ...] = ()
    right: tuple[int | None, ...] = ()

    def __post_init__(self) -> None:
        for name, kind in (("cycles", np.int64), ("keepers", np.int64), ("states", np.float64), ("actions", np.int64)):
            array = np.array(getattr(self, name), dtype=kind, order="C")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        n = len(self.actions)
        for name, nothing in (("by", ""), ("right", None)):
            object.__setattr__(self, name, tuple(getattr(self, name)) or (nothing,) * n)
        if len(self.by) != n or len(self.right) != n:
            raise ValueError(f"episode {self.episode.number}: every decision has one mark, or none has")
        shapes = [array.shape for array in (self.cycles, self.keepers, self.actions)]
        if self.states.ndim != 2 or len(self.states) != n or any(shape != (n,) for shape in shapes):
            raise ValueError(
                f"episode {self.episode.number}: cycles, keepers, actions and the rows of states must be equally many, "
                f"not {shapes[0]}, {shapes[1]}, {shapes[2]} and {self.states.shape}"
            )
        check_episode(self.episode, self.cycles)

    @classmethod
    def of(
        cls, episode: Episode, teacher: str, decisions: Sequence[Decision], n_variables: int, idle: bool = False
    ) -> Demonstration:
        """Make a demonstration of decisions, given one by one; those of a task have ``n_variables`` state variables."""
        return cls(
            episode,
            teacher,
            np.array([d.cycle for d in decisions], dtype=np.int64),
            np.array([d.keeper for d in decisions], dtype=np.int64),
            np.array([d.state for d in decisions], dtype=np.float64).reshape(-1, n_variables),
            np.array([d.action for d in decisions], dtype=np.int64),
            idle,
            tuple(d.by for d in decisions),
            tuple(d.right for d in decisions),
        )

    def __len__(self) -> int:
        """Number of decisions."""
        return len(self.actions)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Demonstration):
            return NotImplemented
        mine, others = ((d.episode, d.episode.final, d.teacher, d.idle, d.by, d.right) for d in (self, other))
        return mine == others and all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("cycles", "keepers", "states", "actions")
        )

    __hash__ = None  # type: ignore[assignment]

    @property
    def duration(self) -> float:
        """Duration in seconds of simulated time."""
        return self.episode.cycles / 10.0

    @property
    def decisions(self) -> list[Decision]:
        """The decisions one by one."""
        return [
            Decision(int(cycle), int(keeper), tuple(map(float, state)), int(action), by, right)
            for cycle, keeper, state, action, by, right in zip(
                self.cycles, self.keepers, self.states, self.actions, self.by, self.right, strict=True
            )
        ]

    @property
    def lessons(self) -> Demonstration:
        """What of it teaches: the teacher's decisions, and corrected ones with the action that was right."""
        taught = [d for d in self.decisions if d.by != LEARNER or d.right is not None]
        said = [replace(d, action=d.action if d.right is None else d.right, by="", right=None) for d in taught]
        return Demonstration.of(self.episode, self.teacher, said, self.states.shape[1], self.idle)
