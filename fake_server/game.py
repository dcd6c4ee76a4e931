"""A match with its teams: who joins, what clients and monitors may do to it, what the referee announces.

No sockets and no text of messages: a server, or a test, drives it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from fake_server.announcements import announcements
from fake_server.options import ServerOptions
from fake_server.soccer.cards import Cards
from fake_server.soccer.kick_off import LineUp, kick_off, team_size
from fake_server.soccer.referee import free_kick
from fake_server.soccer.step import step
from fake_server.soccer.touch import SHOOT_OUT, TouchReferee
from fake_server.text import FIRST_VERSION, LAST_VERSION
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import LEFT, MAX_PLAYERS, RIGHT
from rcss_hat.simulation import keepaway
from rcss_hat.simulation.pitch import HALF_LENGTH, HALF_WIDTH
from rcss_hat.simulation.placement import move_player_to, place_ball, recover_all
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.posts import POST_RADIUS
from rcss_hat.simulation.referee import STOPPED, change_play_mode, drop_ball
from rcss_hat.simulation.state import (
    BEFORE_KICK_OFF,
    EARS_AT_FIRST,
    FREE_KICK_LEFT,
    FREE_KICK_RIGHT,
    GOAL_LEFT,
    GOAL_RIGHT,
    PLAY_ON,
    connect,
    disconnect,
    index,
    new_match,
    recover,
    streams,
)
from rcss_hat.simulation.world import World

LAST_VERSION_11 = 11
_GOAL_DEPTH = 2.44


class JoinError(Exception):
    """A client may not join; the message is the server's answer."""


class Game:
    """A match, its teams and its randomness.

    Parameters
    ----------
    options : ServerOptions
    seed : int
        Of all randomness; also of the player types when ``player::random_seed`` is negative.

    Attributes
    ----------
    params, player_params : ServerParams, PlayerParams
    kernel : ndarray of PARAMS, shape (1,)
        The parameters as the kernels read them.
    types : ndarray of PLAYER_TYPE
    match : ndarray of MATCH, shape (1,)
    streams : ndarray of uint64, shape (3, 4)
    world : World
        These four arrays.
    names : list of str
        Of the left and the right team, empty while there is none.
    cards : Cards
    line_up : LineUp
    announced_at : tuple of int
        `clock` when the referee announced what the last step brought.
    touch : TouchReferee or None
        Judges goals and the lines; None in Keepaway and without referees.
    """

    def __init__(self, options: ServerOptions, seed: int) -> None:
        self.params = options.params
        self.player_params = options.player_params
        types_seed = int(self.player_params["random_seed"])
        if types_seed < 0:
            types_seed = seed % 2**31
            if self.params.profile != "11.1":  # which does not tell the seed it has drawn
                self.player_params.set("random_seed", types_seed)
        self.kernel = self.params.record()
        self.has_referees = bool(self.params["coach_w_referee"]) or not self.params["coach"]
        if not self.has_referees:
            for name in ("keepaway", "half_time", "ball_stuck_area", "use_offside"):
                self.kernel[name] = 0.0
        self.types = player_types(self.params, types_seed, self.player_params.numbers())
        self.match = new_match(self.kernel)
        self.match["score"][0] = [int(self.params.number(f"start_goal_{side}")) for side in "lr"]
        self.streams = streams(seed)
        self.world = World(self.match, self.kernel, self.types, self.streams)
        self._fresh_streams = self.streams.copy()
        self.cards = Cards(self.match)
        self.names = ["", ""]
        self.line_up = LineUp(self.params, self.player_params, self.world)
        self.announced_at = self.clock
        plays_soccer = self.has_referees and not self.kernel["keepaway"][0]
        self.touch = TouchReferee(self.params, self.world) if plays_soccer else None

    # --- what it is ---------------------------------------------------------------------------------------------
    @property
    def time(self) -> int:
        """Cycle."""
        return int(self.match["time"][0])

    @property
    def mode(self) -> int:
        """Play mode."""
        return int(self.match["mode"][0])

    @property
    def clock(self) -> tuple[int, int]:
        """Cycle, and steps spent in the current stoppage."""
        return self.time, int(self.match["stopped"][0])

    @contextmanager
    def as_of(self, clock: tuple[int, int]) -> Iterator[None]:
        """Let the `clock` show another time, for all that is told meanwhile."""
        now = self.clock
        self.match["time"], self.match["stopped"] = clock
        yield
        self.match["time"], self.match["stopped"] = now

    @property
    def waits_for_kick_off(self) -> bool:
        """Whether the match has not begun."""
        return self.time == 0 and self.mode == BEFORE_KICK_OFF

    @property
    def goes_on_unwatched(self) -> bool:
        """Whether nothing that players do is announced at once: open play, without a `TouchReferee`."""
        return self.touch is None and self.mode == PLAY_ON

    @property
    def mode_name(self) -> str:
        """Play mode as clients are told."""
        return PLAY_MODES[self.mode]

    @property
    def mode_with_catch(self) -> str:
        """Play mode as fullstate has it: a free kick with the ball in a goalie's hands has a name of its own."""
        if self.mode in (FREE_KICK_LEFT, FREE_KICK_RIGHT) and self.match["catcher"][0] >= 0:
            return "goalie_catch_ball_l" if self.mode == FREE_KICK_LEFT else "goalie_catch_ball_r"
        return self.mode_name

    @property
    def teams(self) -> tuple[str, str]:
        """Names of the left and the right team."""
        return self.names[0], self.names[1]

    @property
    def score(self) -> tuple[int, int]:
        """Goals of the left and the right team."""
        return int(self.match["score"][0, 0]), int(self.match["score"][0, 1])

    def enabled(self, i: int) -> bool:
        """Tell whether a player is in the game."""
        return bool(self.match["enabled"][0, i])

    def team_name(self, i: int) -> str:
        """Name of a player's team."""
        return self.names[i // MAX_PLAYERS]

    def unum(self, i: int) -> int:
        """Uniform number of a player."""
        return i % MAX_PLAYERS + 1

    def name_for_opponents(self, team: int) -> str:
        """Return what the left (0) or right (1) team is called in what its opponents see."""
        return str(self.params["fixed_teamname_r" if team else "fixed_teamname_l"]) or self.names[team]

    def find_team(self, name: str) -> int | None:
        """Return 0 for the left team's name, 1 for the right one's, None for others."""
        return self.names.index(name) if name and name in self.names else None

    def team_size(self, team: int) -> int:
        """Number of players who ever joined the left (0) or right (1) team."""
        return team_size(self.match, team)

    def ball_place(self) -> str:
        """Return where the ball is: in_field, goal_l, goal_r or out_of_field (19.0.0, src/stadium.cpp, ballPosInfo)."""
        size = self.params.number("ball_size")
        half_goal = 0.5 * (self.params.number("goal_width") + POST_RADIUS)
        x, y = (float(v) for v in self.match["ball_pos"][0])
        if abs(y) <= half_goal and HALF_LENGTH + size <= abs(x) <= HALF_LENGTH + size + _GOAL_DEPTH:
            return "goal_l" if x < 0.0 else "goal_r"
        inside = abs(x) <= HALF_LENGTH + size and abs(y) <= HALF_WIDTH + size
        return "in_field" if inside else "out_of_field"

    # --- who plays ------------------------------------------------------------------------------------------------
    def join(self, team: str, version: float, goalie: bool) -> int:
        """Let a player join.

        Returns
        -------
        int
            Index of the player.

        Raises
        ------
        JoinError
            With the server's answer.
        """
        if team in (self.params["fixed_teamname_l"], self.params["fixed_teamname_r"]):
            raise JoinError("(error conflict_with_fixed_teamname)")
        if team not in self.names:
            if "" not in self.names:
                raise JoinError("(error no_more_team)")
            self.names[self.names.index("")] = team
        k = self.names.index(team)
        first = k * MAX_PLAYERS
        size = self.team_size(k)
        taken = bool(self.match["goalie"][0, first : first + size].any())
        if size >= MAX_PLAYERS or (goalie and taken) or not self.knows_version(version):
            invalid = "invalid" if self.params.profile == "11.1" else "illegal"
            raise JoinError(f"(error no_more_player_or_goalie_or_{invalid}_client_version)")
        connect(self.match, self.kernel, first + size, int(version), goalie)
        return first + size

    def rejoin(self, team: str, unum: int) -> int:
        """Let a player join again; returns his index.

        Raises
        ------
        JoinError
            With the server's answer.
        """
        if self.mode == PLAY_ON:
            raise JoinError("(error cannot_reconnect_while_playon)")
        k = self.find_team(team)
        if k is None or not 1 <= unum <= MAX_PLAYERS:
            raise JoinError("(error no_such_team_or_player)")
        i = k * MAX_PLAYERS + unum - 1
        if self.cards.sent_off(i):
            raise JoinError("(error red_carded_player)")
        version = int(self.match["version"][0, i])
        if not self.knows_version(version):  # of a number that never connected
            raise JoinError("(error illegal_client_version)")
        connect(self.match, self.kernel, i, version, bool(self.match["goalie"][0, i]))
        self.match["ear_off"][0, i] = EARS_AT_FIRST
        self.cards.returned(i)
        return i

    def leave(self, i: int) -> None:
        """Take a player out."""
        disconnect(self.match, i)

    @property
    def versions(self) -> range:
        """Protocol versions of players and trainers that are served."""
        last = LAST_VERSION_11 if self.params.profile == "11.1" else LAST_VERSION
        return range(FIRST_VERSION, last + 1)

    def knows_version(self, version: float) -> bool:
        """Tell whether players of a protocol version are served."""
        return math.isfinite(version) and int(version) in self.versions

    # --- what happens ---------------------------------------------------------------------------------------------
    def settle_randomness(self) -> None:
        """Start the random streams afresh while the first kick-off is awaited.

        How long clients take to connect would otherwise decide what is drawn afterwards.
        """
        if self.waits_for_kick_off and self.match["episode"][0] == 0:
            self.streams[:] = self._fresh_streams

    def step(self) -> list[str]:
        """Simulate a step; returns what the referee announces, which is as of `announced_at`.

        The end of a stoppage is announced before the time goes on.
        """
        self.settle_randomness()
        before, (time, stopped) = self.mode, self.clock
        collided = self.match["collided"].copy()
        step(self.world, self.has_referees)
        self.match["collided"] |= collided  # what commands have run into since everybody was told
        self.cards.mark()
        self.announced_at = (time, stopped + 1) if STOPPED[before] else self.clock
        announced = announcements(self.match, before)
        return announced if self.touch is None else announced + self.touch.look(time)

    def forget_collisions(self) -> None:
        """Begin anew to note who runs into what, once everybody was told."""
        self.match["collided"] = 0

    def kick_off(self) -> list[str]:
        """Start the play, as ``(start)`` and ``(dispstart)`` do; returns what the referee announces."""
        if not self.kernel["keepaway"][0]:
            return self.change_mode(PLAY_ON) if self.params["keepaway"] else kick_off(self.params, self.world)
        self.settle_randomness()
        before = self.mode
        self.match["events"] = 0
        keepaway.kick_off(self.world)
        return announcements(self.match, before)

    def change_mode(self, mode: int) -> list[str]:
        """Change the play mode, as a trainer does; returns what the referee announces."""
        if mode == PLAY_ON and self.kernel["keepaway"][0]:
            return self.kick_off()
        change_play_mode(self.world, mode)
        self.match["events"] = 0
        if self.touch is not None:
            self.touch.notice_mode()
        return [] if mode in (GOAL_LEFT, GOAL_RIGHT) else [PLAY_MODES[mode]]

    def call_foul(self, side: int, x: float, y: float) -> list[str]:
        """Drop the ball at a place (``side`` 0), or give side 1 (left) or another (right) a free kick there."""
        if self.mode in SHOOT_OUT:
            return []
        if side == 0:
            drop_ball(self.world, x, y)
            self.match["events"] = 0
            return ["drop_ball", "play_on"]
        free_kick(self.world, LEFT if side == 1 else RIGHT, x, y)
        self.match["events"] = 0
        return ["foul_l" if side == -1 else "foul_r", self.mode_name]

    def move_ball(self, x: float, y: float, velocity: tuple[float, float]) -> None:
        """Put the ball somewhere, as a trainer does."""
        self.match["catcher"] = -1
        place_ball(self.match, x, y, *velocity)

    def move_player(
        self, i: int, x: float, y: float, angle: float | None = None, velocity: tuple[float, float] | None = None
    ) -> None:
        """Put a player somewhere; ``angle`` (degrees) and ``velocity`` (m/cycle) stay as they are when None."""
        if angle is not None:
            self.match["body"][0, i] = self.match["body_pending"][0, i] = math.radians(angle)
        if velocity is not None:
            self.match["vel"][0, i] = velocity
        move_player_to(self.world, i, x, y)

    def recover(self) -> None:
        """Give everybody full stamina."""
        recover_all(self.match, self.kernel)

    def substitute(self, i: int, player_type: int) -> None:
        """Give a player another type."""
        self.line_up.substituted(i)
        self.cards.substituted(i)
        self.match["type"][0, i] = player_type
        self.match["size"][0, i] = self.types["player_size"][player_type]
        self.match["effort_max"][0, i] = self.types["effort_max"][player_type]
        recover(self.match, self.kernel, i)

    def last_episode(self) -> tuple[int, int, int, bool]:
        """Return number, start, end and whether it was taken, of the episode that ended last."""
        record = keepaway.last_episode(self.match)[0]
        return int(record["episode"]), int(record["start"]), int(record["end"]), bool(record["taken"])

    def player_index(self, side: int, unum: int) -> int | None:
        """Return the index of a player of side 1 (left) or -1 (right), None when there is no such number."""
        if side not in (1, -1) or not 1 <= unum <= MAX_PLAYERS:
            return None
        return index(LEFT if side == 1 else RIGHT, unum)

    def players(self) -> NDArray[np.uint8]:
        """Return the indices of all players in the game."""
        indices: NDArray[np.uint8] = self.match["players"][0, : self.match["n_players"][0]]
        return indices
