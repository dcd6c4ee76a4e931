"""The trainer (offline coach): moves things, changes modes, sees and hears everything.

Source: 19.0.0, src/coach.cpp, src/visualsendercoach.cpp and src/serializercoachstdv7, v8, v13.
"""

from __future__ import annotations

from collections.abc import Sequence

from fake_server.coaching import coach
from fake_server.connection import Connection
from fake_server.game import Game
from fake_server.param_text import all_params
from fake_server.reactions import Reactions, Reply
from rcss_hat.numeric.angles import RAD, normalize_radians
from rcss_hat.protocol import commands as said
from rcss_hat.protocol import messages
from rcss_hat.protocol.messages.frame import arm_target

_GOALS = {"r": (52.5, 0.0), "l": (-52.5, 0.0)}
_MARKS_SINCE, _CARDS_SINCE = 13, 14
"""Trainers of these versions and later see who kicks, and with look arms and tackles; see cards, but not with look."""


class TrainerClient:
    """The trainer's client.

    Parameters
    ----------
    game : Game
    connection : Connection
    version : int
        Of the protocol.
    """

    who = "Coach"
    """Name in logs."""

    def __init__(self, game: Game, connection: Connection, version: int) -> None:
        self.game, self.connection, self.version = game, connection, version
        self.eye = self.ear = self.done = False

    @property
    def waited_for(self) -> bool:
        """Whether a think step still waits for him; only one whose eye is on is asked to think."""
        return self.eye and not self.done and self.connection.connected

    def reply(self, message: str) -> None:
        """Send a text message."""
        self.connection.send(message)

    def welcome(self) -> Sequence[str]:
        """Return the reply to init, and the parameters."""
        game = self.game
        parameters = all_params(game.params, game.player_params, game.types, self.version)
        return [messages.InitOk().to_text(), *parameters]

    # --- what he is told ------------------------------------------------------------------------------------------
    def hear_referee(self, message: str) -> None:
        """Tell what the referee announces."""
        if self.ear:
            self.connection.send(f"(hear referee {self.game.time} {message})")

    def hear_player(self, i: int, message: str) -> None:
        """Tell what a player says, at once."""
        if self.ear:
            team, goalie = self.game.team_name(i), bool(self.game.match["goalie"][0, i])
            heard = messages.Hear(
                time=self.game.time, source="player", text=message, unum=self.game.unum(i), team=team, goalie=goalie
            )
            self.connection.send(heard.to_text())

    def see_global(self) -> None:
        """Send what the trainer sees, if his eye is on."""
        if self.eye:
            self.connection.send(self._everything(answer=False, marks=True))

    def _everything(self, answer: bool, marks: bool) -> str:
        game, match = self.game, self.game.match
        (x, y), (vx, vy) = match["ball_pos"][0], match["ball_vel"][0]
        players = tuple(self._player(int(i), marks, acts=not answer) for i in game.players())
        ball = messages.BallState(x=x, y=y, vx=vx, vy=vy)
        seen = messages.SeeGlobal(time=game.time, answer=answer, goals=_GOALS, ball=ball, players=players)
        return seen.to_text()

    def _player(self, i: int, marks: bool, acts: bool) -> messages.GlobalPlayer:
        row = self.game.match[0]
        (x, y), (vx, vy) = row["pos"][i], row["vel"][i]
        body, neck = float(row["body"][i]), float(row["neck"][i])
        pointing = None
        if marks and row["arm_expires"][i] > 0:
            _, direction = arm_target(self.game.match, i)
            pointing = round(normalize_radians(direction + neck + body) * RAD)
        does = ""
        if marks and row["tackle_cycles"][i] > 0:
            does = "t"
        elif acts and self.version >= _MARKS_SINCE and row["kick_cycles"][i] > 0:
            does = "k"
        card = self.game.cards.shown(i) if acts and self.version >= _CARDS_SINCE else ""
        return messages.GlobalPlayer(
            team=self.game.team_name(i),
            unum=self.game.unum(i),
            goalie=bool(row["goalie"][i]),
            x=x,
            y=y,
            vx=vx,
            vy=vy,
            body=round(body * RAD),
            neck=round(neck * RAD),
            pointing=pointing,
            marks=tuple(filter(None, (does, card))),
        )

    # --- what he commands -----------------------------------------------------------------------------------------
    def take(self, data: bytes) -> Reactions:
        """React to the one command of a datagram."""
        command = said.parse_trainer_command(data, int(self.game.params.number("say_coach_msg_size")))
        reactions = (Reply(command.text),) if isinstance(command, said.Refusal) else self._react(command)
        return reactions if data.endswith(b"\0") else (Reply("(warning message_not_null_terminated)"), *reactions)

    def _react(self, command: said.Command) -> Reactions:
        if isinstance(command, said.Done):
            self.done = True
            return ()
        if isinstance(command, said.TrainerSay):
            hear = Reply(f'(hear {self.game.time} referee "{command.message}")')
            return *([hear] if self.ear else ()), command, Reply("(ok say)")
        if isinstance(command, said.Compression):
            return Reply(f"(ok compression {command.level})"), command
        if (answer := self._answer(command)) is not None:
            return (Reply(answer),)
        if isinstance(command, said.Recover):
            return command, Reply("(ok recover)\n")
        return coach(self.game, command) or (Reply("(error unknown_command)"),)

    def _answer(self, command: said.Command) -> str | None:
        """Answer what concerns nobody else; None for other commands."""
        if isinstance(command, said.Look):
            return self._everything(answer=True, marks=self.version >= _MARKS_SINCE)
        if isinstance(command, said.Eye):
            self.eye = command.on
            return f"(ok eye {'on' if command.on else 'off'})"
        if isinstance(command, said.TrainerEar):
            self.ear = command.on
            return f"(ok ear {'on' if command.on else 'off'})"
        if isinstance(command, said.TeamNames):
            left, right = self.game.teams
            return messages.OkTeamNames(left=left or None, right=right or None).to_text() + "\n"
        return None
