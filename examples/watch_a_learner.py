"""A learner between its lessons: ``python examples/watch_a_learner.py``.

It learns for a while in the arena, plays an episode that can be watched, learns on, and so forth. ``--render human``
shows a page in the browser, in real time (extra ``web``); ``ansi`` draws the last picture of every episode in the
terminal.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import gymnasium

import rcss_hat
import rcss_hat.envs  # registers the environment
from rcss_hat.hat.policy import TeamPolicy

CYCLES_PER_HOUR = 36_000


def show(env: gymnasium.Env, policy: TeamPolicy, seed: int) -> int:
    """Let what was learned so far play an episode; returns its duration in cycles."""
    _, info = env.reset(seed=seed)
    while True:
        decide, _ = policy(info["keeper"] - 1)
        action = decide(info["cycle"], info["status"], float(info["dt"]), env.unwrapped.state)
        picture = env.render() if env.render_mode == "ansi" else None
        _, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            if picture:
                print(picture)
            return int(info["duration"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", choices=["human", "ansi"], default="human")
    parser.add_argument("--lessons", type=int, default=5)
    parser.add_argument("--hours", type=float, default=1.0, help="simulated, of a lesson")
    parser.add_argument("--seed", type=int, default=1)
    o = parser.parse_args()
    config = rcss_hat.RunConfig(
        task=rcss_hat.Task(), learner=rcss_hat.load_config("best"), method=rcss_hat.METHODS["no-prior"](),
        seed=o.seed, hours=o.lessons * o.hours,
    )  # fmt: skip
    env = gymnasium.make("rcss_hat/Keepaway-v0", render_mode=o.render, disable_env_checker=True)
    with tempfile.TemporaryDirectory() as folder, rcss_hat.TrainingRun.create(Path(folder), config) as run:
        for lesson in range(1, o.lessons + 1):
            run.train(until=round(lesson * o.hours * CYCLES_PER_HOUR))
            policy = rcss_hat.load_policy(folder, 3, 2, seed=o.seed)
            print(f"after {run.hours:.1f} h: mean of training {run.windowed_mean:.1f} s; now it plays ...", flush=True)
            print(f"... for {show(env, policy, o.seed + lesson) / 10:.1f} s")
    env.close()


if __name__ == "__main__":
    main()
