"""``rcss-hat keepers`` and ``rcss-hat takers``: one team against a running server."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import click

from rcss_hat.cli.common import (
    POLICIES,
    drawn,
    named_policy,
    packed,
    plain_errors,
    progress_bar,
    say,
    shown,
    task_options,
    typed_settings,
)
from rcss_hat.cli.places import HostPort
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import Address, Place


@dataclass(frozen=True)
class Options:
    """What both teams' commands are told."""

    address: Address
    episodes: int | None
    seed: int | None
    kick_off: bool
    as_json: bool


def _run(task: Task, options: Options, keepers: str | None, end_match: bool = False) -> None:
    from rcss_hat.stage.stages import Part, open_stage
    from rcss_hat.stage.terms import Terms

    seed, episodes = drawn(options.seed), options.episodes
    policy = named_policy(keepers, task, seed, "--policy") if keepers is not None else None
    terms = Terms(typed_settings(), say, end_match, takers=policy is None, kick_off=options.kick_off)
    with open_stage(Place.at(options.address), task, seed, policy, terms) as stage:
        label = f"{'keepers' if policy else 'takers'} on {stage.place}"
        with progress_bar(label, episodes, hide=options.as_json) as update, plain_errors(RuntimeError):
            report = stage.play(Part(episodes, on_episodes=shown(update)))
    if episodes is None:
        report.stopped_on_purpose()
    click.echo(report.to_json() if options.as_json else report.to_text())
    sys.exit(report.exit_code)


@click.command()
@click.option("--on", "address", type=HostPort(), default="localhost:6000", show_default=True, help="The server.")
@click.option("--policy", default="hand", show_default=True, help=POLICIES)
@click.option("--episodes", type=click.IntRange(1), default=None, help="Stop after so many.  [default: at Ctrl-C]")
@click.option("--seed", type=click.IntRange(0), default=None)
@click.option("--kick-off", is_flag=True, help="Wait until the takers are there too, then start the match.")
@click.option(
    "--end-match", is_flag=True, help="Then end the match for everybody; the server needs server::coach_w_referee=1."
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
@packed(Options)
def keepers(task: Task, options: Options, policy: str, end_match: bool) -> None:
    """Launch the keepers against a running server (they must connect before the takers).

    \b
    Example:
      rcss-hat keepers --on localhost:6000 --policy hand --episodes 100
    """
    if end_match and options.episodes is None:
        raise click.UsageError("--end-match needs --episodes: after how many")
    _run(task, options, policy, end_match)


@click.command()
@click.option("--on", "address", type=HostPort(), default="localhost:6000", show_default=True, help="The server.")
@click.option("--episodes", type=click.IntRange(1), default=None, help="Stop after so many.  [default: at Ctrl-C]")
@click.option("--seed", type=click.IntRange(0), default=None)
@click.option("--kick-off", is_flag=True, help="Start the match when everybody is there.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
@packed(Options)
def takers(task: Task, options: Options) -> None:
    """Launch the takers against a running server, once all keepers are on the field.

    \b
    Example:
      rcss-hat takers --on localhost:6000 --kick-off
    """
    _run(task, options, None)
