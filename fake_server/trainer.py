"""The trainer (offline coach): moves things, changes modes, sees everything (reference: 19.0.0, src/coach.cpp)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fake_server import text
from fake_server.connection import Connection
from fake_server.param_text import all_params
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS

if TYPE_CHECKING:
    from fake_server.server import Server

GOALS = "((g r) 52.5 0) ((g l) -52.5 0)"


def _rounded(radians: float) -> int:
    return round(math.degrees(radians))


class TrainerClient:
    """The trainer's client.

    Parameters
    ----------
    server : Server
    connection : Connection
    version : int
        Of the protocol.
    """

    def __init__(self, server: Server, connection: Connection, version: int) -> None:
        self.server, self.connection, self.version = server, connection, version
        self.game = server.game
        self.eye = self.ear = self.done = False
        self.inbox: list[bytes] = []
        self.to_say: list[str] = []

    @property
    def waited_for(self) -> bool:
        """Whether a think step waits for the trainer's ``(done)``."""
        return self.eye

    def send(self, message: str) -> None:
        """Send a text message."""
        self.connection.send(message)

    def welcome(self) -> None:
        """Send the reply to init and the parameters."""
        self.send("(init ok)")
        if self.version >= 7:
            for message in all_params(self.game.params, self.game.player_params, self.game.types, self.version):
                self.send(message)

    def hear_referee(self, message: str) -> None:
        """Tell what the referee announces."""
        if self.ear:
            self.send(f"(hear referee {self.game.time} {message})")

    def hear_player(self, i: int, message: str) -> None:
        """Tell what a player says, at once."""
        if self.ear:
            self.send(f'(hear {self.game.time} ({self.game.visible_name(i)}) "{message}")')

    def see_global(self) -> None:
        """Send what the trainer sees, if his eye is on."""
        if self.eye:
            self.send(f"(see_global {self._everything(full=True)})")

    def _everything(self, full: bool) -> str:
        game = self.game
        match = game.match
        x, y = match["ball_pos"][0]
        vx, vy = match["ball_vel"][0]
        parts = [f"{game.time} {GOALS} ((b) {x:g} {y:g} {vx:g} {vy:g})"]
        for j in sorted(int(k) for k in game.players()):
            (px, py), (pvx, pvy) = match["pos"][0, j], match["vel"][0, j]
            body, neck = _rounded(match["body"][0, j]), _rounded(match["neck"][0, j])
            marks = ""
            if full and match["arm_expires"][0, j] > 0:
                marks += f" {_rounded(text.arm_target(match, j)[1])}"
            if full and match["tackle_cycles"][0, j] > 0:
                marks += " t"
            parts.append(f"(({game.visible_name(j)}) {px:g} {py:g} {pvx:g} {pvy:g} {body} {neck}{marks})")
        return " ".join(parts)

    # --- commands -------------------------------------------------------------------------------------------------
    def execute(self, data: bytes) -> None:
        """Carry out the one command of a datagram."""
        message = data.split(b"\0", 1)[0]
        if self.server.logs.wants_messages:
            self.server.logs.received(self.game.match, "Coach", message.decode("latin-1"))
        command = said.parse_trainer_command(message, int(self.game.params.number("say_coach_msg_size")))
        if isinstance(command, said.Refusal):
            self.send(command.text)
        else:
            self._carry_out(command)

    def _carry_out(self, command: said.Command) -> None:
        game = self.game
        if isinstance(command, said.Start):
            self.server.kick_off()
            self.send("(ok start)")
        elif isinstance(command, said.ChangeMode):
            self.server.announce(game.change_mode(PLAY_MODE_IDS[command.mode]))
            self.send("(ok change_mode)")
        elif isinstance(command, said.MoveBall):
            game.move_ball(command.x, command.y, command.velocity or (0.0, 0.0))
            self.send("(ok move)")
        elif isinstance(command, said.MovePlayer):
            self._move_player(command)
        elif isinstance(command, said.Look):
            self.send(f"(ok look {self._everything(full=False)})")
        elif isinstance(command, said.Eye):
            self.eye = command.on
            self.send(f"(ok eye {'on' if command.on else 'off'})")
        elif isinstance(command, said.TrainerEar):
            self.ear = command.on
            self.send(f"(ok ear {'on' if command.on else 'off'})")
        elif isinstance(command, said.CheckBall):
            self.send(f"(ok check_ball {game.time} {game.ball_place()})")
        elif isinstance(command, said.Recover):
            game.recover()
            self.send("(ok recover)\n")
        else:
            self._carry_out_rest(command)

    def _carry_out_rest(self, command: said.Command) -> None:
        game = self.game
        if isinstance(command, said.TeamNames):
            names = [f" (team {side} {name})" for side, name in zip("lr", game.teams, strict=True) if name]
            self.send(f"(ok team_names{''.join(names)})\n")
        elif isinstance(command, said.TrainerSay):
            self.to_say.append(command.message)
            self.server.logs.speech(game.match, "coach", command.message)
            self.hear_own(command.message)
            self.send("(ok say)")
        elif isinstance(command, said.ChangePlayerType):
            self._change_type(command)
        elif isinstance(command, said.Done):
            self.done = True
        elif isinstance(command, said.Compression):
            self.send(f"(ok compression {command.level})")
            self.connection.compress(command.level)
        else:
            self.send("(error unknown_command)")

    def hear_own(self, message: str) -> None:
        """Tell the trainer what he himself says, in the referee's form, as the server does."""
        if self.ear:
            self.send(f'(hear {self.game.time} referee "{message}")')

    def _move_player(self, command: said.MovePlayer) -> None:
        team = self.game.find_team(command.team)
        i = None if team is None else self.game.player_index(1 if team == 0 else -1, command.unum)
        if i is None or not self.game.enabled(i):
            self.send("(error illegal_object_form)")
            return
        self.game.move_player(i, command.x, command.y, command.angle, command.velocity)
        self.send("(ok move)")

    def _change_type(self, command: said.ChangePlayerType) -> None:
        game = self.game
        team = game.find_team(command.team)
        if team is None:
            self.send("(warning no_team_found)")
            return
        i = game.player_index(1 if team == 0 else -1, command.unum)
        if i is None or not game.enabled(i):
            self.send("(warning no_such_player)")
        elif not 0 <= command.player_type < len(game.types):
            self.send("(error out_of_range_player_type)")
        else:
            game.substitute(i, command.player_type)
            self.server.tell_type(i)
            self.send(f"(ok change_player_type {command.team} {command.unum} {command.player_type})")
