"""``rcss-hat referee``: a trainer that referees whoever plays on a running server."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import click

from rcss_hat.cli.common import TRAINER, Target, deliver, drawn, plain_errors, progress_bar, task_options
from rcss_hat.cli.places import HostPort
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport, kwy_line
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import Place
from rcss_hat.system.files import LiveLog


@click.command()
@click.option("--on", "address", type=HostPort(), default="localhost:6000", show_default=True, help="The server.")
@click.option("--coach-port", type=click.IntRange(1, 65535), help="Its coach_port.  [default: the port behind]")
@click.option("--episodes", type=click.IntRange(1), default=None, help="Stop after so many.  [default: at Ctrl-C]")
@click.option("--seed", type=click.IntRange(0), default=None, help="Of the places where everybody starts.")
@click.option("--kwy", type=Target(), help="Write the Keepaway log there.")
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
    from rcss_hat.stage.trainer import referee_match

    seed = drawn(seed)
    report = RunReport.of(str(Place.at(address)), "-", task, seed, "-", TRAINER)
    with plain_errors():
        log = LiveLog(kwy, report.kwy_text()) if kwy is not None else None
    with progress_bar(f"refereeing {report.stage}", episodes, hide=as_json) as update, plain_errors(RuntimeError):

        def ended(episode: Episode) -> None:
            update(episode.number)
            if log is not None:
                log.add(kwy_line(episode))

        where = address[0], coach_port or address[1] + 1
        try:
            asyncio.run(referee_match(report, task, seed, where, episodes, ended))
        except KeyboardInterrupt:
            report.end_early(INTERRUPTED)
    if episodes is None:
        report.stopped_on_purpose()
    deliver(report.to_json() if as_json else report.to_text(), (kwy, lambda _: log.finish() if log else None))
    sys.exit(report.exit_code)
