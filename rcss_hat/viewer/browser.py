"""One connected page: what it is sent, and what of it may be left out."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from rcss_hat.viewer.seat import Visitor

PICTURE = 1.0 / 60.0
"""Seconds between two pictures sent to a page, at least."""


class Browser(Visitor):
    """One connected page. What comes too fast for it is left out; nobody waits for it.

    Parameters
    ----------
    deliver : callable
        Sends a text to the page, whatever lies between; ends with ConnectionError when the page has gone.
    session : str
        Who it is: the same for all pages of one browser, or of one participant.
    """

    def __init__(self, deliver: Callable[[str], Awaitable[None]], session: str) -> None:
        super().__init__(session)
        self._deliver = deliver
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
        """Send what is queued, until cancelled or the page has gone."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            await self.flush()
            await asyncio.sleep(PICTURE)

    async def flush(self) -> None:
        """Send what is queued now."""
        messages, self._messages = self._messages, []
        latest, self._latest = self._latest, {}
        for text in messages:
            await self._deliver(text)
        for message in latest.values():
            await self._deliver(json.dumps(message))
