"""Connections to the page: how many there may be, how long they may take to ask, and what is said of broken ones."""

from __future__ import annotations

import asyncio
import logging
from typing import cast

from aiohttp import http_exceptions, web

PATIENCE = 5.0
"""Seconds within which a connection has to ask for something."""
MAX_CONNECTIONS = 600
"""Connections at a time; what comes on top is closed at once."""


def quiet_logger() -> logging.Logger:
    """Return a logger that does not mention requests that are no HTTP: whoever sends them is told, nobody else."""
    logger = logging.getLogger("rcss_hat.viewer.door")
    if not logger.filters:
        logger.addFilter(_is_ours)
    return logger


def _is_ours(record: logging.LogRecord) -> bool:
    kind = record.exc_info[0] if record.exc_info else None
    return kind is None or not issubclass(kind, http_exceptions.HttpProcessingError)


class _TurnedAway(asyncio.Protocol):
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        cast(asyncio.Transport, transport).abort()


class Door:
    """Listens for an application on one port of one interface.

    Parameters
    ----------
    app : web.Application
    patience : float
        Seconds within which a connection has to ask for something.
    most : int
        Connections at a time.
    """

    def __init__(self, app: web.Application, patience: float = PATIENCE, most: int = MAX_CONNECTIONS) -> None:
        self._runner = web.AppRunner(
            app,
            access_log=None,
            logger=quiet_logger(),
            keepalive_timeout=patience,
            lingering_time=1.0,
            shutdown_timeout=1.0,
        )
        self._most = most
        self._listener: asyncio.Server | None = None

    async def open(self, host: str, port: int) -> int:
        """Listen; returns the port.

        Raises
        ------
        OSError
            When the port is taken.
        """
        await self._runner.setup()
        server = self._runner.server
        assert server is not None

        def protocol() -> asyncio.Protocol:
            return _TurnedAway() if len(server.connections) >= self._most else server()

        try:
            self._listener = await asyncio.get_running_loop().create_server(protocol, host, port)
        except OSError:
            await self._runner.cleanup()
            raise
        bound: int = self._listener.sockets[0].getsockname()[1]
        return bound

    async def close(self) -> None:
        """Close all connections, and free the port."""
        if self._listener is not None:
            self._listener.close()
        await self._runner.cleanup()
