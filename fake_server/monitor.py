"""A monitor's client: gets a frame per step, and may start the match, place players, drop the ball.

Source: 19.0.0, src/monitor.cpp and src/initsendermonitor.cpp. Unlike there, text frames are made per version: monitors
of different versions do not get each other's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fake_server import binary, show
from fake_server.coaching import coach
from fake_server.connection import Connection
from fake_server.digits import ascii_bytes
from fake_server.game import Game
from fake_server.param_text import EVERYTHING, all_params, json_params
from rcss_hat.protocol import commands as said

if TYPE_CHECKING:
    from fake_server.server import Server

JSON = -1
VERSIONS = (JSON, 1, 2, 3, 4, 5)


class Frames:
    """The frames of one step, made once for every version that somebody watches with."""

    def __init__(self, game: Game) -> None:
        self._game = game
        self._buffer = np.zeros(show.MAX_SHOW, dtype=np.uint8)
        self._made: dict[int, bytes] = {}

    def new_step(self) -> None:
        """Forget the frames of the step before."""
        self._made.clear()

    def frame(self, version: int) -> bytes:
        """Return the frame of a monitor version as a datagram."""
        if version not in self._made:
            self._made[version] = self._make(version)
        return self._made[version]

    def _make(self, version: int) -> bytes:
        game, match = self._game, self._game.match
        if version == JSON:
            return show.json_show(match, game.kernel, game.mode_name, game.teams).encode("latin-1") + b"\0"
        if version == 1:
            return binary.show_1(match, game.teams)
        if version == 2:
            return binary.show_2(match, game.kernel, game.teams)
        head = ascii_bytes(show.monitor_head(game.mode, game.teams, game.score))
        size = show.write_show(match, game.kernel, version, head, self._buffer)
        return self._buffer[:size].tobytes() + b"\0"


class MonitorClient:
    """One monitor.

    Parameters
    ----------
    server : Server
    connection : Connection
    version : int
        -1 (JSON), 1 and 2 (binary), 3 to 5 (text).
    """

    def __init__(self, server: Server, connection: Connection, version: int) -> None:
        self.server, self.connection, self.version = server, connection, version
        self.game = server.game

    def welcome(self) -> None:
        """Send the parameters."""
        game = self.game
        if self.version == 2:
            self.connection.send_bytes(binary.server_params(game.params))
            old = game.params.profile == "11.1"
            self.connection.send_bytes(binary.player_params(game.player_params, old))
            for number in range(len(game.types)):
                self.connection.send_bytes(binary.player_type(game.types, number, old))
        elif self.version >= 3:
            for message in all_params(game.params, game.player_params, game.types, EVERYTHING):
                self.connection.send(message)
        elif self.version == JSON:
            for message in json_params(game.params, game.player_params, game.types):
                self.connection.send(message)

    def message(self, board: int, message: str) -> None:
        """Send a ``(msg ...)``."""
        if self.version == JSON:
            self.connection.send(show.json_message(self.game.match, board, message))
        elif self.version <= 2:
            self.connection.send_bytes(binary.message(self.version, board, message))
        else:
            self.connection.send(show.message(self.game.time, board, message))

    def _reply(self, message: str) -> None:
        self.message(show.MESSAGE_BOARD, message)

    def read(self) -> None:
        """Carry out all commands that have arrived."""
        for data in self.connection.receive():
            self.take(data)

    def take(self, data: bytes) -> None:
        """Carry out the one command of a datagram."""
        if not data.endswith(b"\0") and self.version != 1:
            self._reply("(warning message_not_null_terminated)")
        coach_mode = bool(self.game.params["coach"]) or bool(self.game.params["coach_w_referee"])
        command = said.parse_monitor_command(data, coach_mode)
        if isinstance(command, said.Refusal):
            self._reply(command.text)
        elif isinstance(command, said.Compression):
            self._reply(f"(ok compression {command.level})")
            self.connection.compress(command.level)
        elif not self._carry_out(command):
            self._reply(coach(self.server, command) or "(error illegal_command_form)")

    def _carry_out(self, command: said.Command) -> bool:
        """Carry out what only monitors command; these commands are not answered."""
        server, game = self.server, self.game
        if isinstance(command, said.DispStart):
            server.want_kick_off()
        elif isinstance(command, said.DispBye):
            self.connection.close()
        elif isinstance(command, said.DispFoul):
            server.announce(game.call_foul(command.side, command.x, command.y))
        elif isinstance(command, said.DispCard) and game.params.profile == "11.1":
            return False
        elif isinstance(command, said.DispPlayer | said.DispDiscard | said.DispCard):
            i = game.player_index(command.side, command.unum)
            if i is not None:
                self._treat_player(i, command)
        else:
            return False
        return True

    def _treat_player(self, i: int, command: said.DispPlayer | said.DispDiscard | said.DispCard) -> None:
        """Place a player, take him out, or show him a card; the latter two only to players in the game."""
        if isinstance(command, said.DispPlayer):
            self.game.move_player(i, command.x, command.y, float(command.angle), (0.0, 0.0))
        elif not self.game.enabled(i):
            return
        elif isinstance(command, said.DispDiscard):
            self.server.discard(i)
        else:
            self.server.show_card(i, command.card)
