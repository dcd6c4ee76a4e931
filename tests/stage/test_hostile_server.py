"""A client whose server says anything at all, over real sockets: it goes on, or ends with an error that says why."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from protocol.mutations import mutated
from protocol.recorded import received

from rcss_hat.keepaway.session import DONE, KeepawayPlayer
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.stage.client import Patience, PlayerClient
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.monitor import Monitor

pytestmark = pytest.mark.compiled
PATIENCE = 20.0
PARAMS = b"(server_param (synch_mode 1) (visible_angle 360))\0"
PLAY_ON = b"(hear 0 referee play_on)\0"
SENSE = b"(sense_body 1 (view_mode high normal) (stamina 8000 1) (speed 0 0) (head_angle 0))\0"
MESSAGES = [d.text.encode("latin-1") + b"\0" for d in received() if not d.text.startswith("(think")]


class Hostile(asyncio.DatagramProtocol):
    """Answers the first datagram with a reply and whatever it was given, and counts the answers."""

    def __init__(self, reply: bytes, told: list[bytes]) -> None:
        self.reply, self.told = reply, told
        self.answered = asyncio.Event()

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def datagram_received(self, data: bytes, address: Any) -> None:
        if data.startswith((b"(init", b"(dispinit")):
            for message in (self.reply, *self.told):
                self.transport.sendto(message, address)
        if data.endswith(DONE):
            self.answered.set()


async def serve(reply: bytes, told: list[bytes]) -> tuple[Hostile, int]:
    loop = asyncio.get_running_loop()
    transport, hostile = await loop.create_datagram_endpoint(lambda: Hostile(reply, told), ("127.0.0.1", 0))
    return hostile, transport.get_extra_info("sockname")[1]


async def play(told: list[bytes]) -> Exception | None:
    """Play until the last ``(think)`` was answered; returns what ended it before."""
    hostile, port = await serve(b"(init l 1 before_kick_off)\0", [PARAMS, PLAY_ON, SENSE, *told, b"(think)\0"])
    client = PlayerClient(KeepawayPlayer("keepers", 3, 2, 1, lambda *_: 0), "127.0.0.1", port)
    await client.connect()
    playing = asyncio.create_task(client.run())
    answered = asyncio.create_task(hostile.answered.wait())
    done, _ = await asyncio.wait([playing, answered], timeout=PATIENCE, return_when=asyncio.FIRST_COMPLETED)
    assert done, "neither an answer nor an error"
    failure = playing.exception() if playing in done else None
    playing.cancel()
    answered.cancel()
    await asyncio.gather(playing, answered, return_exceptions=True)
    await client.close()
    hostile.transport.close()
    assert failure is None or isinstance(failure, Exception)
    return failure


@given(st.lists(st.one_of(mutated(MESSAGES), st.binary(max_size=200)), max_size=8))
def test_a_client_answers_or_says_what_was_wrong(told: list[bytes]) -> None:
    failure = asyncio.run(play(told))
    assert failure is None or (isinstance(failure, RemoteProtocolError) and str(failure))


def test_a_client_answers_a_real_server() -> None:
    assert asyncio.run(play([b"(see 1 ((f c) 10 0))\0", b"(hear 1 self hello)\0"])) is None


async def join(reply: bytes) -> Exception | None:
    hostile, port = await serve(reply, [])
    client = PlayerClient(KeepawayPlayer("keepers", 3, 2, 1, lambda *_: 0), "127.0.0.1", port)
    try:
        await client.connect(attempts=2, patience=Patience(0.01, 0.01, 0.01))
    except (RemoteProtocolError, ServerGone) as error:
        return error
    finally:
        await client.close()
        hostile.transport.close()
    return None


@given(mutated(MESSAGES) | st.binary(min_size=1, max_size=100))
def test_a_client_joins_or_says_why_not(reply: bytes) -> None:
    failure = asyncio.run(join(reply))
    assert failure is None or str(failure)


async def look_for_players(told: list[bytes]) -> Exception | None:
    hostile, port = await serve(b"(show 0 (pm 1))\0", told)
    monitor = Monitor("127.0.0.1", port)
    try:
        await monitor.connect()
        await monitor.look(lambda look: look.counts[0] >= 1, PATIENCE)
    except RemoteProtocolError as error:
        return error
    finally:
        monitor.connection.close()
        hostile.transport.close()
    return None


@settings(max_examples=30)
@given(st.lists(mutated(MESSAGES) | st.binary(max_size=100), max_size=8))
def test_who_waits_for_players_is_not_confused(told: list[bytes]) -> None:
    shown = b"(show 1 (pm 1) (tm a b 0 0) ((b) 0 0 0 0) ((l 1) 0 0x1 -3 -37 0 0 0 0 (v h 90) (s 1 1 1 1) (c 0 0)))\0"
    failure = asyncio.run(look_for_players([*told, shown]))
    assert failure is None or str(failure)
