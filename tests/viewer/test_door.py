"""Connections that never ask, ask nonsense, or are too many."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator

import pytest
from aiohttp import web

from rcss_hat.viewer.door import Door

HALF = b"GET / HTTP/1.1\r\nHost: x\r\n"
WHOLE = HALF + b"\r\n"
NO_HTTP = [
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    b"GET / HTTP/9.9\r\n\r\n",
    b"GET /\r\n\r\n",
    b"nonsense\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost : x\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
    b"GET /" + b"x" * 20_000 + b" HTTP/1.1\r\n\r\n",
    b"GET / HTTP/1.1\r\nX: " + b"y" * 20_000 + b"\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: \x00\r\n\r\n",
    b"\r\n\r\n\r\n",
]


@pytest.fixture
async def app() -> web.Application:
    async def hello(request: web.Request) -> web.Response:
        return web.Response(text="hello")

    async def broken(request: web.Request) -> web.Response:
        raise RuntimeError("a fault of ours")

    app = web.Application()
    app.router.add_get("/", hello)
    app.router.add_get("/broken", broken)
    return app


@pytest.fixture
async def port(app: web.Application) -> AsyncIterator[int]:
    door = Door(app, patience=0.3, most=20)
    yield await door.open("127.0.0.1", 0)
    await door.close()


async def send(port: int, data: bytes) -> asyncio.StreamReader:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(data)
    reader.writer = writer  # type: ignore[attr-defined]  # keep it open
    return reader


async def rest(reader: asyncio.StreamReader, seconds: float = 5.0) -> bytes:
    """Everything until the other side closes."""
    async with asyncio.timeout(seconds):
        try:
            return await reader.read()
        except ConnectionResetError:
            return b""


@pytest.mark.parametrize("data", [b"", b"G", HALF, WHOLE + HALF])
async def test_who_does_not_ask_in_time_is_shown_out(port: int, data: bytes) -> None:
    answer = await rest(await send(port, data))
    assert answer.count(b"200 OK") == data.count(b"\r\n\r\n")


async def test_half_requests_leave_room_for_others(port: int) -> None:
    """Sixty at a time where there is room for twenty: the others are turned away, and all are gone soon."""
    halves = [await send(port, HALF) for _ in range(60)]
    assert await asyncio.gather(*(rest(half) for half in halves)) == [b""] * 60
    answer = await send(port, WHOLE)
    assert b"hello" in await rest(answer)


async def test_what_is_no_http_is_answered_and_not_mentioned(port: int, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        for data in NO_HTTP:
            answer = await rest(await send(port, data))
            assert not answer or answer.split(b" ", 2)[1] in (b"400", b"200"), data
            assert b"Traceback" not in answer
    assert caplog.records == []


async def test_faults_of_our_own_are_mentioned(port: int, caplog: pytest.LogCaptureFixture) -> None:
    answer = await rest(await send(port, WHOLE.replace(b"/ ", b"/broken ")))
    assert b"500" in answer
    assert [record.exc_info[0] for record in caplog.records if record.exc_info] == [RuntimeError]


async def test_a_port_that_is_taken_is_an_error(app: web.Application, port: int) -> None:
    door = Door(app)
    with pytest.raises(OSError):
        await door.open("127.0.0.1", port)
    await door.close()
