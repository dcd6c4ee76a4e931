"""What the referees here do not judge, said to whoever runs or watches a match that might need it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fake_server.server import Server

NOT_JUDGED = "not judged here: offside, fouls, back passes, free kick faults, illegal defence"
NO_SHOOT_OUT = "drawn: the penalty shoot-out is not simulated here, the match ends"


class Limits:
    """Warnings of a match, each given once.

    Parameters
    ----------
    server : Server
    """

    def __init__(self, server: Server) -> None:
        self._server = server
        self._due = {NOT_JUDGED, NO_SHOOT_OUT} if server.game.touch is not None else set()

    def look(self, announced: list[str]) -> None:
        """Warn of what a match that has just begun, or ended, misses."""
        game = self._server.game
        if not self._due:
            return
        if not game.waits_for_kick_off:
            self._warn(NOT_JUDGED)
        left, right = game.score
        if game.params["penalty_shoot_outs"] and left == right and "time_up" in announced:
            self._warn(NO_SHOOT_OUT)

    def _warn(self, text: str) -> None:
        """Tell standard error, and monitors as far as they hear the referee."""
        if text not in self._due:
            return
        self._due.remove(text)
        print(f"{self._server.game.time}: {text}", file=sys.stderr, flush=True)
        self._server.tell_monitors(f"({text})")
