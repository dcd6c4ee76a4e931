"""How our players come onto a server: see who is there and what is played, take the seats, wait for everybody."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from rcss_hat.keepaway.conditions import Mismatch, Told, agreed, pace_text, physics_text
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.crew import Crew
from rcss_hat.stage.monitor import Monitor
from rcss_hat.stage.survey import PLAY_ON, Look, WrongServer, is_untouched, refuse_unfit, seat_is_known
from rcss_hat.stage.terms import Terms, reminding

FOR_KEEPERS = 600.0
"""Seconds that takers wait for keepers."""


class Gathering:
    """Brings a crew onto a server.

    Parameters
    ----------
    crew : Crew
    task : Task
    host, port : str, int
    terms : Terms

    Attributes
    ----------
    task : Task
        Once told: what the server plays.
    told : mapping of str to Value
        The server's parameters; empty before they are known.
    untouched : bool
        Nothing was kicked off on this server before.
    on_agreed : callable or None
        Told what is played as soon as that is known: the task, whose physics, how fast.
    refereed : bool
        By a trainer, instead of the server.
    led : bool
        Somebody else starts the match; where the server takes trainers, he may be one.
    """

    def __init__(self, crew: Crew, task: Task, host: str, port: int, terms: Terms) -> None:
        self.crew, self.task, self.terms = crew, task, terms
        self.told: Told = {}
        self.untouched = True
        self._waiting = 0  # keepers before the kick-off
        self.refereed = self.led = False
        self.on_agreed: Callable[[Task, str, str], None] | None = None
        sides = {side for side, _ in crew.seats}
        self.ours = (0 in sides, 1 in sides)
        self.where = f"{host}:{port}"
        self.monitor = Monitor(host, port)

    def agree(self, told: Told) -> None:
        """Compare what the server tells with what was asked for, once.

        Raises
        ------
        WrongServer
            When it plays something else.
        """
        if not told or self.told:
            return
        self.refereed |= self.led and bool(told.get("coach")) and not told.get("keepaway", 1)
        try:
            self.task = agreed(self.task, told, self.terms.typed, self.refereed)
        except Mismatch as error:
            raise WrongServer(f"{self.where}: {error}") from None
        self.told = told
        if self.on_agreed is not None:
            self.on_agreed(self.task, physics_text(told), pace_text(told))

    async def join(self) -> None:
        """Look who is there, then take all seats in order.

        Raises
        ------
        WrongServer
            When our players cannot play there; says what would be right.
        ServerGone, RemoteProtocolError
            When no server answers, or it refuses somebody.
        """
        async with self._saying(lambda: f"waiting for a server at {self.where} ..."):
            await self.monitor.connect()
            look = await self.monitor.look()
        self.agree(self.monitor.told)
        if not self.ours[0]:
            look = await self._wait_for_keepers(look)
        refuse_unfit(look, self.task, self.ours, self.where)
        self.untouched, self._waiting = is_untouched(look), look.counts[0]
        for k, (side, number) in enumerate(self.crew.seats):
            await self.crew.take(k, seat_is_known(look, side, number))
        self.agree(self.crew.first.told)

    def _saying(self, text: Callable[[], str]) -> AbstractAsyncContextManager[None]:
        return reminding(self.terms.say, text)

    async def _wait_for_keepers(self, look: Look) -> Look:
        """Takers join when a monitor shows all keepers, for the first team to connect gets the left side."""
        wanted = f"{self.task.keepers} keepers"

        def arrived(look: Look) -> bool:
            refuse_unfit(look, self.task, self.ours, self.where)
            return look.counts[0] >= self.task.keepers

        return look if arrived(look) else await self._wait(wanted, arrived, FOR_KEEPERS)

    async def everybody(self, patience: float) -> Look:
        """Wait until everybody is there.

        Raises
        ------
        WrongServer
            When there are more than that, or the server did not wait for the keepers.
        ServerGone
            When they did not come within so many seconds, or the server went.
        """
        wanted = f"{self.task.keepers} keepers and {self.task.takers} takers"

        def complete(look: Look) -> bool:
            left, right = look.counts
            if left > self.task.keepers or right > self.task.takers:
                raise WrongServer(
                    f"{left} keepers and {right} takers are at {self.where}, too many for {self.task.size}: somebody "
                    "else has joined; wait, or use another server"
                )
            if self.untouched:
                self._check_kick_off(look)
            return look.counts == (self.task.keepers, self.task.takers)

        return await self._wait(wanted, complete, patience)

    def _check_kick_off(self, look: Look) -> None:
        """Refuse a server that began by itself (``keepaway_start``), and counted the keepers, before all were there."""
        if look.mode != PLAY_ON:  # or stopped by our whistle, to take up numbers again
            self._waiting = look.counts[0]
        elif self._waiting < self.task.keepers:
            raise WrongServer(
                f"the server at {self.where} began by itself with {self._waiting} of {self.task.keepers} keepers, and "
                "places as many for ever: restart it with a later server::keepaway_start"
            )

    async def _wait(self, wanted: str, arrived: Callable[[Look], bool], patience: float) -> Look:
        counts = (0, 0)

        def good(look: Look) -> bool:
            nonlocal counts
            counts = look.counts
            return arrived(look)

        async with self._saying(lambda: f"waiting for {wanted} at {self.where}; {counts[0]} and {counts[1]} are there"):
            try:
                return await self.monitor.look(good, patience)
            except TimeoutError:
                raise ServerGone(f"waited {patience:.0f} s for {wanted}; {counts[0]} and {counts[1]} came") from None
