"""What most programs want of this package, one call each: let somebody play, let somebody teach, let keepers learn.

What these do not offer is in what they return, or in `rcss_hat.open_stage` and `rcss_hat.TrainingRun`, which they call.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Any

from rcss_hat.experiments.run_folder import RunConfig
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.foreign import Policy
from rcss_hat.hat.policy import TeamPolicy, load_policy, python_policy, rules_policy
from rcss_hat.hat.recorder import Recorder
from rcss_hat.hat.taker_policy import TakerPolicy, load_taker_policy
from rcss_hat.hat.teachers import STYLES, teacher_policy
from rcss_hat.hat.transfer import Decisions, TransferMethod, make_method
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import LearnerConfig, load_config
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Part, open_stage
from rcss_hat.stage.terms import Terms

Keepers = str | Policy | DecisionList | TeamPolicy
"""Whoever can play the keepers: a name or file (see `rcss_hat.load_policy`), a function of (state, info), a list."""
Takers = str | Policy


class EndedEarly(RuntimeError):
    """A match that ended before its end.

    Attributes
    ----------
    report : RunReport
        What was played; its ``failure`` is what the exception says.

    Examples
    --------
    >>> import rcss_hat
    >>> try:
    ...     rcss_hat.play(lambda state, info: 0.5, episodes=10)
    ... except rcss_hat.EndedEarly as early:
    ...     print(early.report.failure)
    the policy returned 0.5; legal are 0 (Hold) to 2 (pass to the farthest team mate)
    """

    def __init__(self, report: RunReport) -> None:
        super().__init__(str(report.failure))
        self.report = report


def play(
    keepers: Keepers = "hand",
    *,
    on: str = ARENA,
    task: Task | None = None,
    episodes: int = 100,
    seed: int = 1,
    takers: Takers = "hand",
) -> RunReport:
    """Play a match of Keepaway and report its episodes.

    Parameters
    ----------
    keepers : str, callable, DecisionList or TeamPolicy
        ``"hold"``, ``"random"``, ``"hand"``, the file of a decision list, the folder of a training run, a model (see
        `load_policy`); or a function of (state, info) that returns an action: 0 holds the ball, 1 passes to the
        nearest team mate, and so on.
    on : str
        ``"arena"``, ``"fake"`` (a stand-in server is started), ``"real"`` (an rcssserver is) or ``"HOST:PORT"``.
    task : Task, optional
        By default 3v2 on 20 m x 20 m.
    episodes, seed : int
        In the arena and on the fake server the same seed is the same match.
    takers : str or callable
        ``"hand"``, or a function of (state, info) that returns a macro-action.

    Returns
    -------
    RunReport
        With ``episodes``, ``durations_s``, ``mean_s`` and ``to_text()``.

    Raises
    ------
    EndedEarly
        When the match did not come to its end; its ``report`` holds the episodes that did.
    ValueError
        When there is no such policy or place.

    Examples
    --------
    >>> import rcss_hat
    >>> def policy(state, info):
    ...     return 1 if state[3] < 4.0 else 0  # pass to the nearer team mate when a taker comes close
    >>> report = rcss_hat.play(policy, episodes=50, seed=1)
    >>> len(report.episodes)
    50
    >>> report.mean_s > rcss_hat.play("hold", episodes=50, seed=1).mean_s
    True
    """
    task = task or Task()
    orders = _orders(takers, task, seed)
    return _played(_team(keepers, task, seed), Place.parse(on), task, seed, Part(episodes), orders)


def demonstrate(
    teacher: Keepers = "A", *, on: str = ARENA, task: Task | None = None, episodes: int = 20, seed: int = 1
) -> DemonstrationSet:
    """Let somebody play the keepers, and record every decision.

    People demonstrate with ``rcss-hat demonstrate --browser``; `DemonstrationSet.load` reads what they did.

    Parameters
    ----------
    teacher : str, callable, DecisionList or TeamPolicy
        A scripted person, ``"A"``, ``"B"``, ``"C"``, ``"B-fast"`` or ``"B-limited"``, in the arena; or whoever can
        play (see `play`).
    on, task, episodes, seed
        See `play`.

    Raises
    ------
    EndedEarly
        When the match did not come to its end.
    ValueError
        When there is no such teacher or place.

    Examples
    --------
    >>> import rcss_hat
    >>> demonstrations = rcss_hat.demonstrate("A", episodes=3, seed=1)
    >>> len(demonstrations), demonstrations.X.shape[1]
    (3, 13)
    """
    task, place = task or Task(), Place.parse(on)
    scripted = isinstance(teacher, str) and any(teacher.lower() == name.lower() for name in STYLES)
    if scripted:
        policy = teacher_policy(str(teacher), task.keepers, task.takers, seed)
    else:
        policy = _team(teacher, task, seed)
    in_force = {} if place.address else dict(task.server_values())
    info = DemonstrationInfo(policy.spec, str(place), task, in_force, seed, date.today().isoformat())
    recorder, found = Recorder(), list[Demonstration]()

    def ended(episodes: Sequence[Episode], cycle: int) -> None:
        for e in episodes:
            found.append(Demonstration.of(e, info.teacher, recorder.take(e), info.n_variables))

    _played(policy, place, task, seed, Part(episodes, None, ended, recorder.decided))
    return DemonstrationSet(info, tuple(found))


def learn(
    folder: str | Path,
    method: str | TransferMethod = "no-prior",
    *,
    rules: DecisionList | str | Path | None = None,
    demonstrations: DemonstrationSet | str | Path | None = None,
    task: Task | None = None,
    learner: str | LearnerConfig = "paper",
    hours: float = 30.0,
    seed: int = 1,
) -> TrainingRun:
    """Let keepers learn in the arena by Sarsa, alone or with a transfer method, in a new folder.

    Parameters
    ----------
    folder : str or Path
        Will hold settings, weights and the log of all episodes; ``play(folder)`` plays what was learned.
    method : str or TransferMethod
        A name of `METHODS`, or a method with settings of your own.
    rules : DecisionList, str or Path, optional
        The advice, or its file; needed by the methods that follow advice.
    demonstrations : DemonstrationSet, str or Path, optional
        Needed by the methods that replay them.
    task, seed
        See `play`.
    learner : str or LearnerConfig
        A preset, a TOML file, or settings.
    hours : float
        Simulated hours.

    Returns
    -------
    TrainingRun
        Finished, its folder free for others.

    Raises
    ------
    KeyboardInterrupt
        When it was stopped; ``TrainingRun.open(folder).train()`` goes on.
    ValueError
        When the folder holds a run already, or something does not fit.

    Examples
    --------
    >>> import tempfile
    >>> import rcss_hat
    >>> rules = rcss_hat.summarize(rcss_hat.package_demonstrations("A"), seed=1).decision_list
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = rcss_hat.learn(folder, "ppr", rules=rules, hours=0.2, seed=1)
    ...     episodes = rcss_hat.read_episode_log(run.folder / "episodes.csv")
    >>> run.done, len(episodes) == run.episodes
    (True, True)
    """
    config = RunConfig(
        task=task or Task(),
        learner=load_config(learner) if isinstance(learner, str) else learner,
        method=make_method(method) if isinstance(method, str) else method,
        seed=seed,
        hours=hours,
        source=next((str(s) for s in (rules, demonstrations) if isinstance(s, str | Path)), ""),
    )
    if isinstance(rules, str | Path):
        rules = DecisionList.load(rules, config.task.keepers, config.task.takers)
    if isinstance(demonstrations, str | Path):
        demonstrations = DemonstrationSet.load(demonstrations)
    decisions = None if demonstrations is None else Decisions.of(*demonstrations.sequences())
    with TrainingRun.create(Path(folder), config, rules, decisions) as run:
        if not run.train():
            raise KeyboardInterrupt  # nothing else ends it in the arena
    return run


def _played(
    policy: TeamPolicy, place: Place, task: Task, seed: int, part: Part, orders: TakerPolicy | None = None
) -> RunReport:
    """Play a match to its end."""
    with open_stage(place, task, seed, policy, Terms(say=_say, orders=orders)) as stage:
        report = stage.play(part)
    if report.failure == INTERRUPTED:
        raise KeyboardInterrupt
    if report.failure is not None:
        raise EndedEarly(report)
    return report


def _team(keepers: Keepers, task: Task, seed: int) -> TeamPolicy:
    if isinstance(keepers, TeamPolicy):
        return keepers
    if isinstance(keepers, str):
        return load_policy(keepers, task.keepers, task.takers, seed, task)
    if isinstance(keepers, DecisionList):
        if (keepers.keepers, keepers.takers) != (task.keepers, task.takers):
            raise ValueError(f"the decision list is for {keepers.keepers}v{keepers.takers}; the task is {task.size}")
        return rules_policy(keepers, seed)
    return python_policy(keepers, task.keepers, task.takers, _name(keepers))


def _orders(takers: Takers, task: Task, seed: int) -> TakerPolicy | None:
    if isinstance(takers, str):
        return load_taker_policy(takers, task, seed)
    return TakerPolicy(_name(takers), takers, task.keepers)


def _say(message: str) -> None:
    """Tell whoever waits for a server, or for kernels to be compiled, what for."""
    print(message, file=sys.stderr, flush=True)


def _name(function: Any) -> str:
    return str(getattr(function, "__name__", type(function).__name__))
