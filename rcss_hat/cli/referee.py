"""``rcss-hat referee``: a trainer that referees whoever plays on a running server."""

from __future__ import annotations

import asyncio
import secrets
import sys
from pathlib import Path
from typing import IO

import click

from rcss_hat.cli.common import Stage, plain_errors, progress_bar, stage_text, task_options
from rcss_hat.keepaway.report import Episode, RunReport, kwy_line, kwy_text
from rcss_hat.keepaway.task import Task


@click.command()
@click.option("--on", "address", type=Stage(), default="localhost:6000", show_default=True, help="The server.")
@click.option("--coach-port", type=click.IntRange(1, 65535), help="Its coach_port.  [default: the port behind]")
@click.option("--episodes", type=click.IntRange(1), default=None, help="Stop after so many.  [default: at Ctrl-C]")
@click.option("--seed", type=click.IntRange(0), default=None, help="Of the places where everybody starts.")
@click.option("--kwy", type=click.Path(dir_okay=False, path_type=Path), help="Write the Keepaway log there.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
def referee(
    task: Task,
    address: tuple[str, int],
    coach_port: int | None,
    episodes: int | None,
    seed: int | None,
    kwy: Path | None,
    as_json: bool,
) -> None:
    """Referee Keepaway as a trainer, on a server without Keepaway mode (server::coach=1).

    Waits until both teams are complete, starts the match, ends episodes by the rules of the server's own referee and
    puts everybody back.

    \b
    Example:
      rcss-hat server --fake --referee trainer &
      rcss-hat keepers & rcss-hat takers &
      rcss-hat referee --on localhost:6000 --episodes 100 --kwy match.kwy
    """
    from rcss_hat.team.trainer import referee_match

    seed = secrets.randbelow(2**31) if seed is None else seed
    report = RunReport(stage_text(address), "-", "-", task.size, task.field, task.vision, seed)
    log: IO[str] | None = None
    if kwy is not None:
        kwy.parent.mkdir(parents=True, exist_ok=True)
        log = kwy.open("w")
        log.write(kwy_text([], task.keepers, task.takers, task.length, task.width))
    with progress_bar(f"refereeing {report.stage}", episodes, hide=as_json) as update, plain_errors(RuntimeError):

        def ended(episode: Episode) -> None:
            update(episode.number)
            if log is not None:
                log.write(kwy_line(episode))
                log.flush()

        where = address[0], coach_port or address[1] + 1
        try:
            asyncio.run(referee_match(report, task, seed, where, episodes, ended))
        except KeyboardInterrupt:
            report.failure = report.failure or "interrupted"
        finally:
            if log is not None:
                log.close()
    if report.failure == "interrupted" and episodes is None:
        report.failure = None
    click.echo(report.to_json() if as_json else report.to_text())
    sys.exit(report.exit_code)
