"""From the protocol's events, as monitors receive them and game logs hold them, to snapshots and setups."""

from __future__ import annotations

import math
import re

from rcss_hat.protocol import messages
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.frames import SIDES, TEAMS, Player, Setup, Snapshot

_KICKING = 0x2
_NOBODY = "null"
_GREATEST = 1e7
"""Of metres, degrees or stamina in a frame, far beyond what a server can tell."""
# The entry of a player who is not on the field: of state 0. A frame always has 22 entries, in Keepaway mostly these;
# without them it is read four times faster.
_ABSENT = re.compile(rb" \(\([lr] \d+\) \d+ 0 [^()]*(?:\([^()]*\) ?)*\)")


def read(data: bytes) -> messages.Event:
    """Read a datagram for monitors, or a line of a game log; frames without the players who are not there.

    Raises
    ------
    RemoteProtocolError
        When it is malformed.
    """
    return checked(messages.parse(_ABSENT.sub(b"", data) if data.startswith(b"(show ") else data))


def checked(event: messages.Event) -> messages.Event:
    """Return an event whose numbers can be drawn and reckoned with.

    Raises
    ------
    RemoteProtocolError
        When a frame holds nan, or numbers beyond all bounds.
    """
    if isinstance(event, messages.Show):
        ball = event.ball
        numbers = [event.time, ball.x, ball.y, ball.vx, ball.vy]
        for p in event.players:
            numbers += (p.x, p.y, p.body, p.neck, p.stamina)
        if not all(abs(number) <= _GREATEST for number in numbers[1:]) or not 0 <= event.time < 2**31:
            raise RemoteProtocolError("bad show message: a number is not one of a match")
    return event


def snapshot_of(show: messages.Show, mode: str, team: messages.Team | None = None) -> Snapshot:
    """Make the snapshot of a frame; ``mode`` and ``team`` are what was told last where the frame does not tell it."""
    ball = show.ball
    players = tuple(
        Player(p.side, p.unum, p.x, p.y, p.body, p.neck, p.stamina, bool(p.state & _KICKING))
        for p in show.players
        if p.state
    )
    team = show.team or team
    score = None if team is None else (team.left_score, team.right_score)
    return Snapshot(show.time, show.mode or mode, (ball.x, ball.y, ball.vx, ball.vy), players, score)


def team_names(team: messages.Team | None, keepaway: bool = True) -> tuple[str, str]:
    """Names of both teams; the usual ones for those that are not there."""
    usual = TEAMS if keepaway else SIDES
    if team is None:
        return usual
    left, right = (
        default if name == _NOBODY else name for name, default in zip((team.left, team.right), usual, strict=True)
    )
    return left, right


def setup_of(params: messages.ServerParam | None, title: str, team: messages.Team | None = None) -> Setup:
    """Make the setup from what the server told of itself; what it did not tell is as in 19.0.0.

    Raises
    ------
    WatchError
        When the server told what no server can have.
    """
    if params is None:
        return Setup(title, teams=team_names(team))
    try:
        values = params.to_params()
        setup = Setup.from_params(title, values, team_names(team, bool(values["keepaway"])))
    except RemoteProtocolError as error:
        raise WatchError(f"{title}: {error}") from error
    for name, value, high in (
        ("length", setup.length, 1000.0),
        ("width", setup.width, 1000.0),
        ("reach", setup.reach, 100.0),
        ("step", setup.step_s, 3600.0),
    ):
        if not (1e-3 <= value <= high and math.isfinite(value)):
            raise WatchError(f"{title}: bad server_param message: the {name} of the match cannot be {value:g}")
    return setup
