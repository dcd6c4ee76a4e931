"""A relay that records everything said between clients and a server, and may be as bad as a network can be.

Every client talks to the relay as if it were the server: its first datagram goes to the relay's port, and the answers
come from a new port, one per client, as the server does it. What is recorded can be served again to clients by
``fake-rcssserver replay``: so a bug seen on a real server becomes a test.
"""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import io
import json
import re
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

import asyncio_dgram
import numpy as np
from asyncio_dgram.aio import DatagramServer

from rcss_hat.stage.connection import received

_TIME = re.compile(rb"\((?:sense_body|see|see_global|show) (\d+)")
_INIT = re.compile(rb"\((init|reconnect|dispinit)\s*([^\s()]*)")
HELD_BACK = 0.02
"""Seconds that a datagram is held back."""
_INITIALISED = re.compile(rb"\(init ([lr]) (\d+) ")


@dataclass(frozen=True, slots=True)
class Network:
    """What happens to datagrams on their way, in either direction.

    Attributes
    ----------
    loss, double, reorder : float
        Shares (0 .. 1) of the datagrams that are lost, that come twice, and that are held back by `HELD_BACK` so that
        later ones overtake them.
    delay : float
        Every datagram takes as long as it likes, up to so many seconds.
    seed : int
        Decides which.
    """

    loss: float = 0.0
    double: float = 0.0
    reorder: float = 0.0
    delay: float = 0.0
    seed: int = 0

    @property
    def perfect(self) -> bool:
        """Whether nothing happens to any datagram."""
        return not (self.loss or self.double or self.reorder or self.delay)

    def fate(self, rng: np.random.Generator) -> list[float]:
        """Return after how many seconds each copy of a datagram arrives."""
        if rng.random() < self.loss:
            return []
        copies = 2 if rng.random() < self.double else 1
        held_back = HELD_BACK if rng.random() < self.reorder else 0.0
        return [held_back + self.delay * float(rng.random()) for _ in range(copies)]


class TranscriptWriter:
    """Writes a transcript: gzipped JSON lines, one per datagram; flushed often, so that a crash loses little.

    Parameters
    ----------
    path : Path
        ``.jsonl.gz``.

    Attributes
    ----------
    datagrams : int
        Recorded so far.
    failure : OSError or None
        Why nothing more is recorded, on a full disk for example; what is relayed is relayed all the same.
    """

    def __init__(self, path: Path) -> None:
        self._file = gzip.open(path, "wt", encoding="utf-8", errors="backslashreplace")  # noqa: SIM115
        self._start = time.monotonic()
        self.datagrams = 0
        self.failure: OSError | None = None

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
        if self.failure is not None:
            return
        entry = {
            "client": client,
            "t_cycle": cycle,
            "t_real": round(time.monotonic() - self._start, 4),
            "dir": direction,
            "text": data.rstrip(b"\0").decode("latin-1"),
        }
        try:
            self._file.write(json.dumps(entry) + "\n")
            self.datagrams += 1
            if self.datagrams % 1000 == 0:
                assert isinstance(self._file, io.TextIOWrapper)
                self._file.flush()
        except OSError as problem:
            self.failure = problem

    def close(self) -> None:
        """Finish the file."""
        try:
            self._file.close()
        except OSError as problem:
            self.failure = self.failure or problem


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
    path : Path or None
        Transcript to write, if any.
    listen : int
        Port for clients; 0: any.
    bind : str
        Address to listen on; loopback unless told otherwise.
    network : Network
        What happens to the datagrams; the transcript has what was sent.
    """

    def __init__(
        self,
        host: str,
        port: int,
        path: Path | None,
        listen: int = 0,
        bind: str = "127.0.0.1",
        network: Network = Network(),
    ) -> None:
        self.server, self.bind = (host, port), bind
        self.port = listen
        self.transcript = None if path is None else TranscriptWriter(path)
        self.network = network
        self._rng = np.random.default_rng(network.seed)
        self._under_way: set[asyncio.Task[None]] = set()
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
        tasks += self._under_way
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for client in self._clients.values():
            client.near.close()
            client.far.close()
        if self._door is not None:
            self._door.close()
        if self.transcript is not None:
            self.transcript.close()

    @property
    def datagrams(self) -> int:
        """How many were recorded."""
        return 0 if self.transcript is None else self.transcript.datagrams

    @property
    def failure(self) -> OSError | None:
        """Why the transcript ends before the match does, if it does."""
        return None if self.transcript is None else self.transcript.failure

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
        if self.transcript is not None:
            self.transcript.add(client.name, client.cycle, "send", data)
        await self._deliver(data, client.far, client.server)

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
            if self.transcript is not None:
                self.transcript.add(client.name, client.cycle, "recv", data)
            await self._deliver(data, client.near, client.address)

    async def _deliver(self, data: bytes, stream: DatagramServer, address: tuple[str, int]) -> None:
        if self.network.perfect:
            return await stream.send(data, address)
        for delay in self.network.fate(self._rng):
            task = asyncio.create_task(_later(delay, data, stream, address))
            self._under_way.add(task)
            task.add_done_callback(self._under_way.discard)
        return None


async def _later(delay: float, data: bytes, stream: DatagramServer, address: tuple[str, int]) -> None:
    if delay:
        await asyncio.sleep(delay)
    with contextlib.suppress(OSError, asyncio_dgram.TransportClosed):  # somebody has left meanwhile
        await stream.send(data, address)
