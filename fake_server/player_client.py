"""A player's client as the server sees it: his socket, his commands, and what he is told.

Datagrams are read and answered as they come, but in synch mode what they change in the match waits until everybody is
done (`PlayerClient.commanded`): then the order in which the datagrams of several players arrive decides nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fake_server import text
from fake_server.apply import apply, team_of
from fake_server.connection import Connection
from fake_server.game import Game
from fake_server.param_text import all_params
from fake_server.reactions import Complaint, Reaction, Reactions, Reply
from rcss_hat.protocol import commands as said
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands.action import IS_DONE, NOT_PLAIN, read_action
from rcss_hat.protocol.digits import ascii_bytes
from rcss_hat.protocol.records import ACTION, KICK, MAX_PLAYERS, SENSE_BODY, empty
from rcss_hat.simulation import body
from rcss_hat.simulation.commands import act, too_many_moves
from rcss_hat.simulation.state import BEFORE_KICK_OFF
from rcss_hat.simulation.world import World

_DONE = b"(done)\0"
_CHANGE_NOTHING = frozenset({said.Score, said.Clang, said.Compression, said.SenseBody, said.Done})
"""Commands that are only answered."""


class PlayerClient:
    """One player's client.

    Parameters
    ----------
    game : Game
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

    def __init__(self, game: Game, i: int, connection: Connection) -> None:
        self.game, self.i, self.connection = game, i, connection
        self.version = int(self.game.match["version"][0, i])
        self.done = self.told = False
        self._pending: list[Any] = []
        self._plain: bytes | None = None  # a datagram whose commands stand in the action, the first since the last step
        self._action = empty(ACTION)
        self._sense = empty(SENSE_BODY)
        self._buffer = np.zeros(said.MAX_DATAGRAM, dtype=np.uint8)
        self._gets_fullstate = bool(self.game.params["fullstate_l" if i < MAX_PLAYERS else "fullstate_r"])

    @property
    def who(self) -> str:
        """Name in logs, such as ``keepers_1``."""
        return f"{self.game.team_name(self.i)}_{self.game.unum(self.i)}"

    @property
    def waited_for(self) -> bool:
        """Whether a think step still waits for him."""
        return not self.done and self.connection.connected

    def reply(self, message: str) -> None:
        """Send a text message."""
        self.connection.send(message)

    def welcome(self, reply: str, new: bool) -> list[str]:
        """Return the reply to init or reconnect, the parameters, whose type is not the default one, and how he sees."""
        game = self.game
        told = [reply, *all_params(game.params, game.player_params, game.types, self.version)]
        told += [self.type_of(int(j)) for j in np.flatnonzero(game.match["type"][0])]
        return [*told, "(ok synch_see)"] if new and game.match["synch_see"][0, self.i] else told

    def type_of(self, j: int) -> str:
        """Return what he is told of the type of a player: of opponents only that it has changed."""
        own = j // MAX_PLAYERS == self.i // MAX_PLAYERS
        player_type = int(self.game.match["type"][0, j])
        return messages.ChangePlayerType(unum=self.game.unum(j), player_type=player_type if own else None).to_text()

    def fullstate(self) -> None:
        """Send fullstate where it is switched on."""
        if self._gets_fullstate:
            mode = ascii_bytes(self.game.mode_with_catch)
            size = text.write_fullstate(self.game.match, self.i, mode, self._buffer)
            self.connection.send_buffer(self._buffer, size)

    # --- what he commands -----------------------------------------------------------------------------------------
    def take(self, data: bytes) -> Reactions:
        """Read a datagram, left to right, up to the first syntax error."""
        if data == _DONE:
            self.done = True
            return ()
        if self._plain is None and not self._pending and (found := read_action(data, self._action)) != NOT_PLAIN:
            self._plain = data
            self.done |= bool(found & IS_DONE)
            return ()
        self._spell_out()
        reactions: list[Reaction] = []
        if not data.endswith(b"\0"):
            reactions.append(Reply("(warning message_not_null_terminated)"))
        commands, complete = said.parse_commands(data, self.game.params.profile)
        for command in commands:
            kind = type(command)
            if kind in _ANSWERS and (answer := _ANSWERS[kind](self, command)):
                reactions += (Reply(answer), command) if kind is said.Compression else (Reply(answer),)
            if kind not in _CHANGE_NOTHING:
                self._pending.append(command)
            if kind is said.Bye:
                return reactions
        if not complete:
            line = data.split(bytes(1), 1)[0].decode("latin-1")
            reactions += [Reply("(error illegal_command_form)"), Complaint(f"Error parsing >{line}<")]
        return reactions

    def commanded(self) -> list[Any]:
        """Return the commands that are to be carried out, and forget them."""
        self._spell_out()
        pending, self._pending = self._pending, []
        return pending

    def _spell_out(self) -> None:
        """Make commands of a datagram in plain form."""
        if self._plain is not None:
            commands, _ = said.parse_commands(self._plain, self.game.params.profile)
            self._pending += [command for command in commands if type(command) not in _CHANGE_NOTHING]
            self._plain = None

    def obey(self) -> bool:
        """Carry out what is to be carried out if it is in plain form, where nobody is told of it; else return False.

        That is so in open play that no `TouchReferee` watches, with nobody there who is told what players say.
        """
        if self._plain is None:
            return not self._pending
        if self._action["kind"][0] == KICK:
            self.game.match["events"] = 0
        act(self.game.world, self.i, self._action)
        self._plain = None
        return True

    def answer_done(self, command: said.Done | said.Bye) -> str:
        """Note that the client has finished this cycle, or for good."""
        self.done = True
        return ""

    def answer_score(self, command: said.Score) -> str:
        """Tell the score."""
        own, score = self.i // MAX_PLAYERS, self.game.score
        return messages.Score(time=self.game.time, ours=score[own], theirs=score[1 - own]).to_text()

    def answer_sense_body(self, command: said.SenseBody) -> str:
        """Tell sense_body as it is after the client's own commands so far."""
        return self._buffer[: self._write_sense_body(self._with_pending())].tobytes().decode("latin-1")

    def _write_sense_body(self, world: World) -> int:
        body.sense_body(world, self.i, self._sense)
        return text.write_sense_body(self._sense, world.match, self.i, self._buffer)

    def answer_synch_see(self, command: said.SynchSee) -> str:
        """Confirm."""
        return "(ok synch_see)"

    def answer_gaussian_see(self, command: said.GaussianSee) -> str:
        """Confirm."""
        return "(ok gaussian_see)"

    def answer_clang(self, command: said.Clang) -> str:
        """Confirm."""
        return messages.OkClang(minimum=command.minimum, maximum=command.maximum).to_text()

    def answer_compression(self, command: said.Compression) -> str:
        """Confirm, unless the level is too high."""
        return f"(ok compression {command.level})" if command.level <= 9 else ""

    def answer_ear(self, command: said.Ear) -> str:
        """Complain of a team that does not exist."""
        if command.team is not None and team_of(self.game, self.i, command.team) is None:
            return f"(error no team with name {command.team})"
        return ""

    def answer_move(self, command: said.Move) -> str:
        """Warn of a place that is not allowed, or of one move too many, if the command will be accepted."""
        game, match = self.game, self._with_pending().match
        if match["command_done"][0, self.i]:
            return ""
        if game.mode == BEFORE_KICK_OFF:
            beyond = command.x >= -match["size"][0, self.i] and game.params["forbid_kick_off_offside"]
            return "(warning moving_to_opponent_field)" if beyond and game.params.profile != "11.1" else ""
        too_many = int(match["catcher"][0]) == self.i and too_many_moves(match, game.kernel, self.i)
        return "(error too_many_moves)" if too_many else ""

    def _with_pending(self) -> World:
        """Return the world as it will be when the own commands so far have been carried out."""
        self._spell_out()
        if not self._pending:
            return self.game.world
        world = self.game.world
        world = world._replace(match=world.match.copy(), streams=world.streams.copy())
        for command in self._pending:
            apply(self.game, world, self.i, command)
        return world


_ANSWERS: dict[type, Callable[[PlayerClient, Any], str]] = {
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
