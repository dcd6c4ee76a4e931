"""The vector environment of Stable-Baselines3."""

from __future__ import annotations

import numpy as np
import pytest

sb3 = pytest.importorskip("stable_baselines3")
from rcss_hat.envs.sb3 import KeepawayVecEnv  # noqa: E402 (needs what may be missing)

pytestmark = [pytest.mark.compiled, pytest.mark.slow]


def test_infos_hold_what_a_monitor_would_tell() -> None:
    envs = KeepawayVecEnv(3, max_cycles=30)
    envs.seed(2)
    seen = envs.reset()
    assert seen.shape == (3, 13) and seen.dtype == np.float32
    returns, lengths, cut = np.zeros(3), np.zeros(3, dtype=int), set()
    for _ in range(60):
        seen, rewards, dones, infos = envs.step(np.zeros(3, dtype=int))
        returns += rewards
        lengths += 1
        for i in np.flatnonzero(dones):
            episode = infos[i]["episode"]
            assert (episode["r"], episode["l"]) == (returns[i], lengths[i]) and episode["t"] > 0.0
            assert episode["r"] == infos[i]["duration"]
            assert infos[i]["terminal_observation"].shape == (13,)
            assert infos[i]["TimeLimit.truncated"] == (infos[i]["reason"] == "max_cycles")
            cut.add(infos[i]["reason"])
            returns[i], lengths[i] = 0.0, 0
        assert all("episode" in info for info, done in zip(infos, dones, strict=True) if done)
    assert len(cut) > 1
    assert envs.get_attr("task", [0, 2]) == [envs.env.task] * 2
    assert envs.env_is_wrapped(sb3.common.monitor.Monitor) == [False] * 3
    envs.close()


def test_the_same_seed_is_the_same_match() -> None:
    first, second = KeepawayVecEnv(2), KeepawayVecEnv(2)
    for envs in (first, second):
        envs.seed(5)
    np.testing.assert_array_equal(first.reset(), second.reset())


def test_ppo_learns() -> None:
    torch = pytest.importorskip("torch")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        envs = KeepawayVecEnv(8, normalize=True)
        model = sb3.PPO("MlpPolicy", envs, n_steps=125, batch_size=250, n_epochs=2, seed=1, device="cpu")
        model.learn(2_000)
    finally:
        torch.set_num_threads(threads)
    assert model.num_timesteps == 2_000
    assert len(model.ep_info_buffer) > 10
