"""``rcss-hat train`` and ``rcss-hat evaluate``: learning runs, and playing what they learned."""

from __future__ import annotations

import asyncio
import json
import math
import secrets
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rcss_hat.cli.common import (
    ARENA,
    FAKE,
    INTERRUPTED,
    REAL,
    Stage,
    fail,
    plain_errors,
    progress_bar,
    stage_text,
    task_options,
)
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task

if TYPE_CHECKING:
    from rcss_hat.experiments.training import RunConfig, TrainingRun
    from rcss_hat.hat.decision_list import DecisionList
    from rcss_hat.hat.transfer import Decisions

METHODS = ("none", "no-prior", "value-bonus", "extra-action", "ppr", "chat", "replay")
"""``none`` is another word for ``no-prior``."""
RESTART_S = 60.0
"""How long a server that went away may take to come back."""
WHEN_RESUMING = {"out", "resume", "hours", "executable", "as_json", "quiet"}
"""Options that make sense with ``--resume``; the others come from the folder."""


@dataclass
class Settings:
    """What ``--set`` changes, by what it belongs to."""

    learner: dict[str, Any]
    method: dict[str, Any]

    @classmethod
    def parse(cls, items: tuple[str, ...]) -> Settings:
        """Read ``learner.epsilon=0.05`` and ``method.decay=0.99``; values are written as in TOML."""
        import tomllib

        settings = cls({}, {})
        for item in items:
            name, equals, value = item.partition("=")
            group, dot, key = name.strip().partition(".")
            if not (equals and dot and key) or group not in ("learner", "method"):
                raise click.BadParameter(
                    f"{item!r} is not of the form learner.NAME=VALUE or method.NAME=VALUE", param_hint="--set"
                )
            try:
                number = tomllib.loads(f"value = {value.strip()}")["value"]
            except tomllib.TOMLDecodeError:
                number = value.strip()
            (settings.learner if group == "learner" else settings.method)[key] = number
        return settings


@click.command()
@click.option("--method", type=click.Choice(METHODS), default="none", show_default=True, help="Transfer method.")
@click.option("--rules", type=click.Path(dir_okay=False, path_type=Path), help="Decision list: the advice.")
@click.option("--demonstrations", type=click.Path(dir_okay=False, path_type=Path), help="Demonstrations to replay.")
@click.option("--hours", type=click.FloatRange(0, min_open=True), default=30.0, show_default=True, help="Simulated.")
@click.option("--on", "stage", type=Stage(ARENA, FAKE, REAL), default=ARENA, show_default=True, help="Where to play.")
@click.option(
    "--learner", default="paper", show_default=True, help="Preset (paper, printed, cmac, best) or a .toml file."
)
@click.option("--set", "changes", multiple=True, metavar="GROUP.NAME=VALUE", help="E.g. learner.epsilon=0.05.")
@click.option("--seed", type=click.IntRange(0), default=None, help="Same seed, same run (arena).")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder of the run.")
@click.option("--resume", is_flag=True, help="Go on with the run in --out.")
@click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
@task_options
@click.pass_context
def train(
    context: click.Context,
    task: Task,
    method: str,
    rules: Path | None,
    demonstrations: Path | None,
    hours: float,
    stage: str | tuple[str, int],
    learner: str,
    changes: tuple[str, ...],
    seed: int | None,
    out: Path,
    resume: bool,
    executable: str | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Learn by Sarsa, alone or with a transfer method.

    The folder holds the weights, the settings and a log of all episodes (episodes.csv). A run that was stopped, by
    Ctrl-C or otherwise, goes on with --resume; in the arena it ends exactly as if it had not been stopped.

    \b
    Example:
      rcss-hat train --hours 30 --seed 1 --out runs/no-prior
      rcss-hat train --method ppr --rules rules.json --hours 30 --seed 1 --out runs/ppr
      rcss-hat train --resume --out runs/ppr
      rcss-hat evaluate runs/ppr --episodes 1000
    """
    from rcss_hat.experiments.training import TrainingError, TrainingRun

    with plain_errors(TrainingError):
        if resume:
            _refuse_settings(context)
            run = TrainingRun.open(out)
            if context.get_parameter_source("hours") is ParameterSource.COMMANDLINE:
                run.extend(hours)
        else:
            if seed is None:
                seed = secrets.randbelow(2**31)
            config = _configuration(task, method, rules, demonstrations, hours, stage, learner, changes, seed)
            run = TrainingRun.create(out, config, _rules(rules, task), _decisions(demonstrations))
        started, before = time.monotonic(), run.cycles
        label = f"{run.config.method.name} on {run.config.stage}"
        with progress_bar(label, run.config.hours, "h", quiet or as_json) as bar:
            failure = _train_on_stage(run, _show(bar), executable)
        wall = time.monotonic() - started
    summary = _summary(run, run.cycles - before, wall, failure)
    click.echo(json.dumps(summary) if as_json else _summary_text(run, summary))
    if not run.done:
        again = f"go on with: rcss-hat train --resume --out {out}"
        fail(f"ended at {run.hours:.2f} of {run.config.hours:g} h: {failure or 'interrupted'}; {again}")


def _refuse_settings(context: click.Context) -> None:
    for name in context.params:
        given = context.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if given and name not in WHEN_RESUMING:
            option = {"stage": "on", "changes": "set", "region": "field"}.get(name, name)
            raise click.UsageError(f"--{option} cannot be given with --resume: it comes from the folder of the run")


def _configuration(
    task: Task,
    method: str,
    rules: Path | None,
    demonstrations: Path | None,
    hours: float,
    stage: str | tuple[str, int],
    learner: str,
    changes: tuple[str, ...],
    seed: int,
) -> RunConfig:
    from rcss_hat.experiments.training import RunConfig
    from rcss_hat.hat.transfer import make_method
    from rcss_hat.learning.config import LearnerConfig, load_config

    settings = Settings.parse(changes)
    try:
        base = load_config(learner)
        config = RunConfig(
            task=task,
            learner=LearnerConfig.from_dict({**base.to_dict(), **settings.learner}),
            method=make_method("no-prior" if method == "none" else method, settings.method),
            seed=seed,
            hours=hours,
            stage=stage_text(stage),
            source=str(rules or demonstrations or ""),
        )
        config.learner.build(task.keepers, task.takers)
    except (ValueError, FileNotFoundError) as error:
        raise click.UsageError(str(error)) from error
    if config.method.needs_advice and rules is None:
        raise click.UsageError(f"--method {method} needs --rules")
    if not config.method.needs_advice and rules is not None:
        raise click.UsageError(f"--method {method} uses no --rules")
    if bool(config.method.replay_passes) != (demonstrations is not None):
        needs = "needs" if config.method.replay_passes else "uses no"
        raise click.UsageError(f"--method {method} {needs} --demonstrations")
    return config


def _rules(path: Path | None, task: Task) -> DecisionList | None:
    from rcss_hat.hat.decision_list import DecisionList
    from rcss_hat.hat.files import FileFormatError

    if path is None:
        return None
    try:
        return DecisionList.load(path, task.keepers, task.takers)
    except FileFormatError as error:
        raise click.BadParameter(str(error), param_hint="--rules") from error


def _decisions(path: Path | None) -> Decisions | None:
    from rcss_hat.hat.demonstrations import DemonstrationSet
    from rcss_hat.hat.files import FileFormatError
    from rcss_hat.hat.transfer import Decisions

    if path is None:
        return None
    try:
        return Decisions.of(*DemonstrationSet.load(path).sequences())
    except FileFormatError as error:
        raise click.BadParameter(str(error), param_hint="--demonstrations") from error


def _show(bar: Callable[..., None]) -> Callable[[TrainingRun], None]:
    """Make a function that shows where a run is: simulated hours, windowed mean, cycles per second."""
    started, first = time.monotonic(), -1

    def show(run: TrainingRun) -> None:
        nonlocal first
        if first < 0:
            first = run.cycles
        wall = time.monotonic() - started
        speed = f", {(run.cycles - first) / wall:,.0f} cycles/s" if wall > 0 and run.cycles > first else ""
        bar(run.hours, f"{run.episodes} episodes, last {len(run.recent)}: {run.windowed_mean:.2f} s{speed}")

    return show


def _train_on_stage(run: TrainingRun, show: Callable[[TrainingRun], None], executable: str | None) -> str | None:
    """Train until done, Ctrl-C or failure; return what ended it early."""
    from rcss_hat.experiments.training import interrupt_flag

    show(run)
    if run.config.stage == ARENA:
        with interrupt_flag() as interrupted:
            return None if run.train(show, interrupted) else INTERRUPTED
    while not run.done:
        before = run.cycles
        failure = _train_over_udp(run, show, executable)
        if failure is None or failure == INTERRUPTED or run.cycles == before or not _is_back(run, failure):
            return failure
    return None


def _is_back(run: TrainingRun, failure: str) -> bool:
    """Wait for a server that somebody else runs and perhaps restarts; false when it stays away."""
    from rcss_hat.team.servers import answers

    address = Stage(FAKE, REAL).convert(run.config.stage, None, None)
    if not isinstance(address, tuple):
        return False
    click.echo(f"{failure}; waiting up to {RESTART_S:.0f} s for a server at {run.config.stage} ...", err=True)
    try:
        return asyncio.run(answers(*address, RESTART_S))
    except KeyboardInterrupt:
        return False


def _train_over_udp(run: TrainingRun, show: Callable[[TrainingRun], None], executable: str | None) -> str | None:
    from rcss_hat.cli.stages import play_over_udp
    from rcss_hat.experiments.training import CHECKPOINT_S
    from rcss_hat.keepaway.report import UNKNOWN, Episode

    task, config = run.config.task, run.config
    stage = Stage(FAKE, REAL).convert(config.stage, None, None)
    seed = run.begin_session()
    begun, last_end, saved = run.cycles, 0, time.monotonic()

    def ended(number: int, cycle: int) -> bool:
        nonlocal last_end, saved
        run.record([Episode(number, last_end, cycle, UNKNOWN)])
        last_end = cycle
        show(run)
        if time.monotonic() - saved >= CHECKPOINT_S:
            run.checkpoint()
            saved = time.monotonic()
        return run.done

    report = RunReport(config.stage, config.method.name, "hand", task.size, task.field, task.vision, seed)
    try:
        play_over_udp(report, task, seed, run.policy, stage, ended, executable=executable)
    finally:
        run.settle(report.episodes)
        run.cycles = max(run.cycles, begun + report.cycles)
        run.checkpoint()
    return report.failure


def _summary(run: TrainingRun, cycles: int, wall: float, failure: str | None) -> dict[str, Any]:
    mean = run.windowed_mean
    return {
        "folder": str(run.folder),
        "size": run.config.task.size,
        "field": run.config.task.field,
        "vision": run.config.task.vision,
        "stage": run.config.stage,
        "learner": run.config.learner.name,
        "method": run.config.method.name,
        "seed": run.config.seed,
        "hours": round(run.hours, 4),
        "episodes": run.episodes,
        "last_mean_s": None if math.isnan(mean) else round(mean, 4),
        "last_episodes": len(run.recent),
        "cycles": cycles,
        "wall_s": round(wall, 3),
        "cycles_per_s": round(cycles / wall, 1) if wall > 0 else None,
        "done": run.done,
        "failure": failure,
    }


def _summary_text(run: TrainingRun, summary: dict[str, Any]) -> str:
    config = run.config
    lines = [
        f"{config.task.size} on {config.task.field} m, vision {config.task.vision}, {config.stage}: "
        f"{config.method.describe()}; learner {config.learner.name}, seed {config.seed}"
    ]
    mean = "" if summary["last_mean_s"] is None else f"; last {len(run.recent)}: mean {summary['last_mean_s']:.2f} s"
    lines.append(f"  {run.hours:.2f} simulated hours, {run.episodes} episodes{mean}")
    speed = f", {summary['cycles_per_s']:.0f} cycles/s" if summary["cycles_per_s"] else ""
    lines.append(f"  {summary['cycles']} cycles in {summary['wall_s']:.1f} s{speed}")
    lines.append(f"  in {run.folder}: learners.npz, episodes.csv, config.json" + (", rules.json" if run.rules else ""))
    return "\n".join(lines)


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--episodes", type=click.IntRange(1), default=1000, show_default=True, help="Stop after so many.")
@click.option("--on", "stage", type=Stage(ARENA, FAKE, REAL), default=ARENA, show_default=True, help="Where to play.")
@click.option("--explore", is_flag=True, help="Explore as in training (without learning).")
@click.option("--seed", type=click.IntRange(0), default=None, help="Same seed, same match (fake and arena).")
@click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def evaluate(
    folder: Path,
    episodes: int,
    stage: str | tuple[str, int],
    explore: bool,
    seed: int | None,
    executable: str | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Play learned weights without learning, and without exploration unless asked for.

    The task is that of the training run. The result is also kept in the run's folder (evaluations.jsonl).

    \b
    Example:
      rcss-hat evaluate runs/ppr --episodes 1000
      rcss-hat evaluate runs/ppr --episodes 100 --on fake --seed 7 --json
    """
    from rcss_hat.cli.stages import play_on_stage
    from rcss_hat.experiments.evaluation import frozen_policy
    from rcss_hat.experiments.training import TrainingError, read_config
    from rcss_hat.hat.decision_list import DecisionList
    from rcss_hat.hat.policy import RUN_RULES, RUN_WEIGHTS
    from rcss_hat.hat.transfer import Learners

    if seed is None:
        seed = secrets.randbelow(2**31)
    with plain_errors(TrainingError, ValueError, RuntimeError):
        task = read_config(folder).task
        learners = Learners.load(folder / RUN_WEIGHTS)
        rules = DecisionList.load(folder / RUN_RULES) if (folder / RUN_RULES).exists() else None
        policy = frozen_policy(learners, rules, seed, explore, str(folder))
        report = RunReport(stage_text(stage), str(folder), "hand", task.size, task.field, task.vision, seed)
        with progress_bar(f"{folder.name} on {report.stage}", episodes, hide=quiet or as_json) as bar:
            play_on_stage(report, task, seed, policy, stage, episodes, executable, lambda n, _: bar(n))
        result = {**report.summary(), "learned_episodes": learners.episodes, "explore": explore}
        with (folder / "evaluations.jsonl").open("a", encoding="utf-8") as file:
            file.write(json.dumps(result) + "\n")
    click.echo(json.dumps(result) if as_json else report.to_text())
    if report.failure:
        fail(report.failure, report.exit_code)
    sys.exit(report.exit_code)
