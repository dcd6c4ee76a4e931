"""What the viewer shows: snapshots of a match as they come in, and the frames that are made of them for a page.

A `Snapshot` holds the bare facts of one cycle, whatever they were read from. A frame adds what they mean for Keepaway
and is a plain dictionary, ready for JSON:

========== ============================================================================================================
time       cycle
mode       play mode, ``"play_on"``
ball       ``[x, y, vx, vy]``, metres and metres per cycle
players    list of ``{"id": "l1", "side", "unum", "x", "y", "body", "neck", "stamina", "kicking"}``; angles in degrees
holder     id of the player who can kick the ball, or None
keepers    ids of the keepers, K1 (nearest to the ball) first, then by distance to K1; None outside Keepaway
takers     ids of the takers by distance to K1
state      state variables of K1 (13 in 3v2), or None
seen       True when K1 itself perceived these, False when they come from true positions
values     Q-value of every action, or None
action     what the holder last chose, or None
episode    number of the running episode, from 1; 0 when its begin was not seen
start      cycle in which it began
choices    K1's passes: ``{"action", "name", "mate", "arrow"}``; when a person plays, those that he may choose
score      goals of the left and the right team; None in Keepaway, and where they are not known
pending    action a person has asked for that no keeper has taken up yet, or None
lapsed     action a person asked for a moment ago, too late for any keeper to take it up, or None
========== ============================================================================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, TypedDict

from rcss_hat.protocol.params import Value

PITCH_LENGTH, PITCH_WIDTH = 105.0, 68.0
CYCLE_S = 0.1
"""Seconds of the game in a cycle, at whatever pace it is played."""
TEAMS = ("keepers", "takers")
SIDES = ("left", "right")
"""What teams without a name are called in Keepaway, and in other matches."""
HOLD = "Hold"


class Choice(TypedDict):
    """One pass a person can ask for: its action, its name, its target and the arrow key that points there."""

    action: int
    name: str
    mate: str
    arrow: str | None


class Frame(TypedDict):
    """See the module."""

    time: int
    mode: str
    ball: list[float]
    players: list[dict[str, Any]]
    holder: str | None
    keepers: list[str] | None
    takers: list[str] | None
    state: list[float] | None
    seen: bool
    values: list[float] | None
    action: int | None
    episode: int
    start: int
    choices: list[Choice]
    score: list[int] | None
    pending: int | None
    lapsed: int | None


@dataclass(frozen=True, slots=True)
class Player:
    """A player in one cycle.

    Attributes
    ----------
    side : {"l", "r"}
    unum : int
    x, y : float
        Metres.
    body, neck : float
        Degrees; neck relative to the body.
    stamina : float
    kicking : bool
        As monitors are told.
    """

    side: str
    unum: int
    x: float
    y: float
    body: float
    neck: float
    stamina: float
    kicking: bool

    @property
    def id(self) -> str:
        """Such as ``l1``."""
        return f"{self.side}{self.unum}"

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of a frame."""
        return {"id": self.id, **asdict(self)}

    @classmethod
    def from_dict(cls, entry: dict[str, Any]) -> Player:
        """Read the entry of a frame."""
        return cls(**{name: value for name, value in entry.items() if name != "id"})


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The facts of one cycle: who is on the field, and where.

    Attributes
    ----------
    time : int
        Cycle.
    mode : str
        Play mode.
    ball : (float, float, float, float)
        x, y in metres, vx, vy in metres per cycle.
    players : tuple of Player
        Those on the field, left side first, by number.
    score : (int, int) or None
        Goals of the left and the right team, where they are known.
    """

    time: int
    mode: str
    ball: tuple[float, float, float, float]
    players: tuple[Player, ...]
    score: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class Setup:
    """What does not change during a match.

    Attributes
    ----------
    title : str
        What is watched: ``localhost:6000``, ``arena, seed 1``.
    keepaway : bool
        False: an ordinary match on the whole pitch.
    length, width : float
        Of the Keepaway region, or of the pitch, in metres.
    reach : float
        Distance within which a player can kick the ball, metres.
    step_s : float
        Seconds that people wait from one cycle to the next; the game's own cycles last `CYCLE_S` whatever the pace.
    teams : (str, str)
        Names of the left and the right team.
    """

    title: str
    keepaway: bool = True
    length: float = 20.0
    width: float = 20.0
    reach: float = 1.085
    step_s: float = CYCLE_S
    teams: tuple[str, str] = TEAMS

    @classmethod
    def from_params(cls, title: str, params: Mapping[str, Value], teams: tuple[str, str] = TEAMS) -> Setup:
        """Make the setup of a match with these server parameters."""
        keepaway = bool(params["keepaway"])
        return cls(
            title,
            keepaway,
            float(params["keepaway_length"]) if keepaway else PITCH_LENGTH,
            float(params["keepaway_width"]) if keepaway else PITCH_WIDTH,
            float(params["player_size"]) + float(params["ball_size"]) + float(params["kickable_margin"]),
            float(params["simulator_step"]) / 1000.0,
            teams,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return it ready for JSON."""
        return asdict(self)
