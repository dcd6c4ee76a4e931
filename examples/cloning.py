"""Behaviour cloning and DAgger with a tree of scikit-learn: ``python examples/cloning.py``.

The expert is the hand-coded policy. Cloning learns from its own episodes; DAgger (Ross, Gordon and Bagnell, 2011) lets
the learner play and asks the expert what it would have done there. Both are a few lines, for the library imitation does
not install beside Gymnasium 1.
"""

from __future__ import annotations

import argparse

import curves
import joblib
import numpy as np
from sklearn.tree import DecisionTreeClassifier

from rcss_hat.envs.vector import KeepawayVectorEnv
from rcss_hat.keepaway.policies import hand
from rcss_hat.keepaway.task import Task

TASK = Task()


def expert(states: np.ndarray) -> np.ndarray:
    return np.array([hand(state, TASK.keepers, TASK.takers) for state in states.astype(np.float64)])


def gathered(choose: curves.Choose, decisions: int, seed: int) -> np.ndarray:
    """Let somebody play and return the states of the decisions."""
    envs = KeepawayVectorEnv(4, autoreset_mode="SameStep")
    seen, _ = envs.reset(seed=seed)
    states = []
    for _ in range(decisions // 4):
        states.append(seen)
        seen, *_ = envs.step(choose(seen))
    return np.concatenate(states)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--decisions", type=int, default=400, help="per round")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--save", help="write DAgger's last tree there, for rcss-hat play --keepers tree.joblib")
    o = parser.parse_args()
    for name in ("behaviour-cloning", "dagger"):
        X, rows, tree = np.empty((0, 13), dtype=np.float32), [], None
        for k in range(o.rounds):
            player = tree.predict if name == "dagger" and tree is not None else expert
            X = np.concatenate([X, gathered(player, o.decisions, o.seed * 100 + k)])
            tree = DecisionTreeClassifier(min_samples_leaf=5, random_state=o.seed).fit(X, expert(X))
            rows.append((len(X), curves.mean_duration(tree.predict)))
        curves.write_curve(name, rows, f"{name}, tree of the hand-coded policy, seed {o.seed}", "decisions")
    if o.save:
        joblib.dump(tree, o.save)
    print(f"the expert: {curves.mean_duration(expert):.2f} s")


if __name__ == "__main__":
    main()
