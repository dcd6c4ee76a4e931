"""Everybody who is told what happens in a match: players, the trainer, monitors and the logs."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from fake_server.clients import Clients
from fake_server.game import Game
from fake_server.logs import Logs
from fake_server.monitor import Frames
from fake_server.perception import Perception, Told
from fake_server.show import MESSAGE_BOARD
from fake_server.soccer.limits import Limits
from rcss_hat.protocol.messages import ChangePlayerType, Hear
from rcss_hat.protocol.records import MAX_PLAYERS


class Audience:
    """Tells everybody.

    Parameters
    ----------
    game : Game
    clients : Clients
    logs : Logs
    """

    def __init__(self, game: Game, clients: Clients, logs: Logs) -> None:
        self._game, self._clients, self._logs = game, clients, logs
        self._frames, self._perception = Frames(game), Perception(game)
        self._limits = Limits(game.params, game.match) if game.touch is not None else None
        self._coach_said: list[str] = []

    @property
    def hears_no_player(self) -> bool:
        """Whether nobody but players is told what players say."""
        return self._clients.trainer is None and not self._clients.monitors and not self._logs.wants_messages

    # --- a step ---------------------------------------------------------------------------------------------------
    def show(self) -> None:
        """Give monitors and the game log the frame of a step."""
        game = self._game
        if self._clients.monitors:
            self._frames.new_step()
            for monitor in self._clients.monitors:
                monitor.connection.send_bytes(self._frames.frame(monitor.version))
        self._logs.show(game.match, game.kernel, game.teams)

    def tell_step(self) -> None:
        """Tell players and the trainer of a step: all but what players see."""
        players = self._clients.here()
        seats = [player.i for player in players]
        for player, (_, sense) in zip(players, self._perception.sense_body(seats), strict=True):
            player.connection.send_bytes(sense)
            player.fullstate()
            player.told = True
        for message in self._coach_said:
            heard = Hear(time=self._game.time, source="coach", text=message).to_text()
            for player in players:
                player.connection.send(heard)
        self._coach_said.clear()
        if self._game.match["n_heard"][0]:
            self._tell(self._perception.hear(seats))
        self._game.forget_collisions()
        if self._clients.trainer is not None:
            self._clients.trainer.see_global()

    def send_sees(self, due: NDArray[np.uint8]) -> None:
        """Send so many see messages to every player."""
        if due.any():
            absent = [i for i, player in enumerate(self._clients.players) if player is None]
            due[absent] = 0
            self._tell(self._perception.see(due))

    def _tell(self, told: Told) -> None:
        players = self._clients.players
        for i, data in told:
            player = players[i]
            assert player is not None, "nobody leaves while all are told"
            player.connection.send_bytes(data)

    # --- what is said ---------------------------------------------------------------------------------------------
    def announce(self, messages: list[str]) -> None:
        """Let the referee say something to everybody."""
        for message in messages:
            heard = Hear(time=self._game.time, source="referee", text=message).to_text()
            for player in self._clients.here():
                player.connection.send(heard)
            if self._clients.trainer is not None:
                self._clients.trainer.hear_referee(message)
            self._logs.referee(self._game.match, message)
            self._tell_monitors(f"(referee {message})")
        if self._limits is not None:
            for warning in self._limits.missed(messages):
                print(f"{self._game.time}: {warning}", file=sys.stderr, flush=True)
                self._tell_monitors(f"({warning})")

    def player_spoke(self, i: int, message: str) -> None:
        """Tell trainer, monitors and log what a player said; players hear it in the next cycle."""
        if self._clients.trainer is not None:
            self._clients.trainer.hear_player(i, message)
        self._spoke(f"(player {self._game.team_name(i)} {self._game.unum(i)})", message)

    def trainer_spoke(self, message: str) -> None:
        """Tell monitors and log what the trainer said; players hear it in the next cycle."""
        self._coach_said.append(message)
        self._spoke("referee", message)

    def _spoke(self, who: str, message: str) -> None:
        self._logs.speech(self._game.match, who, message)
        self._tell_monitors(f"({who} {message})")

    def _tell_monitors(self, message: str) -> None:
        """Show a message to monitors, which hear what is said only with ``send_comms``."""
        if self._clients.monitors and self._game.params["send_comms"]:
            for monitor in self._clients.monitors:
                monitor.message(MESSAGE_BOARD, message)

    def tell_substitution(self, i: int, player_type: int) -> None:
        """Tell everybody that a player has another type."""
        for player in self._clients.here():
            player.connection.send(player.type_of(i))
        side = "l" if i < MAX_PLAYERS else "r"
        news = ChangePlayerType(side=side, unum=self._game.unum(i), player_type=player_type).to_text()
        for monitor in self._clients.monitors:
            monitor.message(MESSAGE_BOARD, news)
        self._logs.substitution(self._game.match, news)
