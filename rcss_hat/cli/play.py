"""``rcss-hat play``: a whole match, both teams ours."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import click

from rcss_hat.cli.common import (
    POLICIES,
    SERVER,
    TRAINER,
    Target,
    deliver,
    drawn,
    named_policy,
    named_takers,
    packed,
    plain_errors,
    progress_bar,
    say,
    shown,
    task_options,
    typed_settings,
)
from rcss_hat.cli.places import place_options
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import FAKE, Place
from rcss_hat.system.files import write_text


@dataclass(frozen=True)
class Options:
    """What ``play`` is told, beside the task and the place."""

    keepers: str
    takers: str
    episodes: int
    seed: int | None
    matches: int
    jobs: int
    kwy: Path | None
    processes: bool
    referee: str
    coach_port: int | None
    as_json: bool
    quiet: bool


@click.command()
@place_options(FAKE)
@click.option("--keepers", default="hand", show_default=True, help=POLICIES)
@click.option(
    "--takers", default="hand", show_default=True, help="hand, or a function of (state, info): module:object."
)
@click.option("--episodes", type=click.IntRange(1), default=100, show_default=True, help="Stop after so many.")
@click.option("--seed", type=click.IntRange(0), default=None, help="Same seed, same match (fake and arena).")
@click.option("--matches", type=click.IntRange(1), default=1, show_default=True, help="Arena: so many matches.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Arena: matches at a time.")
@click.option("--kwy", type=Target(), help="Write the Keepaway log there.")
@click.option("--processes", is_flag=True, help="One process per player instead of one for all.")
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
@packed(Options)
def play(task: Task, place: Place, options: Options) -> None:
    """Play Keepaway with both teams and report the episodes.

    \b
    Example:
      rcss-hat play --on fake --keepers hand --episodes 100 --seed 1
      rcss-hat play --on localhost:6000 --keepers rules.json --episodes 50 --json
      rcss-hat play --on arena --keepers hand --matches 50 --episodes 100 --jobs 2 --seed 1
      rcss-hat play --on localhost:6000 --referee trainer   # a server with server::coach=1
    """
    from rcss_hat.stage.stages import Part, open_stage
    from rcss_hat.stage.terms import Terms

    if options.matches > 1 and options.kwy is not None:
        raise click.UsageError("a Keepaway log holds one match, --matches plays many")
    seed, n = drawn(options.seed), options.episodes
    policy = named_policy(options.keepers, task, seed, "--keepers")
    orders = named_takers(options.takers, task, seed, "--takers")
    trainer = None if options.referee == SERVER else options.coach_port or 0
    terms = Terms(typed_settings(), say, trainer=trainer, processes=options.processes, orders=orders)
    label, hidden = f"{options.keepers} on {place}", options.quiet or options.as_json
    with plain_errors(RuntimeError), progress_bar(label, n * options.matches, hide=hidden) as update:
        try:
            with open_stage(place, task, seed, policy, terms) as stage:
                if options.matches > 1:
                    report = stage.play_matches(options.matches, options.jobs, n, lambda ended: update(ended * n))
                else:
                    report = stage.play(Part(n, on_episodes=shown(update)))
        except ValueError as error:
            raise click.UsageError(str(error)) from error
    text = report.to_json() if options.as_json else report.to_text()
    deliver(text, (options.kwy, lambda path: write_text(path, report.kwy_text())))
    sys.exit(report.exit_code)
