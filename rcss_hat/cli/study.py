"""``rcss-hat study``: studies with people, from the links to the report."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import signal
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rcss_hat.cli.common import Target, deliver, packed, plain_errors, progress_bar, say
from rcss_hat.system.locks import SoleWriter

if TYPE_CHECKING:
    from rcss_hat.experiments.experiment import Experiment
    from rcss_hat.studies.folder import StudyFolder
    from rcss_hat.studies.parts import PeopleStudy
    from rcss_hat.studies.server import StudyServer

MOST_HURRY = 5.0
"""Times real time that games are played in a rehearsal, at most."""
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
        played = ""
        if game is not None:
            size, speed = game.task.size, f"{game.speed:g} times real time"
            games = "1 game" if game.episodes == 1 else f"{game.episodes} games"
            played = f", {games} of {size} at {speed}{game.described}"
        lines.append(f"  {planned.name} ({planned.step_kind}{played})")
    deliver("\n".join(lines))


@study.command()
@click.argument("study_file", metavar="STUDY")
@click.option("--out", type=Target(folder=True), required=True, help="The study's folder; one that was begun goes on.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Of the pages; 0: that of the last time, or any."
)
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
    from rcss_hat.studies.address import Address
    from rcss_hat.studies.folder import StudyFolder
    from rcss_hat.studies.links import last_port
    from rcss_hat.studies.server import StudyServer

    found = _loaded(study_file)
    try:
        address = Address(bind, port or last_port(out), public_url)
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
        with suppress(NotImplementedError):  # Windows interrupts instead
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
    "--hurry", type=click.FloatRange(1, 20), default=1.0, show_default=True, help="Times as fast as for people."
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
    fastest = max(c.speed or found.game.speed or 1.0 for c in found.conditions)
    if hurry > 1.0 and fastest * hurry > MOST_HURRY:
        raise click.UsageError(
            f"--hurry: pages show 60 pictures a second, so with games at {fastest:g} times real time it can be "
            f"{max(MOST_HURRY / fastest, 1.0):g} at most; scripted participants would see less than people do"
        )
    many = participants or found.participants
    with plain_errors(ValueError, RuntimeError), SoleWriter(out), progress_bar("rehearsal", many, "people") as bar:
        told = asyncio.run(play(found, out, many, jobs, hurry, say, bar))
    games, breaks = sum(t["games"] for t in told), sum(t["breaks"] for t in told)
    deliver(f"{len(told)} participants played {games} games in {out}" + (f"; {breaks} breaks" if breaks else ""))


@dataclass(frozen=True)
class Options:
    """What ``report`` is told, beside the folder."""

    method: str
    hours: float
    trials: int
    baseline_trials: int
    learner: str
    jobs: int
    no_training: bool


@study.command()
@click.argument("folder", type=Folder)
@click.option("--out", type=Target(folder=True), default=None, help="Where to.  [default: FOLDER/report]")
@click.option("--method", default="ppr", show_default=True, help="How learners use demonstrations; see train --help.")
@click.option("--hours", type=click.FloatRange(0, min_open=True), default=30.0, show_default=True, help="Simulated.")
@click.option("--trials", type=click.IntRange(1), default=2, show_default=True, help="Per participant and group.")
@click.option("--baseline-trials", type=click.IntRange(2), default=10, show_default=True, help="Without a teacher.")
@click.option("--learner", default="paper", show_default=True, metavar="PRESET|FILE", help="Settings of the learners.")
@click.option("--jobs", type=click.IntRange(1), default=os.cpu_count() or 1, help="Trials at a time.  [default: cores]")
@click.option("--no-training", is_flag=True, help="Tell only what people did.")
@packed(Options)
def report(folder: Path, out: Path | None, options: Options) -> None:
    """Describe what people demonstrated, train learners on it, and say what holds for people in general.

    The same command goes on after a stop; trained learners are kept in FOLDER/experiment.

    \b
    Example:
      rcss-hat study report studies/people
      rcss-hat study report studies/people --no-training
    """
    from rcss_hat.experiments.results import Results
    from rcss_hat.studies.folder import REPORT, StudyFolder
    from rcss_hat.studies.report import write_people_report

    with plain_errors(ValueError, RuntimeError):
        found = StudyFolder(folder)
        run = None if options.no_training else _trained(found, options)
        place = out or folder / REPORT
        pages = write_people_report(found, place, None if run is None else Results(run))
    deliver("\n".join(map(str, pages)))


def _trained(folder: StudyFolder, options: Options) -> Experiment:
    """Train what is missing."""
    from rcss_hat.experiments.execution import run_locally
    from rcss_hat.experiments.experiment import Experiment
    from rcss_hat.studies.folder import EXPERIMENT
    from rcss_hat.studies.learning import Training, write_experiment

    training = Training(options.method, options.hours, options.trials, options.baseline_trials, options.learner)
    path = write_experiment(folder, training)
    place = folder.path / EXPERIMENT / hashlib.sha256(path.read_bytes()).hexdigest()[:12]
    run = Experiment.create(str(path), place)
    with progress_bar("demonstration sets", len(run.used_sets()), "sets") as bar:
        run.prepare_sets(options.jobs, lambda ready, _: bar(ready))
    done = run.finished
    with progress_bar("learners", run.n_trials, "trials") as bar:
        bar(done)
        for _ in run.run(lambda work: run_locally(work, options.jobs, say=say)):
            done += 1
            bar(done)
    return run


@study.command()
@click.argument("folder", type=Folder)
@click.option(
    "--participants", "sizes", type=click.IntRange(2, 10_000), multiple=True, help="Per condition; repeatable."
)
@click.option("--games", type=click.IntRange(1), default=None, help="Of each participant.  [default: as in FOLDER]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def power(folder: Path, sizes: tuple[int, ...], games: int | None, as_json: bool) -> None:
    """Say how many participants a study needs, from a rehearsal or a pilot, by simulation.

    Power is the share of studies that would find the difference between two conditions (p < 0.05), if differences and
    variances were those of FOLDER.

    \b
    Example:
      rcss-hat study power studies/rehearsal --participants 8 --participants 20 --games 20
    """
    from rcss_hat.studies.folder import StudyFolder
    from rcss_hat.studies.report import SIZES, powers_of

    with plain_errors(ValueError):
        found = powers_of(StudyFolder(folder), sizes or SIZES, games)
    if as_json:
        deliver(json.dumps([asdict(p) for p in found]))
        return
    lines = [
        f"{p.first} - {p.second}: {p.difference:+.2f} s, {p.participants} each: power {p.power:.2f}" for p in found
    ]
    deliver("\n".join(lines))


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
