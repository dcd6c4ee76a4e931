"""Keepaway for Gymnasium over UDP: the same as in the arena, and what only a server can do to it."""

from __future__ import annotations

import os
import random
import signal
import threading
import time
import warnings
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from quick_servers import QuickServer
from serving import serving

from rcss_hat.envs import KeepawayEnv, MatchFailed, eye
from rcss_hat.keepaway.task import Task

Trajectory = list[tuple[Any, ...]]


def comparable(info: dict[str, Any]) -> dict[str, Any]:
    return {name: value.tolist() if hasattr(value, "tolist") else value for name, value in info.items()}


def trajectory(stage: str, steps: int, options: dict[str, Any], seed: int = 3) -> Trajectory:
    """Play at random, through ends and resets, one of them in the middle of an episode."""
    env, draw = KeepawayEnv(stage=stage, **options), random.Random(1)
    try:
        seen, info = env.reset(seed=seed)
        told: Trajectory = [(seen.tolist(), comparable(info))]
        for k in range(steps):
            seen, reward, terminated, truncated, info = env.step(draw.randrange(3))
            told.append((seen.tolist(), reward, terminated, truncated, comparable(info)))
            if terminated or truncated or k == steps // 2:
                seen, info = env.reset()
                told.append((seen.tolist(), comparable(info)))
        return told
    finally:
        env.close()


def nobody_plays() -> bool:
    return not any(thread.name == "keepaway" for thread in threading.enumerate())


def block_k2(state: Any, info: dict[str, Any]) -> int:
    return 2 if info["taker"] == 1 else 0


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"vision": 90, "max_cycles": 30},
        {"per": "cycle", "max_cycles": 25},
        pytest.param(
            {"hold_cycles": 4, "takers": block_k2},
            marks=pytest.mark.xfail(
                strict=False,
                reason="takers in Python: on a busy machine one match in some twelve goes another way after a reset in "
                "the middle of an episode; see docs/reference/environments.md",
            ),
        ),
    ],
)
def test_the_same_seed_is_the_same_trajectory_as_in_the_arena(
    quick_servers: list[QuickServer], options: dict[str, Any]
) -> None:
    steps = 90 if "per" in options else 45
    mine = trajectory("arena", steps, options)
    assert trajectory("fake", steps, options) == mine
    assert sum(len(step) == 5 and (step[2] or step[3]) for step in mine) > 2
    assert nobody_plays()
    assert not quick_servers


def test_a_server_that_dies_truncates_and_the_next_reset_begins_another_match(quick_servers: list[QuickServer]) -> None:
    env = KeepawayEnv(stage="fake")
    env.reset(seed=1)
    quick_servers[0].die()
    truncated = False
    while not truncated:
        _, _, terminated, truncated, info = env.step(1)
        if terminated:
            env.reset()
    assert info["reason"] == "server"
    assert "exit code -9" in info["failure"]
    seen, info = env.reset()
    assert env.observation_space.contains(seen)
    assert info["number"] == 1 + env.skipped
    env.close()
    assert nobody_plays()


def test_ctrl_c_while_waiting_ends_the_match(quick_servers: list[QuickServer]) -> None:
    env = KeepawayEnv(stage="fake")
    env.reset(seed=1)
    playing = env._steps._playing  # type: ignore[attr-defined]
    waiting = playing.events.get

    def interrupted() -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        return waiting()

    playing.events = SimpleNamespace(get=interrupted, put=playing.events.put)
    with pytest.raises(KeyboardInterrupt):
        env.step(0)
    assert nobody_plays()
    assert not quick_servers
    env.reset()
    env.close()


def test_an_environment_that_is_forgotten_plays_no_longer(quick_servers: list[QuickServer]) -> None:
    env = KeepawayEnv(stage="fake")
    env.reset(seed=1)
    del env
    assert nobody_plays()


@pytest.mark.filterwarnings("error")
def test_a_match_can_be_given_up_before_it_has_begun(quick_servers: list[QuickServer]) -> None:
    env = KeepawayEnv(stage="fake")
    for k in range(6):
        env._steps.begin(1)
        time.sleep(0.004 * k)  # wherever its beginning has come to by then
        env.close()
        assert nobody_plays()
        assert not quick_servers


def test_a_running_server_is_played_on_and_what_differs_is_refused() -> None:
    with serving(Task(), 3) as server:
        stage = f"{server.host}:{server.port}"
        env = KeepawayEnv(stage=stage, field="25x20")
        with pytest.raises(MatchFailed, match="25x20"):
            env.reset()
        env = KeepawayEnv(stage=stage)
        with pytest.warns(UserWarning, match="a seed decides what our players do"):
            env.reset(seed=3)
        _, _, _, _, info = env.step(0)
        assert info["dt"] > 0
        env.close()
    assert nobody_plays()


def test_no_server_is_said_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(MatchFailed, match="no executable 'rcssserver' was found"):
        KeepawayEnv(stage="real").reset()


def seen(stage: str, steps: int) -> list[tuple[dict[str, Any], str]]:
    """What is true and what is drawn where play stands, through ends and resets."""
    env = KeepawayEnv(stage=stage, truth=True, render_mode="ansi")
    _, info = env.reset(seed=3)
    told = [(info, env.render())]
    for k in range(steps):
        _, _, terminated, _, info = env.step(k % 3)
        told.append((info, env.render()))
        if terminated:
            _, info = env.reset()
            told.append((info, env.render()))
    env.close()
    return told


def test_a_monitor_tells_where_everybody_is(quick_servers: list[QuickServer]) -> None:
    arena, fake = seen("arena", 40), seen("fake", 40)
    assert len(arena) > 42, "an episode has ended"
    for (true, drawn), (shown, same) in zip(arena, fake, strict=True):
        assert true["cycle"] == shown["cycle"] and drawn == same
        for name, shape in (("ball", (4,)), ("keepers", (3, 4)), ("takers", (2, 4))):
            assert shown[name].shape == shape
            np.testing.assert_allclose(shown[name], true[name], atol=5.1e-5)
    assert nobody_plays() and not quick_servers


def test_a_monitor_that_is_shown_nothing_ends_the_match(
    quick_servers: list[QuickServer], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(eye, "PATIENCE", 0.1)
    monkeypatch.setattr(eye.Eye, "look", lambda self, patience=0.0: time.sleep(patience))
    env = KeepawayEnv(stage="fake", truth=True)
    with pytest.raises(MatchFailed, match="does not show cycle"):
        env.reset(seed=1)
    env.close()


def test_players_are_not_placed_on_a_server(quick_servers: list[QuickServer]) -> None:
    env = KeepawayEnv(stage="fake")
    with pytest.raises(ValueError, match="arena"):
        env.reset(seed=1, options={"positions": {"ball": [0.0, 0.0]}})
    env.close()


def test_gymnasium_checks_it_without_a_warning(quick_servers: list[QuickServer]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(KeepawayEnv(stage="fake"), skip_render_check=True)
    assert nobody_plays()


def test_stable_baselines_checks_it(quick_servers: list[QuickServer]) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(KeepawayEnv(stage="fake", normalize=True))


def test_a_process_of_its_own_is_started_and_ended() -> None:
    mine = trajectory("fake", 12, {})
    assert mine == trajectory("arena", 12, {})
    assert nobody_plays()
