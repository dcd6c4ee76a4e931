"""The viewer for machines without a browser: the same pictures and keys in a terminal."""

from __future__ import annotations

import asyncio
import os
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TextIO

from rcss_hat.keepaway.decision import action_name
from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.viewer.audience import Source
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.frames import CYCLE_S, Frame, Setup

MARGIN = 1.5
"""Metres shown around the region."""
PICTURE = 0.05
"""Seconds between two pictures, at least."""
TEXT_LINES = 5
KEEPER, TAKER, STRONG, FAINT, PLAIN = "\x1b[1;34m", "\x1b[1;33m", "\x1b[1;7m", "\x1b[2m", "\x1b[0m"
_ENTER, _LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_SEQUENCES = {
    b"\x1b[A": "ArrowUp", b"\x1b[B": "ArrowDown", b"\x1b[C": "ArrowRight", b"\x1b[D": "ArrowLeft",
    b"\x1bOA": "ArrowUp", b"\x1bOB": "ArrowDown", b"\x1bOC": "ArrowRight", b"\x1bOD": "ArrowLeft",
    b"\x1b[H": "Home", b"\x1b[F": "End",
}  # fmt: skip
_REASONS = {OUT: "ball out", TAKEN: "ball taken"}
_SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0)


def read_keys(data: bytes) -> list[str]:
    """Name the keys in what a terminal sent, as browsers name them; unknown escape sequences are left out."""
    keys = []
    at = 0
    while at < len(data):
        if data[at] == 0x1B:
            name = _SEQUENCES.get(data[at : at + 3])
            if name:
                keys.append(name)
            at += 3
        else:
            keys.append(chr(data[at]))
            at += 1
    return keys


def draw_pitch(frame: Frame, setup: Setup, columns: int, rows: int, playing: bool) -> list[str]:
    """Draw the pitch in characters.

    Keepers are blue numbers, takers yellow letters T, the ball is o, the player with the ball @. While a person
    plays, team mates show the key that passes to them instead of their number.

    Parameters
    ----------
    frame : Frame
    setup : Setup
    columns, rows : int
        Room; a character counts as twice as high as it is wide.
    playing : bool

    Returns
    -------
    list of str
        Lines with colours, without line ends.
    """
    scale = min((rows - 1) / (setup.width + 2 * MARGIN), (columns - 1) / (2.0 * (setup.length + 2 * MARGIN)))

    def cell(x: float, y: float) -> tuple[int, int]:
        column = round((x + setup.length / 2.0 + MARGIN) * 2.0 * scale)
        return min(max(round((y + setup.width / 2.0 + MARGIN) * scale), 0), rows - 1), min(max(column, 0), columns - 1)

    cells: dict[tuple[int, int], tuple[str, str]] = {}
    top, left = cell(-setup.length / 2.0, -setup.width / 2.0)
    bottom, right = cell(setup.length / 2.0, setup.width / 2.0)
    for row in range(top, bottom + 1):
        cells[row, left] = cells[row, right] = "|", FAINT
    for column in range(left, right + 1):
        corner = column in (left, right)
        cells[top, column] = cells[bottom, column] = "+" if corner else "-", FAINT
    keys = {c["mate"]: str(c["action"]) for c in frame["choices"]} if playing else {}
    for player in frame["players"]:
        mark, style = ("T", TAKER) if player["side"] == "r" else (str(player["unum"] % 10), KEEPER)
        if playing and player["side"] == "l":
            mark, style = (keys[player["id"]], STRONG) if player["id"] in keys else ("K", KEEPER)
        if player["id"] == frame["holder"]:
            mark = "@"
        cells[cell(player["x"], player["y"])] = mark, style
    cells.setdefault(cell(frame["ball"][0], frame["ball"][1]), ("o", PLAIN))
    width, height = cell(setup.length / 2.0 + MARGIN, setup.width / 2.0 + MARGIN)[::-1]
    return [_line(cells, row, width + 1) for row in range(height + 1)]


def _line(cells: Mapping[tuple[int, int], tuple[str, str]], row: int, columns: int) -> str:
    parts, style = [], PLAIN
    for column in range(columns):
        mark, wanted = cells.get((row, column), (" ", PLAIN))
        if wanted != style:
            parts.append(PLAIN + ("" if wanted == PLAIN else wanted))
            style = wanted
        parts.append(mark)
    return "".join(parts).rstrip() + (PLAIN if style != PLAIN else "")


class Terminal:
    """An audience that draws in a terminal and takes keys from it.

    Parameters
    ----------
    source : Source
    controls : Demonstrator, optional
    out : TextIO, optional
        By default standard output.
    """

    def __init__(self, source: Source, controls: Demonstrator | None = None, out: TextIO | None = None) -> None:
        self.source, self.controls = source, controls
        self.out = out or sys.stdout
        self.stopped = asyncio.Event()
        self._setup: Setup | None = None
        self._frame: Frame | None = None
        self._episodes: list[Episode] = []
        self._playback: Mapping[str, Any] = {}
        self._notice = ""
        self._changed = asyncio.Event()

    # -- audience -----------------------------------------------------------------------------------------------------
    def setup(self, setup: Setup, live: bool) -> None:
        """Take what is watched."""
        self._setup = setup
        self._changed.set()

    def frame(self, frame: Frame) -> None:
        """Take the newest picture."""
        if self.controls is not None:
            self.controls.observe(frame)
        self._frame = frame
        self._changed.set()

    def episodes(self, episodes: Sequence[Episode]) -> None:
        """Take all episodes."""
        self._episodes = list(episodes)

    def episode(self, episode: Episode) -> None:
        """Take one more episode."""
        self._episodes.append(episode)
        self._changed.set()

    def playback(self, status: Mapping[str, Any]) -> None:
        """Take where we are."""
        self._playback = status

    def notice(self, text: str, code: str | None = None, **values: Any) -> None:
        """Take a remark."""
        self._notice = text
        self._changed.set()

    # -- keys ---------------------------------------------------------------------------------------------------------
    def press(self, key: str) -> None:
        """Do what a key means; q leaves."""
        if key == "q":
            self.stopped.set()
        elif self.controls is not None and not self.controls.finished:
            self._demonstrate(self.controls, key)
        else:
            self._seek(key)
        self._changed.set()

    def _demonstrate(self, controls: Demonstrator, key: str) -> None:
        if controls.asking or not controls.started:
            controls.command("here" if controls.asking else "start")
            return
        commands = {"d": "drop", "l": "drop_last", "p": "resume" if controls.paused else "pause", "f": "stop"}
        if key.isdigit() or key == " ":
            controls.keys.press(int(key) if key.isdigit() else 0)
        elif key.startswith("Arrow"):
            for choice in self._frame["choices"] if self._frame else []:
                if choice["arrow"] == key:
                    controls.keys.press_mate(choice["mate"])
        elif key in commands:
            controls.command(commands[key])

    def _seek(self, key: str) -> None:
        speed = float(self._playback.get("speed", 1.0))
        index = min(range(len(_SPEEDS)), key=lambda k: abs(_SPEEDS[k] - speed))
        commands: dict[str, tuple[str, float]] = {
            " ": ("pause" if self._playback.get("playing") else "play", 0),
            "ArrowLeft": ("step", -1), "ArrowRight": ("step", 1), "[": ("episode", -1), "]": ("episode", 1),
            "Home": ("seek", 0), "End": ("seek", 2**31),
            "+": ("speed", _SPEEDS[min(index + 1, len(_SPEEDS) - 1)]), "-": ("speed", _SPEEDS[max(index - 1, 0)]),
        }  # fmt: skip
        if key in commands:
            self.source.command(*commands[key])

    # -- picture ------------------------------------------------------------------------------------------------------
    def text(self, columns: int, rows: int) -> list[str]:
        """Return the whole picture, line by line."""
        setup, frame = self._setup, self._frame
        if setup is None or frame is None:
            return [self._notice or "waiting for the first picture ..."]
        pitch = draw_pitch(frame, setup, columns, max(rows - TEXT_LINES, 6), self.controls is not None)
        return [*pitch, *(line[:columns] for line in self._figures(setup, frame))]

    def _figures(self, setup: Setup, frame: Frame) -> list[str]:
        seconds = (frame["time"] - frame["start"]) * CYCLE_S
        lines = [
            f"{setup.title}   episode {frame['episode']}, {seconds:.1f} s   cycle {frame['time']}, {frame['mode']}"
        ]
        if self._episodes:
            last = self._episodes[-1]
            mean = sum(e.cycles for e in self._episodes) * CYCLE_S / len(self._episodes)
            reason = _REASONS.get(last.reason, "ended")
            lines.append(
                f"{len(self._episodes)} ended, mean {mean:.2f} s; last {last.cycles * CYCLE_S:.1f} s, {reason}"
            )
        if self.controls is not None:
            lines += self._recording(self.controls, frame)
        elif self._playback:
            lines.append(
                f"scene {self._playback['position'] + 1} of {self._playback['length']}, {self._playback['speed']:g}x; "
                "space: play or pause, arrows: step, [ ]: episodes, + -: speed, q: leave"
            )
        else:
            lines.append("q: leave")
        return [*lines, self._notice] if self._notice else lines

    def _recording(self, controls: Demonstrator, frame: Frame) -> list[str]:
        status = controls.status()
        if status["asking"]:
            return ["Are you still there? Nothing was pressed for a while; the game waits for a key."]
        if not status["started"]:
            return ["You play the keeper with the ball (blue). Keep it as long as you can: any key begins."]
        wanted = f" of {status['episodes']}" if status["episodes"] else ""
        text = f"{status['kept']}{wanted} recorded, {status['dropped']} dropped" if status["recording"] else "practice"
        if status["paused"]:
            text += "; paused"
        elif status["dropping"]:
            text += "; this one will be dropped"
        elif status["spoiled"]:
            text += "; recording goes on with the next episode"
        asked = f"   -> {action_name(frame['pending'])}" if frame["pending"] else ""
        passes = " ".join(str(a) for a in controls.keys.actions if a)
        return [
            text + asked,
            f"{passes} or arrows: pass, 0: hold, d: drop this, l: drop last, p: pause, f: finish, q: leave",
        ]

    async def show(self) -> None:
        """Draw what changed, until cancelled."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            size = shutil.get_terminal_size()
            self.out.write(
                "\x1b[H" + "".join(f"{line}\x1b[K\n" for line in self.text(size.columns - 1, size.lines)) + "\x1b[J"
            )
            self.out.flush()
            await asyncio.sleep(PICTURE)

    async def run(self) -> None:
        """Show the source and take keys until it ends or the person leaves.

        Raises
        ------
        WatchError
            When there is nothing to show.
        """
        with _keys_of_terminal(self), _whole_screen(self.out):
            tasks = [asyncio.create_task(work) for work in (self.source.run(self), self.show(), self.stopped.wait())]
            try:
                done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
                for task in done:
                    task.result()
            finally:
                for task in tasks:
                    task.cancel()
                await asyncio.gather(*tasks, return_exceptions=True)


@contextmanager
def _whole_screen(out: TextIO) -> Iterator[None]:
    """Use the terminal's second screen, and give the first one back as it was."""
    out.write(_ENTER)
    try:
        yield
    finally:
        out.write(_LEAVE)
        out.flush()


@contextmanager
def _keys_of_terminal(terminal: Terminal) -> Iterator[None]:
    """Read single keys from standard input; where it is no terminal, there are no keys."""
    if sys.platform == "win32" or not sys.stdin.isatty():
        yield
        return
    import termios
    import tty

    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    loop = asyncio.get_running_loop()

    def read() -> None:
        for key in read_keys(os.read(descriptor, 64)):
            terminal.press(key)

    tty.setcbreak(descriptor)
    loop.add_reader(descriptor, read)
    try:
        yield
    finally:
        loop.remove_reader(descriptor)
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
