"""An environment on a real rcssserver, where one is found on PATH (or named by RCSSSERVER)."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from rcss_hat.envs import KeepawayEnv
from rcss_hat.stage.servers import find_executable

EXECUTABLE = find_executable(os.environ.get("RCSSSERVER"))
pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(EXECUTABLE is None, reason="no rcssserver on PATH; name one by the variable RCSSSERVER"),
]


def test_rewards_sum_up_to_the_durations_that_the_server_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(Path(EXECUTABLE or "").resolve().parent), prepend=os.pathsep)
    env = KeepawayEnv(stage="real")
    with pytest.warns(UserWarning, match="a seed decides what our players do"):
        env.reset(seed=1)
    for episode in range(4):
        if episode:
            env.reset()
        total, over = 0.0, False
        while not over:
            seen, reward, over, truncated, info = env.step(1)
            assert env.observation_space.contains(seen)
            assert not truncated, info
            total += reward
        assert total == info["duration"]
        assert info["reason"] in ("out", "taken")
        assert info["missed"] == 0
    env.close()


def test_a_monitor_shows_where_the_keeper_that_decides_believes_everybody_to_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", str(Path(EXECUTABLE or "").resolve().parent), prepend=os.pathsep)
    env = KeepawayEnv(stage="real", truth=True, render_mode="rgb_array")
    with pytest.warns(UserWarning, match="a seed decides what our players do"):
        seen, info = env.reset(seed=1)
    off = list[float]()
    for _ in range(40):
        me = info["keepers"][info["keeper"] - 1, :2]
        mates = sorted(np.hypot(*(other[:2] - me)) for other in info["keepers"])[1:]
        off += [*(seen[1:3] - mates), seen[0] - np.hypot(*me)]  # dist(K1,K2), dist(K1,K3), dist(K1,C)
        assert info["ball"].shape == (4,) and env.render().shape == (400, 400, 3)
        seen, _, over, _, info = env.step(1)
        if over:
            seen, info = env.reset()
    env.close()
    assert np.median(np.abs(off)) < 0.5
    assert np.quantile(np.abs(off), 0.9) < 2.0
