"""What players are told of a step, written for all of them in one call of a kernel each: sense_body, hear, see."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from fake_server.game import Game
from fake_server.text import Names, Pages, write_hears, write_sees, write_senses
from rcss_hat.protocol.commands import MAX_DATAGRAM
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.records import SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import team_names
from rcss_hat.simulation.state import MAX_MESSAGES, N_PLAYERS

Told = Iterator[tuple[int, bytes]]
"""Index of a player, and a datagram for him."""


class Perception:
    """Writes what players perceive.

    Parameters
    ----------
    game : Game
    """

    def __init__(self, game: Game) -> None:
        self._game = game
        self._see, self._sense = empty(SEE), empty(SENSE_BODY)
        self._order = np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
        self._players, self._indices = (), np.zeros(0, dtype=np.int64)  # type: tuple[Sequence[int], NDArray[np.int64]]
        self._teams: tuple[str, str] | None = None
        self._names = self._named()
        self._pages = self._room(N_PLAYERS)

    def _room(self, datagrams: int) -> Pages:
        ends = np.zeros(max(datagrams, N_PLAYERS * MAX_MESSAGES), dtype=np.int64)
        return Pages(np.zeros(datagrams * MAX_DATAGRAM, dtype=np.uint8), ends, np.zeros_like(ends))

    def _named(self) -> Names:
        """Return how both teams call each other."""
        game = self._game
        tables = [team_names(game.names[own], game.name_for_opponents(1 - own)) for own in range(2)]
        width = max(names.shape[1] for names, _ in tables)
        teams = np.stack([np.pad(names, ((0, 0), (0, width - names.shape[1]))) for names, _ in tables])
        return Names(teams, np.stack([sizes for _, sizes in tables]), np.arange(N_LANDMARKS, dtype=np.uint8))

    def _of(self, players: Sequence[int]) -> NDArray[np.int64]:
        if players != self._players:
            self._players, self._indices = players, np.array(players, dtype=np.int64)
        return self._indices

    def _told(self, n: int) -> Told:
        if n == 0:
            return
        pages = self._pages
        ends = pages.ends[:n].tolist()
        written, start = pages.buffer[: ends[-1]].tobytes(), 0
        for reader, end in zip(pages.readers[:n].tolist(), ends, strict=True):
            yield reader, written[start:end]
            start = end

    def sense_body(self, players: Sequence[int]) -> Told:
        """Write sense_body messages; players are given by index, rising."""
        return self._told(write_senses(self._game.world, self._of(players), self._sense, self._pages))

    def hear(self, players: Sequence[int]) -> Told:
        """Write what players said in the cycle before."""
        return self._told(write_hears(self._game.world, self._of(players), self._order, self._pages))

    def see(self, due: NDArray[np.uint8]) -> Told:
        """Write so many see messages for each of all `N_PLAYERS` players."""
        if self._teams != self._game.teams:
            self._teams, self._names = self._game.teams, self._named()
        datagrams = int(due.sum())
        if datagrams * MAX_DATAGRAM > len(self._pages.buffer):
            self._pages = self._room(datagrams)
        return self._told(write_sees(self._game.world, due, self._names, self._see, self._pages))
