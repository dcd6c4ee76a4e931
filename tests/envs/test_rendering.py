"""Pictures, the page, a person's keys, and recording."""

from __future__ import annotations

import asyncio
import threading
import urllib.request
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from serving import serving

from rcss_hat.envs import KeepawayEnv, keepaway_v0
from rcss_hat.envs.game_log import RecordGameLog
from rcss_hat.envs.manual import ManualPolicy
from rcss_hat.envs.recording import RecordDemonstrations
from rcss_hat.envs.rendering import Renderer, draw
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.keepaway.task import Task
from rcss_hat.viewer.frames import Player, Setup, Snapshot
from rcss_hat.viewer.recording import read_recording


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let people see as fast as it is played."""
    usual = Renderer.__init__

    def quick(self: Renderer, *arguments: Any, **options: Any) -> None:
        usual(self, *arguments, **options)
        self._pace = lambda seconds: None

    monkeypatch.setattr(Renderer, "__init__", quick)


def test_a_picture_shows_everybody_where_he_is() -> None:
    players = (Player("l", 1, -5.0, 0.0, 0.0, 0.0, 8000.0, False), Player("r", 1, 5.0, 5.0, 90.0, 0.0, 8000.0, False))
    picture = draw(Snapshot(1, "play_on", (0.0, -5.0, 0.0, 0.0), players), Setup("here"), 240)
    assert picture.shape == (240, 240, 3)
    assert picture.dtype == np.uint8

    def at(x: float, y: float) -> tuple[int, ...]:
        return tuple(int(v) for v in picture[round((y + 12.0) * 10.0), round((x + 12.0) * 10.0)])

    assert at(-5.0, 0.0) == (38, 84, 214)
    assert at(5.0, 5.0) == (240, 190, 30)
    assert at(0.0, -5.0) == (255, 255, 255)
    assert at(-10.0, 3.0) == (235, 235, 235), "the line of the region"
    assert at(-4.4, 0.0) == (0, 0, 0), "he looks to the right"


def test_pixels_and_characters_show_the_last_cycle() -> None:
    pixels, text = KeepawayEnv(render_mode="rgb_array"), KeepawayEnv(render_mode="ansi")
    for env in (pixels, text):
        env.reset(seed=1)
    before = pixels.render()
    assert before.shape == (400, 400, 3)
    assert text.render().count("T") == 2
    for _ in range(3):
        pixels.step(1)
    assert (pixels.render() != before).any()
    assert KeepawayEnv().render() is None


def test_gymnasium_checks_pictures_without_a_warning(at_once: None) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("rcss_hat/Keepaway-v0", render_mode="rgb_array").unwrapped)
    assert not any(thread.name == "keepaway-page" for thread in threading.enumerate())


def test_people_see_it_in_the_browser_and_decide_by_keys(at_once: None, capsys: pytest.CaptureFixture[str]) -> None:
    env = gymnasium.make("rcss_hat/Keepaway-v0", render_mode="human")
    policy = ManualPolicy(env, waits=False)
    seen, info = env.reset(seed=1)
    link = capsys.readouterr().err.split()[-1]
    assert urllib.request.urlopen(link).status == 200
    assert policy(seen, info) == 0
    policy.keys.press(2)
    assert policy(seen, info) == 0, "nobody has the page open"
    asyncio.run_coroutine_threadsafe(asyncio.sleep(0), env.unwrapped.renderer._page._loop).result()  # type: ignore[attr-defined]
    policy._person.away, policy._person.looking = False, True
    policy.keys.press(2)
    assert policy(seen, info) == 2
    with pytest.raises(ValueError, match="open already"):
        ManualPolicy(env)
    env.close()
    assert not any(thread.name == "keepaway-page" for thread in threading.enumerate())


def test_what_cannot_be_shown_is_refused() -> None:
    with pytest.raises(ValueError, match="render_mode is one of"):
        KeepawayEnv(render_mode="video")
    with pytest.raises(ValueError, match="rcss-hat watch"):
        KeepawayEnv(render_mode="human", stage="fake")
    with pytest.raises(ValueError, match="render_mode='human'"):
        ManualPolicy(KeepawayEnv(render_mode="ansi"))


def test_agents_are_shown_too() -> None:
    env = keepaway_v0.env(per="decision", render_mode="rgb_array")
    env.reset(seed=1)
    assert env.render().shape == (400, 400, 3)
    together = keepaway_v0.parallel_env(render_mode="ansi")
    together.reset(seed=1)
    together.step(dict.fromkeys(together.agents, 0))
    assert "T" in together.render()


def test_what_is_played_becomes_demonstrations(tmp_path: Path) -> None:
    env = RecordDemonstrations(gymnasium.make("rcss_hat/Keepaway-v0"), tmp_path / "mine.csv", "nobody")
    expected, ends = list[tuple[int, int, int, list[float]]](), list[tuple[int, str]]()
    finals: list[tuple[float, ...]] = []
    for episode in range(3):
        _, info = env.reset(seed=2 if episode == 0 else None)
        over = False
        while not over:
            action = 1 if info["cycle"] % 3 == 0 else 0
            expected.append((info["cycle"], info["keeper"], action, env.unwrapped.state.tolist()))  # type: ignore[attr-defined]
            _, _, over, _, info = env.step(action)
        ends.append((info["duration"], info["reason"][0]))
        finals.append(tuple(env.unwrapped.state.tolist()))  # type: ignore[attr-defined]
    env.reset()
    env.step(0)
    env.close()
    read = DemonstrationSet.load(tmp_path / "mine.csv")
    assert [(d.episode.cycles, d.episode.reason) for d in read] == ends
    assert [d.episode.final for d in read] == finals
    assert [int(c) for d in read for c in d.cycles] == [cycle for cycle, *_ in expected]
    assert read.y.tolist() == [action for _, _, action, _ in expected]
    np.testing.assert_allclose(read.X, [state for *_, state in expected], atol=1e-6)


def test_only_decisions_are_demonstrated(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="decisions"):
        RecordDemonstrations(KeepawayEnv(per="cycle"), tmp_path / "mine.csv")


def test_a_game_log_is_the_one_that_a_server_writes(tmp_path: Path) -> None:
    logs = {
        "game_logging": True,
        "game_log_dir": str(tmp_path),
        "game_log_fixed": True,
        "game_log_fixed_name": "server",
    }
    with serving(Task(), 3, **logs, game_log_version=5, game_log_compression=0) as server:
        on_server = KeepawayEnv(stage=f"{server.host}:{server.port}")
        with pytest.warns(UserWarning, match="a seed"):
            on_server.reset(seed=3)
        for k in range(8):
            _, _, over, _, _ = on_server.step(k % 3)
            if over:
                on_server.reset()
        on_server.close()
    env = RecordGameLog(KeepawayEnv(), tmp_path / "mine.rcg")
    env.reset(seed=3)
    for k in range(8):
        _, _, over, _, _ = env.step(k % 3)
        if over:
            env.reset()
    env.reset(seed=4)
    env.close()

    def frames(path: Path) -> dict[bytes, bytes]:
        lines = path.read_bytes().splitlines()
        assert lines[0] == b"ULG5"
        return {line.split(b" ", 2)[1]: line for line in lines if line.startswith(b"(show ")}

    theirs, mine = frames(tmp_path / "server.rcg"), frames(tmp_path / "mine.rcg")
    common = [time for time in mine if time in theirs]
    assert len(common) > 40
    assert [mine[time] for time in common] == [theirs[time] for time in common]
    recording = read_recording(tmp_path / "mine.rcg")
    assert recording.skipped == 0
    assert len(recording.scenes) == len(mine)
    assert read_recording(tmp_path / "mine-2.rcg").scenes


def test_servers_write_their_own_game_logs(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="servers write their own"):
        RecordGameLog(KeepawayEnv(stage="fake"), tmp_path / "mine.rcg")
