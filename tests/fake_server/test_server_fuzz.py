"""Whatever bytes arrive, at whatever port: the server lives and goes on answering."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from server_clients import Client, Clients, options, serving

WORDS = (
    "(init", "(reconnect", "(dispinit", "version", "(turn", "(dash", "(kick", "(say", "(move", "(ear",
    "(change_view", "(compression 3)", "(attentionto", "(pointto", "(tackle", "(catch", "(clang", "(done)",
    "(score)", "(sense_body)", "(bye)", "(synch_see)", "(change_focus", "(dispstart)", "(dispfoul",
    "(dispplayer", "(dispdiscard", "(start)", "(change_mode", "(player", "(ball)", "(look)", "(eye", "on",
    "off", "(recover)", "(check_ball)", "play_on", "goal_l", "free_kick_l", "time_over", "before_kick_off",
    "(change_player_type", "(team_names)", "keepers", "our", "opp", "l", "r", "1", "11", "12", "-1", "0",
    "1e400", "-1e308", "nan", "0.5", '"', "(", ")", " ", "\x00", "\n", "ÿ", "narrow", "high", "low", "wide",
)  # fmt: skip
texts = st.lists(st.sampled_from(WORDS), max_size=12).map(lambda words: " ".join(words).encode("latin-1"))
datagrams = st.one_of(st.binary(max_size=300), texts, texts.map(lambda text: text + b"\0"))


@pytest.fixture(scope="module")
def clients():
    with serving(options(coach_w_referee=True, keepaway=True)) as clients:
        yield clients


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.sampled_from(["player", "trainer", "monitor", "door", "coach", "online"]), datagrams)))
def test_no_datagram_ends_the_server(clients: Clients, sent: list[tuple[str, bytes]]) -> None:
    server = clients.server
    doors = {"door": server.port, "coach": server.coach_port, "online": server.olcoach_port}
    known = _well_known(clients)
    stranger = Client(server.port)
    for who, data in sent:
        if who in known:
            known[who].socket.sendto(data, known[who].address)
        else:
            stranger.socket.sendto(data, ("127.0.0.1", doors[who]))
    asker = Client(server.port)
    assert asker.ask("(init nobody-else (version 99))", r"\(error").startswith("(error ")
    asker.close()
    stranger.close()
    assert server.running


def _well_known(clients: Clients) -> dict[str, Client]:
    """A player, a trainer and a monitor that are in; those who were brought to leave come again."""
    server = clients.server
    found = {}
    for client in clients.all:
        member = server.clients.get(client.socket.getsockname())
        if member is not None and member.connection is not None and member.connection.connected:
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
