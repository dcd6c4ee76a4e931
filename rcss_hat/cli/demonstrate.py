"""``rcss-hat demonstrate``: record (state, action) pairs of a teacher."""

from __future__ import annotations

import asyncio
import datetime
import json
import secrets
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import ARENA, FAKE, REAL, Stage, fail, plain_errors, progress_bar, stage_text, task_options
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.task import Task

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.hat.policy import TeamPolicy


@click.command()
@click.option("--on", "stage", type=Stage(FAKE, ARENA, REAL), default=FAKE, show_default=True, help="Where to play.")
@click.option("--teacher", default="hand", show_default=True, help="hold, random, hand, a decision list, or a run.")
@click.option("--episodes", type=click.IntRange(1), default=20, show_default=True, help="How many in all.")
@click.option("--seed", type=click.IntRange(0), default=None, help="Same seed, same demonstration (fake and arena).")
@click.option(
    "--out", type=click.Path(dir_okay=False, path_type=Path), required=True, help="The table, x.csv (and x.json)."
)
@click.option("--resume", is_flag=True, help="Go on with an existing file.")
@click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
def demonstrate(
    task: Task,
    stage: str | tuple[str, int],
    teacher: str,
    episodes: int,
    seed: int | None,
    out: Path,
    resume: bool,
    executable: str | None,
    as_json: bool,
) -> None:
    """Record a teacher that controls the keeper with the ball.

    Every finished episode is on the disk before the next one begins; Ctrl-C keeps them all.

    \b
    Example:
      rcss-hat demonstrate --on fake --teacher hand --episodes 20 --seed 1 --out demo.csv
      rcss-hat summarize demo.csv --out rules.json
    """
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
    from rcss_hat.hat.policy import PolicyError, load_policy

    seed = secrets.randbelow(2**31) if seed is None else seed
    try:
        policy = load_policy(teacher, task.keepers, task.takers, seed)
    except PolicyError as error:
        raise click.BadParameter(str(error), param_hint="--teacher") from error
    today = datetime.date.today().isoformat()
    info = DemonstrationInfo(teacher, stage_text(stage), task, dict(task.server_values()), seed, today)
    report = RunReport(stage_text(stage), teacher, "hand", task.size, task.field, task.vision, seed)
    with plain_errors(ValueError, RuntimeError):
        out.parent.mkdir(parents=True, exist_ok=True)
        with (
            DemonstrationWriter(out, info, resume) as writer,
            progress_bar(f"{teacher} demonstrates", episodes, hide=as_json) as update,
        ):
            missing = episodes - len(writer.entries)
            if missing <= 0:
                click.echo(f"{out} already has {len(writer.entries)} episodes", err=True)
            elif stage == ARENA:
                _in_arena(task, seed, policy, missing, writer, update)
            else:
                _over_udp(report, task, stage, seed, policy, missing, writer, update, executable)
        description = DemonstrationSet.load(out).describe()
    if as_json:
        summary = {**report.summary(), "out_file": str(out), "episodes": len(writer.entries)}
        summary.update(decisions=writer.n_decisions, mean_s=round(writer.mean_duration, 4))
        click.echo(json.dumps(summary))
    else:
        click.echo(description.to_text())
    if report.failure and not as_json:
        fail(f"{report.failure} (the finished episodes are in {out})", report.exit_code)
    sys.exit(report.exit_code)


def _in_arena(
    task: Task, seed: int, policy: TeamPolicy, episodes: int, writer: DemonstrationWriter, update: Callable[..., None]
) -> None:
    from rcss_hat.arena.match import ArenaMatch

    match = ArenaMatch(task, seed, policy, log_decisions=True)
    pending: list[Any] = []
    for finished in match.advance(episodes=episodes):
        pending.extend(match.take_decisions())
        for episode in finished:
            for decision in pending:
                if decision["episode"] == episode.number:
                    writer.add(decision["cycle"], decision["keeper"], decision["state"], decision["action"])
            writer.end_episode(episode.start, episode.end, episode.reason)
            pending = [decision for decision in pending if decision["episode"] > episode.number]
            update(len(writer.entries))


def _over_udp(
    report: RunReport,
    task: Task,
    stage: str | tuple[str, int],
    seed: int,
    policy: TeamPolicy,
    episodes: int,
    writer: DemonstrationWriter,
    update: Callable[..., None],
    executable: str | None,
) -> None:
    from rcss_hat.cli.stages import own_server
    from rcss_hat.team.demonstration import DemonstrationRecorder
    from rcss_hat.team.match import play

    policy.warm_up()
    server = own_server(task, seed, stage, executable)
    address = stage if isinstance(stage, tuple) else None
    recorder = DemonstrationRecorder(writer, policy)

    def ended(episode: Episode) -> None:
        recorder.end_episode(episode)
        update(len(writer.entries))

    try:
        asyncio.run(play(report, task, seed, recorder, episodes, server, address, on_episode=ended))
    except KeyboardInterrupt:
        report.failure = report.failure or "interrupted"
    finally:
        if server is not None:
            server.clean()
