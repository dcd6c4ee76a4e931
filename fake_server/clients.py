"""Who is connected, and whose datagrams have arrived."""

from __future__ import annotations

import contextlib
import selectors
import socket
from collections.abc import Iterator

from fake_server.connection import Address, Connection
from fake_server.monitor import MonitorClient
from fake_server.player_client import PlayerClient
from fake_server.trainer import TrainerClient
from rcss_hat.simulation.state import N_PLAYERS

Client = PlayerClient | TrainerClient | MonitorClient
_THINK = b"(think)\0"


class Clients:
    """The clients of a server, and the sockets that it reads.

    Attributes
    ----------
    players : list
        The `PlayerClient` of every player index, or None.
    monitors : list of MonitorClient
    trainer : TrainerClient or None
    by_address : dict
        All of them.
    """

    def __init__(self) -> None:
        self.players: list[PlayerClient | None] = [None] * N_PLAYERS
        self.monitors: list[MonitorClient] = []
        self.trainer: TrainerClient | None = None
        self.by_address: dict[Address, Client] = {}
        self._here: list[PlayerClient] = []
        self._everybody = selectors.DefaultSelector()
        self._others = selectors.DefaultSelector()  # all but the players
        self._bell, self._ear = socket.socketpair()
        self._ear.setblocking(False)
        self.watch(self._ear, None)

    # --- who is there ---------------------------------------------------------------------------------------------
    def here(self) -> list[PlayerClient]:
        """Return the players who are there, by index."""
        return self._here

    def add(self, client: Client) -> None:
        """Take a client in; a player who had the place before is forgotten."""
        if isinstance(client, PlayerClient):
            old = self.players[client.i]
            if old is not None:
                self.remove(old)
            self._seat(client.i, client)
        elif isinstance(client, MonitorClient):
            self.monitors.append(client)
        else:
            self.trainer = client
        self.by_address[client.connection.address] = client
        self.watch(client.connection.socket, client)

    def _seat(self, i: int, client: PlayerClient | None) -> None:
        self.players[i] = client
        self._here = [player for player in self.players if player is not None]  # a new list: old ones are gone through

    def remove(self, client: Client) -> None:
        """Forget a client and close the socket."""
        if isinstance(client, PlayerClient):
            self._seat(client.i, None)
        elif isinstance(client, MonitorClient):
            self.monitors.remove(client)
        else:
            self.trainer = None
        connection = client.connection
        for selector in (self._everybody, self._others):
            with contextlib.suppress(KeyError):
                selector.unregister(connection.socket)
        connection.dispose()
        if self.by_address.get(connection.address) is client:
            del self.by_address[connection.address]

    def gone(self) -> list[Client]:
        """Return those who are no longer connected: players, the trainer, monitors."""
        if all(client.connection.connected for client in self.by_address.values()):
            return []
        everybody: list[Client | None] = [*self.players, self.trainer, *self.monitors]
        return [client for client in everybody if client is not None and not client.connection.connected]

    # --- what they send -------------------------------------------------------------------------------------------
    def watch(self, opened: socket.socket, source: Client | int | None) -> None:
        """Note whose datagrams come through a socket: a client's, or those for a known port (its number)."""
        self._everybody.register(opened, selectors.EVENT_READ, source)
        if not isinstance(source, PlayerClient):
            self._others.register(opened, selectors.EVENT_READ, source)

    def wait(self, timeout: float, players: bool) -> list[Client | int]:
        """Return whose datagrams have arrived, after so many seconds at most; of players only if wanted."""
        selector = self._everybody if players else self._others
        sources = [key.data for key, _ in selector.select(timeout)]
        if None in sources:
            with contextlib.suppress(BlockingIOError):
                self._ear.recv(64)
        return [source for source in sources if source is not None]

    def ring(self) -> None:
        """End a wait; may be called from a signal handler or another thread."""
        with contextlib.suppress(OSError):
            self._bell.send(b"\0")

    def close(self) -> None:
        """Close all sockets but those of the known ports."""
        for client in self.by_address.values():
            client.connection.dispose()
        for opened in (self._everybody, self._others, self._bell, self._ear):
            opened.close()

    # --- what they are sent ---------------------------------------------------------------------------------------
    def hold(self) -> None:
        """Keep all messages to players and trainer until `release`."""
        for connection in self._thinking():
            connection.hold()

    def release(self) -> None:
        """Send every player and the trainer what was kept, in a burst."""
        for connection in self._thinking():
            connection.release()

    def _thinking(self) -> Iterator[Connection]:
        for player in self._here:
            yield player.connection
        if self.trainer is not None:
            yield self.trainer.connection

    def start_thinking(self) -> list[PlayerClient | TrainerClient]:
        """Ask everybody to think who was told of a step; returns those who have to answer.

        The original lets players join only while others think, so that a step always comes before the first think.
        """
        thinkers: list[PlayerClient | TrainerClient] = [player for player in self.here() if player.told]
        if self.trainer is not None and self.trainer.eye:
            thinkers.append(self.trainer)
        for client in thinkers:
            client.done = False
            client.connection.send_bytes(_THINK)
        return thinkers
