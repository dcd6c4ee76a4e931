"""``rcss-hat demonstrate``: record (state, action) pairs of a teacher."""

from __future__ import annotations

import asyncio
import datetime
import json
import math
import secrets
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import (
    ARENA,
    FAKE,
    REAL,
    Stage,
    fail,
    plain_errors,
    progress_bar,
    stage_text,
    task_options,
    tell_of_compilation,
)
from rcss_hat.cli.person import demonstrate_by_hand, parse_actions
from rcss_hat.cli.stages import own_server, server_pace
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.task import Task

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.hat.policy import TeamPolicy


@click.command()
@click.option(
    "--on", "stage", type=Stage(FAKE, ARENA, REAL), default=None, help="Where to play.  [default: fake; people: arena]"
)
@click.option(
    "--teacher",
    default="hand",
    show_default=True,
    help="hold, random, hand, a decision list, a run, or a scripted person: A, B, C, B-fast, B-limited.",
)
@click.option("--browser", is_flag=True, help="You demonstrate, in a browser.")
@click.option("--terminal", is_flag=True, help="You demonstrate, in this terminal.")
@click.option("--actions", default=None, help="You: what you may do, e.g. hold,pass1.  [default: everything]")
@click.option(
    "--speed",
    type=click.FloatRange(0.1, 20),
    default=1.0,
    show_default=True,
    help="You: times real time; servers at most 5.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Of the page; 0: any.")
@click.option("--open/--no-open", "open_browser", default=True, help="Open the page by itself.")
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
    stage: str | tuple[str, int] | None,
    teacher: str,
    browser: bool,
    terminal: bool,
    actions: str | None,
    speed: float,
    port: int,
    open_browser: bool,
    episodes: int,
    seed: int | None,
    out: Path,
    resume: bool,
    executable: str | None,
    as_json: bool,
) -> None:
    """Record a teacher that controls the keeper with the ball: a policy, a scripted person, or you.

    Every finished episode is on the disk before the next one ends; Ctrl-C keeps them all.

    \b
    Example:
      rcss-hat demonstrate --on fake --teacher hand --episodes 20 --seed 1 --out demo.csv
      rcss-hat demonstrate --browser --episodes 20 --out mine.csv
      rcss-hat demonstrate --browser --on fake --speed 5 --out fast.csv
      rcss-hat demonstrate --browser --on localhost:6000 --actions hold,pass1 --out mine.csv
      rcss-hat summarize demo.csv --out rules.json
    """
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
    from rcss_hat.hat.teachers import STYLES

    person = browser or terminal
    stage = stage or (ARENA if person else FAKE)
    name = "person" if person else teacher
    if speed != 1.0 and not person:
        raise click.UsageError("--speed is for people: give it with --browser or --terminal")
    scripted = next((style for style in STYLES if style.lower() == teacher.lower()), None)
    if scripted and not person and stage != ARENA:
        raise click.UsageError(f"the scripted person {scripted} sees the whole field: use --on arena")
    try:
        allowed = parse_actions(actions, task.keepers)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--actions") from error
    seed = secrets.randbelow(2**31) if seed is None else seed
    policy = None if person or scripted else _policy(teacher, task, seed)
    pace = {"synch_mode": False, **server_pace(stage, speed)} if person and stage != ARENA else {}
    in_force = {} if isinstance(stage, tuple) else {**task.server_values(), **pace}
    notes = f"played {speed:g} times as fast as real time" if speed != 1.0 else ""
    today = datetime.date.today().isoformat()
    info = DemonstrationInfo(name, stage_text(stage), task, in_force, seed, today, notes)
    report = RunReport(stage_text(stage), name, "hand", task.size, task.field, task.vision, seed)
    with plain_errors(ValueError, RuntimeError):
        out.parent.mkdir(parents=True, exist_ok=True)
        with (
            DemonstrationWriter(out, info, resume) as writer,
            progress_bar(f"{name} demonstrates", episodes, hide=as_json or person) as update,
        ):
            missing = episodes - len(writer.entries)
            if missing <= 0:
                click.echo(f"{out} already has {len(writer.entries)} episodes", err=True)
            elif person:
                server = own_server(task, seed, stage, executable, **pace) if stage != ARENA else None
                demonstrate_by_hand(
                    report, task, stage, seed, writer, episodes, speed, allowed, terminal, port, open_browser, server
                )
            elif scripted:
                _scripted(task, scripted, seed + len(writer.entries), missing, writer, update)
            elif policy is not None and stage == ARENA:
                _in_arena(task, seed, policy, missing, writer, update)
            elif policy is not None:
                _over_udp(report, task, stage, seed, policy, missing, writer, update, executable)
        recorded = DemonstrationSet.load(out)
    if as_json:
        summary = {**report.summary(), "out_file": str(out), "episodes": len(writer.entries)}
        mean = None if math.isnan(writer.mean_duration) else round(writer.mean_duration, 4)
        summary.update(decisions=writer.n_decisions, mean_s=mean)
        click.echo(json.dumps(summary))
    elif len(recorded):
        click.echo(recorded.describe().to_text())
    else:
        click.echo("no episode was recorded")
    if report.missed and not as_json:
        cycles = report.cycles * (task.keepers + task.takers)
        share = 100.0 * report.missed / max(cycles, 1)
        click.echo(f"In {share:.1f} % of all cycles a player's command came too late for the server.", err=True)
    if report.failure and not as_json:
        fail(f"{report.failure} (the finished episodes are in {out})", report.exit_code)
    sys.exit(report.exit_code)


def _policy(teacher: str, task: Task, seed: int) -> TeamPolicy:
    from rcss_hat.hat.policy import PolicyError, load_policy
    from rcss_hat.hat.teachers import STYLES

    try:
        return load_policy(teacher, task.keepers, task.takers, seed)
    except PolicyError as error:
        raise click.BadParameter(
            f"{error}; scripted persons are {', '.join(STYLES)}", param_hint="--teacher"
        ) from error


def _scripted(
    task: Task, style: str, seed: int, episodes: int, writer: DemonstrationWriter, update: Callable[..., None]
) -> None:
    from rcss_hat.experiments.demonstrating import demonstrate as let_teach

    for demonstration in let_teach(task, style, episodes, seed):
        for decision in demonstration.decisions:
            writer.add(decision.cycle, decision.keeper, decision.state, decision.action)
        episode = demonstration.episode
        writer.end_episode(episode.start, episode.end, episode.reason)
        update(len(writer.entries))


def _in_arena(
    task: Task, seed: int, policy: TeamPolicy, episodes: int, writer: DemonstrationWriter, update: Callable[..., None]
) -> None:
    from rcss_hat.arena.match import ArenaMatch

    tell_of_compilation("rcss_hat.arena.loop")
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
    from rcss_hat.team.demonstration import DemonstrationRecorder
    from rcss_hat.team.match import play

    tell_of_compilation("rcss_hat.keepaway.agent")
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
