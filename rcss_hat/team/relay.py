"""A relay that records everything said between clients and a server.

Every client talks to the relay as if it were the server: its first datagram goes to the relay's port, and the answers
come from a new port, one per client, as the server does it. What is recorded can be served again to clients by
``fake-rcssserver replay``: so a bug seen on a real server becomes a test.
"""

from __future__ import annotations

import asyncio
import gzip
import io
import json
import re
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

import asyncio_dgram
from asyncio_dgram.aio import DatagramServer

from rcss_hat.team.connection import received

_TIME = re.compile(rb"\((?:sense_body|see|see_global|show) (\d+)")
_INIT = re.compile(rb"\((init|reconnect|dispinit)\s*([^\s()]*)")
_INITIALISED = re.compile(rb"\(init ([lr]) (\d+) ")


class TranscriptWriter:
    """Writes a transcript: gzipped JSON lines, one per datagram; flushed often, so that a crash loses little.

    Parameters
    ----------
    path : Path
        ``.jsonl.gz``.
    """

    def __init__(self, path: Path) -> None:
        self._file = gzip.open(path, "wt", encoding="utf-8", errors="backslashreplace")  # noqa: SIM115
        self._start = time.monotonic()
        self.datagrams = 0

    def add(self, client: str, cycle: int, direction: str, data: bytes) -> None:
        """Record one datagram.

        Parameters
        ----------
        client : str
        cycle : int
            Of the last sense_body, see or show that this client received; -1 before.
        direction : {"recv", "send"}
            Server to client, or client to server.
        data : bytes
        """
        entry = {
            "client": client,
            "t_cycle": cycle,
            "t_real": round(time.monotonic() - self._start, 4),
            "dir": direction,
            "text": data.rstrip(b"\0").decode("latin-1"),
        }
        self._file.write(json.dumps(entry) + "\n")
        self.datagrams += 1
        if self.datagrams % 1000 == 0:
            assert isinstance(self._file, io.TextIOWrapper)
            self._file.flush()

    def close(self) -> None:
        """Finish the file."""
        self._file.close()


@dataclass
class _Client:
    name: str
    address: tuple[str, int]
    near: DatagramServer
    far: DatagramServer
    server: tuple[str, int]
    cycle: int = -1
    tasks: list[asyncio.Task[None]] = field(default_factory=list)


class Relay:
    """Stands between clients and a server and records both directions; an asynchronous context manager.

    Parameters
    ----------
    host, port : str, int
        Of the server.
    path : Path
        Transcript to write.
    listen : int
        Port for clients; 0: any.
    bind : str
        Address to listen on; loopback unless told otherwise.
    """

    def __init__(self, host: str, port: int, path: Path, listen: int = 0, bind: str = "127.0.0.1") -> None:
        self.server, self.bind = (host, port), bind
        self.port = listen
        self.transcript = TranscriptWriter(path)
        self._door: DatagramServer | None = None
        self._clients: dict[tuple[str, int], _Client] = {}
        self._task: asyncio.Task[None] | None = None
        self._anonymous = 0

    async def __aenter__(self) -> Relay:
        self._door = await asyncio_dgram.bind((self.bind, self.port))
        self.port = int(self._door.sockname[1])
        self._task = asyncio.create_task(self._welcome())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        tasks = [task for client in self._clients.values() for task in client.tasks]
        if self._task is not None:
            tasks.append(self._task)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for client in self._clients.values():
            client.near.close()
            client.far.close()
        if self._door is not None:
            self._door.close()
        self.transcript.close()

    async def _welcome(self) -> None:
        assert self._door is not None
        while True:
            data, address = received(await self._door.recv())
            client = self._clients.get(address)
            if client is None:
                client = await self._new_client(data, address)
            await self._to_server(client, data)

    async def _new_client(self, first: bytes, address: tuple[str, int]) -> _Client:
        near = await asyncio_dgram.bind((self.bind, 0))
        far = await asyncio_dgram.bind(("0.0.0.0", 0))
        self._anonymous += 1
        found = _INIT.match(first)
        team = found[2].decode("latin-1") if found else ""
        name = f"{team or 'client'}_{self._anonymous}" if not found or found[1] != b"dispinit" else "monitor"
        client = _Client(name, address, near, far, self.server)
        self._clients[address] = client
        client.tasks = [
            asyncio.create_task(self._from_client(client)),
            asyncio.create_task(self._from_server(client, team)),
        ]
        return client

    async def _to_server(self, client: _Client, data: bytes) -> None:
        self.transcript.add(client.name, client.cycle, "send", data)
        await client.far.send(data, client.server)

    async def _from_client(self, client: _Client) -> None:
        while True:
            data, address = received(await client.near.recv())
            if address == client.address:
                await self._to_server(client, data)

    async def _from_server(self, client: _Client, team: str) -> None:
        while True:
            data, address = received(await client.far.recv())
            client.server = address
            found = _INITIALISED.match(data)
            if found:
                client.name = f"{team}_{found[2].decode()}"
            stamp = _TIME.match(data)
            if stamp:
                client.cycle = int(stamp[1])
            self.transcript.add(client.name, client.cycle, "recv", data)
            await client.near.send(data, client.address)
