"""A study: the conditions of an experiment, as `rcss_hat.experiments.study_file` reads them from a TOML file."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from msgspec.structs import replace as replaced

from rcss_hat.experiments.run_folder import RunConfig
from rcss_hat.experiments.study_parts import (
    MAX_CONDITIONS,
    MAX_HOURS,
    MAX_TRIALS,
    Claim,
    Figure,
    Published,
    Round,
    Sampling,
    SetSpec,
    StageComparison,
    Table,
)
from rcss_hat.hat.transfer import TransferMethod
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.config import LearnerConfig, load_config
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.schema import did_you_mean
from rcss_hat.stage.place import ARENA


class StudyError(ValueError):
    """A study that is not valid; the message names the place and what would be right."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """One condition: what is learned, how, and how often.

    Attributes
    ----------
    name, label : str
        For files, and for people.
    task : Task
    learner : LearnerConfig
    method : TransferMethod
    demonstrations : str or None
        Set that is summarised to D, or replayed.
    rounds : tuple of Round
    hours : float
    trials : int
    evaluation_episodes : int
        Episodes without learning, before and after.
    published : Published
    stage : str
        Where it is played: ``arena``, ``fake``, ``real`` or ``HOST:PORT``.
    baseline : str or None
        Condition that it is compared with, instead of the study's.
    sampled : bool
        Whether it was drawn by ``[sampling]``: one trial, whatever is asked for.
    """

    name: str
    label: str
    task: Task
    learner: LearnerConfig
    method: TransferMethod
    demonstrations: str | None
    rounds: tuple[Round, ...]
    hours: float
    trials: int
    evaluation_episodes: int
    published: Published
    stage: str = ARENA
    baseline: str | None = None
    sampled: bool = False

    def __post_init__(self) -> None:
        """Check what other numbers of hours than the file's can do."""
        if not 0 <= self.hours <= MAX_HOURS:
            raise StudyError(f"condition {self.name!r}: hours must be 0 to {MAX_HOURS:,}, not {self.hours:g}")

    def run_config(self, seed: int) -> RunConfig:
        """Return the settings of one trial's training run."""
        return RunConfig(
            task=self.task,
            learner=self.learner,
            method=self.method,
            seed=seed,
            hours=self.hours,
            stage=self.stage,
            source=self.demonstrations or "",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A whole experiment.

    Attributes
    ----------
    title, description : str
    seed : int
    baseline : str or None
    conditions : dict of str to Condition
    sets : dict of str to SetSpec
    tables, figures, claims, comparisons : tuple
    missed_at_most : float
        Share of missed cycles beyond which a trial is not pooled with others.
    sampling : Sampling or None
    task : Task
        Of teachers that are not told another.
    folder : Path
        What file names in the study are relative to.
    """

    title: str
    description: str
    seed: int
    baseline: str | None
    conditions: dict[str, Condition]
    sets: dict[str, SetSpec]
    tables: tuple[Table, ...]
    figures: tuple[Figure, ...]
    claims: tuple[Claim, ...]
    comparisons: tuple[StageComparison, ...]
    missed_at_most: float
    sampling: Sampling | None
    task: Task
    folder: Path

    def __post_init__(self) -> None:
        """Check that it is not more than a study can be."""
        if len(self.conditions) > MAX_CONDITIONS:
            raise StudyError(f"{len(self.conditions):,} conditions are more than a study can have: {MAX_CONDITIONS:,}")
        trials = sum(condition.trials for condition in self.conditions.values())
        if trials > MAX_TRIALS:
            raise StudyError(f"{trials:,} trials are more than a study can have: {MAX_TRIALS:,} in all conditions")

    def trial_seed(self, condition: str, trial: int) -> int:
        """Return the seed of a trial: drawn from the study's seed, the condition's name and the trial's number."""
        key = (zlib.crc32(condition.encode()), trial)
        return derived_seed(self.seed, *key)

    def scaled(self, trials: int | None = None, hours: float | None = None) -> Study:
        """Return the study with other numbers of trials and hours in all conditions.

        Later rounds keep their share of the time. Conditions that only evaluate (0 hours) stay so.

        Raises
        ------
        StudyError
            When trials or hours are more than a study can have.
        """
        changed = {}
        for name, condition in self.conditions.items():
            factor = 1.0 if hours is None or condition.hours == 0.0 else hours / condition.hours
            changed[name] = replace(
                condition,
                trials=condition.trials if trials is None or condition.sampled else trials,
                hours=condition.hours * factor,
                rounds=tuple(replaced(r, hour=r.hour * factor) for r in condition.rounds),
            )
        return replace(self, conditions=changed)

    def learned_by(self, learner: str) -> Study:
        """Return the study with another learner in all conditions.

        Parameters
        ----------
        learner : str
            A preset, or a ``.toml`` file. Settings that conditions change are changed in it no more.

        Raises
        ------
        StudyError
            When there is no such learner.
        """
        try:
            config = load_config(learner)
        except (ValueError, FileNotFoundError) as problem:
            raise StudyError(f"learner: {problem}") from problem
        conditions = {name: replace(condition, learner=config) for name, condition in self.conditions.items()}
        return replace(self, conditions=conditions)

    def played_on(self, stage: str) -> Study:
        """Return the study with another stage in all conditions.

        Parameters
        ----------
        stage : str
            ``arena``, ``fake`` or ``real``.

        Raises
        ------
        StudyError
            When the study compares stages, or needs what they lack.
        """
        own = {condition.stage for condition in self.conditions.values()}
        if len(own) > 1:
            raise StudyError(f"the study says itself what is played where ({', '.join(sorted(own))}); leave out --on")
        if stage != ARENA and any(r.watch is not None for c in self.conditions.values() for r in c.rounds):
            raise StudyError("rounds with watch need what only the arena shows; choose other conditions (--only)")
        return replace(self, conditions={n: replace(c, stage=stage) for n, c in self.conditions.items()})

    def baseline_of(self, condition: str) -> str | None:
        """Return the condition that another one is compared with."""
        return self.conditions[condition].baseline or self.baseline

    def chosen(self, names: tuple[str, ...]) -> Study:
        """Return the study with some of its conditions only.

        Raises
        ------
        StudyError
            When there is no such condition.
        """
        for name in names:
            check_known(name, self.conditions, "condition", "--only")
        kept = {name: c for name, c in self.conditions.items() if name in names}
        kept = {n: replace(c, baseline=c.baseline if c.baseline in kept else None) for n, c in kept.items()}
        return replace(
            self,
            baseline=self.baseline if self.baseline in kept else None,
            conditions=kept,
            tables=tuple(replaced(t, conditions=_those(t.conditions, kept)) for t in self.tables),
            figures=tuple(replaced(f, conditions=_those(f.conditions, kept)) for f in self.figures),
            claims=tuple(c for c in self.claims if all({*t.conditions, *t.than} <= kept.keys() for t in c.tests)),
            comparisons=tuple(
                replaced(c, pairs=tuple(pair for pair in c.pairs if kept.keys() >= set(pair))) for c in self.comparisons
            ),
        )


def check_known(name: str, known: Mapping[str, Any], what: str, where: str) -> None:
    """Raise StudyError when ``known`` has no ``name``."""
    if name not in known:
        there = ", ".join(known) or "none"
        raise StudyError(f"{where}: there is no {what} {name!r}; there are {there}{did_you_mean(name, known)}")


def _those(names: tuple[str, ...], kept: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(name for name in names if name in kept)
