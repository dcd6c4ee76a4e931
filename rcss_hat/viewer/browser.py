"""One connected page of the viewer: what it is sent, and what of it may be left out."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping
from typing import Any

from aiohttp import web

from rcss_hat.viewer.seat import Visitor

PICTURE = 1.0 / 60.0
"""Seconds between two pictures sent to a page, at least."""


class Browser(Visitor):
    """One connected page. What comes too fast for it is left out; nobody waits for it."""

    def __init__(self, socket: web.WebSocketResponse, session: str) -> None:
        super().__init__(session)
        self.socket = socket
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
