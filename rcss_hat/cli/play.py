"""``rcss-hat play``: a whole match, both teams ours."""

from __future__ import annotations

import secrets
import sys
import time
from collections.abc import Callable
from pathlib import Path

import click

from rcss_hat.cli.common import (
    ARENA,
    FAKE,
    REAL,
    SERVER,
    TRAINER,
    Stage,
    plain_errors,
    progress_bar,
    stage_text,
    task_options,
)
from rcss_hat.keepaway.report import RunReport, kwy_text
from rcss_hat.keepaway.task import Task


def _play_matches(
    report: RunReport, task: Task, matches: int, episodes: int, jobs: int, update: Callable[[int], None]
) -> None:
    """Play a batch in the arena; the report's episodes are in the order of the matches."""
    from rcss_hat.arena.batch import MatchResult, play_batch

    begun = time.monotonic()
    finished: list[MatchResult] = []
    assert report.seed is not None
    try:
        for result in play_batch(task, report.keepers, report.seed, matches, episodes, jobs):
            finished.append(result)
            update(len(finished) * episodes)
    except KeyboardInterrupt:
        report.failure = "interrupted"
    for result in sorted(finished, key=lambda result: result.number):
        report.episodes += result.episodes
        report.cycles += result.cycles
    report.wall_s = time.monotonic() - begun


@click.command()
@click.option("--on", "stage", type=Stage(FAKE, ARENA, REAL), default=FAKE, show_default=True, help="Where to play.")
@click.option("--keepers", default="hand", show_default=True, help="hold, random, hand, a decision list, or a run.")
@click.option("--takers", type=click.Choice(["hand"]), default="hand", show_default=True, help="Policy of the takers.")
@click.option("--episodes", type=click.IntRange(1), default=100, show_default=True, help="Stop after so many.")
@click.option("--seed", type=click.IntRange(0), default=None, help="Same seed, same match (fake and arena).")
@click.option("--matches", type=click.IntRange(1), default=1, show_default=True, help="Arena: so many matches.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Arena: matches at a time.")
@click.option("--kwy", type=click.Path(dir_okay=False, path_type=Path), help="Write the Keepaway log there.")
@click.option("--processes", is_flag=True, help="One process per player instead of one for all.")
@click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
@click.option(
    "--referee",
    type=click.Choice([SERVER, TRAINER]),
    default=SERVER,
    show_default=True,
    help="Who ends and starts episodes: the server, or a trainer of ours (for servers without Keepaway mode).",
)
@click.option(
    "--coach-port",
    type=click.IntRange(1, 65535),
    default=None,
    help="Where a running server listens for trainers.  [default: the port behind the players']",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
@task_options
def play(
    task: Task,
    stage: str | tuple[str, int],
    keepers: str,
    takers: str,
    episodes: int,
    seed: int | None,
    matches: int,
    jobs: int,
    kwy: Path | None,
    processes: bool,
    executable: str | None,
    referee: str,
    coach_port: int | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Play Keepaway with both teams and report the episodes.

    \b
    Example:
      rcss-hat play --on fake --keepers hand --episodes 100 --seed 1
      rcss-hat play --on localhost:6000 --keepers rules.json --episodes 50 --json
      rcss-hat play --on arena --keepers hand --matches 50 --episodes 100 --jobs 2 --seed 1
      rcss-hat play --on localhost:6000 --referee trainer   # a server with server::coach=1
    """
    from rcss_hat.cli.stages import play_in_processes_on_stage, play_on_stage
    from rcss_hat.hat.policy import PolicyError, load_policy

    if referee == TRAINER and stage == ARENA:
        raise click.UsageError("a trainer referees on a server, not in the arena")
    if matches > 1 and (stage != ARENA or kwy is not None):
        raise click.UsageError("--matches plays in the arena, and a Keepaway log holds one match")
    if seed is None:
        seed = secrets.randbelow(2**31)
    try:
        policy = load_policy(keepers, task.keepers, task.takers, seed)
    except PolicyError as error:
        raise click.BadParameter(str(error), param_hint="--keepers") from error
    report = RunReport(stage_text(stage), keepers, takers, task.size, task.field, task.vision, seed)
    with (
        progress_bar(f"{keepers} on {report.stage}", episodes * matches, hide=quiet or as_json) as update,
        plain_errors(RuntimeError),
    ):

        def show(finished: int, cycle: int) -> None:
            update(finished)

        trainer = None if referee == SERVER else coach_port or 0
        if matches > 1:
            _play_matches(report, task, matches, episodes, jobs, update)
        elif processes and stage != ARENA:
            play_in_processes_on_stage(report, task, seed, policy, stage, episodes, executable, show, trainer)
        else:
            play_on_stage(report, task, seed, policy, stage, episodes, executable, show, trainer)
    if kwy is not None:
        kwy.parent.mkdir(parents=True, exist_ok=True)
        kwy.write_text(kwy_text(report.episodes, task.keepers, task.takers, task.length, task.width))
    click.echo(report.to_json() if as_json else report.to_text())
    sys.exit(report.exit_code)
