"""``server::auto_mode``: kick off and end without a person (19.0.0, src/stadium.cpp, checkAutoMode)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fake_server.simulation.state import BEFORE_KICK_OFF, N_PLAYERS, TIME_OVER

if TYPE_CHECKING:
    from fake_server.server import Server


class AutoMode:
    """The waits of an automatic match, counted in steps.

    Parameters
    ----------
    server : Server
    """

    def __init__(self, server: Server) -> None:
        self._server = server
        self._on = bool(server.game.params["auto_mode"])
        self._connect = self._kick_off = self._game_over = 0
        self._wind_up()

    def _wind_up(self) -> None:
        number = self._server.game.params.number
        self._connect = max(0, int(number("connect_wait")))
        self._kick_off = max(0, int(number("kick_off_wait")))

    def step(self) -> None:
        """Count a step; kick off or stop the server when it is time."""
        if not self._on:
            return
        game = self._server.game
        if game.mode == BEFORE_KICK_OFF:
            if len(game.players()) == N_PLAYERS or game.time > 0:
                self._kick_off -= 1
            else:
                self._connect -= 1
            if self._kick_off <= 0 or self._connect <= 0:
                self._server.kick_off()
        else:
            self._wind_up()
        if game.mode != TIME_OVER:
            self._game_over = max(0, int(game.params.number("game_over_wait")))
        else:
            self._game_over -= 1
            if self._game_over <= 0:
                self._server.stop("Game Over. Exiting...")
