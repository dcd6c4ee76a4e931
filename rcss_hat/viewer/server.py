"""The local web page: shows a source to browsers, and takes the keys of one of them.

Only this machine can reach it: it listens on the loopback interface, answers only to loopback host names (so that no
foreign name can be pointed at it) or to the public one it was given, takes WebSockets only from its own page, and only
from browsers that opened the link with the token in it. The first browser whose page connects plays; others may watch,
and play when it has gone. What is shown and heard is `rcss_hat.viewer.room`'s; here is only HTTP around it.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import secrets
import sys
import webbrowser
from typing import Any

from aiohttp import WSMsgType, web

from rcss_hat.viewer.audience import Source, WatchError
from rcss_hat.viewer.browser import Browser
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.door import Door
from rcss_hat.viewer.pagefiles import HEADERS, public_origin, static_files
from rcss_hat.viewer.protocol import MAX_MESSAGE
from rcss_hat.viewer.room import Manner, Room

HOST = "127.0.0.1"
LOOPBACK_NAMES = {"127.0.0.1", "localhost"}
HEARTBEAT = 5.0
"""Seconds between two questions whether a page is still there."""
FAREWELL = 0.5
"""Seconds a page gets to take the last messages when the viewer is closed."""

_FOREIGN = "This page answers only to localhost and 127.0.0.1.\n"
_NO_TOKEN = "Open the link that rcss-hat printed: it has a token in it, and this address has not.\n"


class Viewer:
    """A page that shows a source; made by `serve`.

    Parameters
    ----------
    room : Room
    public_url : str, optional
        Under which the page is reached through a reverse proxy.

    Attributes
    ----------
    url : str
        Link with the token, for the browser that is to play.
    """

    def __init__(self, room: Room, public_url: str | None = None) -> None:
        self.room = room
        self.url = ""
        self._public = public_url
        self._origin = None if public_url is None else public_origin(public_url)
        self._token = secrets.token_urlsafe(24)
        self._sessions: set[str] = set()
        self._files = static_files()
        self._cookie = "rcss_hat"
        self._door: Door | None = None
        self._sockets: dict[Browser, web.WebSocketResponse] = {}
        self._source_task: asyncio.Task[None] | None = None

    # -- beginning and end --------------------------------------------------------------------------------------------
    async def start(self, port: int) -> None:
        """Listen, and begin to show the source; nobody is there to play yet."""
        app = web.Application(middlewares=[self._guard], client_max_size=MAX_MESSAGE)
        app.router.add_get("/", self._page)
        app.router.add_get("/socket", self._socket)
        app.router.add_get("/{name}", self._static)
        door = Door(app)
        bound = await door.open(HOST, port)
        self._door = door
        self._cookie = f"rcss_hat_{bound}"
        address = f"http://{HOST}:{bound}/" if self._public is None else self._public.rstrip("/") + "/"
        self.url = f"{address}?token={self._token}"
        self._source_task = asyncio.create_task(self.room.run())

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
        if self.room.failure is not None:
            raise WatchError(self.room.failure)

    async def close(self) -> None:
        """Stop showing, tell the pages, and free the port."""
        if self._source_task is not None:
            self._source_task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._source_task
        self.room.close()
        for browser, socket in list(self._sockets.items()):
            with contextlib.suppress(ConnectionError, TimeoutError):
                async with asyncio.timeout(FAREWELL):
                    await browser.flush()
            await socket.close(code=1001, message=b"the viewer was closed")
        if self._door is not None:
            await self._door.close()
            self._door = None

    async def __aenter__(self) -> Viewer:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    # -- requests -----------------------------------------------------------------------------------------------------
    @web.middleware
    async def _guard(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Refuse foreign names and those without token or session; the rest gets the security headers."""
        if not self._is_ours(request.headers.get("Host", "")):
            return web.Response(status=403, text=_FOREIGN, headers=HEADERS)
        if request.method != "GET":
            return web.Response(status=405, text="Only GET.\n", headers=HEADERS)
        if self._session(request) is None and not (request.path == "/" and self._has_token(request)):
            return web.Response(status=403, text=_NO_TOKEN, headers=HEADERS)
        response: web.StreamResponse = await handler(request)
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    def _is_ours(self, host: str) -> bool:
        """Tell whether a name is one under which this page is reached: with its port, or the public one."""
        return host.rpartition(":")[0] in LOOPBACK_NAMES or (self._origin is not None and host == self._origin[1])

    def _session(self, request: web.Request) -> str | None:
        cookie = request.cookies.get(self._cookie, "")
        return cookie if cookie in self._sessions else None

    def _has_token(self, request: web.Request) -> bool:
        given = request.query.get("token", "")
        return secrets.compare_digest(given.encode(), self._token.encode())

    async def _page(self, request: web.Request) -> web.StreamResponse:
        """Give the page; who has the token and no session yet gets one."""
        response = self._file("index.html" if self.room.controls is None else "play.html")
        if self._session(request) is None:
            session = secrets.token_urlsafe(24)
            self._sessions.add(session)
            secure = self._origin is not None and self._origin[0] == "https"
            response.set_cookie(self._cookie, session, httponly=True, samesite="Strict", path="/", secure=secure)
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
        host, public = request.headers["Host"], self._origin
        own = f"http://{host}" if public is None or host != public[1] else f"{public[0]}://{public[1]}"
        if request.headers.get("Origin") != own:
            return web.Response(status=403, text="Only the viewer's own page may connect.\n")
        session = self._session(request)
        assert session is not None  # the guard lets nobody in without
        socket = web.WebSocketResponse(heartbeat=HEARTBEAT, max_msg_size=MAX_MESSAGE)
        await socket.prepare(request)
        browser = Browser(socket.send_str, session)
        self._sockets[browser] = socket
        self.room.enter(browser)
        sender = asyncio.create_task(browser.send())
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    self.room.hear(browser, message.data)
        finally:
            self.room.leave(browser)
            del self._sockets[browser]
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sender
        return socket


async def serve(
    source: Source,
    controls: Demonstrator | None = None,
    *,
    port: int = 0,
    open_browser: bool = True,
    manner: Manner | None = None,
    public_url: str | None = None,
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
    manner : Manner, optional
        How it is shown.
    public_url : str, optional
        Under which the page is reached through a reverse proxy.

    Returns
    -------
    Viewer
        Running; its ``url`` is for the person, ``close()`` ends it.

    Raises
    ------
    OSError
        When the port is taken.
    """
    viewer = Viewer(Room(source, controls, manner), public_url)
    await viewer.start(port)
    if open_browser and has_desktop():
        await asyncio.to_thread(webbrowser.open, viewer.url)
    return viewer


def has_desktop() -> bool:
    """Tell whether a browser can show a window here; in a bare terminal a text browser might be started in it."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
