"""From the protocol's events, as monitors receive them and game logs hold them, to snapshots and setups."""

from __future__ import annotations

import re

from rcss_hat.protocol import messages
from rcss_hat.viewer.frames import TEAMS, Player, Setup, Snapshot

_KICKING = 0x2
_NOBODY = "null"
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
    return messages.parse(_ABSENT.sub(b"", data) if data.startswith(b"(show ") else data)


def snapshot_of(show: messages.Show, mode: str) -> Snapshot:
    """Make the snapshot of a frame; ``mode`` is the play mode where the frame does not tell it."""
    ball = show.ball
    players = tuple(
        Player(p.side, p.unum, p.x, p.y, p.body, p.neck, p.stamina, bool(p.state & _KICKING))
        for p in show.players
        if p.state
    )
    return Snapshot(show.time, show.mode or mode, (ball.x, ball.y, ball.vx, ball.vy), players)


def team_names(team: messages.Team | None) -> tuple[str, str]:
    """Names of both teams; the usual ones for those that are not there."""
    if team is None:
        return TEAMS
    left, right = (
        usual if name == _NOBODY else name for name, usual in zip((team.left, team.right), TEAMS, strict=True)
    )
    return left, right


def setup_of(params: messages.ServerParam | None, title: str, teams: tuple[str, str] = TEAMS) -> Setup:
    """Make the setup from what the server told of itself; what it did not tell is as in 19.0.0."""
    return Setup(title, teams=teams) if params is None else Setup.from_params(title, params.to_params(), teams)
