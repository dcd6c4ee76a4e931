from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from rcss_hat.keepaway.decision import Decision
from rcss_hat.stage.connection import Connection
from rcss_hat.viewer import live
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.live import MonitorSource
from rcss_hat.viewer.narrator import Insight

from .audience import Remembering, datagrams, until

Address = tuple[str, int]


class RecordedServer(asyncio.DatagramProtocol):
    """Answers a monitor from a new port, as rcssserver does, and plays a recording to it."""

    def __init__(self, recorded: list[bytes], pause: float = 0.001) -> None:
        self.recorded, self.pause = recorded, pause
        self.greetings: list[bytes] = []
        self.farewells: list[bytes] = []
        self.playing: asyncio.Task[None] | None = None
        self.end: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.port = transport.get_extra_info("sockname")[1]

    def datagram_received(self, data: bytes, address: Address) -> None:
        self.greetings.append(data)
        if self.playing is None:
            self.playing = asyncio.create_task(self.play(address))

    async def play(self, address: Address) -> None:
        server = self

        class Session(asyncio.DatagramProtocol):
            def datagram_received(self, data: bytes, address: Address) -> None:
                server.farewells.append(data)

        loop = asyncio.get_running_loop()
        self.end, _ = await loop.create_datagram_endpoint(Session, local_addr=("127.0.0.1", 0))
        for data in self.recorded:
            self.end.sendto(data + b"\0", address)
            await asyncio.sleep(self.pause)

    def stop(self) -> None:
        if self.playing is not None:
            self.playing.cancel()
        if self.end is not None:
            self.end.close()


@asynccontextmanager
async def server(recorded: list[bytes], port: int = 0) -> AsyncIterator[RecordedServer]:
    loop = asyncio.get_running_loop()
    transport, protocol = await loop.create_datagram_endpoint(
        lambda: RecordedServer(recorded), local_addr=("127.0.0.1", port)
    )
    try:
        yield protocol
    finally:
        protocol.stop()
        transport.close()


async def watch(source: MonitorSource, audience: Remembering) -> asyncio.Task[None]:
    return asyncio.create_task(source.run(audience))


async def test_a_server_is_watched_as_a_monitor() -> None:
    recorded = datagrams("monitor-v5.txt.gz")[:140]
    async with server(recorded) as game:
        audience, insight = Remembering(), Insight()
        insight.decided(Decision(30, 3, (1.5,) * 13, 0))
        source = MonitorSource("127.0.0.1", game.port, insight)
        task = await watch(source, audience)
        await until(lambda: audience.frames and audience.frames[-1]["time"] >= 110)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await until(lambda: game.farewells)
    assert game.greetings[0] == b"(dispinit version 4)\0"
    assert game.farewells == [b"(dispbye)\0"]
    assert audience.setups[-1][0].title == f"127.0.0.1:{game.port}" and audience.setups[-1][1] is True
    assert audience.setups[-1][0].teams == ("keepers", "takers")
    assert [(e.start, e.end) for e in audience.ended] == [(0, 32), (32, 52), (52, 63), (63, 103)]
    assert (
        len(audience.frames)
        == len({f["time"] for f in audience.frames}) + sum(f["time"] == 0 for f in audience.frames) - 1
    )
    assert not source.command("pause", 0)


async def test_a_broken_message_is_told_and_the_next_one_shown() -> None:
    recorded = datagrams("monitor-v5.txt.gz")[:40]
    recorded[20] = recorded[20][:200]
    async with server(recorded) as game:
        audience = Remembering()
        task = await watch(MonitorSource("127.0.0.1", game.port), audience)
        await until(lambda: len(audience.frames) >= 38)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
    assert any("could not be read" in notice for notice in audience.notices)


async def test_a_server_that_refuses_is_named_with_what_it_said() -> None:
    async with server([b"(error illegal_client_version)"]) as game:
        with pytest.raises(WatchError, match=r"refuses a monitor of version 4.*illegal_client_version"):
            await MonitorSource("127.0.0.1", game.port).run(Remembering())


@pytest.mark.parametrize("where", [0, 1, 10])
async def test_a_server_that_was_greeted_twice_does_not_refuse(where: int) -> None:
    """It was slow to answer, and says so of the second greeting, perhaps first of all."""
    recorded = datagrams("monitor-v5.txt.gz")[:20]
    recorded.insert(where, b"(error only_init_allowed_on_init_port)")
    async with server(recorded) as game:
        audience = Remembering()
        task = await watch(MonitorSource("127.0.0.1", game.port), audience)
        await until(lambda: len(audience.frames) >= 19)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def test_no_server_is_an_error_that_says_where() -> None:
    async with server([]) as game:
        port = game.port
    with pytest.raises(WatchError, match=rf"no server answers at 127\.0\.0\.1:{port} .*is it running"):
        await MonitorSource("127.0.0.1", port, patience=0.6).run(Remembering())
    with pytest.raises(WatchError, match=r"host 'no\.such\.host\.invalid' is not known"):
        await MonitorSource("no.such.host.invalid", 6000).run(Remembering())


async def test_a_server_that_goes_ends_the_show() -> None:
    async with server(datagrams("monitor-v5.txt.gz")[:20]) as game:
        audience = Remembering()
        with pytest.raises(WatchError, match="has gone"):
            await MonitorSource("127.0.0.1", game.port, patience=0.4).run(audience)
    assert len(audience.frames) == 19


async def test_who_stays_sees_the_server_when_it_comes_back() -> None:
    recorded = datagrams("monitor-v5.txt.gz")[:30]
    audience = Remembering()
    async with server(recorded) as game:
        port = game.port
        task = await watch(MonitorSource("127.0.0.1", port, patience=0.5, stay=True), audience)
        await until(lambda: len(audience.frames) >= 29)
    await until(lambda: any("has gone" in notice for notice in audience.notices))
    async with server(recorded, port):
        await until(lambda: len(audience.frames) >= 58)
    assert audience.notices[-1] == "" or "has gone" in audience.notices[-1]
    assert len(audience.setups) >= 2
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)


class OneMoment(Connection):
    """A connection that has a datagram in the very moment in which the test stops watching, and none after it."""

    waiting: asyncio.Future[bytes] | None = None

    async def open(self, first: bytes, *, attempts: int = 60, pause: float = 0.25) -> bytes:
        OneMoment.waiting = None
        return datagrams("monitor-v5.txt.gz")[0]

    async def receive(self) -> bytes:
        OneMoment.waiting = asyncio.get_running_loop().create_future()
        return await OneMoment.waiting

    async def send(self, data: bytes) -> None:
        assert data == b"(dispbye)\0"


async def test_a_datagram_in_the_last_moment_does_not_keep_us_watching(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live, "Connection", OneMoment)
    watching = asyncio.create_task(MonitorSource("127.0.0.1", 6000).run(Remembering()))
    await until(lambda: OneMoment.waiting)
    assert OneMoment.waiting is not None
    OneMoment.waiting.set_result(datagrams("monitor-v5.txt.gz")[0])
    watching.cancel()
    done, _ = await asyncio.wait({watching}, timeout=5.0)
    assert done and watching.cancelled()
