"""What a match is played under beside the task, and the voice that says what is being waited for."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Mapping, Set
from dataclasses import dataclass, field
from pathlib import Path

from rcss_hat.keepaway.conditions import SETTINGS
from rcss_hat.keepaway.decision import KeeperPolicy
from rcss_hat.protocol.params import Value

REMINDER = 5.0
"""Seconds after which it is said again what is being waited for."""


def silent(message: str) -> None:
    """Say nothing."""


@dataclass(frozen=True, slots=True)
class Terms:
    """What a match is played under, beside the task.

    Attributes
    ----------
    typed : set of str
        Which of a task's settings somebody asked for (see `rcss_hat.keepaway.conditions.SETTINGS`); a server that
        plays others is refused. The rest is what the server plays.
    say : callable
        Told, now and then, what is being waited for.
    ends_match : bool
        Whether the match ends for everybody when our episodes are played.
    trainer : int or None
        A trainer of ours referees instead of the server; it connects to this port of a running server (0: the one
        behind the players' port). Not in the arena.
    processes : bool
        Every player in a process of its own. Not in the arena.
    pace : mapping of str to Value
        Parameters of a server that is started for the match, beside the task's.
    logs : Path, optional
        Folder for what such a server writes: ``console.log``, ``keepaway.kwy``. By default it is thrown away.
    takers, kick_off : bool
        Whether the takers are ours, and whether we start the match.
    orders : callable, optional
        Policy of our takers, which decide on macro-actions then (`rcss_hat.keepaway.taker`). In the
        arena a `rcss_hat.hat.taker_policy.TakerPolicy`.
    """

    typed: Set[str] = SETTINGS
    say: Callable[[str], None] = silent
    ends_match: bool = False
    trainer: int | None = None
    processes: bool = False
    pace: Mapping[str, Value] = field(default_factory=dict)
    logs: Path | None = None
    takers: bool = True
    kick_off: bool = True
    orders: KeeperPolicy | None = None


@contextlib.asynccontextmanager
async def reminding(say: Callable[[str], None], text: Callable[[], str]) -> AsyncIterator[None]:
    """Say every few seconds what is being waited for."""

    async def remind() -> None:
        while True:
            await asyncio.sleep(REMINDER)
            say(text())

    reminder = asyncio.create_task(remind())
    try:
        yield
    finally:
        reminder.cancel()
        await asyncio.gather(reminder, return_exceptions=True)
