"""A player's client as the server sees it: his socket, his commands, and what he is told.

Datagrams are read and answered as they come, but in synch mode what they change in the match waits until everybody is
done (`PlayerClient.carry_out`): then the order in which the datagrams of several players arrive decides nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from fake_server import text
from fake_server.apply import apply, team_of
from fake_server.connection import Connection
from fake_server.digits import ascii_bytes
from fake_server.game import Game
from fake_server.param_text import all_params
from fake_server.simulation import body, hearing, vision
from fake_server.simulation.commands import too_many_moves
from fake_server.simulation.state import BEFORE_KICK_OFF, MAX_MESSAGES, PHYSICS
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.records import MAX_PLAYERS, SEE, SENSE_BODY, empty

if TYPE_CHECKING:
    from fake_server.server import Server

_DONE = b"(done)\0"
_CHANGE_NOTHING = frozenset({said.Score, said.Clang, said.Compression, said.SenseBody, said.Done})
"""Commands that are only answered."""


class PlayerClient:
    """One player's client.

    Parameters
    ----------
    server : Server
    i : int
        Index of the player in the match.
    connection : Connection

    Attributes
    ----------
    done : bool
        Whether the client has said ``(done)``, or goodbye, since the last ``(think)``.
    told : bool
        Whether he was told of a step; nobody is asked to think before.
    """

    def __init__(self, server: Server, i: int, connection: Connection) -> None:
        self.server, self.i, self.connection = server, i, connection
        self.game: Game = server.game
        self.version = int(self.game.match["version"][0, i])
        self.done = self.told = False
        self._pending: list[Any] = []
        self._see, self._sense = empty(SEE), empty(SENSE_BODY)
        self._buffer = np.zeros(text.MAX_MESSAGE, dtype=np.uint8)
        self._landmarks = np.ones(N_LANDMARKS, dtype=np.uint8)
        self._order = np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
        self._ends = np.zeros(MAX_MESSAGES, dtype=np.int64)
        self._gets_fullstate = bool(self.game.params["fullstate_l" if i < MAX_PLAYERS else "fullstate_r"])
        self._teams: tuple[str, str] | None = None
        self._names, self._sizes = text.team_names("", "")

    @property
    def who(self) -> str:
        """Name in logs, such as ``keepers_1``."""
        return f"{self.game.team_name(self.i)}_{self.game.unum(self.i)}"

    @property
    def waited_for(self) -> bool:
        """Whether a think step still waits for him."""
        return not self.done and self.connection.connected

    def send(self, message: str) -> None:
        """Send a text message."""
        self.connection.send(message)

    def welcome(self, reply: str, new: bool) -> None:
        """Send the reply to init or reconnect, the parameters, whose type is not the default one, and how he sees."""
        self.send(reply)
        game = self.game
        for message in all_params(game.params, game.player_params, game.types, self.version):
            self.send(message)
        for j in np.flatnonzero(game.match["type"][0]):
            self.tell_type(int(j))
        if new and game.match["synch_see"][0, self.i]:
            self.send("(ok synch_see)")

    def tell_type(self, j: int) -> None:
        """Tell the type of a player, or to opponents that it has changed."""
        own = j // MAX_PLAYERS == self.i // MAX_PLAYERS
        player_type = int(self.game.match["type"][0, j])
        self.send(text.change_player_type(self.game.unum(j), player_type if own else None))

    # --- what he is told every cycle ------------------------------------------------------------------------------
    def sense_body(self, match: np.ndarray | None = None) -> None:
        """Send sense_body, of the game's match or of a copy."""
        game = self.game
        if match is None:
            match = game.match
        body.sense_body(match, game.kernel, game.types, self.i, self._sense)
        self.connection.send_buffer(self._buffer, text.write_sense_body(self._sense, match, self.i, self._buffer))

    def fullstate(self) -> None:
        """Send fullstate where it is switched on."""
        if self._gets_fullstate:
            mode = ascii_bytes(self.game.mode_with_catch)
            size = text.write_fullstate(self.game.match, self.i, mode, self._buffer)
            self.connection.send_buffer(self._buffer, size)

    def hear(self) -> None:
        """Send what players said in the cycle before."""
        match = self.game.match
        n = hearing.deliver(match, self.game.kernel, self.i, self.game.streams, self._order)
        if n > 0:
            text.write_hear(match, self.i, self._order, n, self._buffer, self._ends)
            start = 0
            for end in self._ends[:n].tolist():
                self.connection.send_bytes(self._buffer[start:end].data)
                start = end

    def see(self) -> None:
        """Send a see message."""
        game = self.game
        if self._teams != game.teams:
            self._teams = game.teams
            own = self.i // MAX_PLAYERS
            self._names, self._sizes = text.team_names(game.names[own], game.names[1 - own])
        vision.see(game.match, game.kernel, game.types, self.i, game.streams, self._landmarks, self._see)
        self.connection.send_buffer(self._buffer, text.write_see(self._see, self._names, self._sizes, self._buffer))

    # --- what he commands -----------------------------------------------------------------------------------------
    def read(self) -> None:
        """Read and answer all datagrams that have arrived."""
        for data in self.connection.receive():
            self.take(data)

    def take(self, data: bytes) -> None:
        """Read a datagram, left to right, up to the first syntax error."""
        if not data.endswith(b"\0"):
            self.send("(warning message_not_null_terminated)")
        if self.server.logs.wants_messages:
            self.server.logs.received(self.game.match, self.who, data.split(b"\0", 1)[0].decode("latin-1"))
        if data == _DONE:
            self.done = True
            return
        commands, complete = said.parse_commands(data, self.game.params.profile)
        for command in commands:
            kind = type(command)
            answer = _ANSWERS.get(kind)
            if answer is not None:
                answer(self, command)
            if kind not in _CHANGE_NOTHING:
                self._pending.append(command)
            if kind is said.Bye:
                return
        if not complete:
            self.send("(error illegal_command_form)")
            if not self.server.options.quiet:
                print(f"Error parsing >{data.split(bytes(1), 1)[0].decode('latin-1')}<", file=sys.stderr)

    def answer_done(self, command: said.Done | said.Bye) -> None:
        """Note that the client has finished this cycle, or for good."""
        self.done = True

    def answer_score(self, command: said.Score) -> None:
        """Tell the score."""
        own, score = self.i // MAX_PLAYERS, self.game.score
        self.send(text.score_reply(self.game.time, score[own], score[1 - own]))

    def answer_sense_body(self, command: said.SenseBody) -> None:
        """Send sense_body as it is after the client's own commands so far."""
        self.sense_body(self._with_pending())

    def answer_synch_see(self, command: said.SynchSee) -> None:
        """Confirm."""
        self.send("(ok synch_see)")

    def answer_gaussian_see(self, command: said.GaussianSee) -> None:
        """Confirm."""
        self.send("(ok gaussian_see)")

    def answer_clang(self, command: said.Clang) -> None:
        """Confirm."""
        self.send(f"(ok clang (ver {command.minimum} {command.maximum}))")

    def answer_compression(self, command: said.Compression) -> None:
        """Confirm and compress, unless the level is too high."""
        if command.level <= 9:
            self.send(f"(ok compression {command.level})")
            self.connection.compress(command.level)

    def answer_ear(self, command: said.Ear) -> None:
        """Complain of a team that does not exist."""
        if command.team is not None and team_of(self.game, self.i, command.team) is None:
            self.send(f"(error no team with name {command.team})")

    def answer_move(self, command: said.Move) -> None:
        """Warn of a place that is not allowed, or of one move too many, if the command will be accepted."""
        game, match = self.game, self._with_pending()
        if match["command_done"][0, self.i]:
            return
        if game.mode == BEFORE_KICK_OFF:
            beyond = command.x >= -match["size"][0, self.i] and game.params["forbid_kick_off_offside"]
            if beyond and game.params.profile != "11.1":
                self.send("(warning moving_to_opponent_field)")
        elif int(match["catcher"][0]) == self.i and too_many_moves(match, game.kernel, self.i):
            self.send("(error too_many_moves)")

    def _with_pending(self) -> np.ndarray:
        """Return the match as it will be when the own commands so far have been carried out."""
        if not self._pending:
            return self.game.match
        match, rng = self.game.match.copy(), self.game.streams[PHYSICS].copy()
        for command in self._pending:
            apply(self.game, match, rng, self.i, command)
        return match

    def carry_out(self) -> None:
        """Carry out the commands that have been read."""
        pending, self._pending = self._pending, []
        for command in pending:
            kind = type(command)
            if kind is said.Bye:
                self.server.player_left(self)
                return
            accepted = self._apply(command)
            if accepted and kind is said.Say:
                self.server.player_spoke(self.i, command.message)

    def _apply(self, command: said.Command) -> bool:
        """Carry out a command, and let the referee know if it moves the ball."""
        game, touch = self.game, self.game.touch
        if touch is None or not isinstance(command, said.Kick | said.Tackle):
            return apply(game, game.match, game.streams[PHYSICS], self.i, command)
        before = game.match["ball_acc"][0].copy()
        accepted = apply(game, game.match, game.streams[PHYSICS], self.i, command)
        strength = float(np.hypot(*(game.match["ball_acc"][0] - before)))
        if strength > 0.0:
            touch.touched(self.i, strength)
        return accepted


_ANSWERS: dict[type, Callable[[PlayerClient, Any], None]] = {
    said.Done: PlayerClient.answer_done,
    said.Bye: PlayerClient.answer_done,
    said.Score: PlayerClient.answer_score,
    said.SenseBody: PlayerClient.answer_sense_body,
    said.SynchSee: PlayerClient.answer_synch_see,
    said.GaussianSee: PlayerClient.answer_gaussian_see,
    said.Clang: PlayerClient.answer_clang,
    said.Compression: PlayerClient.answer_compression,
    said.Ear: PlayerClient.answer_ear,
    said.Move: PlayerClient.answer_move,
}
"""What commands are answered with at once."""
