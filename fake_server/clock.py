"""The two ways in which a server's time goes on: in synch mode and in real time.

In synch mode a cycle is: simulation step, sense_body and what was said, the see messages due before the think,
``(think)`` to everybody, a wait until all have said ``(done)``, and the see messages due before the next step. In real
time a loop of 10 ms reads commands and does what is due; time that a late loop has lost is dropped, not caught up.
Source: 19.0.0, src/stadium.cpp (doSendThink), src/synctimer.cpp and src/stdtimer.cpp.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

import numpy as np

from fake_server.options import PATIENCE
from fake_server.player_client import PlayerClient
from fake_server.server import Server
from fake_server.trainer import TrainerClient
from rcss_hat.simulation import clock
from rcss_hat.simulation.state import N_PLAYERS

_MONITOR_CYCLES = 32


@dataclass(frozen=True)
class Timing:
    """How long a server in synch mode waits; the defaults are the original's.

    Attributes
    ----------
    patience : float
        Seconds to wait for ``(done)``.
    most_misses : int
        After more cycles than this in a row in which somebody missed it, the server gives up.
    pause : float
        Seconds between cycles before the match, while clients connect.
    monitor_pause : float
        Seconds for monitors to catch up, in every 32nd cycle of a match that somebody watches.
    """

    patience: float = PATIENCE
    most_misses: int = 20
    pause: float = 0.05
    monitor_pause: float = 0.02


class SynchClock:
    """Synch mode.

    Parameters
    ----------
    server : Server
    timing : Timing
    """

    def __init__(self, server: Server, timing: Timing) -> None:
        self._server, self._timing = server, timing
        self._due = np.zeros(N_PLAYERS, dtype=np.uint8)
        self._misses = 0
        self._watched_cycles = 0

    def run(self) -> None:
        """Go on until the server is stopped."""
        while self._server.running:
            self.cycle()

    def cycle(self) -> None:
        """Simulate a step, tell everybody, and wait for their answers."""
        server = self._server
        match, params = server.game.match, server.game.kernel
        server.clients.hold()
        server.step()
        clock.sees_before_think(match, params, self._due)
        server.audience.send_sees(self._due)
        server.kicked_off = False
        if server.running:
            self._think()
        if server.kicked_off:
            match["clock"] = 0  # the first cycle of a match is the first of the clock's period
        else:
            clock.sees_after_think(match, params, self._due)
            server.audience.send_sees(self._due)

    def _pause(self) -> None:
        server, timing = self._server, self._timing
        if server.game.time <= 0:
            server.clients.release()
            give_up = time.monotonic() + timing.pause
            while server.running and not server.about_to_start and (left := give_up - time.monotonic()) > 0.0:
                server.read_others(left)
        elif server.clients.monitors:
            self._watched_cycles += 1
            if self._watched_cycles % _MONITOR_CYCLES == 0:
                time.sleep(timing.monitor_pause)

    def _think(self) -> None:
        """Let everybody think, wait, and carry out what they command."""
        server = self._server
        self._pause()
        if not server.about_to_start:  # who hears play_on before a think would act in cycle 0, others would not
            self._wait_for(server.clients.start_thinking())
            server.carry_out()
        server.kick_off_if_wanted()

    def _wait_for(self, thinkers: list[PlayerClient | TrainerClient]) -> None:
        server = self._server
        server.clients.release()
        give_up = time.monotonic() + self._timing.patience
        left = self._timing.patience if thinkers else 0.0
        while server.running:
            server.read_all(max(left, 0.0))
            thinkers = [client for client in thinkers if client.waited_for]
            if not thinkers:
                self._misses = 0
                return
            if left <= 0.0:  # not before a last look: it may have been the server that was kept from working
                self._missed()
                return
            left = give_up - time.monotonic()

    def _missed(self) -> None:
        """Somebody has not answered; at cycle 0 that does not matter."""
        server = self._server
        if server.game.time <= 0:
            return
        print(f"Someone missed a cycle at {server.game.time}", file=sys.stderr, flush=True)
        self._misses += 1
        if self._misses > self._timing.most_misses:
            print("Waiting too long for clients! Exiting", file=sys.stderr, flush=True)
            server.exit_code = 1
            server.stop()


class RealTimeClock:
    """Real time.

    Parameters
    ----------
    server : Server
    """

    def __init__(self, server: Server) -> None:
        self._server = server
        factor = max(1, int(server.game.params.number("slow_down_factor")))
        self._tick = clock.TICK_MS / 1000.0 * factor
        self._due = np.zeros(N_PLAYERS, dtype=np.uint8)

    def run(self) -> None:
        """Go on until the server is stopped."""
        server = self._server
        match, params = server.game.match, server.game.kernel
        next_tick = time.monotonic()
        while server.running:
            next_tick += self._tick
            while server.running and (left := next_tick - time.monotonic()) > 0.0:
                server.read_others(left)
            next_tick = max(next_tick, time.monotonic() - self._tick)
            server.read_all(0.0)
            server.carry_out()
            if clock.tick(match, params, self._due) & clock.STEP_DUE:
                server.clients.hold()
                server.step()
            server.audience.send_sees(self._due)
            server.clients.release()
