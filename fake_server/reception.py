"""The three known ports: first datagrams of players and monitors, of the trainer, of online coaches.

Everything after the first datagram goes through a client's own port. The answers to those who are refused come from the
known port (19.0.0, src/stadium.cpp).
"""

from __future__ import annotations

import contextlib
import math
import socket
from typing import TYPE_CHECKING

from fake_server import text
from fake_server.connection import Address, Connection
from fake_server.game import JoinError
from fake_server.monitor import JSON, VERSIONS, MonitorClient
from fake_server.player_client import PlayerClient
from fake_server.trainer import TrainerClient
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.records import MAX_PLAYERS

if TYPE_CHECKING:
    from fake_server.server import Server

_ILLEGAL_VERSION = "(error illegal_client_version)"
_UNKNOWN = "(error unknown_command)"
NO_ONLINE_COACH = "(error online_coach_not_supported)"
"""Answer to online coaches: an own one, for the original has them."""


class Reception:
    """The sockets of the known ports.

    Parameters
    ----------
    server : Server

    Attributes
    ----------
    port, coach_port, olcoach_port : int
        Those really bound.

    Raises
    ------
    OSError
        When a port cannot be had; names it.
    """

    def __init__(self, server: Server) -> None:
        self._server = server
        self.doors: list[socket.socket] = []
        try:
            for name in ("port", "coach_port", "olcoach_port"):
                self.doors.append(self._open(name))
        except OSError:
            self.close()
            raise
        self.port, self.coach_port, self.olcoach_port = (int(door.getsockname()[1]) for door in self.doors)

    def _open(self, name: str) -> socket.socket:
        bind = self._server.options.bind
        port = int(self._server.options.params.number(name))
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

    def read(self, number: int) -> None:
        """Answer all datagrams that have arrived at a door: 0 players and monitors, 1 trainer, 2 online coaches."""
        door = self.doors[number]
        while True:
            try:
                data, address = door.recvfrom(text.MAX_MESSAGE)
            except OSError:
                return
            self._answer(number, data, address)

    def _answer(self, number: int, data: bytes, address: Address) -> None:
        known = self._server.clients.get(address)
        if known is not None and known.connection is not None and known.connection.connected:
            if isinstance(known, MonitorClient) and known.version == 1:
                known.take(data)
            else:
                known.connection.send("(error only_init_allowed_on_init_port)")
            return
        try:
            if number == 0:
                self._welcome(data, address)
            elif number == 1:
                self._welcome_trainer(data, address)
            else:
                raise JoinError(NO_ONLINE_COACH)
        except JoinError as refusal:
            with contextlib.suppress(OSError):
                self.doors[number].sendto(str(refusal).encode("latin-1") + b"\0", address)

    def _connect(self, address: Address) -> Connection:
        try:
            return Connection(self._server.options.bind, address)
        except OSError:
            raise JoinError("(error connection_failed)") from None

    def _welcome(self, data: bytes, address: Address) -> None:
        command = said.parse_init(data, self._server.game.params.profile)
        if isinstance(command, said.Refusal):
            raise JoinError(command.text)
        if isinstance(command, said.DispInit):
            self._welcome_monitor(command.version, address)
        else:
            self._welcome_player(command, data, address)

    def _welcome_player(self, command: said.Init | said.Reconnect, data: bytes, address: Address) -> None:
        server, game = self._server, self._server.game
        new = isinstance(command, said.Init)
        if isinstance(command, said.Init):
            i = game.join(command.team, command.version, command.goalie)
        else:
            i = game.rejoin(command.team, command.unum)
        side, unum = "l" if i < MAX_PLAYERS else "r", game.unum(i)
        try:
            player = PlayerClient(server, i, self._connect(address))
        except JoinError:
            game.leave(i)
            raise
        server.add_player(player)
        mode = game.mode_name
        player.welcome(text.init_reply(side, unum, mode) if new else text.reconnect_reply(side, mode), new)
        name = f"{game.team_name(i)} {unum}"
        server.say(
            f"A new (v{player.version}) player ({name}) connected." if new else f"A player ({name}) reconnected."
        )
        if server.logs.wants_messages:
            server.logs.received(game.match, player.who, data.split(b"\0", 1)[0].decode("latin-1"))

    def _welcome_monitor(self, version: float, address: Address) -> None:
        server = self._server
        most = int(server.game.params.number("max_monitors"))
        if 0 < most <= len(server.monitors):
            raise JoinError("(error no_more_monitor)")
        old = server.game.params.profile == "11.1"
        if not math.isfinite(version) or int(version) not in ((1, 2) if old else VERSIONS):
            raise JoinError(_UNKNOWN if old else _ILLEGAL_VERSION)
        monitor = MonitorClient(server, self._connect(address), int(version))
        server.add_monitor(monitor)
        server.say(f"A new ({'json' if monitor.version == JSON else f'v{monitor.version}'}) monitor connected.")
        monitor.welcome()

    def _welcome_trainer(self, data: bytes, address: Address) -> None:
        server, params = self._server, self._server.game.params
        if not params["coach"] and not params["coach_w_referee"]:
            raise JoinError("(error connected_offline_coach_without_coach_mode)")
        if server.trainer is not None:
            raise JoinError("(error already_have_offline_coach)")
        command = said.parse_trainer_init(data)
        if isinstance(command, said.Refusal):
            raise JoinError(command.text)
        if command is None:  # an old habit of the server: kick off, then do it, and answer nobody
            server.kick_off()
            TrainerClient(server, None, text.FIRST_VERSION).take(data)
            return
        if not isinstance(command, said.TrainerInit) or not server.game.knows_version(command.version):
            raise JoinError(_ILLEGAL_VERSION)
        trainer = TrainerClient(server, self._connect(address), int(command.version))
        server.add_trainer(trainer)
        trainer.welcome()
        server.say(f"A new (v{int(command.version)}) offline coach connected")
        if server.logs.wants_messages:
            server.logs.received(server.game.match, "Coach", data.split(b"\0", 1)[0].decode("latin-1"))
