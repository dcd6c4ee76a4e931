"""The trials of a study on a Dask cluster: ``python examples/study_on_dask.py [tcp://SCHEDULER:8786]``.

Without an address it makes a cluster of its own on this machine. What it runs is what ``rcss-hat experiment --dask``
runs.
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from distributed import LocalCluster

STUDY = """\
title = "How many episodes does a demonstration need?"
seed = 1
baseline = "alone"

[defaults]
hours = {hours}
trials = {trials}
evaluation_episodes = {evaluations}

[demonstrations.all]
package = "A"

[demonstrations.few]
of = ["all"]
pick = "first"
episodes = 5

[[condition]]
name = "alone"

[[condition]]
name = "few"
method = "ppr"
demonstrations = "few"

[[condition]]
name = "all"
method = "ppr"
demonstrations = "all"
"""


@contextlib.contextmanager
def scheduler(address: str | None, workers: int) -> Iterator[str]:
    if address:
        yield address
        return
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("address", nargs="?", help="of a scheduler")
    parser.add_argument("--workers", type=int, default=2, help="of a cluster of our own")
    parser.add_argument("--hours", type=float, default=2.0)
    parser.add_argument("--trials", type=int, default=3)
    parser.add_argument("--evaluations", type=int, default=200, help="episodes of each")
    parser.add_argument("--out", type=Path, default=Path("out/study-on-dask"))
    o = parser.parse_args()
    o.out.mkdir(parents=True, exist_ok=True)
    study = o.out / "study.toml"
    study.write_text(STUDY.format(hours=o.hours, trials=o.trials, evaluations=o.evaluations))
    with scheduler(o.address, o.workers) as address:
        command = [
            sys.executable,
            "-m",
            "rcss_hat",
            "experiment",
            str(study),
            "--dask",
            address,
            "--out",
            str(o.out / "trials"),
        ]
        sys.exit(subprocess.run(command, check=False).returncode)


if __name__ == "__main__":
    main()
