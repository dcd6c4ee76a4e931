"""PPO and DQN of Stable-Baselines3, with and without a guide: ``python examples/deep_q_and_ppo.py ppo|dqn|jsrl``.

DQN discounts by the cycles that a decision took (a semi-Markov decision process): the reward of a step is the sum of
``g**i``, its discount ``g**dt``. ``jsrl`` is DQN with a jump-start (Uchendu et al., 2023): at first a guide, the
decision list of the paper, plays the first decisions of every episode, then fewer and fewer of them.
"""

from __future__ import annotations

import argparse
from typing import Any

import curves
import numpy as np
import torch
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.type_aliases import ReplayBufferSamples

from rcss_hat.envs.sb3 import KeepawayVecEnv
from rcss_hat.hat.decision_list import PAPER_RULES

GAMMA = 0.99
"""Per cycle."""


class SmdpReplayBuffer(ReplayBuffer):
    """Keeps the discount of every step, which `DQN` then uses instead of a fixed one."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.discounts = np.zeros((self.buffer_size, self.n_envs), dtype=np.float32)

    def add(self, obs: Any, next_obs: Any, action: Any, reward: Any, done: Any, infos: list[dict[str, Any]]) -> None:
        self.discounts[self.pos] = [info["discount"] for info in infos]
        played = np.array([info.get("action", chosen) for info, chosen in zip(infos, action.ravel(), strict=True)])
        super().add(obs, next_obs, played.reshape(action.shape), reward, done, infos)

    def _get_samples(self, batch_inds: np.ndarray, env: Any = None) -> ReplayBufferSamples:
        state = np.random.get_state()  # noqa: NPY002 (the parent draws from it which match each sample is of)
        found = super()._get_samples(batch_inds, env)
        np.random.set_state(state)  # noqa: NPY002
        matches = np.random.randint(0, high=self.n_envs, size=(len(batch_inds),))  # noqa: NPY002
        return found._replace(discounts=self.to_torch(self.discounts[batch_inds, matches].reshape(-1, 1)))


class GuidedVecEnv(KeepawayVecEnv):
    """In the first decisions of an episode the guide's actions are played; the learner learns from them, too."""

    horizon = 0

    def step_async(self, actions: np.ndarray) -> None:
        guided = self._lengths < self.horizon
        if guided.any():
            actions = np.array(actions)
            states = self.env.matches.batch.states
            for i in np.flatnonzero(guided):
                actions[i] = PAPER_RULES.predict(states[i : i + 1])[0]
        super().step_async(actions)

    def step_wait(self) -> Any:
        """Tell the learner what was played."""
        observations, rewards, dones, infos = super().step_wait()
        for info, action in zip(infos, self._actions.tolist(), strict=True):
            info["action"] = action
        return observations, rewards, dones, infos


def make(kind: str, envs: KeepawayVecEnv, seed: int) -> Any:
    if kind == "ppo":
        return PPO("MlpPolicy", envs, n_steps=256, batch_size=512, n_epochs=5, gamma=0.98, ent_coef=0.01,
                   seed=seed, device="cpu")  # fmt: skip
    return DQN("MlpPolicy", envs, learning_rate=1e-3, buffer_size=50_000, learning_starts=500, batch_size=64,
               train_freq=1, gradient_steps=1, target_update_interval=500, exploration_fraction=0.5,
               exploration_final_eps=0.02, replay_buffer_class=SmdpReplayBuffer, seed=seed, device="cpu")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=["ppo", "dqn", "jsrl"])
    parser.add_argument("--steps", type=int, default=60_000)
    parser.add_argument("--points", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--save", help="write the model there, for rcss-hat play --keepers model.zip")
    o = parser.parse_args()
    torch.set_num_threads(1)
    settings: dict[str, Any] = {"normalize": True, "reward": "seconds"}
    if o.kind != "ppo":
        settings["discount"] = GAMMA
    envs = (GuidedVecEnv if o.kind == "jsrl" else KeepawayVecEnv)(8, **settings)
    envs.seed(o.seed)
    model = make(o.kind, envs, o.seed)

    def greedy(seen: np.ndarray) -> np.ndarray:
        return np.asarray(model.predict(seen, deterministic=True)[0])

    rows = [(0, curves.mean_duration(greedy, normalize=True))]

    def look(inside: dict[str, Any], around: dict[str, Any]) -> bool:
        """Evaluate now and then, and let the guide play less and less."""
        done = model.num_timesteps
        if isinstance(envs, GuidedVecEnv):
            envs.horizon = round(30 * max(0.0, 1.0 - 2.0 * done / o.steps))
        if done >= len(rows) * (o.steps // o.points):
            rows.append((done, curves.mean_duration(greedy, normalize=True)))
        return True

    model.learn(o.steps, callback=look)
    curves.write_curve(o.kind, rows, f"{o.kind} of Stable-Baselines3, greedy, seed {o.seed}, 200 episodes a point")
    if o.save:
        model.save(o.save)


if __name__ == "__main__":
    main()
