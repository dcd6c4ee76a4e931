"""Matches over a network that loses, doubles, reorders and delays: counted as the server does, or refused."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from asyncio_dgram.aio import DatagramServer
from serving import serving

from fake_server.options import parse_options
from fake_server.running import running_server
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway import session
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.stage.client import Patience, PlayerClient
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.monitor import Monitor
from rcss_hat.stage.options import server_options
from rcss_hat.stage.relay import HELD_BACK, Network, Relay

pytestmark = pytest.mark.compiled
TASK = Task()
HASTY = Patience(again=0.05, late=0.1, looking=5.0)


async def match(network: Network, episodes: int) -> tuple[RunReport, list[Episode]]:
    """Play on a server behind a relay; returns what was reported and what the server has logged."""
    policy = load_policy("hold", 3, 2, 1)
    policy.warm_up()
    report = RunReport("relay", "hold", "hand", TASK.size, TASK.field, TASK.vision, 1)
    with serving(TASK) as server:
        async with Relay(server.host, server.port, None, network=network) as relay:
            await play_match(report, Match(TASK, (relay.bind, relay.port), 1, policy, True, episodes))
        return report, server.episodes()


@pytest.mark.parametrize(
    "network",
    [
        Network(loss=0.02, seed=1),
        Network(double=0.2, seed=2),
        Network(reorder=0.3, seed=3),
        Network(loss=0.02, double=0.2, reorder=0.1, delay=0.02, seed=4),
    ],
)
def test_what_a_bad_network_leaves_is_counted_as_the_server_does(
    network: Network, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session, "SILENT", 0.1)  # for this network is near
    monkeypatch.setattr(session, "OVERDUE", 0.05)
    report, logged = asyncio.run(match(network, 2))
    assert report.failure is None
    assert [(e.start, e.end) for e in report.episodes] == [(e.start, e.end) for e in logged[:2]]


def test_a_network_that_lets_nothing_through_is_refused() -> None:
    client = PlayerClient(KeepawayPlayer("keepers", 3, 2, 1, lambda *_: 0), "127.0.0.1", 0)

    async def join(port: int) -> None:
        async with Relay("127.0.0.1", port, None, network=Network(loss=1.0)) as relay:
            client._port = relay.port
            await client.connect(attempts=3, patience=HASTY)

    with running_server(options(True)) as server, pytest.raises(ServerGone, match="no server answers"):
        asyncio.run(join(server.port))


# -- joining -----------------------------------------------------------------------------------------------------------
class Picky(Relay):
    """Loses the first datagrams that begin in some way, or brings them last."""

    def __init__(self, port: int, lost: list[bytes], late: bytes | None = None) -> None:
        super().__init__("127.0.0.1", port, None)
        self.lost, self.late = list(lost), late

    async def _deliver(self, data: bytes, stream: DatagramServer, address: tuple[str, int]) -> None:
        for beginning in self.lost:
            if data.startswith(beginning):
                self.lost.remove(beginning)
                return
        if self.late is not None and data.startswith(self.late):
            self.late = None
            asyncio.get_running_loop().call_later(0.02, lambda: asyncio.ensure_future(stream.send(data, address)))
            return
        await stream.send(data, address)


def options(synch: bool):  # type: ignore[no-untyped-def]
    given = server_options(
        TASK, real=False, port=0, coach_port=0, olcoach_port=0, keepaway_logging=False, synch_mode=synch
    )
    return parse_options(given)


def places(lost: list[bytes], late: bytes | None = None, players: int = 2) -> list[tuple[int, int]]:
    """Let players of two teams join behind a picky relay; returns the sides and numbers they think they have."""

    async def join(port: int) -> list[tuple[int, int]]:
        async with Picky(port, lost, late) as relay:
            clients = [
                PlayerClient(KeepawayPlayer(team, 3, 2, 1, lambda *_: 0), "127.0.0.1", relay.port)
                for team in ("keepers", "takers")[:players]
            ]
            for client in clients:
                await client.connect(patience=HASTY)
            monitor = Monitor("127.0.0.1", port)
            await monitor.connect()
            await monitor.look(lambda look: look.counts == (1, players - 1), 10.0)
            monitor.connection.close()
            for client in clients:
                assert client.player.params["keepaway"] and client.player.mode == "before_kick_off"
                await client.close()
        assert relay.lost == []
        return [(client.player.side, client.player.unum) for client in clients]

    with running_server(options(False)) as server:
        return asyncio.run(join(server.port))


@pytest.mark.parametrize(
    "lost",
    [
        [],
        [b"(init keepers", b"(init keepers", b"(init takers"],
        [b"(server_param"],
        [b"(server_param", b"(server_param"],
        [b"(init l"],
        [b"(init r"],
        [b"(init r", b"(server_param", b"(server_param"],
    ],
)
def test_a_greeting_that_was_lost_makes_no_second_player(lost: list[bytes]) -> None:
    assert places(lost) == [(1, 1), (2, 1)]


@pytest.mark.parametrize("late", [b"(init l", b"(server_param"])
def test_a_greeting_in_another_order_is_the_same(late: bytes) -> None:
    assert places([], late) == [(1, 1), (2, 1)]


def test_refusals_are_short_and_escaped() -> None:
    async def join() -> str:
        loop = asyncio.get_running_loop()

        class Rude(asyncio.DatagramProtocol):
            def connection_made(self, transport) -> None:  # type: ignore[no-untyped-def]
                self.transport = transport

            def datagram_received(self, data: bytes, address) -> None:  # type: ignore[no-untyped-def]
                self.transport.sendto(b"(error \x1b]0;title\x07 " + b"x" * 4000 + b")\0", address)

        transport, _ = await loop.create_datagram_endpoint(Rude, ("127.0.0.1", 0))
        port = transport.get_extra_info("sockname")[1]
        client = PlayerClient(KeepawayPlayer("keepers", 3, 2, 1, lambda *_: 0), "127.0.0.1", port)
        with pytest.raises(RemoteProtocolError) as raised:
            await client.connect(attempts=2, patience=HASTY)
        await client.close()
        transport.close()
        return str(raised.value)

    said = asyncio.run(join())
    assert said.startswith("the server refuses 'keepers': \\x1b]0;title\\x07 x")
    assert said.isprintable() and len(said) <= 200


# -- the relay ---------------------------------------------------------------------------------------------------------
def test_the_seed_decides_what_happens_to_datagrams() -> None:
    network = Network(loss=0.2, double=0.2, reorder=0.3, delay=0.15)
    fates = [network.fate(np.random.default_rng(5)) for _ in range(2)]
    assert fates[0] == fates[1]
    rng = np.random.default_rng(1)
    many = [network.fate(rng) for _ in range(4000)]
    arrived = [fate for fate in many if fate]
    assert np.mean([not fate for fate in many]) == pytest.approx(0.2, abs=0.03)
    assert np.mean([len(fate) == 2 for fate in arrived]) == pytest.approx(0.2, abs=0.03)
    assert max(delay for fate in many for delay in fate) < 0.15 + HELD_BACK
    assert Network().fate(rng) == [0.0]
