"""From a study's folder to an experiment: a condition per participant, per group, of the best, and of all together."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.folder import EXPERIMENT, StudyFolder
from rcss_hat.studies.parts import said
from rcss_hat.studies.shown import Shown, shown_by
from rcss_hat.system.files import write_text

BASELINE = "no-prior"
BEST = 10
"""Games that everybody contributes to the set of the best, where he has so many."""


@dataclass(frozen=True, slots=True)
class Training:
    """How learners are trained.

    Attributes
    ----------
    method : str
    hours : float
        Simulated.
    trials : int
        Per participant, group and set.
    baseline_trials : int
        Without a teacher.
    learner : str
    evaluation_episodes : int
    """

    method: str = "ppr"
    hours: float = 30.0
    trials: int = 2
    baseline_trials: int = 10
    learner: str = "paper"
    evaluation_episodes: int = 1000


@dataclass(frozen=True, slots=True)
class Names:
    """Conditions of the experiment, by what they are.

    Attributes
    ----------
    participants : dict of (str, str) to str
        By participant and step.
    groups : dict of str to str
        By the study's condition.
    together : dict of str to str
        ``best`` and ``all``.
    """

    participants: dict[tuple[str, str], str]
    groups: dict[str, str]
    together: dict[str, str]


def names_of(shown: Sequence[Shown]) -> Names:
    """Name the conditions of an experiment."""
    mine = {(s.participant, s.step): f"{s.participant}-{s.step}" for s in shown}
    conditions = list(dict.fromkeys(s.condition for s in shown if s.condition))
    groups = {c: f"group-{c}" for c in conditions} if len(conditions) > 1 else {}
    return Names(mine, groups, {"best": "best-of-all", "all": "all-together"})


def experiment_text(folder: StudyFolder, shown: Sequence[Shown], training: Training) -> str:
    """Write an experiment's file: TOML, with file names relative to the study's folder.

    Raises
    ------
    FileFormatError
        When there is nothing to learn from, or demonstrations are of several tasks.
    """
    if not shown:
        raise FileFormatError(f"{folder.path} has no demonstration yet: nobody has finished a game")
    task = shown[0].demonstration.info.task
    for s in shown:
        if s.demonstration.info.task != task:
            raise FileFormatError(
                f"{s.participant} demonstrated {s.demonstration.info.task.size}, {shown[0].participant} {task.size}: "
                "one experiment needs one task"
            )
    names = names_of(shown)
    title = said(folder.study.title, folder.study.language, folder.study.language)
    who = "scripted participants of a rehearsal" if folder.rehearsal else "people"
    lines = [
        f"title = {_quoted(f'{title}: what learners gain')}",
        f"description = {_quoted(f'{training.method} after demonstrations by {who}.')}",
        f"seed = {folder.study.seed}",
        f"baseline = {_quoted(BASELINE)}",
        "[defaults]",
        f"size = {_quoted(task.size)}",
        f"field = {_quoted(task.field)}",
        f"vision = {task.vision}",
        f"profile = {_quoted(task.profile)}",
        f"learner = {_quoted(training.learner)}",
        f"hours = {training.hours!r}",
        f"trials = {training.trials}",
        f"evaluation_episodes = {training.evaluation_episodes}",
        *_sets(folder, shown, names),
        *_condition(BASELINE, "No Prior", [f"trials = {max(training.baseline_trials, 2)}"]),
    ]
    for s in shown:
        lines += _taught(names.participants[s.participant, s.step], f"{s.participant} {s.condition}".strip(), training)
    for condition, name in names.groups.items():
        lines += _taught(name, f"all of {condition}", training)
    lines += _taught(names.together["best"], "the best games of everybody", training)
    lines += _taught(names.together["all"], "all games of everybody", training)
    lines += _shows(names)
    return "\n".join(lines) + "\n"


def _sets(folder: StudyFolder, shown: Sequence[Shown], names: Names) -> list[str]:
    lines = []
    for s in shown:
        file = f"participants/{s.participant}/{s.step}.csv"
        label = f"{s.participant} {s.condition}, {len(s.demonstration)} games"
        lines += _set(names.participants[s.participant, s.step], label, [f"file = {_quoted(file)}"])
    everybody = list(names.participants.values())
    for condition, name in names.groups.items():
        mine = [names.participants[s.participant, s.step] for s in shown if s.condition == condition]
        lines += _set(name, f"all of {condition}", [f"of = {json.dumps(mine)}"])
    each = min(BEST, *(max(len(s.demonstration) // 2, 1) for s in shown), BEST)
    best = [f"of = {json.dumps(everybody)}", 'pick = "best"', f"episodes = {each}"]
    lines += _set(names.together["best"], f"the best {each} of everybody", best)
    return lines + _set(names.together["all"], "everybody", [f"of = {json.dumps(everybody)}"])


def _set(name: str, label: str, rest: list[str]) -> list[str]:
    return [f"[demonstrations.{_quoted(name)}]", f"label = {_quoted(label)}", *rest]


def _taught(name: str, label: str, training: Training) -> list[str]:
    return _condition(name, label, [f"method = {_quoted(training.method)}", f"demonstrations = {_quoted(name)}"])


def _condition(name: str, label: str, rest: list[str]) -> list[str]:
    return ["[[condition]]", f"name = {_quoted(name)}", f"label = {_quoted(label)}", *rest]


def _shows(names: Names) -> list[str]:
    whole = [BASELINE, *names.groups.values(), *names.together.values()]
    mine = [BASELINE, *names.participants.values()]
    lines = []
    for kind in ("table", "figure"):
        lines += [f"[[{kind}]]", 'name = "groups"', 'title = "Groups, and everybody together"']
        lines += [f"conditions = {json.dumps(whole)}"]
    return [
        *lines,
        "[[table]]",
        'name = "participants"',
        'title = "Every participant"',
        f"conditions = {json.dumps(mine)}",
    ]


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def write_experiment(folder: StudyFolder, training: Training, shown: Sequence[Shown] | None = None) -> Path:
    """Write the file of a study's experiment beside its data, so that ``rcss-hat experiment`` can run it.

    Raises
    ------
    FileFormatError, NotWritten
    """
    known = [s for kept in folder.participants() for s in shown_by(kept)] if shown is None else shown
    path = folder.path / f"{EXPERIMENT}.toml"
    write_text(path, experiment_text(folder, known, training))
    return path
