from __future__ import annotations

import asyncio
import io
import os
import pty
import re
import sys

import pytest

from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer.audience import Audience, WatchError
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.frames import Frame, Setup
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.recording import read_recording
from rcss_hat.viewer.terminal import Terminal, draw_pitch, read_keys

from .audience import DATA, SETUP, end, nobody_decides, snapshot, until

FIELD = {"l1": (-8.0, -8.0), "l2": (8.0, -8.0), "l3": (0.0, 8.0), "r1": (-8.0, 8.0), "r2": (-4.0, 4.0)}
COLOURS = re.compile(r"\x1b\[[0-9;]*m")


def frame(time: int = 3, ball: tuple[float, float] = (-7.5, -8.0)) -> Frame:
    return make_frame(snapshot(time, ball, **FIELD), SETUP, 2, 1)


def plain(lines: list[str]) -> list[str]:
    return [COLOURS.sub("", line) for line in lines]


def test_keys_are_named_as_in_browsers() -> None:
    assert read_keys(b"1d\x1b[A\x1b[B\x1b[C\x1b[D \x1bOC\x1b[H\x1b[F\x1b[Z]") == [
        "1", "d", "ArrowUp", "ArrowDown", "ArrowRight", "ArrowLeft", " ", "ArrowRight", "Home", "End", "]",
    ]  # fmt: skip
    assert read_keys(b"") == [] and read_keys(b"\x1b") == []


def test_the_pitch_shows_everybody_where_he_is() -> None:
    lines = plain(draw_pitch(frame(), SETUP, 80, 24, playing=False))
    assert len(lines) <= 24 and max(map(len, lines)) <= 80
    rows = {mark: row for row, line in enumerate(lines) for mark in line if mark in "23@T"}
    columns = {mark: line.index(mark) for line in lines for mark in line if mark in "23@"}
    assert rows["@"] == rows["2"] < rows["3"]
    assert columns["@"] < columns["3"] < columns["2"]
    assert sum(line.count("T") for line in lines) == 2
    assert [line.strip()[0] + line.strip()[-1] for line in lines if "+--" in line] == ["++", "++"]


@pytest.mark.parametrize(("columns", "rows"), [(40, 12), (20, 30), (200, 60), (8, 6)])
def test_the_pitch_fits_any_terminal(columns: int, rows: int) -> None:
    lines = plain(draw_pitch(frame(), SETUP, columns, rows, playing=True))
    assert len(lines) <= rows and max(map(len, lines)) <= columns


def test_who_plays_sees_the_keys_on_the_team_mates() -> None:
    text = "\n".join(plain(draw_pitch(frame(), SETUP, 80, 24, playing=True)))
    here = frame()
    assert {c["mate"]: c["action"] for c in here["choices"]} == {"l2": 1, "l3": 2}
    assert "1" in text and "2" in text and "3" not in text and "@" in text


class Told:
    """A source that takes commands."""

    def __init__(self) -> None:
        self.commands: list[tuple[str, float]] = []

    async def run(self, audience: Audience) -> None:
        raise WatchError("there is nothing")

    def command(self, name: str, value: float) -> bool:
        self.commands.append((name, value))
        return True


def demonstrating() -> tuple[Terminal, Demonstrator]:
    demonstration = Demonstrator(KeyChannel(), None, 5)
    terminal = Terminal(Told(), demonstration, io.StringIO())
    terminal.setup(SETUP, True)
    terminal.frame(frame())
    return terminal, demonstration


@pytest.mark.parametrize(
    ("key", "action"), [("1", 1), ("2", 2), ("ArrowRight", 1), ("ArrowDown", 2), ("3", None), ("x", None)]
)
async def test_keys_ask_for_passes(key: str, action: int | None) -> None:
    terminal, demonstration = demonstrating()
    terminal.press(key)
    pending = demonstration.keys.pending
    assert (pending.action if pending else None) == action
    terminal.press("0")
    assert demonstration.keys.pending is None


async def test_keys_steer_the_recording() -> None:
    terminal, demonstration = demonstrating()
    terminal.press("p")
    assert demonstration.paused
    terminal.press("p")
    assert not demonstration.paused
    terminal.press("d")
    assert demonstration.status()["dropping"]
    end(terminal, Episode(1, 0, 10, OUT))
    end(terminal, Episode(2, 10, 20, OUT))
    terminal.press("l")
    assert demonstration.status()["last_dropped"]
    terminal.press("f")
    assert demonstration.finished
    assert not terminal.stopped.is_set()
    terminal.press("q")
    assert terminal.stopped.is_set()


async def test_the_figures_tell_episode_score_and_recording() -> None:
    terminal, _ = demonstrating()
    end(terminal, Episode(1, 0, 45, OUT))
    terminal.press("2")
    terminal.frame(frame())
    terminal.notice("careful")
    text = "\n".join(plain(terminal.text(160, 40)))
    for part in ("test   episode 2, 0.2 s   cycle 3, play_on", "1 ended, mean 4.50 s; last 4.5 s, ball out", "practice",
                 "-> PASS2", "1 2 or arrows: pass", "careful"):  # fmt: skip
        assert part in text
    assert all(len(line) <= 50 for line in plain(terminal.text(50, 20)))


async def test_keys_steer_a_recording_that_is_played() -> None:
    source = Told()
    terminal = Terminal(source, None, io.StringIO())
    terminal.setup(SETUP, False)
    terminal.frame(frame())
    terminal.playback({"playing": True, "speed": 1.0, "position": 4, "length": 10})
    for key in (" ", "ArrowLeft", "ArrowRight", "[", "]", "Home", "End", "+", "-", "1"):
        terminal.press(key)
    assert source.commands == [
        ("pause", 0), ("step", -1), ("step", 1), ("episode", -1), ("episode", 1), ("seek", 0), ("seek", 2**31),
        ("speed", 2.0), ("speed", 0.5),
    ]  # fmt: skip
    assert "scene 5 of 10, 1x" in "\n".join(terminal.text(100, 30))


async def test_a_log_is_shown_and_the_screen_given_back() -> None:
    out = io.StringIO()
    terminal = Terminal(Playback(read_recording(DATA / "sample-v5.rcg.gz"), 20.0), None, out)
    running = asyncio.create_task(terminal.run())
    await until(lambda: "cycle 2" in out.getvalue())
    terminal.press("q")
    await running
    text = out.getvalue()
    assert text.startswith("\x1b[?1049h") and text.endswith("\x1b[?1049l")
    assert "sample-v5.rcg.gz   episode 1" in text


async def test_what_goes_wrong_is_raised_after_the_screen_was_given_back() -> None:
    out = io.StringIO()
    with pytest.raises(WatchError, match="nothing"):
        await Terminal(Told(), None, out).run()
    assert out.getvalue().endswith("\x1b[?1049l")


async def test_keys_are_read_from_a_real_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    import termios

    outer, inner = pty.openpty()
    before = termios.tcgetattr(inner)
    with os.fdopen(inner, "r") as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        demonstration = Demonstrator(KeyChannel(), None)

        class Still(Told):
            async def run(self, audience: Audience) -> None:
                audience.setup(Setup("still"), live=True)
                audience.frame(frame())
                await asyncio.Event().wait()

        terminal = Terminal(Still(), demonstration, io.StringIO())
        running = asyncio.create_task(terminal.run())
        await until(lambda: terminal._frame)
        os.write(outer, b"\x1b[B")
        await until(lambda: demonstration.keys.pending)
        assert demonstration.keys.pending is not None and demonstration.keys.pending.mate == "l3"
        os.write(outer, b"q")
        await running
        assert termios.tcgetattr(stdin.fileno()) == before
    os.close(outer)


async def test_a_terminal_asks_whether_anybody_is_there() -> None:
    demonstration = Demonstrator(KeyChannel(), None)
    terminal = Terminal(Told(), demonstration, io.StringIO())
    terminal.setup(SETUP, True)
    terminal.frame(frame())
    assert "Are you still there?" not in "\n".join(terminal.text(100, 30))
    nobody_decides(demonstration)
    assert "Are you still there?" in "\n".join(terminal.text(100, 30)) and demonstration.standing
    terminal.press("1")
    assert not demonstration.standing and demonstration.keys.pending is None, "the key answered, and passed nothing"


async def test_a_terminal_begins_with_a_key() -> None:
    demonstration = Demonstrator(KeyChannel(), None, Terms(start=True))
    terminal = Terminal(Told(), demonstration, io.StringIO())
    terminal.setup(SETUP, True)
    terminal.frame(frame())
    assert "any key begins" in "\n".join(terminal.text(100, 30)) and demonstration.standing
    terminal.press("1")
    assert not demonstration.standing and demonstration.keys.pending is None
