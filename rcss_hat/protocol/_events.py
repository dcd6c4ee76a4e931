"""What a server may say, one frozen record per kind of message.

Times are cycles, distances metres, angles degrees, velocities metres per cycle, sides ``"l"`` and ``"r"``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.params import BY_NAME, ServerParams, Value


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Something a server said."""


# --- joining -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, slots=True, kw_only=True)
class Init(Event):
    """A player was accepted: ``(init SIDE UNUM MODE)``."""

    side: str
    unum: int
    mode: str


@dataclass(frozen=True, slots=True, kw_only=True)
class InitOk(Event):
    """A trainer was accepted: ``(init ok)``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reconnect(Event):
    """A player is back: ``(reconnect SIDE MODE)``."""

    side: str
    mode: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerParam(Event):
    """The parameters of the server, by name; booleans come as 0 and 1."""

    values: Mapping[str, Value]

    def to_params(self, profile: str = "19.0") -> ServerParams:
        """Return them as server parameters; what the message lacks has the profile's default.

        Raises
        ------
        RemoteProtocolError
            When a value is of the wrong kind.
        """
        params = ServerParams(profile)
        for name, value in self.values.items():
            if name in BY_NAME:
                try:
                    params.set(name, value)
                except TypeError as error:
                    raise RemoteProtocolError(f"bad server_param message: {error}") from None
        return params


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayerParam(Event):
    """The limits of heterogeneous players, by name."""

    values: Mapping[str, Value]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayerType(Event):
    """One type of player: its number and its parameters by name (``id`` among them)."""

    id: int
    values: Mapping[str, Value]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangePlayerType(Event):
    """A player has another type now; None: an opponent, whose type stays unknown. Monitors and coaches get the side."""

    unum: int
    player_type: int | None = None
    side: str | None = None


# --- every cycle ---------------------------------------------------------------------------------------------------
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class See(Event):
    """What a player sees: a SEE record, shape (1,)."""

    record: NDArray[np.void]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SenseBody(Event):
    """What a player feels: a SENSE_BODY record, shape (1,)."""

    record: NDArray[np.void]


@dataclass(frozen=True, slots=True, kw_only=True)
class Hear(Event):
    """Something said.

    Attributes
    ----------
    time : int
    source : str
        ``referee``, ``coach`` (the trainer), ``online_coach_left``, ``online_coach_right``, ``self``, ``our``, ``opp``,
        or ``player``: to trainers, and to players of version 7, who are not told which side spoke.
    text : str or None
        Without quotes; None when only the fact of speaking was heard.
    direction : float or None
        Relative to the body.
    unum : int or None
        Of a team mate; to trainers, of any player.
    team : str or None
        To trainers only: the speaker's team.
    goalie : bool
        To trainers only.
    """

    time: int
    source: str
    text: str | None = None
    direction: float | None = None
    unum: int | None = None
    team: str | None = None
    goalie: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Think(Event):
    """Synch mode: the server waits for commands and ``(done)``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BallState(Event):
    """Position and velocity of the ball."""

    x: float
    y: float
    vx: float
    vy: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FullstatePlayer(Event):
    """A player in a fullstate message; what a version does not tell is None.

    Attributes
    ----------
    arm : (float, float) or None
        Distance (m) and direction (**radians**) of where the arm points, relative to the face.
    focus_point : (float, float) or None
        Distance and direction.
    marks : tuple of str
        ``t`` tackling, ``k`` kicking, ``f`` fouled, ``r`` red card, ``y`` yellow card.
    """

    side: str
    unum: int
    goalie: bool
    player_type: int | None
    x: float
    y: float
    vx: float
    vy: float
    body: float
    neck: float
    arm: tuple[float, float] | None
    focus_point: tuple[float, float] | None
    stamina: float
    effort: float
    recovery: float
    capacity: float | None
    marks: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fullstate(Event):
    """The whole truth, for players of a side with ``fullstate_l`` or ``fullstate_r``.

    Attributes
    ----------
    counts : tuple of int
        Own kick, dash, turn, catch, move, turn_neck, change_view, say (version 18 and later: change_focus).
    arm : tuple of float
        Own arm: cycles until movable, cycles it stays up, distance, direction (degrees), count.
    score : (int, int)
        Ours, theirs.
    """

    time: int
    mode: str
    quality: str
    width: str
    counts: tuple[int, ...]
    arm: tuple[float, float, float, float, float]
    score: tuple[int, int]
    ball: BallState
    players: tuple[FullstatePlayer, ...]


# --- answers -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, slots=True, kw_only=True)
class Ok(Event):
    """A command was accepted: its name, and what else the answer says, for example ``eye`` and ``on``."""

    command: str
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class OkClang(Event):
    """Versions of the coach language."""

    minimum: int
    maximum: int


@dataclass(frozen=True, slots=True, kw_only=True)
class OkCompression(Event):
    """From now on messages are compressed; a negative level: no longer."""

    level: int


@dataclass(frozen=True, slots=True, kw_only=True)
class OkCheckBall(Event):
    """Where the ball is: ``in_field``, ``goal_l``, ``goal_r`` or ``out_of_field``."""

    time: int
    where: str


@dataclass(frozen=True, slots=True, kw_only=True)
class OkTeamNames(Event):
    """Names of the teams; None where there is none yet."""

    left: str | None
    right: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Error(Event):
    """A message was refused; the text is without ``(error`` and ``)``."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Warning(Event):
    """A message was accepted with a warning."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Score(Event):
    """Goals of the own and the other team."""

    time: int
    ours: int
    theirs: int


# --- trainer -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, slots=True, kw_only=True)
class GlobalPlayer(Event):
    """A player as a trainer sees it; marks as in `FullstatePlayer`."""

    team: str
    unum: int
    goalie: bool
    x: float
    y: float
    vx: float
    vy: float
    body: float
    neck: float
    pointing: float | None
    marks: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SeeGlobal(Event):
    """What a trainer sees: every cycle, or as the answer to look.

    Attributes
    ----------
    answer : bool
        Whether it answers look.
    goals : dict
        Position of the goals ``"l"`` and ``"r"``.
    """

    time: int
    answer: bool
    goals: Mapping[str, tuple[float, float]]
    ball: BallState
    players: tuple[GlobalPlayer, ...]


# --- monitor and game log ------------------------------------------------------------------------------------------
@dataclass(frozen=True, slots=True, kw_only=True)
class ShowPlayer(Event):
    """A player in a monitor's frame.

    Attributes
    ----------
    state : int
        State flags; 0: not connected.
    arm : (float, float) or None
        The point on the field it points to.
    quality : str
        ``h`` or ``l``.
    view_angle : float
    focus_point : (float, float) or None
        Frames of version 5.
    capacity : float or None
        Frames of version 4 and 5.
    attention : (str, int) or None
        Side and number of the player it listens to.
    counts : tuple of int
        kick, dash, turn, catch, move, turn_neck, change_view, say, tackle, pointto, attentionto (version 5:
        change_focus).
    """

    side: str
    unum: int
    player_type: int
    state: int
    x: float
    y: float
    vx: float
    vy: float
    body: float
    neck: float
    arm: tuple[float, float] | None
    quality: str
    view_angle: float
    focus_point: tuple[float, float] | None
    stamina: float
    effort: float
    recovery: float
    capacity: float | None
    attention: tuple[str, int] | None
    counts: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Team(Event):
    """Names and scores: in a monitor's frame, and as a line of a game log (then with a time).

    Attributes
    ----------
    left, right : str
        ``null`` while there is no such team.
    penalties : tuple of int
        Scored and missed by the left, scored and missed by the right team; empty before penalty kicks.
    """

    left: str
    right: str
    left_score: int
    right_score: int
    penalties: tuple[int, ...] = ()
    time: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Show(Event):
    """A monitor's frame of version 3 to 5, or that of a game log (mode and team are None there)."""

    time: int
    mode: str | None
    team: Team | None
    ball: BallState
    players: tuple[ShowPlayer, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayMode(Event):
    """A line of a game log: the play mode changed."""

    time: int
    mode: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Msg(Event):
    """What a monitor is told: board 1 is for people (referee, players, replies), board 2 for the log."""

    time: int
    board: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknown(Event):
    """A well-formed message of a kind this package does not know."""

    data: bytes
