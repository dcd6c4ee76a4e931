"""``rcss-hat study``: studies with people, from the links to the report."""

from __future__ import annotations

import asyncio
import json
import os
import signal
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rcss_hat.cli.common import Target, deliver, plain_errors, progress_bar, say
from rcss_hat.system.locks import SoleWriter

if TYPE_CHECKING:
    from rcss_hat.studies.parts import PeopleStudy
    from rcss_hat.studies.server import StudyServer

Folder = click.Path(exists=True, file_okay=False, path_type=Path)


@click.group()
def study() -> None:
    """Let people demonstrate in a study: serve its pages, rehearse it, report on it.

    \b
    Example:
      rcss-hat study rehearse people --participants 12 --out studies/rehearsal
      rcss-hat study serve people --out studies/people
      rcss-hat study report studies/people
    """


def _loaded(name: str) -> PeopleStudy:
    from rcss_hat.studies.people_file import PeopleError, load_people

    try:
        return load_people(name)
    except PeopleError as problem:
        raise click.UsageError(str(problem)) from problem


@study.command()
@click.argument("study_file", metavar="STUDY")
def check(study_file: str) -> None:
    """Check a study's file, and show who would be assigned to what, and the steps of the first participant.

    \b
    Example:
      rcss-hat study check people
    """
    from rcss_hat.studies.plan import assigned, participant_name, plan_of

    found = _loaded(study_file)
    lines = [f"{participant_name(k)}: {', '.join(assigned(found, k))}" for k in range(1, found.participants + 1)]
    lines.append(f"Steps of {participant_name(1)}:")
    for planned in plan_of(found, 1):
        game = planned.game
        played = (
            "" if game is None else f", {game.episodes} games of {game.task.size} at {game.speed:g} times real time"
        )
        lines.append(f"  {planned.name} ({planned.step_kind}{played})")
    deliver("\n".join(lines))


@study.command()
@click.argument("study_file", metavar="STUDY")
@click.option("--out", type=Target(folder=True), required=True, help="The study's folder; one that was begun goes on.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Of the pages; 0: any.")
@click.option("--bind", default="127.0.0.1", show_default=True, help="Interface to listen on.")
@click.option("--public-url", default="", help="Address behind a reverse proxy, with its path: https://lab.org/hat/")
@click.option(
    "--jobs", type=click.IntRange(1), default=os.cpu_count() or 1, help="Processes for games.  [default: cores]"
)
def serve(study_file: str, out: Path, port: int, bind: str, public_url: str, jobs: int) -> None:
    """Serve a study: a link per participant, an open link for everybody, and the experimenter's page.

    What participants do is in the folder at once; whatever ends this command, start it again and all go on where they
    were. Ctrl-C ends.

    \b
    Example:
      rcss-hat study serve people --out studies/people --port 8000 --public-url https://lab.example.org/hat/
    """
    from rcss_hat.studies.folder import StudyFolder
    from rcss_hat.studies.server import Address, StudyServer

    found = _loaded(study_file)
    try:
        address = Address(bind, port, public_url)
    except ValueError as problem:
        raise click.UsageError(str(problem)) from problem
    with plain_errors(ValueError, RuntimeError), SoleWriter(out):
        folder = StudyFolder.begin(out, found)
        with suppress(KeyboardInterrupt):
            asyncio.run(_serve(StudyServer(folder, address, jobs, say)))


async def _serve(server: StudyServer) -> None:
    """Serve until Ctrl-C."""
    from rcss_hat.studies.links import write_links

    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stopped.set)
    say("Starting ...")
    async with server:
        written = write_links(server)
        say(f"The experimenter's page: {server.lab_link}")
        say(f"Open link, the next free place for everybody: {server.open_link}")
        say(f"A link per participant: {written}")
        say("Ctrl-C ends; everything is kept.")
        await stopped.wait()
        say("Ending ...")


@study.command()
@click.argument("study_file", metavar="STUDY")
@click.option("--participants", type=click.IntRange(1, 10_000), default=None, help="How many.  [default: the study's]")
@click.option("--out", type=Target(folder=True), required=True, help="The rehearsal's folder, apart from people's.")
@click.option(
    "--hurry", type=click.FloatRange(1, 20), default=2.0, show_default=True, help="Times as fast as for people."
)
@click.option(
    "--jobs", type=click.IntRange(1), default=os.cpu_count() or 1, help="Processes for games.  [default: cores]"
)
def rehearse(study_file: str, participants: int | None, out: Path, hurry: float, jobs: int) -> None:
    """Let scripted participants go through a study, by its own pages, with human reaction times.

    They play in the manner of the teachers A, B and C, each a little different. The same command goes on after a stop.

    \b
    Example:
      rcss-hat study rehearse people --participants 12 --out studies/rehearsal
      rcss-hat study report studies/rehearsal
    """
    from rcss_hat.studies.rehearsal import rehearse as play

    found = _loaded(study_file)
    many = participants or found.participants
    with plain_errors(ValueError, RuntimeError), SoleWriter(out), progress_bar("rehearsal", many, "people") as bar:
        told = asyncio.run(play(found, out, many, jobs, hurry, say, bar))
    games, breaks = sum(t["games"] for t in told), sum(t["breaks"] for t in told)
    deliver(f"{len(told)} participants played {games} games in {out}" + (f"; {breaks} breaks" if breaks else ""))


@study.command()
@click.argument("folder", type=Folder)
@click.argument("participant")
def remove(folder: Path, participant: str) -> None:
    """Remove everything that is kept of a participant, and the reports and experiments that hold his data, too.

    While the study is served, use the experimenter's page.

    \b
    Example:
      rcss-hat study remove studies/people p007
    """
    from rcss_hat.studies.folder import StudyFolder

    with plain_errors(ValueError), SoleWriter(folder):
        made = StudyFolder(folder).remove(participant)
    also = f", and with it {', '.join(map(str, made))}: make them again" if made else ""
    deliver(f"Everything of {participant} is removed{also}.")


@study.command()
@click.argument("folder", type=Folder)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def status(folder: Path, as_json: bool) -> None:
    """Say who is where, from the folder; the study may be served meanwhile.

    \b
    Example:
      rcss-hat study status studies/people
    """
    from rcss_hat.studies.folder import StudyFolder

    with plain_errors(ValueError):
        people = StudyFolder(folder).participants()
    entries = []
    for kept in people:
        progress = kept.progress
        games = {name: len(played.games) for name, played in progress.played.items()}
        entries.append({"participant": kept.name, "step": progress.current.name, "games": games})
    lines = [f"{e['participant']}: at {e['step']}; games: {e['games']}" for e in entries]
    deliver(json.dumps(entries) if as_json else "\n".join(lines) or "Nobody has begun yet.")
