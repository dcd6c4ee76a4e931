"""The local web page: shows a source to browsers, and takes the keys of one of them.

Only this machine can reach it: it listens on the loopback interface, answers only to loopback host names (so that no
foreign name can be pointed at it), takes WebSockets only from its own page, and only from browsers that opened the
link with the token in it. The first browser whose page connects plays; others may watch, and play when it has gone.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import secrets
import sys
import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from aiohttp import WSMsgType, web

from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.audience import Source, WatchError
from rcss_hat.viewer.browser import Browser
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.door import Door
from rcss_hat.viewer.frames import Frame, Setup
from rcss_hat.viewer.pagefiles import HEADERS, static_files
from rcss_hat.viewer.seat import PLAYER, Seat

HOST = "127.0.0.1"
LOOPBACK_NAMES = {"127.0.0.1", "localhost"}
MAX_MESSAGE = 4096
"""Bytes of the longest message a page may send."""
HEARTBEAT = 5.0
"""Seconds between two questions whether a page is still there."""
SEAT_KEPT = 3.0
"""Seconds that the seat is kept for a browser without a page: as long as loading one again takes."""
FAREWELL = 0.5
"""Seconds a page gets to take the last messages when the viewer is closed."""
_HUGE = 1e15

_FOREIGN = "This page answers only to localhost and 127.0.0.1.\n"
_NO_TOKEN = "Open the link that rcss-hat printed: it has a token in it, and this address has not.\n"


class Viewer:
    """A page that shows a source; made by `serve`.

    Attributes
    ----------
    url : str
        Link with the token, for the browser that is to play.
    failure : str or None
        Why the source ended, when it did.
    """

    def __init__(self, source: Source, controls: Demonstrator | None) -> None:
        self.source, self.controls = source, controls
        self.url = ""
        self.failure: str | None = None
        self._token = secrets.token_urlsafe(24)
        self._sessions: set[str] = set()
        self._seat = Seat()
        self._release: asyncio.TimerHandle | None = None
        self._browsers: set[Browser] = set()
        self._files = static_files()
        self._cookie = "rcss_hat"
        self._door: Door | None = None
        self._source_task: asyncio.Task[None] | None = None
        self._told: dict[str, Mapping[str, Any]] = {}
        self._episodes: list[dict[str, Any]] = []

    # -- beginning and end --------------------------------------------------------------------------------------------
    async def start(self, port: int) -> None:
        """Listen, and begin to show the source; nobody is there to play yet."""
        self._seat_changed()
        app = web.Application(middlewares=[self._guard], client_max_size=MAX_MESSAGE)
        app.router.add_get("/", self._page)
        app.router.add_get("/socket", self._socket)
        app.router.add_get("/{name}", self._static)
        door = Door(app)
        bound = await door.open(HOST, port)
        self._door = door
        self._cookie = f"rcss_hat_{bound}"
        self.url = f"http://{HOST}:{bound}/?token={self._token}"
        self._source_task = asyncio.create_task(self._run_source())

    async def _run_source(self) -> None:
        try:
            await self.source.run(self)
        except WatchError as error:
            self.failure = str(error)
            self.notice(f"The end: {error}.")

    async def wait(self) -> None:
        """Wait until the source ends.

        Raises
        ------
        WatchError
            Why it ended, when that was no good end.
        """
        if self._source_task is not None:
            await asyncio.wait({self._source_task})
            if not self._source_task.cancelled():
                self._source_task.result()
        if self.failure is not None:
            raise WatchError(self.failure)

    async def close(self) -> None:
        """Stop showing, tell the pages, and free the port."""
        if self._source_task is not None:
            self._source_task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._source_task
        if self.controls is not None:
            self._tell_controls()
            self._say_and_keep("farewell", {"type": "farewell", **self.controls.farewell()})
        for browser in list(self._browsers):
            with contextlib.suppress(ConnectionError, TimeoutError):
                async with asyncio.timeout(FAREWELL):
                    await browser.flush()
            await browser.socket.close(code=1001, message=b"the viewer was closed")
        if self._release is not None:
            self._release.cancel()
        if self._door is not None:
            await self._door.close()
            self._door = None

    async def __aenter__(self) -> Viewer:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    # -- audience: what the source tells ------------------------------------------------------------------------------
    def setup(self, setup: Setup, live: bool) -> None:
        """Tell the pages what is watched."""
        self._say_and_keep("setup", {"type": "setup", "setup": setup.to_dict(), "live": live})

    def frame(self, frame: Frame) -> None:
        """Show the newest picture."""
        if self.controls is not None:
            self.controls.observe(frame)
            self._tell_controls()
        self._show("frame", {"type": "frame", "frame": frame})

    def episodes(self, episodes: Sequence[Episode]) -> None:
        """Tell the pages all episodes."""
        self._episodes = [_episode(e) for e in episodes]
        for browser in self._browsers:
            browser.say({"type": "episodes", "episodes": self._episodes})

    def episode(self, episode: Episode) -> None:
        """Tell the pages one more episode."""
        self._episodes.append(_episode(episode))
        for browser in self._browsers:
            browser.say({"type": "episode", "episode": self._episodes[-1]})
        if self.controls is not None:
            self._tell_controls()

    def playback(self, status: Mapping[str, Any]) -> None:
        """Tell the pages where in a recording we are."""
        self._show("playback", {"type": "playback", **status})

    def notice(self, text: str) -> None:
        """Tell people something."""
        self._say_and_keep("notice", {"type": "notice", "text": text})

    def _tell_controls(self) -> None:
        assert self.controls is not None
        status = {"type": "demonstration", **self.controls.status()}
        if self._told.get("demonstration") != status:
            self._show("demonstration", status)

    def _say_and_keep(self, kind: str, message: Mapping[str, Any]) -> None:
        self._told[kind] = message
        for browser in self._browsers:
            browser.say(message)

    def _show(self, kind: str, message: Mapping[str, Any]) -> None:
        self._told[kind] = message
        for browser in self._browsers:
            browser.show(kind, message)

    # -- requests -----------------------------------------------------------------------------------------------------
    @web.middleware
    async def _guard(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Refuse foreign names and those without token or session; the rest gets the security headers."""
        name = request.headers.get("Host", "").rpartition(":")[0]
        if name not in LOOPBACK_NAMES:
            return web.Response(status=403, text=_FOREIGN, headers=HEADERS)
        if request.method != "GET":
            return web.Response(status=405, text="Only GET.\n", headers=HEADERS)
        if self._session(request) is None and not (request.path == "/" and self._has_token(request)):
            return web.Response(status=403, text=_NO_TOKEN, headers=HEADERS)
        response: web.StreamResponse = await handler(request)
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    def _session(self, request: web.Request) -> str | None:
        cookie = request.cookies.get(self._cookie, "")
        return cookie if cookie in self._sessions else None

    def _has_token(self, request: web.Request) -> bool:
        given = request.query.get("token", "")
        return secrets.compare_digest(given.encode(), self._token.encode())

    async def _page(self, request: web.Request) -> web.StreamResponse:
        """Give the page; who has the token and no session yet gets one."""
        response = self._file("index.html")
        if self._session(request) is None:
            session = secrets.token_urlsafe(24)
            self._sessions.add(session)
            response.set_cookie(self._cookie, session, httponly=True, samesite="Strict", path="/")
        return response

    async def _static(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info["name"]
        if name not in self._files:
            return web.Response(status=404, text="There is nothing of that name.\n")
        return self._file(name)

    def _file(self, name: str) -> web.Response:
        content, content_type = self._files[name]
        return web.Response(body=content, content_type=content_type, charset="utf-8")

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        """Serve one page."""
        if request.headers.get("Origin") != f"http://{request.headers['Host']}":
            return web.Response(status=403, text="Only the viewer's own page may connect.\n")
        session = self._session(request)
        assert session is not None  # the guard lets nobody in without
        socket = web.WebSocketResponse(heartbeat=HEARTBEAT, max_msg_size=MAX_MESSAGE)
        await socket.prepare(request)
        browser = Browser(socket, session)
        self._greet(browser)
        sender = asyncio.create_task(browser.send())
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    self._hear(browser, message.data)
        finally:
            self._leave(browser)
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sender
        return socket

    def _greet(self, browser: Browser) -> None:
        """Tell a new page what the others know, then count it among them."""
        self._seat.enter(browser)
        browser.say({"type": "hello", "role": self._seat.role(browser), "demonstrate": self.controls is not None})
        browser.say({"type": "episodes", "episodes": self._episodes})
        if self.controls is not None:
            self._told["demonstration"] = {"type": "demonstration", **self.controls.status()}
        for kind in ("setup", "notice", "demonstration", "playback", "frame", "farewell"):
            if kind in self._told:
                browser.say(self._told[kind])
        self._browsers.add(browser)
        self._seat_changed()

    def _leave(self, browser: Browser) -> None:
        self._browsers.discard(browser)
        self._seat.leave(browser)
        self._seat_changed()

    def _seat_changed(self) -> None:
        """Tell the pages who plays, and the demonstration whether anybody is there and looks."""
        seat = self._seat
        for browser in self._browsers:
            browser.show("seat", {"type": "seat", "role": seat.role(browser), "state": seat.state})
        if self._release is not None:
            self._release.cancel()
            self._release = None
        if seat.owner is not None and not seat.occupied:
            self._release = asyncio.get_running_loop().call_later(SEAT_KEPT, self._give_up_seat)
        if self.controls is not None:
            self.controls.person(seat.occupied)
            self.controls.look(seat.looking)
            self._tell_controls()

    def _give_up_seat(self) -> None:
        if self._seat.give_up():
            self._seat_changed()

    # -- what people ask for ------------------------------------------------------------------------------------------
    def _hear(self, browser: Browser, text: str) -> None:
        """Take a message of a page; what is malformed, or not for that browser to ask, changes nothing."""
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            message = None
        if not isinstance(message, dict):
            refusal: str | None = "expected a JSON object"
        elif message.get("type") in ("look", "seat"):
            refusal = self._attend(browser, message)
        elif self._seat.role(browser) != PLAYER:
            refusal = "another browser plays; this one can only watch"
        else:
            refusal = None if self._obey(message) else self._refusal(message)
        if refusal is not None:
            browser.say({"type": "refused", "text": refusal})

    def _attend(self, browser: Browser, message: dict[str, Any]) -> str | None:
        """Note whether somebody looks at a page, or let it play; returns why not."""
        if message["type"] == "look":
            if not isinstance(message.get("value"), bool):
                return "expected true or false"
            browser.looking = message["value"]
        elif not self._seat.take(browser.session):
            return "another browser plays at the moment"
        self._seat_changed()
        return None

    def _obey(self, message: dict[str, Any]) -> bool:
        kind, value = message.get("type"), message.get("value")
        if kind == "playback":
            return isinstance(message.get("name"), str) and self.source.command(message["name"], _number(value))
        controls = self.controls
        if controls is None:
            return False
        if kind == "press":
            done = type(value) is int and controls.keys.press(value)
        elif kind == "mate":
            done = isinstance(value, str) and controls.keys.press_mate(value)
        else:
            done = kind == "demonstration" and isinstance(value, str) and controls.command(value)
        self._tell_controls()
        return done

    def _refusal(self, message: dict[str, Any]) -> str:
        """Say for people why something was not done."""
        kind, value = message.get("type"), message.get("value")
        if kind == "press" and self.controls is not None:
            passes = " and ".join(str(a) for a in self.controls.keys.actions if a)
            return f"there is no such pass here: 0 holds the ball, {passes} passes it"
        if kind == "mate":
            return "no pass goes there at the moment"
        if (kind, value) == ("demonstration", "drop_last"):
            return "there is no episode to drop"
        return "that cannot be done now"


def _number(value: Any) -> float:
    """Return a number of a message; 0 for what is none, or beyond all use."""
    return float(value) if isinstance(value, (int, float)) and abs(value) < _HUGE else 0.0


def _episode(episode: Episode) -> dict[str, Any]:
    told = {name: value for name, value in asdict(episode).items() if name != "final"}  # pages show no state of its end
    return {**told, "cycles": episode.cycles}


async def serve(
    source: Source, controls: Demonstrator | None = None, *, port: int = 0, open_browser: bool = True
) -> Viewer:
    """Show a source on a local web page, and let the first browser play when there are controls.

    Parameters
    ----------
    source : Source
        `rcss_hat.viewer.live.MonitorSource` or `rcss_hat.viewer.playback.Playback`.
    controls : Demonstrator, optional
        Who takes the keys; without it the page only watches.
    port : int
        TCP port on 127.0.0.1; 0: any that is free.
    open_browser : bool
        Open the page in the user's browser.

    Returns
    -------
    Viewer
        Running; its ``url`` is for the person, ``close()`` ends it.

    Raises
    ------
    OSError
        When the port is taken.
    """
    viewer = Viewer(source, controls)
    await viewer.start(port)
    if open_browser and has_desktop():
        await asyncio.to_thread(webbrowser.open, viewer.url)
    return viewer


def has_desktop() -> bool:
    """Tell whether a browser can show a window here; in a bare terminal a text browser might be started in it."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
