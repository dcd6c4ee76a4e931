"""Whatever bytes arrive, at whatever port: the server lives, its time goes on, and it answers."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from protocol.mutations import mutated
from protocol.recorded import sent
from server_clients import Client, Clients, options, serving

from fake_server.clock import Timing

WORDS = (
    "(init", "(reconnect", "(dispinit", "version", "(turn", "(dash", "(kick", "(say", "(move", "(ear",
    "(change_view", "(compression 3)", "(attentionto", "(pointto", "(tackle", "(catch", "(clang", "(done)",
    "(score)", "(sense_body)", "(bye)", "(synch_see)", "(change_focus", "(dispstart)", "(dispfoul",
    "(dispplayer", "(dispdiscard", "(start)", "(change_mode", "(player", "(ball)", "(look)", "(eye", "on",
    "off", "(recover)", "(check_ball)", "play_on", "goal_l", "free_kick_l", "time_over", "before_kick_off",
    "(change_player_type", "(team_names)", "keepers", "our", "opp", "l", "r", "1", "11", "12", "-1", "0",
    "1e400", "-1e308", "nan", "0.5", '"', "(", ")", " ", "\x00", "\n", "ÿ", "narrow", "high", "low", "wide",
)  # fmt: skip
COMMANDS = (
    b"(move (ball) 1 2 0 1 1)\0", b"(move (player keepers 1) 1 2 30 1 1)\0", b"(dispplayer 1 1 16 16 0)\0",
    b"(dispfoul 16 16 1)\0", b"(change_focus 3 10)\0", b"(dash (l 20 30) (r 30))\0", b"(kick 60 30)(turn_neck 10)\0",
    b"(tackle 30 on)\0", b"(catch 10)\0", b"(pointto 10 30)\0", b"(change_player_type keepers 1 3)\0",
    b"(change_mode free_kick_r)\0", b"(eye on)\0", b"(move -10 10)\0",
)  # fmt: skip
REAL = [datagram.text.encode("latin-1") + b"\0" for datagram in sent()]
texts = st.lists(st.sampled_from(WORDS), max_size=12).map(lambda words: " ".join(words).encode("latin-1"))
datagrams = st.one_of(
    st.binary(max_size=300), texts, texts.map(lambda text: text + b"\0"), mutated([*COMMANDS, *REAL]), mutated(COMMANDS)
)
sendings = st.lists(
    st.tuples(st.sampled_from(["player", "player", "trainer", "monitor", "door", "coach", "online"]), datagrams),
    max_size=30,
)


@pytest.fixture(scope="module", params=["real time", "synch mode"])
def clients(request: pytest.FixtureRequest):
    impatient = Timing(patience=0.002, most_misses=10**9, pause=0.0)
    wanted = options(coach_w_referee=True, keepaway=True, send_comms=True, synch_mode=request.param == "synch mode")
    with serving(wanted, impatient) as clients:
        yield clients


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(sendings)
@example([("player", b"x" * 60_000), ("door", b"(init " + b"x" * 9000), ("trainer", b""), ("monitor", b"")])
@example(
    [("trainer", b"(move (ball) 1e308 -1e308 0 1e308 1e308)\0"), ("player", b"(kick 100 nan)(dash 1e308 1e308)\0")]
)
@example([("trainer", b"(move (player keepers 1) 1e308 -1e308 1e308 1e308 -1e308)\0"), ("player", b"(turn 1e308)\0")])
def test_no_datagram_ends_the_server(clients: Clients, sent: list[tuple[str, bytes]]) -> None:
    server = clients.server
    doors = {"door": server.port, "coach": server.coach_port, "online": server.olcoach_port}
    known = _well_known(clients)
    stranger = Client(server.port)
    for who, data in sent:
        if who in known:
            known[who].socket.sendto(data, known[who].address)
        else:
            stranger.socket.sendto(data, ("127.0.0.1", doors.get(who, server.port)))
    asker = Client(server.port)
    assert asker.ask("(init nobody-else (version 99))", r"\(error").startswith("(error ")
    asker.close()
    stranger.close()
    assert server.running


def test_time_has_gone_on(clients: Clients) -> None:
    """After all of that, which runs before: whoever comes now is shown step after step."""
    monitor = clients.monitor()
    for _ in range(3):
        monitor.until(r"\(show ")


def _well_known(clients: Clients) -> dict[str, Client]:
    """A player, a trainer and a monitor that are in; those who were brought to leave come again."""
    server = clients.server
    found = {}
    for client in clients.all:
        member = server.clients.by_address.get(client.socket.getsockname())
        if member is not None and member.connection.connected:
            found[type(member).__name__.removesuffix("Client").lower()] = client
    for name, first, port in (
        ("trainer", "(init (version 11))", server.coach_port),
        ("monitor", "(dispinit version 4)", server.port),
        ("player", "(init keepers (version 11))", server.port),
    ):
        if name not in found:
            client = clients.open(port)
            client.send(first)
            client.receive()
            if client.address is not None:
                found[name] = client
    for client in found.values():  # keep their queues short
        client.socket.setblocking(False)
        try:
            while client.socket.recv(8192):
                pass
        except BlockingIOError:
            pass
    return found
