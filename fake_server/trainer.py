"""The trainer (offline coach): moves things, changes modes, sees and hears everything.

Source: 19.0.0, src/coach.cpp, src/visualsendercoach.cpp and src/serializercoachstdv7, v8, v13.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fake_server import text
from fake_server.coaching import coach
from fake_server.connection import Connection
from fake_server.param_text import all_params
from rcss_hat.numeric.angles import RAD, normalize_radians
from rcss_hat.protocol import commands as said

if TYPE_CHECKING:
    from fake_server.server import Server

_GOALS = "((g r) 52.5 0) ((g l) -52.5 0)"
_MARKS_SINCE = 13
"""Trainers of this version and later see who kicks, and see arms and tackles with look too."""


class TrainerClient:
    """The trainer's client.

    Parameters
    ----------
    server : Server
    connection : Connection or None
        None for a first datagram that is no init: it is carried out, but nobody can be answered.
    version : int
        Of the protocol.
    """

    def __init__(self, server: Server, connection: Connection | None, version: int) -> None:
        self.server, self.connection, self.version = server, connection, version
        self.game = server.game
        self.eye = self.ear = self.done = False

    @property
    def connected(self) -> bool:
        """Whether anybody is there."""
        return self.connection is not None and self.connection.connected

    @property
    def waited_for(self) -> bool:
        """Whether a think step still waits for him; only one whose eye is on is asked to think."""
        return self.eye and not self.done and self.connected

    def send(self, message: str) -> None:
        """Send a text message."""
        if self.connection is not None:
            self.connection.send(message)

    def welcome(self) -> None:
        """Send the reply to init, the parameters, and whose type is not the default one."""
        game = self.game
        self.send("(init ok)")
        for message in all_params(game.params, game.player_params, game.types, self.version):
            self.send(message)

    # --- what he is told ------------------------------------------------------------------------------------------
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
            self.send(f"(see_global {self._everything(marks=True)})")

    def _everything(self, marks: bool) -> str:
        game, match = self.game, self.game.match
        x, y = match["ball_pos"][0]
        vx, vy = match["ball_vel"][0]
        players = [f" {self._player(int(i), marks)}" for i in game.players()]
        return f"{game.time} {_GOALS} ((b) {x:g} {y:g} {vx:g} {vy:g}){''.join(players)}"

    def _player(self, i: int, marks: bool) -> str:
        row = self.game.match[0]
        (x, y), (vx, vy) = row["pos"][i], row["vel"][i]
        body, neck = float(row["body"][i]), float(row["neck"][i])
        words = [f"({self.game.visible_name(i)})", f"{x:g} {y:g} {vx:g} {vy:g} {round(body * RAD)} {round(neck * RAD)}"]
        if marks and row["arm_expires"][i] > 0:
            _, direction = text.arm_target(self.game.match, i)
            words.append(str(round(normalize_radians(direction + neck + body) * RAD)))
        if marks and row["tackle_cycles"][i] > 0:
            words.append("t")
        elif marks and self.version >= _MARKS_SINCE and row["kick_cycles"][i] > 0:
            words.append("k")
        return f"({' '.join(words)})"

    # --- what he commands -----------------------------------------------------------------------------------------
    def read(self) -> None:
        """Carry out all commands that have arrived."""
        if self.connection is not None:
            for data in self.connection.receive():
                if not data.endswith(b"\0"):
                    self.send("(warning message_not_null_terminated)")
                self.take(data)

    def take(self, data: bytes) -> None:
        """Carry out the one command of a datagram, and answer."""
        if self.server.logs.wants_messages:
            self.server.logs.received(self.game.match, "Coach", data.split(b"\0", 1)[0].decode("latin-1"))
        command = said.parse_trainer_command(data, int(self.game.params.number("say_coach_msg_size")))
        if isinstance(command, said.Refusal):
            self.send(command.text)
        else:
            self._carry_out(command)

    def _carry_out(self, command: said.Command) -> None:
        game = self.game
        if isinstance(command, said.Done):
            self.done = True
        elif isinstance(command, said.Look):
            self.send(f"(ok look {self._everything(marks=self.version >= _MARKS_SINCE)})")
        elif isinstance(command, said.Eye):
            self.eye = command.on
            self.send(f"(ok eye {'on' if command.on else 'off'})")
        elif isinstance(command, said.TrainerEar):
            self.ear = command.on
            self.send(f"(ok ear {'on' if command.on else 'off'})")
        elif isinstance(command, said.TeamNames):
            names = [f" (team {side} {name})" for side, name in zip("lr", game.teams, strict=True) if name]
            self.send(f"(ok team_names{''.join(names)})\n")
        elif isinstance(command, said.TrainerSay):
            self._say(command.message)
        elif isinstance(command, said.Compression):
            self.send(f"(ok compression {command.level})")
            if self.connection is not None:
                self.connection.compress(command.level)
        else:
            reply = coach(self.server, command) or "(error unknown_command)"
            self.send(reply + "\n" if isinstance(command, said.Recover) else reply)

    def _say(self, message: str) -> None:
        if self.ear:
            self.send(f'(hear {self.game.time} referee "{message}")')
        self.server.trainer_spoke(message)
        self.send("(ok say)")
