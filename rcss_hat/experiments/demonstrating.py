"""Scripted teachers in the arena: demonstrating, and judging what a learner does.

A teacher is shown the picture of every cycle, as a person at the viewer is, and answers for the decisions of the cycle.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.brains import EXTERNAL, fixed_brains
from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.hat.teachers import ScriptedTeacher
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task

ARENA = "arena"


class _Picture:
    """Shows a teacher the true positions of a match, once per cycle."""

    def __init__(self, teacher: ScriptedTeacher) -> None:
        self.teacher = teacher
        self.match: ArenaMatch | None = None
        self.episode = -1

    def key(self) -> int:
        """Show the cycle the match is in, and return the key the teacher presses."""
        match = self.match
        assert match is not None
        episode = int(match.match["episode"][0])
        if episode != self.episode:
            self.teacher.new_episode()
            self.episode = episode
        n, positions = match.task.keepers, match.match["pos"][0][match.seats]
        return self.teacher(match.cycle, match.match["ball_pos"][0], positions[:n], positions[n:])

    def __call__(self, state: NDArray[np.float64], info: dict[str, Any]) -> int:
        """Decide for a keeper, as an external policy of the arena."""
        return self.key()


def demonstrate(task: Task, teacher: str, episodes: int, seed: int) -> DemonstrationSet:
    """Let a scripted teacher play the keepers, and record every decision.

    Parameters
    ----------
    task : Task
    teacher : str
        One of `rcss_hat.hat.teachers.STYLES`.
    episodes : int
    seed : int
        Of the match and the teacher.

    Raises
    ------
    ValueError
        When there is no such teacher.
    """
    picture = _Picture(ScriptedTeacher(teacher, seed))
    brains = fixed_brains(EXTERNAL, task.keepers, seed)
    policy = TeamPolicy(teacher, brains, task.keepers, task.takers)
    match = ArenaMatch(task, seed, policy, external=picture, log_decisions=True)
    picture.match = match
    info = DemonstrationInfo(teacher, ARENA, task, dict(task.server_values()), seed)
    return DemonstrationSet(info, tuple(_episodes(match, picture, episodes, teacher, judged=False)))


def watch(task: Task, policy: TeamPolicy, teacher: str, episodes: int, seed: int) -> DemonstrationSet:
    """Let a policy play, and a scripted teacher say for every decision what he would have done.

    The states are those the policy comes into, the actions are the teacher's (as in DAgger: Ross, Gordon and Bagnell,
    AISTATS 2011).

    Parameters
    ----------
    task : Task
    policy : TeamPolicy
        Should not be learning.
    teacher, episodes, seed
        See `demonstrate`.
    """
    picture = _Picture(ScriptedTeacher(teacher, seed))
    match = ArenaMatch(task, seed, policy, log_decisions=True)
    picture.match = match
    info = DemonstrationInfo(teacher, ARENA, task, dict(task.server_values()), seed, notes="watching a learner")
    return DemonstrationSet(info, tuple(_episodes(match, picture, episodes, teacher, judged=True)))


def _episodes(match: ArenaMatch, picture: _Picture, wanted: int, teacher: str, judged: bool) -> Iterator[Demonstration]:
    rows: list[np.void] = []
    keys: list[int] = []
    found = 0
    while found < wanted:
        ended: list[Episode] = [e for part in match.advance(cycles=match.cycle + 1) for e in part]
        # The end of an episode comes first in its cycle: decisions of this cycle belong to the next one.
        for episode in ended:
            yield _demonstration(episode, teacher, rows, keys, len(match.state))
            rows, keys = [], []
            found += 1
        key = picture.key()
        for row in match.take_decisions():
            rows.append(row)
            keys.append(key if judged else int(row["action"]))


def _demonstration(
    episode: Episode, teacher: str, rows: list[np.void], keys: list[int], n_variables: int
) -> Demonstration:
    return Demonstration(
        episode,
        teacher,
        np.array([row["cycle"] for row in rows], dtype=np.int64),
        np.array([row["keeper"] for row in rows], dtype=np.int64),
        np.array([row["state"] for row in rows], dtype=np.float64).reshape(-1, n_variables),
        np.array(keys, dtype=np.int64),
    )
