"""``rcss-hat experiment`` and ``rcss-hat report``: studies with many trials, and what they say."""

from __future__ import annotations

import json
import os
import shlex
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import INTERRUPTED, Target, deliver, packed, plain_errors, progress_bar, say
from rcss_hat.stage.place import ARENA, PLACES, REAL, parse_address

if TYPE_CHECKING:
    from rcss_hat.experiments.execution import Work
    from rcss_hat.experiments.experiment import Experiment
    from rcss_hat.experiments.venue import Supply

TELL_S, MOST_TOLD = 5.0, 4
"""Seconds between two words on trials that are being played on servers, and how many of them are named."""


def _addresses(context: click.Context, param: click.Parameter, value: str | None) -> tuple[str, ...]:
    """Read addresses that are separated by commas, each only once: a server plays one match at a time."""
    texts = [text.strip() for text in (value or "").split(",") if text.strip()]
    try:
        addresses = [f"{host}:{port}" for host, port in map(parse_address, texts)]
    except ValueError as problem:
        raise click.BadParameter(str(problem)) from problem
    if len(set(addresses)) < len(addresses):
        raise click.BadParameter("a server is named twice; it plays one match at a time")
    return tuple(addresses)


@dataclass(frozen=True)
class Options:
    """What ``experiment`` is told, beside the study."""

    out: Path | None
    trials: int | None
    hours: float | None
    learner: str | None
    only: tuple[str, ...]
    stage: str | None
    executable: str | None
    servers: tuple[str, ...]
    jobs: int | None
    dask: str | None
    no_report: bool
    as_json: bool
    quiet: bool


@click.command()
@click.argument("study")
@click.option("--out", type=Target(folder=True), help="Folder.  [default: results/STUDY]")
@click.option("--trials", type=click.IntRange(1), default=None, help="Instead of those of the study.")
@click.option("--hours", type=click.FloatRange(0, min_open=True), default=None, help="Instead of those of the study.")
@click.option("--learner", metavar="PRESET|FILE", default=None, help="Instead of those of the study.")
@click.option("--only", multiple=True, metavar="CONDITION", help="Some conditions only; repeatable.")
@click.option("--on", "stage", type=click.Choice(PLACES), default=None, help="Instead of where the study says.")
@click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
@click.option(
    "--servers", callback=_addresses, metavar="HOST:PORT,...", help="Running servers to use, instead of starting some."
)
@click.option("--jobs", type=click.IntRange(1, 1024), default=None, help="Trials at a time here.  [default: all cores]")
@click.option("--dask", metavar="ADDRESS", default=None, help="Scheduler of a Dask cluster to run the trials on.")
@click.option("--no-report", is_flag=True, help="Only run.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
@packed(Options)
def experiment(study: str, options: Options) -> None:
    """Run the trials of an experiment, in parallel and resumable, and write its report.

    STUDY is a study of the package (paper, methods, real, size-4v3, sets, rounds), a TOML file of the same form, or the
    folder of a study with people: one condition per participant, per group, of the best games and of all together.
    The same command goes on after a stop, and only redraws the report when everything has been run.

    On servers every trial starts its own; one that dies or hangs is replaced, and the trial goes on where it was.

    \b
    Example:
      rcss-hat experiment paper --jobs 2 --out results/paper
      rcss-hat experiment paper --trials 3 --hours 10 --only no-prior --only A-ppr --out results/quick
      rcss-hat experiment methods --on real --trials 3 --hours 10 --jobs 2 --out results/on-real
      rcss-hat experiment real --servers 10.0.0.2:6000,10.0.0.3:6000
      rcss-hat experiment my-study.toml --dask tcp://10.0.0.1:8786
    """
    from rcss_hat.experiments.execution import ClusterError, run_locally, run_on_cluster
    from rcss_hat.experiments.experiment import Experiment, ExperimentError
    from rcss_hat.experiments.run_folder import TrainingError
    from rcss_hat.experiments.study import StudyError
    from rcss_hat.inputs import FileFormatError

    if not options.no_report:
        import rcss_hat.experiments.reporting  # noqa: F401 (what it lacks is said now, not after hours of work)

    folder = options.out or Path("results") / Path(study).stem
    study = _of_people(study)
    processes = options.jobs or len(options.servers) or os.cpu_count() or 1
    if options.dask and options.servers:
        raise click.UsageError("--servers cannot be given with --dask: its workers start their own servers")
    command = shlex.join(["rcss-hat", *sys.argv[1:]]) if sys.argv[1:2] == ["experiment"] else ""
    with plain_errors(ExperimentError):
        try:
            run = Experiment.create(
                study, folder, options.trials, options.hours, options.only, command, options.learner, options.stage
            )
            supply = _supply(run, options)
        except StudyError as error:
            raise click.UsageError(str(error)) from error

    def runner(work: Work) -> Iterator[dict[str, Any]]:
        if options.dask:
            return run_on_cluster(work, options.dask, supply)
        return run_locally(work, processes, say=say, supply=supply)

    hidden = options.quiet or options.as_json
    stopped = None
    with plain_errors(StudyError, ExperimentError, TrainingError, ClusterError, FileFormatError):
        try:
            with progress_bar("demonstration sets", len(run.used_sets()), "sets", hidden) as bar:
                run.prepare_sets(processes, lambda ready, _: bar(ready))
            _run(run, runner, hidden)
        except KeyboardInterrupt:
            stopped = INTERRUPTED
        except OSError as error:  # a full disk, for example: what has been finished is told and reported all the same
            stopped = str(error)
        place, pages = _report_of(run) if not options.no_report and run.finished else (None, [])
        if stopped:
            missing = run.n_trials - run.finished
            click.echo(f"Error: {stopped}; the same command goes on: {missing} trials are missing", err=True)
        text = json.dumps(_summary(run, pages)) if options.as_json else _told(run, pages)
        deliver(text, (place, lambda _: _write_report(run)))
    if stopped:
        sys.exit(1)


def _supply(run: Experiment, options: Options) -> Supply:
    """Check that the trials can have their servers, and say which."""
    from rcss_hat.experiments.venue import Supply
    from rcss_hat.stage.servers import find_executable

    stages = {condition.stage for condition in run.study.conditions.values()}
    if options.servers and stages == {ARENA}:
        raise click.UsageError("--servers are not used by this study: it is played in the arena (--on real)")
    if options.dask and stages - set(PLACES):
        raise click.UsageError("a study that names running servers (stage = HOST:PORT) is not for --dask")
    own = REAL in stages and not (options.servers or options.dask)
    if own and find_executable(options.executable) is None:
        raise click.UsageError(
            f"no executable {options.executable or 'rcssserver'!r} was found; give --executable PATH, or --on fake"
        )
    return Supply(options.executable, options.servers, run.folder / "servers")


def _of_people(study: str) -> str:
    """Return the file of the experiment that belongs to the folder of a study with people; else what was given."""
    from rcss_hat.inputs import FileFormatError

    if not (Path(study) / "study-1.json").is_file():
        return study
    from rcss_hat.studies.folder import StudyFolder
    from rcss_hat.studies.learning import Training, write_experiment

    with plain_errors(FileFormatError):
        return str(write_experiment(StudyFolder(Path(study)), Training()))


def _report_of(run: Experiment) -> tuple[Path, list[Path]]:
    """Return where the report of an experiment goes, and its pages."""
    from rcss_hat.experiments.document import pages_in
    from rcss_hat.experiments.reporting import report_folder

    return report_folder(run), pages_in(report_folder(run))


def _write_report(run: Experiment) -> None:
    from rcss_hat.experiments.reporting import write_report

    write_report(run)


def _run(run: Experiment, runner: Any, hidden: bool) -> None:
    with progress_bar(run.study.title, run.n_trials, "trials", hidden) as bar, _telling(run, bar):
        bar(run.finished)
        for result in run.run(runner):
            done = run.finished
            greedy = f", {result['greedy']['mean_s']:.1f} s" if result["greedy"] else ""
            bar(done, f"{result['condition']} {result['trial']}{greedy}")


@contextmanager
def _telling(run: Experiment, bar: Callable[..., None]) -> Iterator[None]:
    """Say every few seconds how far trials on servers are: one takes many minutes."""
    over = threading.Event()

    def tell() -> None:
        while not over.wait(TELL_S):
            told = _progress(run)
            if told:
                bar(run.finished, told)

    teller = threading.Thread(target=tell, name="progress", daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()


def _progress(run: Experiment) -> str:
    """Name the trials that are being played on servers, with the hours they have learned; a few of them."""
    from rcss_hat.experiments.episode_log import last_hour
    from rcss_hat.experiments.training import EPISODES
    from rcss_hat.experiments.venue import running_matches

    parts = []
    for name, match in running_matches(run.folder)[:MOST_TOLD]:
        hour = last_hour(run.folder / "trials" / name / EPISODES) if match.what == "training" else None
        parts.append(f"{name} {match.what}" if hour is None else f"{name} {hour:.1f} h")
    return "; ".join(parts)


def _summary(run: Experiment, pages: list[Path]) -> dict[str, Any]:
    return {
        "folder": str(run.folder),
        "study": run.study.title,
        "trials": run.n_trials,
        "finished": run.finished,
        "seconds": run.info["seconds"],
        "report": [str(page) for page in pages],
    }


def _told(run: Experiment, pages: list[Path]) -> str:
    head = f"{run.study.title}: {run.finished} of {run.n_trials} trials in {run.folder}"
    return "\n".join([head, *(f"  {page}" for page in pages)])


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=Target(folder=True), help="Where to.  [default: FOLDER/report]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def report(folder: Path, out: Path | None, as_json: bool) -> None:
    """Write tables, statistics and figures of an experiment, finished or not.

    Markdown, CSV and one self-contained HTML page. The claims of the study and their verdicts are printed.

    \b
    Example:
      rcss-hat report results/paper
      rcss-hat report results/paper --out docs/results/paper
    """
    from rcss_hat.experiments.document import pages_in
    from rcss_hat.experiments.experiment import Experiment, ExperimentError
    from rcss_hat.experiments.reporting import report_folder, write_report
    from rcss_hat.experiments.results import Results

    with plain_errors(ExperimentError, ValueError):
        run = Experiment.open(folder)
        if not run.finished:
            raise ExperimentError(f"no trial in {folder} has ended yet")
        place = out or report_folder(run)
        pages = pages_in(place)
        verdicts = Results(run).verdicts()
        claims = [{"claim": v.claim.text, "verdict": v.verdict} for v in verdicts]
        found = {"report": list(map(str, pages)), "trials": run.n_trials, "finished": run.finished, "claims": claims}
        lines = [_told(run, pages), *(f"  {v.verdict}: {v.claim.text}" for v in verdicts)]
        deliver(json.dumps(found) if as_json else "\n".join(lines), (place, lambda path: write_report(run, path)))
