"""Keepaway refereed by a trainer, without sockets: for servers that have no Keepaway mode.

The rules are those of the server's own referee (19.0.0, src/referee.cpp, KeepawayRef): the ball out of the region, or
four steps with a taker in kicking range, and the same places for everybody afterwards. What differs follows from the
trainer protocol: a trainer sees the end of an episode when the players do and cannot place them before they have
answered, so the first cycle of an episode is lost to them; they are told by ``(hear T coach "...")`` a cycle later.
The UT Austin players take any message of a trainer for the end of an episode.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.keepaway.session import EPISODE_END
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import (
    ChangeMode,
    Command,
    Done,
    Eye,
    MoveBall,
    MovePlayer,
    Recover,
    TeamNames,
    TrainerEar,
    TrainerInit,
    TrainerSay,
    datagram,
)
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.stage.survey import WrongServer

PROTOCOL_VERSION = 11
TURNOVER_TIME = 4
"""Steps that takers need in kicking range of the ball."""
_CORNER = 3.0
_BALL_OFFSET = 4.0
_MIDDLE = 1.0
_PLAY_ON = "play_on"
OFF, BALL_OFF, ROLLS = 2.0, 0.5, 0.1
"""Metres by which a player, whom what was commanded in the cycle of the move still moves, and the ball, which nobody
can reach from his place, may be off their places when they are next seen; metres per cycle of a ball that does not lie
still. Otherwise the network has lost the move, or somebody whose move was lost has kicked the ball."""
AGAIN, PATIENCE = 3, 30
"""Looks after which a question or a change of the play mode counts as lost; looks at people who are not at their
places after which the server counts as unwilling."""
_THINK, _DONE = b"(think)", datagram(Done())
_HEAR, _HEAR_REFEREE = b"(hear ", b"(hear referee "
Point = tuple[float, float]


class KeepawayRules:
    """When an episode ends and where the next one begins.

    Parameters
    ----------
    task : Task
    reach : float
        Kicking range (m), from a player's centre to the ball's.
    """

    def __init__(self, task: Task, reach: float = 1.085) -> None:
        self.task, self.reach = task, reach
        self._held = 0

    def restart(self) -> None:
        """Forget who had the ball."""
        self._held = 0

    def ending(self, ball: Point, keepers: Sequence[Point], takers: Sequence[Point]) -> str | None:
        """Look at one step; returns OUT or TAKEN when the episode ends with it, else None."""
        x, y = ball
        if not (abs(x) < 0.5 * self.task.length and abs(y) < 0.5 * self.task.width):
            return OUT
        if self._held >= TURNOVER_TIME:
            return TAKEN
        if self._anybody_near(ball, takers):
            self._held += 1
        elif self._anybody_near(ball, keepers):
            self._held = 0
        return None

    def _anybody_near(self, ball: Point, players: Sequence[Point]) -> bool:
        return any((x - ball[0]) ** 2 + (y - ball[1]) ** 2 < self.reach**2 for x, y in players)

    def ball_place(self) -> Point:
        """Where the ball lies at the start of an episode."""
        return _BALL_OFFSET - 0.5 * self.task.length, _BALL_OFFSET - 0.5 * self.task.width

    def places(self, keepers: int, takers: int, rng: np.random.Generator) -> tuple[list[Point], list[Point]]:
        """Draw the places of keepers and takers at the start of an episode."""
        half_x, half_y = 0.5 * self.task.length, 0.5 * self.task.width
        first = int(rng.integers(keepers))

        def keeper(slot: int) -> Point:
            if slot >= 3:
                return float(rng.uniform(-_MIDDLE, _MIDDLE)), float(rng.uniform(-_MIDDLE, _MIDDLE))
            inward, down = rng.uniform(0.0, _CORNER, 2)
            x = inward - half_x if slot == 0 else half_x - inward
            return float(x), float(half_y - down if slot == 2 else down - half_y)

        def taker() -> Point:
            inward, up = rng.uniform(0.0, _CORNER, 2)
            return float(inward - half_x), float(half_y - up)

        return [keeper((first + k) % keepers) for k in range(keepers)], [taker() for _ in range(takers)]


class KeepawayTrainer:
    """A trainer that waits for the teams, starts the match, and ends and starts episodes.

    Parameters
    ----------
    task : Task
    seed : int
        Of the places.

    Attributes
    ----------
    episodes : list of Episode
        Finished so far; an episode starts in the cycle in which the one before ended.
    present : (int, int)
        Players of the left and right team seen before the start.
    started : bool
    start : int
        Cycle in which the episode that is played began.
    begun : int
        Cycle in which the first one did.
    told : dict of str to Value
        The server's parameters.
    """

    def __init__(self, task: Task, seed: int) -> None:
        self.task = task
        self.episodes: list[Episode] = []
        self.present = (0, 0)
        self.started = False
        self.cycle = 0
        self._rules = KeepawayRules(task)
        self._rng = np.random.default_rng([seed, task.keepers, task.takers])
        self._names: tuple[str, str] | None = None
        self._mode = ""
        self.start = self.begun = 0
        self.told: dict[str, Value] = {}
        self._unanswered = 0  # looks since the last question or change of the mode
        self._asked = False
        self._to_place: list[MovePlayer] = []  # not yet seen at their places
        self._ball_to_place = False
        self._looks_for_them = 0

    @staticmethod
    def first_datagram() -> bytes:
        """Return what asks the server for the trainer's place."""
        return datagram(TrainerInit(PROTOCOL_VERSION))

    def initialised(self, reply: bytes) -> list[bytes]:
        """Take the reply to the first datagram; returns datagrams to send.

        Raises
        ------
        WrongServer, RemoteProtocolError
            When the server refuses, or says something else.
        """
        event = messages.parse(reply)
        if isinstance(event, messages.Error):
            hint = ""
            if "without_coach_mode" in event.text:
                hint = "; it must run with server::coach=1"
            raise WrongServer(f"the server refuses a trainer: {event.text}{hint}")
        if not isinstance(event, messages.InitOk):
            raise RemoteProtocolError(f"expected the reply to a trainer's init, received {type(event).__name__}")
        return [datagram(Eye(True)), datagram(TrainerEar(True))]

    def receive(self, data: bytes) -> list[bytes]:
        """Take one datagram from the server; returns datagrams to send.

        Raises
        ------
        WrongServer, RemoteProtocolError
            When it cannot be refereed, or sends something malformed.
        """
        if data.startswith(_THINK):
            return [_DONE]
        if data.startswith(_HEAR) and not data.startswith(_HEAR_REFEREE):
            return []
        return [datagram(command) for command in self._commands(messages.parse(data))]

    def _commands(self, event: messages.Event) -> Iterator[Command]:
        if isinstance(event, messages.SeeGlobal):
            yield from self._see(event)
        elif isinstance(event, messages.OkTeamNames):
            self._asked = False
            if event.left is not None and event.right is not None:
                self._names = event.left, event.right
        elif isinstance(event, messages.Hear):
            if event.source == "referee" and event.text in PLAY_MODE_IDS:
                self._mode = event.text
        elif isinstance(event, messages.ServerParam):
            self._take_params(event)
        elif isinstance(event, messages.Error):
            raise RemoteProtocolError(f"the server refuses a trainer's command: {event.text}")

    def _take_params(self, event: messages.ServerParam) -> None:
        params: ServerParams = event.to_params()
        self.told = dict(event.values)
        if params["keepaway"] and params["coach_w_referee"]:
            raise WrongServer(
                "the server referees Keepaway itself (server::keepaway=1); a trainer needs server::keepaway=0"
            )
        region = params.number("keepaway_length"), params.number("keepaway_width")
        if "keepaway_length" in event.values and region != (self.task.length, self.task.width):
            raise WrongServer(
                f"the server tells players of a region of {region[0]:g}x{region[1]:g} m, not {self.task.field}; "
                f"give it server::keepaway_length={self.task.length:g} server::keepaway_width={self.task.width:g}"
            )
        self._rules.reach = sum(params.number(name) for name in ("player_size", "ball_size", "kickable_margin"))

    # -- what it sees -------------------------------------------------------------------------------------------------
    def _see(self, event: messages.SeeGlobal) -> Iterator[Command]:
        new, self.cycle = event.time > self.cycle, event.time
        if not self.started:
            yield from self._wait(event)
        elif self._mode == "" and self._is_unanswered():
            yield ChangeMode(_PLAY_ON)
        elif new and self._mode == _PLAY_ON:
            keepers, takers = self._teams(event)
            if self._to_place or self._ball_to_place:
                yield from self._place_again(event)
                if self._to_place or self._ball_to_place:
                    return  # an episode has not begun before everybody is where it begins
            ball = event.ball.x, event.ball.y
            reason = self._rules.ending(ball, [(p.x, p.y) for p in keepers], [(p.x, p.y) for p in takers])
            if reason is not None:
                self.episodes.append(Episode(len(self.episodes) + 1, self.start, event.time, reason))
                self.start = event.time
                yield TrainerSay(EPISODE_END)
                yield from self._place(keepers, takers)

    def _teams(self, event: messages.SeeGlobal) -> tuple[list[messages.GlobalPlayer], list[messages.GlobalPlayer]]:
        """Players of the left and of the right team, by their numbers."""
        left, right = self._names or ("", "")
        players = sorted(event.players, key=lambda player: player.unum)
        return [p for p in players if p.team == left], [p for p in players if p.team == right]

    def _wait(self, event: messages.SeeGlobal) -> Iterator[Command]:
        """Start the match when both teams are complete."""
        keepers, takers = self._teams(event)
        self.present = len(keepers), len(takers)
        if self._names is None:
            complete = len(event.players) >= self.task.keepers + self.task.takers
            if complete and (not self._asked or self._is_unanswered()):
                self._asked = True
                yield TeamNames()
        elif self.present == (self.task.keepers, self.task.takers):
            self.started = True
            self._unanswered, self._mode = 0, ""
            self.start = self.begun = event.time
            yield from self._place(keepers, takers)
            # Not (start): that would be a kick-off of soccer, with the types of the players drawn anew.
            yield ChangeMode(_PLAY_ON)

    def _place(
        self, keepers: Sequence[messages.GlobalPlayer], takers: Sequence[messages.GlobalPlayer]
    ) -> Iterator[Command]:
        """Put everybody, then the ball (which players under way would push), to the places of a new episode."""
        self._to_place = []
        if keepers:
            places = self._rules.places(len(keepers), len(takers), self._rng)
            for player, (x, y) in zip([*keepers, *takers], [*places[0], *places[1]], strict=True):
                move = MovePlayer(player.team, player.unum, round(x, 4), round(y, 4), player.body, (0.0, 0.0))
                self._to_place.append(move)
                yield move
        yield MoveBall(*self._rules.ball_place())
        yield Recover()
        self._ball_to_place = True
        self._rules.restart()

    def _place_again(self, event: messages.SeeGlobal) -> Iterator[Command]:
        """Repeat the moves of those who are not seen at their places."""
        seen = {(p.team, p.unum): (p.x, p.y) for p in event.players}
        here = [(move, seen.get((move.team, move.unum), (move.x, move.y))) for move in self._to_place]
        self._to_place = [move for move, (x, y) in here if np.hypot(x - move.x, y - move.y) > OFF]
        x, y = self._rules.ball_place()
        lies = (
            np.hypot(event.ball.x - x, event.ball.y - y) <= BALL_OFF and np.hypot(event.ball.vx, event.ball.vy) <= ROLLS
        )
        self._ball_to_place = bool(self._to_place) or not lies  # who was still about may have kicked it
        self._looks_for_them = self._looks_for_them + 1 if self._ball_to_place else 0
        if self._looks_for_them > PATIENCE:
            raise WrongServer(f"the server does not put players where the trainer wants them (cycle {event.time})")
        yield from self._to_place
        if self._ball_to_place:
            yield MoveBall(x, y)
            self._rules.restart()

    def _is_unanswered(self) -> bool:
        """Count a look without an answer; tell whether there were enough of them to say it again."""
        self._unanswered = (self._unanswered + 1) % AGAIN
        return self._unanswered == 0
