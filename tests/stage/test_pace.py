"""How fast servers play, and when players decide at these paces."""

from __future__ import annotations

import asyncio
import threading

import pytest

from fake_server.options import parse_options
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.simulation.clock import TICK_MS
from rcss_hat.stage import options
from rcss_hat.stage.client import PlayerClient
from rcss_hat.stage.connection import ServerGone
from rcss_hat.stage.crew import never
from rcss_hat.stage.match import Match
from rcss_hat.stage.monitor import Monitor
from rcss_hat.stage.options import pace_options, server_options

TASK = Task()
SENSE = b"(sense_body %d (view_mode high normal) (stamina 8000 1) (speed 0 0))"


@pytest.mark.parametrize("speed", [0.1, 0.5, 1.0, 1.67, 2.0, 2.5, 3.33, 5.0])
def test_a_paced_server_has_cycles_of_so_many_ticks(speed: float) -> None:
    changes = pace_options(speed)
    params = parse_options(server_options(TASK, real=False, synch_mode=False, **changes)).params
    step = params.number("simulator_step")
    assert step == pytest.approx(100.0 / speed, rel=0.01)
    assert step % TICK_MS == 0 and options.TICK_MS == TICK_MS
    assert params["sense_body_step"] == step and params.number("send_step") == 1.5 * step
    assert 0 < params.number("recv_step") <= TICK_MS
    assert bool(changes) == (speed != 1.0)


@pytest.mark.parametrize(
    ("speed", "nearest"),
    [(3.0, "2.5 or 3.33"), (4.0, "3.33 or 5"), (6.0, "5"), (10.0, "5"), (20.0, "5"), (1.05, "1 or 1.11")],
)
def test_other_paces_are_errors_that_name_the_nearest(speed: float, nearest: str) -> None:
    with pytest.raises(ValueError, match=f"cannot play {speed:g} times as fast: .*multiples of 10 ms.*; try {nearest}"):
        pace_options(speed)


def player_in(step: int, cycle: int) -> KeepawayPlayer:
    """A player in a cycle of so many milliseconds in which he has seen nothing yet."""
    player = KeepawayPlayer("keepers", 3, 2, 1, never)
    player.receive(b"(server_param (simulator_step %d)(synch_mode 0))" % step)
    assert player.wait() is None
    player.receive(b"(hear 1 referee play_on)")
    player.receive(SENSE % cycle)
    return player


@pytest.mark.parametrize(("step", "wait"), [(200, 0.150), (100, 0.075), (50, 0.0375), (20, 0.012), (10, 0.005)])
def test_players_wait_for_a_see_as_long_as_their_commands_still_come_in_time(step: int, wait: float) -> None:
    player = player_in(step, 5)
    assert player.wait() == pytest.approx(wait)
    player.receive(b"(see 4 ((b) 10 0))")
    assert player.wait() == pytest.approx(wait)
    player.receive(b"(see 5 ((b) 10 0))")
    assert player.wait() == 0.0


async def test_only_the_next_cycle_puts_a_decision_off() -> None:
    player = player_in(100, 5)
    client = PlayerClient(player, "127.0.0.1", 6000)
    client._schedule()
    waiting = client._timer
    player.receive(b'(hear 5 90 our 2 "x")')
    client._schedule()
    assert waiting is not None and client._timer is waiting
    player.receive(SENSE % 6)
    client._schedule()
    assert waiting.cancelled() and client._timer is not None and client._timer is not waiting
    assert player.missed == 1
    client._timer.cancel()


async def test_compiling_does_not_stop_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Players compile until the loop lets them go on, then they look for a server, which there is none."""
    allowed, compiled = threading.Event(), []
    monkeypatch.setattr(KeepawayPlayer, "prepare", lambda player: compiled.append(allowed.wait(60.0)))

    async def nobody(monitor: Monitor) -> None:
        assert compiled == [True]
        raise ServerGone("nobody answers")

    monkeypatch.setattr(Monitor, "connect", nobody)
    match = Match(TASK, ("127.0.0.1", 6000), 1, load_policy("hold", 3, 2, 1))
    asyncio.get_running_loop().call_later(0.01, allowed.set)
    with pytest.raises(ServerGone, match="nobody answers"):
        await match.connect()
