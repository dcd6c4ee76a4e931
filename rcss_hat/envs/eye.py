"""A monitor beside the players: where everybody is on a server, as its referee knows it."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import DispBye, DispInit, datagram
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.stage.connection import Connection, ServerGone
from rcss_hat.stage.monitor import MONITOR_VERSION
from rcss_hat.stage.place import Address
from rcss_hat.viewer.shows import read

PATIENCE = 1.0
"""Seconds that a frame may be on its way, while the server waits for our players."""
ATTEMPTS, PAUSE = 2400, 0.05
"""How often a server is asked that is only being started, and after how many seconds each."""
_SHOW = b"(show "


class Eye:
    """Sees a match on a server, cycle by cycle.

    A server in synch mode waits 20 ms for its monitors in every 32nd cycle.
    """

    def __init__(self) -> None:
        self._connection: Connection | None = None
        self._newest = b""
        self._shown: messages.Show | None = None

    async def open(self, address: Address) -> None:
        """Connect, before the match begins.

        Raises
        ------
        ServerGone
            When there is no server, or it does not serve monitors of this version, as those of the time of 11.1.
        """
        connection = Connection(*address, "monitor")
        reply = await connection.open(datagram(DispInit(MONITOR_VERSION)), attempts=ATTEMPTS, pause=PAUSE)
        if reply.startswith(b"(error"):
            connection.close()
            raise ServerGone(f"monitor: the server at {address[0]}:{address[1]} refuses a monitor")
        self._connection = connection

    def look(self, patience: float = 0.0) -> None:
        """Take what has been shown meanwhile; wait for something so many seconds at most."""
        if self._connection is None:
            return
        for data in self._connection.arrived(patience):
            if data.startswith(_SHOW):
                self._newest = data

    def at(self, cycle: int) -> messages.Show:
        """Return the newest frame, which is that of a cycle in which the server waits for our players.

        Raises
        ------
        ServerGone
            When it is not shown in time, or cannot be read.
        """
        self.look()
        give_up = time.monotonic() + PATIENCE
        while _time(self._newest) < cycle:
            left = give_up - time.monotonic()
            if self._connection is None or left <= 0.0:
                raise ServerGone(f"monitor: the server does not show cycle {cycle}")
            self.look(left)
        if self._shown is None or self._shown.time != _time(self._newest):
            try:
                event = read(self._newest)
            except RemoteProtocolError as error:
                raise ServerGone(f"monitor: {error}") from error
            assert isinstance(event, messages.Show), "it begins as a frame does"
            self._shown = event
        return self._shown

    def close(self) -> None:
        """Leave."""
        if self._connection is not None:
            self._connection.send_now(datagram(DispBye()))
            self._connection.close()
            self._connection = None


def _time(frame: bytes) -> int:
    """Return the cycle that a frame shows; -1: none."""
    word = frame[len(_SHOW) : len(_SHOW) + 10].split(b" ", 1)[0]
    return int(word) if word.isdigit() else -1


def truth_of(show: messages.Show, task: Task) -> dict[str, NDArray[np.float64]]:
    """Return where a frame shows everybody; see `rcss_hat.envs.stepping.Steps.truth`.

    Who is not on the field is nowhere (nan).
    """
    sizes = {"l": task.keepers, "r": task.takers}
    teams = {side: np.full((n, 4), np.nan) for side, n in sizes.items()}
    for p in show.players:
        if p.state and p.unum <= sizes[p.side]:
            teams[p.side][p.unum - 1] = p.x, p.y, p.vx, p.vy
    ball = np.array([show.ball.x, show.ball.y, show.ball.vx, show.ball.vy])
    return {"ball": ball, "keepers": teams["l"], "takers": teams["r"]}
