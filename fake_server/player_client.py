"""A player's client as the server sees it: his socket, his commands, and what he is told."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fake_server import text
from fake_server.connection import Connection
from fake_server.digits import ascii_bytes
from fake_server.game import Game
from fake_server.param_text import all_params
from fake_server.simulation import body, commands, hearing, vision
from fake_server.simulation.state import MAX_MESSAGES, PHYSICS
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.records import HIGH, LEFT, LOW, MAX_PLAYERS, NARROW, NORMAL, RIGHT, SEE, SENSE_BODY, WIDE, empty

if TYPE_CHECKING:
    from fake_server.server import Server

WIDTHS = {"narrow": NARROW, "normal": NORMAL, "wide": WIDE}
QUALITIES = {"high": HIGH, "low": LOW}
SIDES = {"our": 0, "opp": 1}
_EAR_COMPLETE = {None: True, "complete": True, "c": True, "partial": False, "p": False}
_EAR_PARTIAL = {None: True, "complete": False, "c": False, "partial": True, "p": True}


class PlayerClient:
    """One player's client.

    Parameters
    ----------
    server : Server
    i : int
        Index of the player in the match.
    connection : Connection
    """

    def __init__(self, server: Server, i: int, connection: Connection) -> None:
        self.server, self.i, self.connection = server, i, connection
        self.game: Game = server.game
        self.version = int(self.game.match["version"][0, i])
        self.done = False
        self.inbox: list[bytes] = []
        self._see, self._sense = empty(SEE), empty(SENSE_BODY)
        self._buffer = np.zeros(text.MAX_MESSAGE, dtype=np.uint8)
        self._landmarks = np.ones(N_LANDMARKS, dtype=np.uint8)
        self._order = np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
        self._team_names: tuple[str, str] | None = None
        self._names, self._sizes = text.team_names("", "")

    @property
    def who(self) -> str:
        """Name in logs, such as ``keepers_1``."""
        return f"{self.game.team_name(self.i)}_{self.game.unum(self.i)}"

    @property
    def side(self) -> str:
        """``l`` or ``r``."""
        return "l" if self.i < MAX_PLAYERS else "r"

    def send(self, message: str) -> None:
        """Send a text message."""
        self.connection.send(message)

    def welcome(self, reply: str) -> None:
        """Send the reply to init or reconnect and the parameters."""
        self.send(reply)
        game = self.game
        if self.version >= 7:
            for message in all_params(game.params, game.player_params, game.types, self.version):
                self.send(message)
            for j in game.players():
                self.tell_type(int(j))

    def tell_type(self, j: int) -> None:
        """Tell of a player who has not the default type."""
        player_type = int(self.game.match["type"][0, j])
        own = j // MAX_PLAYERS == self.i // MAX_PLAYERS
        if player_type and self.version >= 7:
            self.send(text.change_player_type(self.game.unum(j), player_type if own else None))

    # --- what he is told every cycle ------------------------------------------------------------------------------
    def sense_body(self) -> None:
        """Send sense_body, and fullstate where it is switched on."""
        game = self.game
        body.sense_body(game.match, game.kernel, game.types, self.i, self._sense)
        self.connection.send_buffer(self._buffer, text.write_sense_body(self._sense, game.match, self.i, self._buffer))
        if game.params[f"fullstate_{self.side}"] and self.version >= 7:
            mode = ascii_bytes(game.mode_name)
            self.connection.send_buffer(self._buffer, text.write_fullstate(game.match, self.i, mode, self._buffer))

    def hear(self) -> None:
        """Send what was said in the cycle before."""
        game = self.game
        match = game.match
        n = hearing.deliver(match, game.kernel, self.i, game.streams, self._order)
        for m, how in self._order[:n].tolist():
            speaker = int(match["heard_by"][0, m])
            message = match["heard"][0, m, : match["heard_n"][0, m]].tobytes().decode("latin-1")
            self.send(self._heard(how, speaker, message))

    def _heard(self, how: int, speaker: int, message: str) -> str:
        game, now = self.game, self.game.time
        if how == hearing.HEAR_SELF:
            return text.hear_self(now, message)
        own = speaker // MAX_PLAYERS == self.i // MAX_PLAYERS
        if how == hearing.HEAR_PART:
            return text.hear_partly(now, game.unum(speaker) if own else 0)
        direction = int(hearing.voice_direction(game.match, self.i, speaker))
        if own:
            return text.hear_team_mate(now, direction, game.unum(speaker), message)
        return text.hear_opponent(now, direction, message)

    def see(self) -> None:
        """Send a see message."""
        game = self.game
        if self._team_names != game.teams:
            self._team_names = game.teams
            own = self.i // MAX_PLAYERS
            self._names, self._sizes = text.team_names(game.names[own], game.names[1 - own])
        vision.see(game.match, game.kernel, game.types, self.i, game.streams, self._landmarks, self._see)
        self.connection.send_buffer(self._buffer, text.write_see(self._see, self._names, self._sizes, self._buffer))

    # --- what he commands -----------------------------------------------------------------------------------------
    def execute(self, data: bytes) -> None:
        """Carry out the commands of a datagram, left to right, up to the first syntax error."""
        terminated = data.endswith(b"\0")
        message = data.split(b"\0", 1)[0]
        if self.server.logs.wants_messages:
            self.server.logs.received(self.game.match, self.who, message.decode("latin-1"))
        parsed, complete = said.parse_commands(message, self.game.params.profile)
        for command in parsed:
            if not self.connection.connected:
                return
            self._carry_out(command)
        if not complete:
            self.send("(error illegal_command_form)")
        if not terminated and self.version >= 8:
            self.send("(warning message_not_null_terminated)")

    def _carry_out(self, command: said.Command) -> None:
        game, i = self.game, self.i
        match, params, types = game.match, game.kernel, game.types
        rng = game.streams[PHYSICS]
        if isinstance(command, said.Dash):
            commands.dash(match, params, types, i, command.power, command.direction or 0.0)
        elif isinstance(command, said.Turn):
            commands.turn(match, params, types, i, command.moment, rng)
        elif isinstance(command, said.Kick):
            commands.kick(match, params, types, i, command.power, command.direction, rng)
        elif isinstance(command, said.TurnNeck):
            commands.turn_neck(match, params, i, command.moment)
        elif isinstance(command, said.Say):
            self._say(command.message)
        elif isinstance(command, said.Done):
            self.done = True
        elif isinstance(command, said.Move):
            caught = int(match["catcher"][0]) == i
            if caught and commands.too_many_moves(match, params, i):
                self.send("(error too_many_moves)")
            commands.move(match, params, types, i, command.x, command.y, rng)
        elif isinstance(command, said.Tackle):
            commands.tackle(match, params, types, i, command.number, bool(command.foul), rng)
        elif isinstance(command, said.Catch):
            commands.catch_ball(match, params, types, i, command.direction, rng)
        elif isinstance(command, said.DashLegs):
            for leg, dashes in ((commands.LEFT_LEG, command.left), (commands.RIGHT_LEG, command.right)):
                if dashes is not None:
                    commands.dash_legs(match, params, i, leg, *dashes)
        else:
            self._carry_out_rest(command)

    def _carry_out_rest(self, command: said.Command) -> None:
        game, i = self.game, self.i
        match, params = game.match, game.kernel
        if isinstance(command, said.ChangeView):
            commands.change_view(match, i, WIDTHS[command.width], QUALITIES[command.quality or "high"])
        elif isinstance(command, said.AttentionTo):
            self._attend(command)
        elif isinstance(command, said.PointTo):
            if command.distance is None:
                commands.point_to_off(match, params, i)
            else:
                commands.point_to(match, params, i, command.distance, command.direction)
        elif isinstance(command, said.Ear):
            self._set_ear(command)
        elif isinstance(command, said.SenseBody):
            self.sense_body()
        elif isinstance(command, said.Score):
            own = i // MAX_PLAYERS
            self.send(text.score_reply(game.time, game.score[own], game.score[1 - own]))
        elif isinstance(command, said.Clang):
            self.send(f"(ok clang (ver {command.minimum} {command.maximum}))")
        elif isinstance(command, said.Compression):
            if command.level <= 9:
                self.send(f"(ok compression {command.level})")
                self.connection.compress(command.level)
        elif isinstance(command, said.SynchSee):
            if commands.synch_see(match, i):
                self.send("(ok synch_see)")
        elif isinstance(command, said.GaussianSee):
            if commands.gaussian_see(match, i):
                self.send("(ok gaussian_see)")
        elif isinstance(command, said.ChangeFocus):
            commands.change_focus(match, params, i, command.distance, command.direction)
        elif isinstance(command, said.Bye):
            self.server.player_left(self)

    def _say(self, message: str) -> None:
        data = np.frombuffer(message.encode("latin-1"), dtype=np.uint8)
        if commands.say(self.game.match, self.game.kernel, self.i, data, len(data)):
            self.server.player_spoke(self, message)

    def _team_index(self, name: str) -> int | None:
        own = self.i // MAX_PLAYERS
        if name in SIDES:
            return own if name == "our" else 1 - own
        if name in ("l", "left", "r", "right"):
            return 0 if name[0] == "l" else 1
        return self.game.find_team(name)

    def _attend(self, command: said.AttentionTo) -> None:
        if command.team is None:
            commands.attention_off(self.game.match, self.i)
            return
        team = self._team_index(command.team)
        if team is not None:
            commands.attention_to(self.game.match, self.i, LEFT if team == 0 else RIGHT, command.unum)

    def _set_ear(self, command: said.Ear) -> None:
        teams: tuple[int | None, ...] = (0, 1)
        if command.team is not None:
            teams = (self._team_index(command.team),)
            if teams[0] is None:
                self.send(f"(error no team with name {command.team})")
                return
        bits = 0
        for team in teams:
            shift = 0 if team == self.i // MAX_PLAYERS else 2
            bits |= (1 if _EAR_COMPLETE[command.mode] else 0) << shift
            bits |= (2 if _EAR_PARTIAL[command.mode] else 0) << shift
        before = int(self.game.match["ear_off"][0, self.i])
        self.game.match["ear_off"][0, self.i] = before & ~bits if command.on else before | bits
