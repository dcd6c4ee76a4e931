"""The three known ports: first datagrams of players and monitors, of the trainer, of online coaches.

Everything after the first datagram goes through a client's own port. The answers to those who are refused come from the
known port (19.0.0, src/stadium.cpp).
"""

from __future__ import annotations

import contextlib
import math
import socket
import sys
from collections.abc import Iterator, Sequence

from fake_server import text
from fake_server.clients import Client, Clients
from fake_server.connection import Address, Connection, Nobody
from fake_server.game import Game, JoinError
from fake_server.monitor import JSON, VERSIONS, MonitorClient
from fake_server.options import PROGRAM, ServerOptions
from fake_server.player_client import PlayerClient
from fake_server.reactions import Arrival, Datagram, Reaction
from fake_server.trainer import TrainerClient
from rcss_hat.protocol import commands as said
from rcss_hat.protocol import messages
from rcss_hat.protocol.records import MAX_PLAYERS

_ILLEGAL_VERSION = "(error illegal_client_version)"
_UNKNOWN = "(error unknown_command)"
_MOST_REFUSALS = 100
"""Refused versions that are named; the console is not for whoever sends a million of them."""
NO_ONLINE_COACH = "(error online_coach_not_supported)"
"""Answer to online coaches: an own one, for the original has them."""


class Reception:
    """The sockets of the known ports.

    Parameters
    ----------
    options : ServerOptions
    game : Game
    clients : Clients
        Who is in.

    Attributes
    ----------
    port, coach_port, olcoach_port : int
        Those really bound.

    Raises
    ------
    OSError
        When a port cannot be had; names it.
    """

    def __init__(self, options: ServerOptions, game: Game, clients: Clients) -> None:
        self._options, self._game, self._clients = options, game, clients
        self._refused: set[tuple[str, float, str]] = set()
        self.doors: list[socket.socket] = []
        try:
            for name in ("port", "coach_port", "olcoach_port"):
                self.doors.append(self._open(name))
        except OSError:
            self.close()
            raise
        self.port, self.coach_port, self.olcoach_port = (int(door.getsockname()[1]) for door in self.doors)

    def _open(self, name: str) -> socket.socket:
        bind = self._options.bind
        port = int(self._options.params.number(name))
        door = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        door.setblocking(False)
        try:
            door.bind((bind, port))
        except OSError as error:
            door.close()
            raise OSError(f"cannot listen on {bind}, UDP port {port} (server::{name}): {error.strerror}") from None
        return door

    def close(self) -> None:
        """Close the sockets."""
        for door in self.doors:
            door.close()

    def read(self, number: int) -> Iterator[tuple[Client, Reaction]]:
        """Read all datagrams that have arrived at a door: 0 players and monitors, 1 trainer, 2 online coaches.

        Yields
        ------
        Client
            Who came, or was there.
        Reaction
            What is to be done about him, before the next is read. Who is refused was told so.
        """
        door = self.doors[number]
        while True:
            try:
                data, address = door.recvfrom(said.MAX_DATAGRAM)
            except OSError:
                return
            try:
                yield from self._react(number, data, address)
            except JoinError as refusal:
                with contextlib.suppress(OSError):
                    door.sendto(str(refusal).encode("latin-1") + b"\0", address)

    def _react(self, number: int, data: bytes, address: Address) -> Iterator[tuple[Client, Reaction]]:
        known = self._clients.by_address.get(address)
        if known is not None and known.connection.connected:
            if isinstance(known, MonitorClient) and known.version == 1:
                yield known, Datagram(data)
            else:
                known.connection.send("(error only_init_allowed_on_init_port)")
        elif number == 0:
            yield self._welcome(data, address)
        elif number == 1:
            yield from self._welcome_trainer(data, address)
        else:
            raise JoinError(NO_ONLINE_COACH)

    def _check_version(self, who: str, version: float, address: Address) -> None:
        """Say on the console which version of a player or trainer is refused."""
        game = self._game
        if not game.knows_version(version):
            self._name_version(who, version, address, game.versions)

    def _name_version(self, who: str, version: float, address: Address, served: Sequence[int]) -> None:
        """Say on the console which version is refused, once for each computer and version."""
        refusal = (who, version, address[0])
        if refusal in self._refused or len(self._refused) >= _MOST_REFUSALS:
            return
        self._refused.add(refusal)
        print(
            f"{PROGRAM}: {address[0]}:{address[1]}: a {who} of protocol version {version:g} was refused; "
            f"versions {served[0]} to {served[-1]} are served",
            file=sys.stderr,
            flush=True,
        )

    def _connect(self, address: Address) -> Connection:
        try:
            return Connection(self._options.bind, address)
        except OSError:
            raise JoinError("(error connection_failed)") from None

    def _welcome(self, data: bytes, address: Address) -> tuple[Client, Arrival]:
        command = said.parse_init(data, self._game.params.profile)
        if isinstance(command, said.Refusal):
            raise JoinError(command.text)
        if isinstance(command, said.DispInit):
            return self._welcome_monitor(command.version, data, address)
        return self._welcome_player(command, data, address)

    def _welcome_player(
        self, command: said.Init | said.Reconnect, data: bytes, address: Address
    ) -> tuple[Client, Arrival]:
        game = self._game
        new = isinstance(command, said.Init)
        if isinstance(command, said.Init):
            self._check_version("player", command.version, address)
            i = game.join(command.team, command.version, command.goalie)
        else:
            i = game.rejoin(command.team, command.unum)
        side, unum, mode = "l" if i < MAX_PLAYERS else "r", game.unum(i), game.mode_name
        try:
            player = PlayerClient(game, i, self._connect(address))
        except JoinError:
            game.leave(i)
            raise
        place = messages.Init(side=side, unum=unum, mode=mode) if new else messages.Reconnect(side=side, mode=mode)
        welcome = player.welcome(place.to_text(), new)
        name = f"player ({game.team_name(i)} {unum})"
        news = f"A new (v{player.version}) {name} connected." if new else f"A {name} reconnected."
        return player, Arrival(welcome, news, data)

    def _welcome_monitor(self, version: float, data: bytes, address: Address) -> tuple[Client, Arrival]:
        params = self._game.params
        most = int(params.number("max_monitors"))
        if 0 < most <= len(self._clients.monitors):
            raise JoinError("(error no_more_monitor)")
        old = params.profile == "11.1"
        served = (1, 2) if old else VERSIONS
        if not math.isfinite(version) or int(version) not in served:
            self._name_version("monitor", version, address, served)
            raise JoinError(_UNKNOWN if old else _ILLEGAL_VERSION)
        monitor = MonitorClient(self._game, self._connect(address), int(version))
        kind = "json" if monitor.version == JSON else f"v{monitor.version}"
        return monitor, Arrival(monitor.welcome(), f"A new ({kind}) monitor connected.", data)

    def _welcome_trainer(self, data: bytes, address: Address) -> Iterator[tuple[Client, Reaction]]:
        game, params = self._game, self._game.params
        if not params["coach"] and not params["coach_w_referee"]:
            raise JoinError("(error connected_offline_coach_without_coach_mode)")
        if self._clients.trainer is not None:
            raise JoinError("(error already_have_offline_coach)")
        command = said.parse_trainer_init(data)
        if isinstance(command, said.Refusal):
            raise JoinError(command.text)
        if command is None:  # an old habit of the server: kick off, then do it, and answer nobody
            stranger = TrainerClient(game, Nobody(), text.FIRST_VERSION)
            yield stranger, said.Start()
            yield stranger, Datagram(data)
            return
        if isinstance(command, said.TrainerInit):
            self._check_version("trainer", command.version, address)
        if not isinstance(command, said.TrainerInit) or not game.knows_version(command.version):
            raise JoinError(_ILLEGAL_VERSION)
        trainer = TrainerClient(game, self._connect(address), int(command.version))
        news = f"A new (v{trainer.version}) offline coach connected"
        yield trainer, Arrival(trainer.welcome(), news, data)
