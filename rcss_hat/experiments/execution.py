"""Running trials in parallel: on this machine by joblib, elsewhere on a Dask cluster.

Both run the same function on the same jobs. A trial that has ended is on the disk before the next result is waited for.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from rcss_hat.experiments.training import CHECKPOINT_S
from rcss_hat.experiments.trial import Job, keep_files, run_trial, run_trial_away
from rcss_hat.experiments.venue import Supply
from rcss_hat.numeric.compiling import compiling
from rcss_hat.stage.terms import silent
from rcss_hat.system.workers import in_parallel

Result = dict[str, Any]
Work = Iterable[tuple[Job, Path]]
"""Trials, and the folders of this machine that they belong in."""


class ClusterError(RuntimeError):
    """A Dask cluster that cannot be used; the message says what would help."""


def run_locally(
    work: Work,
    processes: int,
    checkpoint_s: float = CHECKPOINT_S,
    say: Callable[[str], None] = silent,
    supply: Supply | None = None,
) -> Iterator[Result]:
    """Run trials in processes of this machine, yielding results as they come.

    Parameters
    ----------
    work : iterable of (Job, Path)
        Taken as processes become free.
    processes : int
        1: in this process.
    checkpoint_s : float
        See `rcss_hat.experiments.training.TrainingRun.train`.
    say : callable
        Told, now and then, what is being compiled.
    supply : Supply, optional
        Servers, for trials that are played on some.
    """
    rest = iter(work)
    first = list(itertools.islice(rest, 1))
    if not first:
        return
    with compiling(say, "the players and the simulation", "rcss_hat.arena.loop"):
        warm_up()
    trials = ((job, folder, checkpoint_s, supply) for job, folder in itertools.chain(first, rest))
    yield from in_parallel(run_trial, trials, processes)


def run_on_cluster(work: Work, address: str, supply: Supply | None = None) -> Iterator[Result]:
    """Run trials on a Dask cluster, yielding results as they come; needs the extra ``rcss-hat[dask]``.

    The workers need this package at the same version, but no common disk: files come back with the results.

    Parameters
    ----------
    work : iterable of (Job, Path)
        See `run_locally`.
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``.
    supply : Supply, optional
        Of trials on ``real``: the rcssserver that each worker starts, one for each of its threads.

    Raises
    ------
    ClusterError
        When Dask is not installed, there is no scheduler or worker, a worker has another version, or workers die.
    """
    try:
        from distributed import Client, KilledWorker, as_completed
    except ImportError as problem:
        raise ClusterError("Dask is not installed: pip install 'rcss-hat[dask]'") from problem
    trials = list(work)
    if not trials:
        return
    try:
        client = Client(address, timeout=5)
    except (OSError, TimeoutError, ValueError) as problem:
        raise ClusterError(f"no Dask scheduler answers at {address}: {problem}") from problem
    with client:
        _check_workers(client, address)
        futures = client.map(run_trial_away, [job for job, _ in trials], supply=supply, pure=False)
        where = {future.key: folder for future, (_, folder) in zip(futures, trials, strict=True)}
        try:
            for future in as_completed(futures):
                result, contents = future.result()
                keep_files(where[future.key], contents)
                yield result
        except KilledWorker as problem:
            raise ClusterError(f"a trial ended every Dask worker that ran it: {problem}") from problem
        finally:
            client.cancel(futures)


def _check_workers(client: Any, address: str) -> None:
    found = client.run(_version)
    if not found:
        raise ClusterError(f"the Dask scheduler at {address} has no workers")
    for worker, version in found.items():
        if version != _version():
            raise ClusterError(f"Dask worker {worker} has rcss-hat {version}, this machine {_version()}")


def _version() -> str:
    from rcss_hat import __version__

    return __version__


def warm_up() -> None:
    """Compile everything a trial runs, so that worker processes find it in the cache instead of racing to fill it."""
    from rcss_hat.experiments.evaluation import evaluate, frozen_policy
    from rcss_hat.hat.decision_list import PAPER_RULES
    from rcss_hat.hat.transfer import PPR, Learners
    from rcss_hat.keepaway.task import Task
    from rcss_hat.learning.config import LearnerConfig

    learners = Learners.create(LearnerConfig(), PPR(), seed=0)
    evaluate(frozen_policy(learners, PAPER_RULES, 0), Task(), 0, 1)


Runner = Callable[[Work], Iterator[Result]]
"""`run_locally` or `run_on_cluster` with their last arguments filled in."""
