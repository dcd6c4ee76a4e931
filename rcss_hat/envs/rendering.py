"""Pictures of a running match: an array of pixels, characters, or the page in the browser."""

from __future__ import annotations

import asyncio
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.messages import Show
from rcss_hat.stage.place import ARENA
from rcss_hat.viewer import shows
from rcss_hat.viewer.audience import Audience
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.frames import CYCLE_S, Frame, Setup, Snapshot
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.stage_reel import snapshot_of
from rcss_hat.viewer.terminal import draw_pitch

HUMAN, RGB, ANSI = "human", "rgb_array", "ansi"
RENDER_MODES = [HUMAN, RGB, ANSI]
FPS = round(1.0 / CYCLE_S)
"""Cycles per second of the game."""
SIDE = 400
"""Pixels of the longer side of a picture."""
COLUMNS, ROWS = 80, 32
_MARGIN = 2.0
_GRASS, _LINE, _BALL = (58, 125, 68), (235, 235, 235), (255, 255, 255)
_COLOURS = {"l": (38, 84, 214), "r": (240, 190, 30)}
_PLAYER, _BALL_SHOWN = 0.6, 0.35
"""Radii in metres, as drawn; true ones are half as large."""
_OPENING = 20.0
"""Seconds for the page to be opened."""


def check_render_mode(mode: str | None, place: str) -> None:
    """Check what somebody wants to see.

    Raises
    ------
    ValueError
        For what there is not, and on servers, which show their matches to monitors.
    """
    if mode is not None and mode not in RENDER_MODES:
        raise ValueError(f"render_mode is one of {', '.join(RENDER_MODES)}, not {mode!r}")
    if mode == HUMAN and place != ARENA:
        raise ValueError(f"the page shows the arena; a match on {place} is watched with rcss-hat watch")


def draw(snapshot: Snapshot, setup: Setup, side: int = SIDE) -> NDArray[np.uint8]:
    """Draw players, who look where their bodies do, and the ball.

    Parameters
    ----------
    snapshot : Snapshot
    setup : Setup
        Of the region.
    side : int
        Pixels of the longer side.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
    """
    length, width = setup.length + 2.0 * _MARGIN, setup.width + 2.0 * _MARGIN
    scale = side / max(length, width)
    shape = max(round(width * scale), 1), max(round(length * scale), 1)
    x = (np.arange(shape[1]) + 0.5) / scale - length / 2.0
    y = ((np.arange(shape[0]) + 0.5) / scale - width / 2.0)[:, None]
    picture = np.empty((*shape, 3), dtype=np.uint8)
    picture[:] = _GRASS
    across, down = np.abs(x) - setup.length / 2.0, np.abs(y) - setup.width / 2.0
    picture[np.abs(np.maximum(across, down)) < 0.75 / scale] = _LINE
    for player in snapshot.players:
        _disc(picture, x - player.x, y - player.y, _PLAYER, _COLOURS[player.side])
        way = np.radians(player.body)
        nose = x - player.x - _PLAYER * np.cos(way), y - player.y - _PLAYER * np.sin(way)
        _disc(picture, *nose, _PLAYER / 3.0, (0, 0, 0))
    _disc(picture, x - snapshot.ball[0], y - snapshot.ball[1], _BALL_SHOWN, _BALL)
    return picture


def _disc(
    picture: NDArray[np.uint8],
    dx: NDArray[np.floating],
    dy: NDArray[np.floating],
    radius: float,
    colour: tuple[int, int, int],
) -> None:
    """Fill a circle; only the rows and columns that it may touch are looked at."""
    columns, rows = np.flatnonzero(np.abs(dx) <= radius), np.flatnonzero(np.abs(dy[:, 0]) <= radius)
    if len(columns) and len(rows):
        part = np.ix_(rows, columns)
        picture[part] = np.where((dx[columns] ** 2 + dy[rows] ** 2 <= radius**2)[..., None], colour, picture[part])


class Renderer:
    """Shows one environment's matches.

    Parameters
    ----------
    mode : {"human", "rgb_array", "ansi"}
    setup : Setup
    controls : Demonstrator, optional
        Who takes the keys of the page.
    pace : callable
        Waits so many seconds; for people, who see a cycle in 0.1 s.
    """

    def __init__(
        self,
        mode: str,
        setup: Setup,
        controls: Demonstrator | None = None,
        pace: Callable[[float], object] = time.sleep,
    ) -> None:
        self.mode, self.setup, self._pace = mode, setup, pace
        self.controls = controls
        self._page: Page | None = None
        self._latest: Any = None
        self._shown: tuple[Snapshot, int, int] | None = None

    def seen(self, record: Any) -> None:
        """Take what there is to see in a cycle, a record of `rcss_hat.arena.records.FRAME`."""
        self._latest = record
        if self.mode == HUMAN:
            if self._page is None:
                self._page = Page(self.setup, self.controls)
            self._page.show(self._frame())
            self._pace(self.setup.step_s)

    def shown(self, show: Show, number: int, start: int) -> None:
        """Take what a monitor was shown, with number and start of the running episode."""
        self._latest = None
        self._shown = shows.snapshot_of(show, "play_on"), number, start

    def _scene(self) -> tuple[Snapshot, int, int]:
        record = self._latest
        if record is None:
            assert self._shown is not None, "something was seen"
            return self._shown
        return snapshot_of(record), int(record["episode"]), int(record["episode_start"])

    def _frame(self) -> Frame:
        snapshot, number, start = self._scene()
        return make_frame(snapshot, self.setup, number, start)

    @property
    def is_open(self) -> bool:
        """Whether the page is there."""
        return self._page is not None

    def picture(self) -> NDArray[np.uint8] | str | None:
        """Return what `render` of the environment returns: nothing for people, who see the page."""
        if (self._latest is None and self._shown is None) or self.mode == HUMAN:
            return None
        if self.mode == RGB:
            return draw(self._scene()[0], self.setup)
        return "\n".join(draw_pitch(self._frame(), self.setup, COLUMNS, ROWS, playing=False)) + "\n"

    def close(self) -> None:
        """Close the page."""
        if self._page is not None:
            self._page.close()
            self._page = None


class Page:
    """The page of a match that is played step by step, served by a thread; a `rcss_hat.viewer.audience.Source`.

    Attributes
    ----------
    url : str
        Its link.
    """

    def __init__(self, setup: Setup, controls: Demonstrator | None = None, open_browser: bool = True) -> None:
        self.setup, self._controls, self._open = setup, controls, open_browser
        self.url = ""
        self._loop: asyncio.AbstractEventLoop | None = None
        self._audience: Audience | None = None
        self._latest: Frame | None = None
        self._closed: asyncio.Event | None = None
        self._ready, self._failure = threading.Event(), ""
        self._thread = threading.Thread(target=self._serve, name="keepaway-page", daemon=True)
        self._thread.start()
        self._ready.wait(_OPENING)
        if self._failure or not self.url:
            raise RuntimeError(f"the page cannot be shown: {self._failure or 'it takes too long'}")
        print(f"Watch at {self.url}", file=sys.stderr)

    def _serve(self) -> None:
        try:
            asyncio.run(self._show())
        except (OSError, ImportError) as error:
            self._failure = str(error)
        finally:
            self._ready.set()

    async def _show(self) -> None:
        from rcss_hat.viewer.server import serve  # an extra: those who look at pixels do without

        self._loop, self._closed = asyncio.get_running_loop(), asyncio.Event()
        viewer = await serve(self, self._controls, open_browser=self._open)
        self.url = viewer.url
        self._ready.set()
        try:
            await self._closed.wait()
        finally:
            await viewer.close()

    async def run(self, audience: Audience) -> None:
        """Show what comes; see `Source.run`."""
        audience.setup(self.setup, live=True)
        self._audience = audience
        if self._latest is not None:
            audience.frame(self._latest)
        assert self._closed is not None
        await self._closed.wait()

    def command(self, name: str, value: float) -> bool:
        """Refuse: an environment is not stopped or sought."""
        return False

    def show(self, frame: Frame) -> None:
        """Show a picture; called outside of the thread."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._take, frame)

    def _take(self, frame: Frame) -> None:
        self._latest = frame
        if self._audience is not None:
            self._audience.frame(frame)

    def close(self) -> None:
        """End the page."""
        if self._loop is not None and self._closed is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._closed.set)
        self._thread.join(_OPENING)


def changes_for(renderer: Renderer | None, place: str) -> dict[str, Any]:
    """Return what a `rcss_hat.envs.stepping.Setting` needs so that a renderer sees a match in some place."""
    if renderer is None:
        return {}
    return {"on_frame": renderer.seen} if place == ARENA else {"on_show": renderer.shown}


def renderer(mode: str | None, title: str, params: Any) -> Renderer | None:
    """Return what shows an environment with these server parameters; None: nobody looks."""
    return None if mode is None else Renderer(mode, Setup.from_params(title, params))
