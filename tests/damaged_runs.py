"""Reads runs whose checkpoint is damaged, and plays on what is accepted: ``damaged_runs.py FOLDER TIMES``.

The file itself is damaged, and, as often, numbers inside of arrays whose file is sound. Prints how many were refused
and how many played on; ``FOLDER/log.txt`` says in its last line what was tried when the process died.
"""

from __future__ import annotations

import faulthandler
import random
import sys
from pathlib import Path

import numpy as np
from damage import damaged

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.experiments.run_folder import CONFIG, RunConfig, TrainingError
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.hat.policy import RUN_WEIGHTS
from rcss_hat.hat.transfer import make_method
from rcss_hat.keepaway.task import Task
from rcss_hat.learning.checkpoint import load_checkpoint, save_checkpoint
from rcss_hat.learning.config import LearnerConfig

CYCLES = 40
"""Played on after every damage that was accepted."""
WHOLE = (0, 1, -1, 2, 7, 22, 60, 96, 255, 1000, 10**6, 2**31 - 1, -(2**31), 2**53)
VALUES = (*WHOLE, np.nan, np.inf, -np.inf, 1e30, 1e300)


def main(folder: Path, times: int) -> None:
    """Damage, read, play."""
    run_folder = folder / "run"
    config = RunConfig(
        task=Task(),
        learner=LearnerConfig(tilings=2, lambda_=0.9, alpha=0.1),
        method=make_method("no-prior"),
        seed=3,
        hours=400 / 36_000,
    )
    TrainingRun.create(run_folder, config).train()
    path = run_folder / RUN_WEIGHTS
    whole, log = path.read_bytes(), run_folder / "episodes.csv"
    episodes = log.read_bytes()
    saved = load_checkpoint(path)
    counts = [0, 0]
    with (folder / "log.txt").open("w") as tried:
        for k in range(2 * times):
            seed = f"run {k}"
            if k < times:
                path.write_bytes(damaged(whole, seed))
            else:
                arrays, header = wrong_numbers(saved.arrays, saved.header, seed)
                save_checkpoint(path, header, arrays)
            log.write_bytes(episodes)
            print(seed, file=tried, flush=True)
            counts[play_on(run_folder)] += 1
    assert (run_folder / CONFIG).exists()
    print(*counts)


def play_on(folder: Path) -> bool:
    """Open the run and play some cycles; false when it was refused."""
    before = (folder / "episodes.csv").read_bytes()
    try:
        run = TrainingRun.open(folder)
    except TrainingError as error:
        assert "\n" not in str(error) and len(str(error)) < 700, error
        assert (folder / "episodes.csv").read_bytes() == before, "a run that is refused stays as it is"
        return False
    match = ArenaMatch(run.config.task, run.config.seed, run.policy)
    match.restore(run._arena)
    for _ in match.advance(cycles=match.cycle + CYCLES):
        pass
    return True


def wrong_numbers(arrays: dict[str, np.ndarray], header: dict, seed: str) -> tuple[dict[str, np.ndarray], dict]:
    """Put wrong numbers into one to three places of arrays and header."""
    rng = random.Random(seed)
    arrays = {name: array.copy() for name, array in arrays.items()}
    header = {**header, "run": dict(header["run"])}
    for _ in range(rng.choice((1, 1, 2, 3))):
        if rng.random() < 0.1:
            part = header["run"] if isinstance(header["run"], dict) and rng.random() < 0.5 else header
            part[rng.choice(sorted(part))] = rng.choice((None, -1, 0, 7, 1e300, "x", [], {}, 10**30, True))
            continue
        array = arrays[rng.choice(sorted(arrays))]
        if array.dtype.names:
            array = array[rng.choice(array.dtype.names)]
        flat = array.reshape(-1)
        if not flat.size:
            continue
        at = rng.randrange(flat.size)
        with np.errstate(all="ignore"):
            if rng.random() < 0.3:
                noise = np.frombuffer(rng.randbytes(flat.itemsize), dtype=flat.dtype)
                flat[at : at + 1] = noise
            else:
                flat[at] = np.array(rng.choice(VALUES), dtype=np.float64).astype(flat.dtype)
        array[...] = flat.reshape(array.shape)
    return arrays, header


if __name__ == "__main__":
    faulthandler.enable()
    main(Path(sys.argv[1]), int(sys.argv[2]))
