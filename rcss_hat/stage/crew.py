"""The players of ours in a match, whoever runs them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Protocol

from rcss_hat.keepaway.decision import KeeperPolicy, hold_cycles_of, onlooker_of
from rcss_hat.keepaway.endings import Endings, Span
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.aside import aside
from rcss_hat.stage.client import PlayerClient
from rcss_hat.stage.joining import take_place
from rcss_hat.stage.survey import KEEPERS, TAKERS
from rcss_hat.stage.tally import Heard

Seat = tuple[int, int]
"""Side (0 left, 1 right) and uniform number."""
OnHeard = Callable[[Heard], None]


def never(cycle: int, status: int, reward: float, state: object) -> int:
    """Policy of those who are never asked."""
    raise AssertionError("nobody asks")


class Crew(Protocol):
    """Players who can be led through a match.

    Attributes
    ----------
    seats : list of (int, int)
        Side and number of each, in the order in which they join: keepers first, for a server gives the left side to
        the team that comes first.
    first : Heard
        What the first of them has heard.
    """

    seats: list[Seat]

    @property
    def first(self) -> Heard:
        """What the first player has heard."""

    @property
    def missed(self) -> int:
        """Cycles in which some player could not answer in time."""

    def unheard(self) -> list[Span]:
        """Between which cycles an episode ended that nobody was told of."""

    async def prepare(self) -> None:
        """Compile, before a server waits for an answer."""

    async def take(self, k: int, known: bool) -> None:
        """Let player ``k`` take its seat; ``known``: the number was given before."""

    def start(self, on_heard: OnHeard) -> list[asyncio.Task[None]]:
        """Let everybody play; the tasks end with what ended a player. The function is told what the first hears."""

    async def leave(self) -> None:
        """Say goodbye, so that the bodies can be taken up again."""


class LocalCrew:
    """Players in this process.

    Parameters
    ----------
    task : Task
    host, port : str, int
    seed : int
        Of the players' own randomness.
    keepers : callable or None
        Policy of the keepers; None: they are not ours.
    takers : bool
        Whether the takers are ours.
    orders : callable, optional
        Policy of our takers; None: they are hand-coded.
    """

    def __init__(
        self,
        task: Task,
        host: str,
        port: int,
        seed: int,
        keepers: KeeperPolicy | None,
        takers: bool = True,
        orders: KeeperPolicy | None = None,
    ) -> None:
        self.players: list[KeepawayPlayer] = []
        self.endings = Endings()
        self.seats: list[Seat] = []
        if keepers is not None:
            hold_cycles = hold_cycles_of(keepers)
            for number in range(task.keepers):
                decide, ended = keepers(number)
                self.players.append(
                    KeepawayPlayer(KEEPERS, task.keepers, task.takers, seed, decide, ended, hold_cycles, self.endings)
                )
            for player in self.players:
                player.onlooker = onlooker_of(keepers)
            self.seats += [(0, number + 1) for number in range(task.keepers)]
        if takers:
            lasts = 1 if orders is None else hold_cycles_of(orders)
            for number in range(task.takers):
                order, told = (None, None) if orders is None else orders(number)
                self.players.append(
                    KeepawayPlayer(TAKERS, task.keepers, task.takers, seed, order, told, lasts, self.endings)
                )
            self.seats += [(1, number + 1) for number in range(task.takers)]
        self.clients = [PlayerClient(player, host, port) for player in self.players]
        self._where = (host, port)

    @property
    def first(self) -> KeepawayPlayer:
        """The first player."""
        return self.players[0]

    @property
    def missed(self) -> int:
        """Cycles in which some player could not answer in time."""
        return sum(player.missed for player in self.players)

    def unheard(self) -> list[Span]:
        """Between which cycles an episode ended that nobody was told of."""
        return self.endings.unheard()

    async def prepare(self) -> None:
        """Compile."""
        await aside(self.first.prepare)

    async def take(self, k: int, known: bool) -> None:
        """Let player ``k`` take its seat."""
        await take_place(self.clients[k], *self._where, self.seats[k], known)

    def start(self, on_heard: OnHeard) -> list[asyncio.Task[None]]:
        """Let everybody play."""
        self.clients[0].on_message = on_heard
        return [asyncio.create_task(client.run(), name=client.player.name) for client in self.clients]

    async def leave(self) -> None:
        """Say goodbye."""
        for client in self.clients:
            await client.close()
