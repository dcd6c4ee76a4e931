"""Who begins before everybody is there."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from rcss_hat.keepaway.task import Task
from rcss_hat.stage.gathering import Gathering
from rcss_hat.stage.survey import Look, WrongServer
from rcss_hat.stage.terms import Terms


class Shown:
    """A monitor that is shown some keepers and takers, one look after the other."""

    def __init__(self, *looks: tuple[str, int, int]) -> None:
        self.looks = iter(looks)

    async def look(self, good: Callable[[Look], bool], patience: float) -> Look:
        for cycle, (mode, *counts) in enumerate(self.looks):
            left, right = (frozenset(range(1, n + 1)) for n in counts)
            look = Look(cycle, mode, ("keepers", "takers"), (left, right), (left, right))
            if good(look):
                return look
        raise TimeoutError


class Seats:
    seats = ((0, 1), (1, 1))


def gathered(*looks: tuple[str, int, int]) -> Look:
    gathering = Gathering(Seats(), Task(), "localhost", 6000, Terms())  # type: ignore[arg-type]
    gathering.monitor = Shown(*looks)  # type: ignore[assignment]
    return asyncio.run(gathering.everybody(1.0))


def test_a_server_may_begin_by_itself_when_all_keepers_are_there() -> None:
    assert (
        gathered(("before_kick_off", 2, 0), ("before_kick_off", 3, 0), ("play_on", 3, 1), ("play_on", 3, 2)).cycle == 3
    )
    assert gathered(("before_kick_off", 3, 2)).cycle == 0


@pytest.mark.parametrize("before", [0, 1, 2])
def test_a_server_that_did_not_wait_for_all_keepers_is_refused(before: int) -> None:
    """It places as many as it counted then, which makes other games of all that follow."""
    with pytest.raises(WrongServer, match=f"began by itself with {before} of 3 keepers.*keepaway_start"):
        gathered(("before_kick_off", before, 0), ("play_on", 3, 0), ("play_on", 3, 2))
