"""Running trials in parallel: on this machine by joblib, elsewhere on a Dask cluster.

Both run the same function on the same jobs. A trial that has ended is on the disk before the next result is waited for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed

from rcss_hat.experiments.training import CHECKPOINT_S
from rcss_hat.experiments.trial import Job, keep_files, run_trial, run_trial_away

Result = dict[str, Any]


class ClusterError(RuntimeError):
    """A Dask cluster that cannot be used; the message says what would help."""


def run_locally(
    jobs: Sequence[Job], folders: Sequence[Path], processes: int, checkpoint_s: float = CHECKPOINT_S
) -> Iterator[Result]:
    """Run trials in processes of this machine, yielding results as they come.

    Parameters
    ----------
    jobs : sequence of Job
    folders : sequence of Path
        One per job.
    processes : int
        1: in this process.
    checkpoint_s : float
        See `rcss_hat.experiments.training.TrainingRun.train`.
    """
    if not jobs:
        return
    warm_up()
    parallel = Parallel(n_jobs=processes, return_as="generator_unordered")
    with closing(
        parallel(delayed(run_trial)(*item, checkpoint_s) for item in zip(jobs, folders, strict=True))
    ) as found:
        yield from found


def run_on_cluster(jobs: Sequence[Job], folders: Sequence[Path], address: str) -> Iterator[Result]:
    """Run trials on a Dask cluster, yielding results as they come; needs the extra ``rcss-hat[dask]``.

    The workers need this package at the same version, but no common disk: files come back with the results.

    Parameters
    ----------
    jobs, folders
        See `run_locally`; the folders are of this machine.
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    ClusterError
        When Dask is not installed, there is no scheduler or worker, or a worker has another version.
    """
    try:
        from distributed import Client, as_completed
    except ImportError as problem:
        raise ClusterError("Dask is not installed: pip install 'rcss-hat[dask]'") from problem
    if not jobs:
        return
    try:
        client = Client(address, timeout=5)
    except (OSError, TimeoutError, ValueError) as problem:
        raise ClusterError(f"no Dask scheduler answers at {address}: {problem}") from problem
    with client:
        _check_workers(client, address)
        futures = client.map(run_trial_away, jobs, pure=False)
        where = dict(zip((future.key for future in futures), folders, strict=True))
        try:
            for future in as_completed(futures):
                result, contents = future.result()
                keep_files(where[future.key], contents)
                yield result
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


Runner = Callable[[Sequence[Job], Sequence[Path]], Iterator[Result]]
"""`run_locally` or `run_on_cluster` with their last arguments filled in."""
