"""A monitor's client: gets a frame per step, and may start the match or place players."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fake_server import binary, show
from fake_server.connection import Connection
from fake_server.digits import ascii_bytes
from fake_server.param_text import all_params
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS

if TYPE_CHECKING:
    from fake_server.server import Server

JSON, VERSIONS = -1, (-1, 1, 2, 3, 4, 5)
ALL_PARAMETERS = 10**6
"""Protocol version that is told of every parameter."""
_SIXTEENTH = 1.0 / 16.0


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
        self.inbox: list[bytes] = []
        self._buffer = np.zeros(show.MAX_SHOW, dtype=np.uint8)

    def welcome(self) -> None:
        """Send the parameters."""
        game = self.game
        if self.version == 2:
            self.connection.send_bytes(binary.server_params(game.params))
            self.connection.send_bytes(binary.player_params(game.player_params))
            for number in range(len(game.types)):
                self.connection.send_bytes(binary.player_type(game.types, number))
        elif self.version >= 3:
            for message in all_params(game.params, game.player_params, game.types, ALL_PARAMETERS):
                self.connection.send(message)

    def show(self) -> None:
        """Send a frame."""
        game, match = self.game, self.game.match
        if self.version == JSON:
            self.connection.send(show.json_show(match, game.kernel, game.mode_name, game.teams))
        elif self.version == 1:
            self.connection.send_bytes(binary.show_1(match, game.teams))
        elif self.version == 2:
            self.connection.send_bytes(binary.show_2(match, game.kernel, game.teams))
        else:
            head = ascii_bytes(show.monitor_head(game.mode, game.teams, game.score))
            size = show.write_show(match, game.kernel, self.version, head, self._buffer)
            self.connection.send_buffer(self._buffer, size)

    def message(self, board: int, message: str) -> None:
        """Send a ``(msg ...)``."""
        if self.version == JSON:
            self.connection.send(show.json_message(self.game.match, board, message))
        elif self.version <= 2:
            self.connection.send_bytes(binary.message(self.version, board, message))
        else:
            self.connection.send(show.message(self.game.time, board, message))

    def execute(self, data: bytes) -> None:
        """Carry out a monitor's command."""
        coach_mode = bool(self.game.params["coach"]) or bool(self.game.params["coach_w_referee"])
        command = said.parse_monitor_command(data, coach_mode)
        if isinstance(command, said.Refusal):
            self.message(show.MESSAGE_BOARD, command.text)
            return
        game = self.game
        if isinstance(command, said.DispStart):
            self.server.kick_off()
        elif isinstance(command, said.DispBye):
            self.connection.close()
        elif isinstance(command, said.DispFoul):
            x, y = command.x, command.y
            self.server.announce(game.call_foul(command.side, x, y))
        elif isinstance(command, said.DispPlayer):
            i = game.player_index(command.side, command.unum)
            if i is not None and game.enabled(i):
                game.move_player(i, command.x, command.y, float(command.angle), (0.0, 0.0))
        elif isinstance(command, said.DispDiscard):
            i = game.player_index(command.side, command.unum)
            if i is not None and game.enabled(i):
                self.server.discard(i)
        else:
            self._as_trainer(command)

    def _as_trainer(self, command: said.Command) -> None:
        """Carry out what monitors may do in coach mode only; replies come as messages."""
        game = self.game
        reply = "(error illegal_command_form)"
        if isinstance(command, said.Start):
            self.server.kick_off()
            reply = "(ok start)"
        elif isinstance(command, said.ChangeMode):
            self.server.announce(game.change_mode(PLAY_MODE_IDS[command.mode]))
            reply = "(ok change_mode)"
        elif isinstance(command, said.MoveBall):
            game.move_ball(command.x, command.y, command.velocity or (0.0, 0.0))
            reply = "(ok move)"
        elif isinstance(command, said.MovePlayer):
            team = game.find_team(command.team)
            i = None if team is None else game.player_index(1 if team == 0 else -1, command.unum)
            if i is None or not game.enabled(i):
                reply = "(error illegal_object_form)"
            else:
                game.move_player(i, command.x, command.y, command.angle, command.velocity)
                reply = "(ok move)"
        elif isinstance(command, said.Recover):
            game.recover()
            reply = "(ok recover)"
        elif isinstance(command, said.CheckBall):
            reply = f"(ok check_ball {game.time} {game.ball_place()})"
        elif isinstance(command, said.Compression):
            self.connection.compress(command.level)
            reply = f"(ok compression {command.level})"
        self.message(show.MESSAGE_BOARD, reply)
