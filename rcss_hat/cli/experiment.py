"""``rcss-hat experiment`` and ``rcss-hat report``: studies with many trials, and what they say."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import fail, plain_errors, progress_bar

if TYPE_CHECKING:
    from rcss_hat.experiments.experiment import Experiment
    from rcss_hat.experiments.trial import Job


@click.command()
@click.argument("study")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder.  [default: results/STUDY]")
@click.option("--trials", type=click.IntRange(1), default=None, help="Instead of those of the study.")
@click.option("--hours", type=click.FloatRange(0, min_open=True), default=None, help="Instead of those of the study.")
@click.option("--learner", metavar="PRESET|FILE", default=None, help="Instead of those of the study.")
@click.option("--only", multiple=True, metavar="CONDITION", help="Some conditions only; repeatable.")
@click.option("--jobs", type=click.IntRange(1), default=None, help="Trials at a time here.  [default: all cores]")
@click.option("--dask", metavar="ADDRESS", default=None, help="Scheduler of a Dask cluster to run the trials on.")
@click.option("--no-report", is_flag=True, help="Only run.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def experiment(
    study: str,
    out: Path | None,
    trials: int | None,
    hours: float | None,
    learner: str | None,
    only: tuple[str, ...],
    jobs: int | None,
    dask: str | None,
    no_report: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run the trials of an experiment, in parallel and resumable, and write its report.

    STUDY is a study of the package (paper, methods, size-4v3, sets, rounds) or a TOML file of the same form.
    The same command goes on after a stop, and only redraws the report when everything has been run.

    \b
    Example:
      rcss-hat experiment paper --jobs 2 --out results/paper
      rcss-hat experiment paper --trials 3 --hours 10 --only no-prior --only A-ppr --out results/quick
      rcss-hat experiment my-study.toml --dask tcp://10.0.0.1:8786
    """
    from rcss_hat.experiments.execution import ClusterError, run_locally, run_on_cluster
    from rcss_hat.experiments.experiment import Experiment, ExperimentError
    from rcss_hat.experiments.study import StudyError
    from rcss_hat.experiments.training import TrainingError

    folder = out or Path("results") / Path(study).stem
    processes = jobs or os.cpu_count() or 1
    command = shlex.join(["rcss-hat", *sys.argv[1:]]) if sys.argv[1:2] == ["experiment"] else ""
    try:
        run = Experiment.create(study, folder, trials, hours, only, command, learner)
    except StudyError as error:
        raise click.UsageError(str(error)) from error
    except ExperimentError as error:
        fail(str(error))

    def runner(work: Sequence[Job], folders: Sequence[Path]) -> Iterator[dict[str, Any]]:
        return run_on_cluster(work, folders, dask) if dask else run_locally(work, folders, processes)

    hidden = quiet or as_json
    interrupted = False
    with plain_errors(StudyError, ExperimentError, TrainingError, ClusterError):
        try:
            with progress_bar("demonstration sets", len(run.used_sets()), "sets", hidden) as bar:
                run.prepare_sets(processes, lambda ready, _: bar(ready))
            _run(run, runner, hidden)
        except KeyboardInterrupt:
            interrupted = True
        pages = [] if no_report else _report(run)
    _tell(run, pages, as_json)
    if interrupted:
        fail(f"interrupted; the same command goes on: {run.n_trials - run.finished} trials are missing")


def _run(run: Experiment, runner: Any, hidden: bool) -> None:
    done = run.finished
    with progress_bar(run.study.title, run.n_trials, "trials", hidden) as bar:
        bar(done, "compiling" if done < run.n_trials else "")
        for result in run.run(runner):
            done += 1
            greedy = f", {result['greedy']['mean_s']:.1f} s" if result["greedy"] else ""
            bar(done, f"{result['condition']} {result['trial']}{greedy}")


def _report(run: Experiment) -> list[Path]:
    from rcss_hat.experiments.reporting import write_report

    return write_report(run) if run.finished else []


def _tell(run: Experiment, pages: list[Path], as_json: bool) -> None:
    summary = {
        "folder": str(run.folder),
        "study": run.study.title,
        "trials": run.n_trials,
        "finished": run.finished,
        "seconds": run.info["seconds"],
        "report": [str(page) for page in pages],
    }
    if as_json:
        click.echo(json.dumps(summary))
        return
    click.echo(f"{run.study.title}: {run.finished} of {run.n_trials} trials in {run.folder}")
    for page in pages:
        click.echo(f"  {page}")


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Where to.  [default: FOLDER/report]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def report(folder: Path, out: Path | None, as_json: bool) -> None:
    """Write tables, statistics and figures of an experiment, finished or not.

    Markdown, CSV and one self-contained HTML page. The claims of the study and their verdicts are printed.

    \b
    Example:
      rcss-hat report results/paper
      rcss-hat report results/paper --out docs/results/paper
    """
    from rcss_hat.experiments.experiment import Experiment, ExperimentError
    from rcss_hat.experiments.reporting import write_report
    from rcss_hat.experiments.results import Results

    with plain_errors(ExperimentError, ValueError):
        run = Experiment.open(folder)
        pages = write_report(run, out)
        verdicts = Results(run).verdicts()
    if as_json:
        claims = [{"claim": v.claim.text, "verdict": v.verdict} for v in verdicts]
        pages_text = [str(page) for page in pages]
        click.echo(
            json.dumps({"report": pages_text, "trials": run.n_trials, "finished": run.finished, "claims": claims})
        )
        return
    _tell(run, pages, as_json=False)
    for verdict in verdicts:
        click.echo(f"  {verdict.verdict}: {verdict.claim.text}")
