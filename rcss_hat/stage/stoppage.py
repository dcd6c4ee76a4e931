"""What ends a match before its time, in words."""

from __future__ import annotations

from rcss_hat.keepaway.session import SHARED_CORNER
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.survey import WrongServer
from rcss_hat.stage.tally import Heard

_ENDLESS = "; a match without end needs server::half_time=-1"
_OVER = "time_"
"""How the referee begins to say that the match is over."""
_REMEDIES = {
    "half_time": _ENDLESS,
    _OVER: _ENDLESS,
    "before_kick_off": _ENDLESS,
    "offside": "; Keepaway needs server::use_offside=0",
    SHARED_CORNER: "; the server began with fewer keepers and places as many for ever: restart it",
}
"""What prevents that the referee stops play, by the begin of his words."""


class MatchOver(ServerGone):
    """Somebody else has ended the match, or the team that is not ours has left."""


def check_keepaway(player: Heard) -> None:
    """Raise WrongServer when the match that has begun is not Keepaway."""
    if player.mode.startswith("kick_off_"):
        raise WrongServer(
            "the server has kicked off soccer, not Keepaway; start it with server::keepaway=1 (one older than 14 with "
            "server::keepaway_start=SECONDS too), or with server::coach=1 for --referee trainer"
        )


def stopped(player: Heard, where: str) -> Exception:
    """Return what is to be raised when the referee has stopped play, as a player has heard."""
    why = next((remedy for word, remedy in _REMEDIES.items() if player.stopped_by.startswith(word)), "")
    kind = MatchOver if player.stopped_by.startswith(_OVER) else WrongServer
    return kind(f"play at {where} was stopped: {player.stopped_by}{why}")
