"""Clients over loopback for tests of the server."""

from __future__ import annotations

import re
import socket
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fake_server.clock import Timing
from fake_server.options import ServerOptions
from fake_server.running import running_server
from fake_server.server import Server
from rcss_hat.protocol.params import ServerParams, Value

PATIENCE = 20.0
FAST = Timing(patience=PATIENCE, pause=0.002, monitor_pause=0.0)
_PARAMETERS = ("(server_param", "(player_param", "(player_type")


def options(seed: int | None = 1, profile: str = "19.0", **changes: Value) -> ServerOptions:
    """Options of a quiet server on any free ports, without logs."""
    quiet: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    quiet |= dict.fromkeys(("game_logging", "text_logging", "keepaway_logging"), False)
    return ServerOptions(params=ServerParams(profile, **quiet | changes), seed=seed, quiet=True)


def keepaway(folder: Path | None = None, seed: int = 1, **changes: Value) -> ServerOptions:
    """Options of Keepaway in synch mode, with full vision."""
    task: dict[str, Value] = {"keepaway": True, "synch_mode": True, "synch_offset": 80, "visible_angle": 360.0}
    task |= {"half_time": -1, "use_offside": False, "forbid_kick_off_offside": False, "stamina_inc_max": 3500.0}
    if folder is not None:
        task |= {"keepaway_logging": True, "keepaway_log_dir": str(folder), "keepaway_log_fixed": True}
    return options(seed, **task | changes)


class Client:
    """A UDP client that speaks text and waits for what it expects."""

    def __init__(self, port: int) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.door = ("127.0.0.1", port)
        self.address: tuple[str, int] | None = None
        self.got: list[str] = []

    def send(self, text: str, end: str = "\0", to_door: bool = False) -> None:
        address = self.door if to_door or self.address is None else self.address
        self.socket.sendto((text + end).encode("latin-1"), address)

    def receive_bytes(self, timeout: float = PATIENCE) -> bytes:
        """Next datagram; TimeoutError when none comes."""
        self.socket.settimeout(timeout)
        data, address = self.socket.recvfrom(8192)
        if address != self.door:
            self.address = address
        return data

    def receive(self, timeout: float = PATIENCE) -> str:
        data = self.receive_bytes(timeout)
        assert data.endswith(b"\0")
        self.got.append(data[:-1].decode("latin-1"))
        return self.got[-1]

    def until(self, pattern: str, timeout: float = PATIENCE) -> list[str]:
        """Messages up to the first one that matches a regular expression from its start on."""
        messages: list[str] = []
        give_up = time.monotonic() + timeout
        while True:
            left = give_up - time.monotonic()
            if left <= 0.0:
                raise AssertionError(f"no {pattern!r} in {messages[-10:]}")
            try:
                messages.append(self.receive(left))
            except TimeoutError:
                continue
            if re.match(pattern, messages[-1]):
                return messages

    def ask(self, text: str, pattern: str, **how: str) -> str:
        """Send, and return the first message that matches."""
        self.send(text, **how)
        return self.until(pattern)[-1]

    def join(self, init: str) -> str:
        """Send an init, return the reply and leave out the parameters."""
        reply = self.ask(init, r"\((init|reconnect|error)")
        if not reply.startswith("(error"):
            self.until(r"\(player_type \(id (17|6)\)")
        return reply

    def quiet_for(self, seconds: float) -> bool:
        """Whether nothing at all comes for so long."""
        try:
            self.receive(seconds)
        except TimeoutError:
            return True
        return False

    def close(self) -> None:
        self.socket.close()


class Clients:
    """Opens clients and closes all of them."""

    def __init__(self, server: Server) -> None:
        self.server = server
        self.all: list[Client] = []

    def open(self, port: int | None = None) -> Client:
        client = Client(self.server.port if port is None else port)
        self.all.append(client)
        return client

    def player(self, team: str = "keepers", version: int = 11) -> Client:
        client = self.open()
        assert client.join(f"(init {team} (version {version}))").startswith("(init")
        return client

    def trainer(self, version: int = 11) -> Client:
        client = self.open(self.server.coach_port)
        assert client.join(f"(init (version {version}))") == "(init ok)"
        return client

    def monitor(self, version: int = 4) -> Client:
        client = self.open()
        client.send(f"(dispinit version {version})")
        client.until(r"\(player_type \(id 17\)")
        return client


@contextmanager
def serving(
    wanted: ServerOptions,
    timing: Timing | None = FAST,
    on_episode: Callable[[int, int, int, bool], None] | None = None,
) -> Iterator[Clients]:
    """A running server, and clients for it."""
    with running_server(wanted, timing=timing, on_episode=on_episode) as server:
        clients = Clients(server)
        try:
            yield clients
        finally:
            for client in clients.all:
                client.close()


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until something holds of the server."""
    give_up = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < give_up, "it never came about"
        time.sleep(0.002)


def without_parameters(messages: list[str]) -> list[str]:
    return [message for message in messages if not message.startswith(_PARAMETERS)]


def packed(text: str) -> bytes:
    stream = zlib.compressobj(6)
    return stream.compress(text.encode("latin-1") + b"\0") + stream.flush(zlib.Z_SYNC_FLUSH)
