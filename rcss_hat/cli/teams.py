"""``rcss-hat keepers`` and ``rcss-hat takers``: one team against a running server."""

from __future__ import annotations

import asyncio
import secrets
import sys

import click

from rcss_hat.cli.common import Stage, plain_errors, progress_bar, stage_text, task_options
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task


def _run(
    task: Task,
    address: tuple[str, int],
    keepers: str | None,
    seed: int | None,
    episodes: int | None,
    kick_off: bool,
    as_json: bool,
) -> None:
    from rcss_hat.hat.policy import PolicyError, load_policy
    from rcss_hat.team.match import play_team

    seed = secrets.randbelow(2**31) if seed is None else seed
    try:
        policy = load_policy(keepers, task.keepers, task.takers, seed) if keepers is not None else None
    except PolicyError as error:
        raise click.BadParameter(str(error), param_hint="--policy") from error
    if policy is not None:
        policy.warm_up()
    report = RunReport(stage_text(address), keepers or "-", "hand", task.size, task.field, task.vision, seed)
    label = f"{'keepers' if policy else 'takers'} on {report.stage}"
    with progress_bar(label, episodes, hide=as_json) as update, plain_errors(RuntimeError):
        try:
            asyncio.run(play_team(report, task, seed, policy, episodes, address, kick_off, lambda n, _: update(n)))
        except KeyboardInterrupt:
            report.failure = report.failure or "interrupted"
    if report.failure == "interrupted" and episodes is None:
        report.failure = None
    click.echo(report.to_json() if as_json else report.to_text())
    sys.exit(report.exit_code)


@click.command()
@click.option("--on", "address", type=Stage(), default="localhost:6000", show_default=True, help="The server.")
@click.option("--policy", default="hand", show_default=True, help="hold, random, hand, a decision list, or a run.")
@click.option("--episodes", type=click.IntRange(1), default=None, help="Stop after so many.  [default: at Ctrl-C]")
@click.option("--seed", type=click.IntRange(0), default=None)
@click.option("--kick-off", is_flag=True, help="Wait until the takers are there too, then start the match.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
def keepers(
    task: Task,
    address: tuple[str, int],
    policy: str,
    episodes: int | None,
    seed: int | None,
    kick_off: bool,
    as_json: bool,
) -> None:
    """Launch the keepers against a running server (they must connect before the takers).

    \b
    Example:
      rcss-hat keepers --on localhost:6000 --policy hand --episodes 100
    """
    _run(task, address, policy, seed, episodes, kick_off, as_json)


@click.command()
@click.option("--on", "address", type=Stage(), default="localhost:6000", show_default=True, help="The server.")
@click.option("--episodes", type=click.IntRange(1), default=None, help="Stop after so many.  [default: at Ctrl-C]")
@click.option("--seed", type=click.IntRange(0), default=None)
@click.option("--kick-off", is_flag=True, help="Start the match when everybody is there.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
def takers(
    task: Task, address: tuple[str, int], episodes: int | None, seed: int | None, kick_off: bool, as_json: bool
) -> None:
    """Launch the takers against a running server, once all keepers are on the field.

    \b
    Example:
      rcss-hat takers --on localhost:6000 --kick-off
    """
    _run(task, address, None, seed, episodes, kick_off, as_json)
