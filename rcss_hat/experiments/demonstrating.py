"""Scripted teachers in the arena: demonstrating, and judging what a learner does.

A teacher is shown the picture of every cycle, as a person at the viewer is, and answers for the decisions of the cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.hat.recorder import Recorder
from rcss_hat.hat.teachers import Onlooker, ScriptedTeacher, teacher_policy
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Part, open_stage


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
    policy = teacher_policy(teacher, task.keepers, task.takers, seed)
    return _recorded(DemonstrationInfo(teacher, ARENA, task, dict(task.server_values()), seed), policy, episodes)


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
    judge = Onlooker(ScriptedTeacher(teacher, seed), task.keepers, task.takers)
    info = DemonstrationInfo(teacher, ARENA, task, dict(task.server_values()), seed, notes="watching a learner")
    return _recorded(info, policy, episodes, judge)


def _recorded(
    info: DemonstrationInfo, policy: TeamPolicy, episodes: int, judge: Onlooker | None = None
) -> DemonstrationSet:
    recorder, found = Recorder(), list[Demonstration]()

    def decided(decision: Decision) -> None:
        recorder.decided(decision if judge is None else replace(decision, action=judge.key))

    def ended(episodes: Sequence[Episode], cycle: int) -> None:
        for e in episodes:
            found.append(Demonstration.of(e, info.teacher, recorder.take(e), info.n_variables))

    with open_stage(Place(ARENA), info.task, info.seed or 0, policy) as stage:
        report = stage.play(Part(episodes, None, ended, decided, None if judge is None else judge.look))
    if report.failure is not None:  # Ctrl-C: fewer episodes are no demonstration
        raise KeyboardInterrupt
    return DemonstrationSet(info, tuple(found))
