"""The local web page: shows a source to browsers, and takes the keys of one of them.

Only this machine can reach it: it listens on the loopback interface, answers only to loopback host names (so that no
foreign name can be pointed at it), takes WebSockets only from its own page, and only from browsers that opened the
link with the token in it. The first browser whose page connects plays; others may watch.
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
from importlib import resources
from typing import Any

from aiohttp import WSMsgType, web

from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.audience import Source, WatchError
from rcss_hat.viewer.demonstration import Demonstration
from rcss_hat.viewer.frames import Frame, Setup

HOST = "127.0.0.1"
LOOPBACK_NAMES = {"127.0.0.1", "localhost"}
PLAYER, WATCHER = "player", "watcher"
MAX_MESSAGE = 4096
"""Bytes of the longest message a page may send."""
PICTURE = 1.0 / 60.0
"""Seconds between two pictures sent to a page, at least."""
HEARTBEAT = 20.0
FAREWELL = 0.5
"""Seconds a page gets to take the last messages when the viewer is closed."""
_HUGE = 1e15

_TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
_FOREIGN = "This page answers only to localhost and 127.0.0.1.\n"
_NO_TOKEN = "Open the link that rcss-hat printed: it has a token in it, and this address has not.\n"


def static_files() -> dict[str, tuple[bytes, str]]:
    """Read the page's files: name to (content, content type)."""
    folder = resources.files("rcss_hat.viewer") / "static"
    found = {}
    for file in folder.iterdir():
        suffix = "." + file.name.rpartition(".")[2]
        if suffix in _TYPES:
            found[file.name] = file.read_bytes(), _TYPES[suffix]
    return found


class _Browser:
    """One connected page. What comes too fast for it is left out; nobody waits for it."""

    def __init__(self, socket: web.WebSocketResponse, role: str) -> None:
        self.socket, self.role = socket, role
        self._messages: list[str] = []
        self._latest: dict[str, Mapping[str, Any]] = {}
        self._wake = asyncio.Event()

    def say(self, message: Mapping[str, Any]) -> None:
        """Queue a message that must not be lost."""
        self._messages.append(json.dumps(message))
        self._wake.set()

    def show(self, kind: str, message: Mapping[str, Any]) -> None:
        """Queue a message that the next one of its kind replaces."""
        self._latest[kind] = message
        self._wake.set()

    async def send(self) -> None:
        """Send what is queued, until the page has gone."""
        while not self.socket.closed:
            await self._wake.wait()
            self._wake.clear()
            await self.flush()
            await asyncio.sleep(PICTURE)

    async def flush(self) -> None:
        """Send what is queued now."""
        messages, self._messages = self._messages, []
        latest, self._latest = self._latest, {}
        for text in messages:
            await self.socket.send_str(text)
        for message in latest.values():
            await self.socket.send_str(json.dumps(message))


class Viewer:
    """A page that shows a source; made by `serve`.

    Attributes
    ----------
    url : str
        Link with the token, for the browser that is to play.
    failure : str or None
        Why the source ended, when it did.
    """

    def __init__(self, source: Source, controls: Demonstration | None) -> None:
        self.source, self.controls = source, controls
        self.url = ""
        self.failure: str | None = None
        self._token = secrets.token_urlsafe(24)
        self._sessions: set[str] = set()
        self._player: str | None = None
        self._players = 0  # pages of the browser that plays
        self._browsers: set[_Browser] = set()
        self._files = static_files()
        self._cookie = "rcss_hat"
        self._runner: web.AppRunner | None = None
        self._source_task: asyncio.Task[None] | None = None
        self._told: dict[str, Mapping[str, Any]] = {}
        self._episodes: list[dict[str, Any]] = []

    # -- beginning and end --------------------------------------------------------------------------------------------
    async def start(self, port: int) -> None:
        """Listen, and begin to show the source; nobody is there to play yet."""
        self._count_players(0)
        app = web.Application(middlewares=[self._guard], client_max_size=MAX_MESSAGE)
        app.router.add_get("/", self._page)
        app.router.add_get("/socket", self._socket)
        app.router.add_get("/{name}", self._static)
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=1.0)
        await self._runner.setup()
        try:
            await web.TCPSite(self._runner, HOST, port).start()
        except OSError:
            await self._runner.cleanup()
            raise
        bound = self._runner.addresses[0][1]
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
        for browser in list(self._browsers):
            with contextlib.suppress(ConnectionError, TimeoutError):
                async with asyncio.timeout(FAREWELL):
                    await browser.flush()
            await browser.socket.close(code=1001, message=b"the viewer was closed")
        if self._runner is not None:
            await self._runner.cleanup()
            self._runner = None

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
            self.controls.episode_over(episode)
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
            return web.Response(
                status=403, text="This page answers only to localhost and 127.0.0.1.\n", headers=_HEADERS
            )
        if request.method != "GET":
            return web.Response(status=405, text="Only GET.\n", headers=_HEADERS)
        if self._session(request) is None and not (request.path == "/" and self._has_token(request)):
            return web.Response(status=403, text=_NO_TOKEN, headers=_HEADERS)
        response: web.StreamResponse = await handler(request)
        if not response.prepared:
            response.headers.update(_HEADERS)
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
        if self._player is None:
            self._player = session
        role = PLAYER if session == self._player else WATCHER
        socket = web.WebSocketResponse(heartbeat=HEARTBEAT, max_msg_size=MAX_MESSAGE)
        await socket.prepare(request)
        browser = _Browser(socket, role)
        self._greet(browser)
        sender = asyncio.create_task(browser.send())
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    self._hear(browser, message.data)
        finally:
            self._browsers.discard(browser)
            if role == PLAYER:
                self._count_players(-1)
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sender
        return socket

    def _greet(self, browser: _Browser) -> None:
        """Tell a new page what the others know, then count it among them."""
        browser.say({"type": "hello", "role": browser.role, "demonstrate": self.controls is not None})
        browser.say({"type": "episodes", "episodes": self._episodes})
        if self.controls is not None:
            self._told["demonstration"] = {"type": "demonstration", **self.controls.status()}
        for kind in ("setup", "notice", "demonstration", "playback", "frame"):
            if kind in self._told:
                browser.say(self._told[kind])
        self._browsers.add(browser)
        if browser.role == PLAYER:
            self._count_players(1)

    def _count_players(self, change: int) -> None:
        """Let the demonstration know whether anybody is there to play."""
        self._players += change
        if self.controls is not None:
            self.controls.person(self._players > 0)

    # -- what people ask for ------------------------------------------------------------------------------------------
    def _hear(self, browser: _Browser, text: str) -> None:
        """Take a message of a page; what is malformed, or not for that browser to ask, changes nothing."""
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            message = None
        if not isinstance(message, dict):
            browser.say({"type": "refused", "text": "expected a JSON object"})
        elif browser.role != PLAYER:
            browser.say({"type": "refused", "text": "another browser plays; this one can only watch"})
        elif not self._obey(message):
            browser.say({"type": "refused", "text": f"cannot do {text[:200]}"})

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


def _number(value: Any) -> float:
    """Return a number of a message; 0 for what is none, or beyond all use."""
    return float(value) if isinstance(value, (int, float)) and abs(value) < _HUGE else 0.0


def _episode(episode: Episode) -> dict[str, Any]:
    return {**asdict(episode), "cycles": episode.cycles}


async def serve(
    source: Source, controls: Demonstration | None = None, *, port: int = 0, open_browser: bool = True
) -> Viewer:
    """Show a source on a local web page, and let the first browser play when there are controls.

    Parameters
    ----------
    source : Source
        `rcss_hat.viewer.live.MonitorSource` or `rcss_hat.viewer.playback.Playback`.
    controls : Demonstration, optional
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
