"""One client's socket, on real sockets of this machine."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator

import pytest

from rcss_hat.stage.connection import AT_A_TIME, Connection, ServerGone

Answering = tuple[Connection, socket.socket]


@pytest.fixture
async def joined() -> AsyncIterator[Answering]:
    """A connection, and the server's end of it."""
    server = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    server.bind(("127.0.0.1", 0))
    server.setblocking(False)
    connection = Connection("127.0.0.1", server.getsockname()[1], "keeper 1")
    opening = asyncio.create_task(connection.open(b"hello\0"))
    first, address = await asyncio.get_running_loop().sock_recvfrom(server, 100)
    assert first == b"hello\0"
    server.connect(address)
    server.send(b"welcome\0")
    assert await opening == b"welcome\0"
    yield connection, server
    connection.close()
    server.close()


async def test_datagrams_are_awaited_one_by_one(joined: Answering) -> None:
    connection, server = joined
    server.send(b"one\0")
    server.send(b"two\0")
    assert [await connection.receive(), await connection.receive()] == [b"one\0", b"two\0"]
    await connection.send(b"three\0")
    connection.send_now(b"four\0")
    loop = asyncio.get_running_loop()
    assert [await loop.sock_recv(server, 100) for _ in range(2)] == [b"three\0", b"four\0"]


async def test_who_listens_is_given_all_that_came_in_its_order(joined: Answering) -> None:
    connection, server = joined
    sent = [b"%d\0" % k for k in range(2 * AT_A_TIME + 1)]
    taken: list[bytes] = []
    for data in sent:
        server.send(data)
    all_came = asyncio.Event()

    def take(data: bytes) -> None:
        taken.append(data)
        if len(taken) == len(sent):
            all_came.set()

    connection.listen(take, pytest.fail)
    await asyncio.wait_for(all_came.wait(), 5.0)
    assert taken == sent
    connection.deaf()
    server.send(b"late\0")
    assert await connection.receive() == b"late\0"
    assert taken == sent


async def test_a_fault_of_who_listens_ends_it_and_is_told(joined: Answering) -> None:
    connection, server = joined
    told: asyncio.Future[Exception] = asyncio.get_running_loop().create_future()

    def take(data: bytes) -> None:
        raise FileNotFoundError(data.decode())  # no fault of the network's

    connection.listen(take, told.set_result)
    server.send(b"one\0")
    server.send(b"two\0")
    assert isinstance(await asyncio.wait_for(told, 5.0), FileNotFoundError)
    assert await connection.receive() == b"two\0"


async def test_a_server_that_has_gone_is_noticed(joined: Answering) -> None:
    connection, server = joined
    told: asyncio.Future[Exception] = asyncio.get_running_loop().create_future()
    connection.listen(lambda data: None, told.set_result)
    server.close()
    connection.send_now(b"anybody?\0")
    error = await asyncio.wait_for(told, 5.0)
    assert isinstance(error, ServerGone) and "keeper 1: the server at 127.0.0.1" in str(error)


async def test_what_the_network_cannot_take_at_once_is_sent_later(
    joined: Answering, monkeypatch: pytest.MonkeyPatch
) -> None:
    connection, server = joined

    class Full:
        def send(self, data: bytes) -> int:
            raise BlockingIOError

    with monkeypatch.context() as patch:
        own = connection._socket
        patch.setattr(connection, "_socket", Full())
        connection.send_now(b"late\0")
        connection._socket = own
    assert await asyncio.wait_for(asyncio.get_running_loop().sock_recv(server, 100), 5.0) == b"late\0"
