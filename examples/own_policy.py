"""A policy of one's own on three stages: ``python examples/own_policy.py [--real rcssserver]``.

In the arena and on the stand-in server the same seed is the same match, decision for decision. The real server cannot
be seeded; there the mean is what agrees.
"""

from __future__ import annotations

import argparse
import os
import shutil
from pathlib import Path

import numpy as np

import rcss_hat

NEAREST_TAKER, OPEN_K2, OPEN_K3 = 3, 11, 12
"""Places of these in the state of 3v2; docs/explanation/keepaway.md shows all 13."""


def policy(state: np.ndarray, info: dict[str, object]) -> int:
    """Hold until a taker is within 5 m, then pass to the team mate that stands more open."""
    if state[NEAREST_TAKER] > 5.0:
        return 0
    return 1 if state[OPEN_K2] >= state[OPEN_K3] else 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--real", metavar="RCSSSERVER", help="an rcssserver to play on as well")
    o = parser.parse_args()
    stages = ["arena", "fake"]
    if o.real:
        os.environ["PATH"] = f"{Path(shutil.which(o.real) or o.real).parent}{os.pathsep}{os.environ['PATH']}"
        stages.append("real")
    durations = {}
    for stage in stages:
        report = rcss_hat.play(policy, on=stage, episodes=o.episodes, seed=o.seed)
        durations[stage] = report.durations_s
        print(report.to_text())
    print(f"the same episodes in the arena and on the stand-in: {durations['arena'] == durations['fake']}")


if __name__ == "__main__":
    main()
