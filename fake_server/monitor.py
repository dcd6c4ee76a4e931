"""A monitor's client: gets a frame per step, and may start the match, place players, drop the ball.

Source: 19.0.0, src/monitor.cpp and src/initsendermonitor.cpp. Unlike there, text frames are made per version: monitors
of different versions do not get each other's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fake_server import show
from fake_server.coaching import coach
from fake_server.connection import Connection
from fake_server.game import Game
from fake_server.param_text import EVERYTHING, all_params, json_params
from fake_server.reactions import Card, Discard, Placement, Reactions, Reply
from rcss_hat.protocol import commands as said
from rcss_hat.protocol import messages
from rcss_hat.protocol.digits import ascii_bytes
from rcss_hat.protocol.messages import binary
from rcss_hat.protocol.messages.show import MAX_SHOW
from rcss_hat.protocol.messages.show_json import json_message

JSON = -1
VERSIONS = (JSON, 1, 2, 3, 4, 5)


class Frames:
    """The frames of one step, made once for every version that somebody watches with."""

    def __init__(self, game: Game) -> None:
        self._game = game
        self._buffer = np.zeros(MAX_SHOW, dtype=np.uint8)
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
            return show.show_1(match, game.kernel, game.teams)
        if version == 2:
            return show.show_2(match, game.kernel, game.teams)
        head = ascii_bytes(show.monitor_head(game.mode, game.teams, game.score))
        size = show.write_show(match, game.kernel, version, head, self._buffer)
        return self._buffer[:size].tobytes() + b"\0"


class MonitorClient:
    """One monitor.

    Parameters
    ----------
    game : Game
    connection : Connection
    version : int
        -1 (JSON), 1 and 2 (binary), 3 to 5 (text).
    """

    who = ""
    """Name in logs: what monitors send is not logged."""

    def __init__(self, game: Game, connection: Connection, version: int) -> None:
        self.game, self.connection, self.version = game, connection, version

    def welcome(self) -> Sequence[str | bytes]:
        """Return the parameters."""
        game = self.game
        if self.version == 2:
            old = game.params.profile == "11.1"
            types = [binary.player_type(game.types, number, old) for number in range(len(game.types))]
            return [binary.server_params(game.params), binary.player_params(game.player_params, old), *types]
        if self.version >= 3:
            return all_params(game.params, game.player_params, game.types, EVERYTHING)
        return json_params(game.params, game.player_params, game.types) if self.version == JSON else ()

    def message(self, board: int, message: str) -> None:
        """Send a ``(msg ...)``."""
        if self.version == JSON:
            self.connection.send(json_message(self.game.match, board, message))
        elif self.version <= 2:
            self.connection.send_bytes(binary.message(self.version, board, message))
        else:
            self.connection.send(messages.Msg(time=self.game.time, board=board, text=message).to_text())

    def reply(self, message: str) -> None:
        """Answer a datagram."""
        self.message(show.MESSAGE_BOARD, message)

    def take(self, data: bytes) -> Reactions:
        """React to the one command of a datagram."""
        if data.endswith(b"\0") or self.version == 1:
            return self._react(data)
        return Reply("(warning message_not_null_terminated)"), *self._react(data)

    def _react(self, data: bytes) -> Reactions:
        coach_mode = bool(self.game.params["coach"]) or bool(self.game.params["coach_w_referee"])
        command = said.parse_monitor_command(data, coach_mode)
        if isinstance(command, said.Refusal):
            return (Reply(command.text),)
        if isinstance(command, said.Compression):
            return Reply(f"(ok compression {command.level})"), command
        if isinstance(command, said.DispStart | said.DispBye | said.DispFoul):
            return (command,)
        old = self.game.params.profile == "11.1"
        if isinstance(command, said.DispPlayer | said.DispDiscard) or (isinstance(command, said.DispCard) and not old):
            return self._treat_player(command)
        return coach(self.game, command) or (Reply("(error illegal_command_form)"),)

    def _treat_player(self, command: said.DispPlayer | said.DispDiscard | said.DispCard) -> Reactions:
        """Place a player, take him out, or show him a card; the latter two only to players in the game."""
        i = self.game.player_index(command.side, command.unum)
        if i is None:
            return ()
        if isinstance(command, said.DispPlayer):
            return (Placement(i, command.x, command.y, float(command.angle), (0.0, 0.0)),)
        if not self.game.enabled(i):
            return ()
        return (Discard(i),) if isinstance(command, said.DispDiscard) else (Card(i, command.card),)
