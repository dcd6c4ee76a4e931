"""A page of a game that is connected to the server: what it is sent, how fast, and how much it may say."""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections import deque

from aiohttp import web

from rcss_hat.viewer.protocol import MAX_MESSAGE

HEARTBEAT = 5.0
"""Seconds between two questions whether a page is still there."""
BURST, PER_S = 400, 100.0
"""Messages a page may send at once, and per second."""
MOST_WAITING = 2_000
"""Messages that may wait for a page before it is given up."""
SLOW = 3
"""So many messages may wait before pictures are left out."""
REPLACED = 4001
"""Code with which a page is closed for another one of the same participant."""
_PICTURE = '{"type": "frame"'


class GamePage:
    """A connected page.

    Parameters
    ----------
    number : int

    Attributes
    ----------
    socket : web.WebSocketResponse
    """

    def __init__(self, number: int) -> None:
        self.number = number
        self.socket = web.WebSocketResponse(heartbeat=HEARTBEAT, max_msg_size=MAX_MESSAGE)
        self._waiting: deque[str] = deque()
        self._wake = asyncio.Event()
        self._sender: asyncio.Task[None] | None = None
        self._closing: asyncio.Task[None] | None = None
        self._may_say, self._since = float(BURST), time.monotonic()

    async def open(self, request: web.Request) -> None:
        """Take the connection."""
        await self.socket.prepare(request)
        self._sender = asyncio.create_task(self._send())

    def takes(self, text: str) -> bool:
        """Whether the page may say one thing more; one that says too much is closed."""
        now = time.monotonic()
        self._may_say = min(BURST, self._may_say + (now - self._since) * PER_S) - 1.0
        self._since = now
        return self._may_say >= 0.0

    def say(self, text: str) -> None:
        """Send a message; a picture is left out when the page is slow."""
        if text.startswith(_PICTURE) and len(self._waiting) >= SLOW:
            return
        if len(self._waiting) >= MOST_WAITING:
            self._close_soon(1008)
            return
        self._waiting.append(text)
        self._wake.set()

    def go_on(self) -> None:
        """Let it load the participant's next step."""
        self.say(json.dumps({"type": "farewell", "url": "./", "kept": 0, "episodes": None, "file": None, "next": None}))

    def replaced(self) -> None:
        """Tell it that another page was opened, and close it."""
        self._close_soon(REPLACED)

    def _close_soon(self, code: int) -> None:
        if self._closing is None:
            self._closing = asyncio.create_task(self.close(code))

    async def _send(self) -> None:
        with contextlib.suppress(ConnectionError):
            while True:
                await self._wake.wait()
                self._wake.clear()
                while self._waiting:
                    await self.socket.send_str(self._waiting.popleft())

    async def close(self, code: int) -> None:
        """Close the connection."""
        if self._sender is not None:
            self._sender.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._sender
        with contextlib.suppress(ConnectionError, TimeoutError):
            async with asyncio.timeout(2.0):
                await self.socket.close(code=code)
