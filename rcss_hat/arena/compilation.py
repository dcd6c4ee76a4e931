"""First start: compile the loop's two halves, simulation and players, in two processes at a time.

Compilation takes most of a minute of processor time, and numba compiles one function at a time. Both processes write
to the cache of compiled kernels; afterwards the loop itself is compiled from what they left there.
"""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

from fake_server.simulation import body, clock, commands, cycle, hearing, vision
from fake_server.simulation.state import PHYSICS
from rcss_hat.hat.brains import choose, finish
from rcss_hat.keepaway import agent as players
from rcss_hat.numeric.jit import is_cached

if TYPE_CHECKING:
    from rcss_hat.arena.match import ArenaMatch

_LOOP = "rcss_hat.arena.loop"
_OTHER_HALF = (
    "from rcss_hat.arena.compilation import compile_players; from rcss_hat.arena.match import ArenaMatch; "
    "from rcss_hat.hat.policy import load_policy; from rcss_hat.keepaway.task import Task; "
    "compile_players(ArenaMatch(Task(), 0, load_policy('hold', 3, 2, 0)))"
)
_PATIENCE_S = 600.0


def compile_halves(spare: ArenaMatch) -> None:
    """Fill the cache of compiled kernels, unless it holds the loop or there is a single processor.

    Parameters
    ----------
    spare : ArenaMatch
        A match nobody needs: compiling a kernel means running it.
    """
    if is_cached(_LOOP) or (os.cpu_count() or 1) < 2:
        return
    with subprocess.Popen([sys.executable, "-c", _OTHER_HALF], stdout=subprocess.DEVNULL) as other:
        try:
            compile_simulation(spare)
            other.wait(_PATIENCE_S)  # whatever went wrong there: the loop compiles what it does not find
        finally:
            other.kill()


def compile_simulation(match: ArenaMatch) -> None:
    """Compile what the loop calls of the simulation, with the types it calls it with."""
    state, params, types, streams, seat = match.match, match.params, match.types, match.streams, match.seats[0]
    cycle.step(state, params, types, streams)
    clock.sees_before_think(state, params, match.due)
    body.sense_body(state, params, types, seat, match.sense)
    hearing.hear_teammate(state, params, seat, streams, match.heard)
    vision.see(state, params, types, seat, streams, match.landmarks, match.sees[:1])
    commands.act(state, params, types, seat, match.actions[:1], streams[PHYSICS])
    clock.sees_after_think(state, params, match.due)


def compile_players(match: ArenaMatch) -> None:
    """Compile what the loop calls of players and policies, with the types it calls it with."""
    agent, params, state, b = match.agents[:1], match.params, match.state, match.policy.brains
    players.perceive(agent, params, match.sense, match.sees[:1], True, match.heard, True)
    players.decide(agent, params, state)
    players.act(agent, params, 0, match.actions[:1])
    learner, weights, traces = b.learners[:1], b.weights[0], b.traces[0]
    choose(
        b.kind, 3, 2, b.rules, b.has_rules, b.features, b.table, weights, traces, learner, b.method, b.streams[0],
        True, 0.0, state,
    )  # fmt: skip
    finish(b.kind, b.features, b.table, weights, traces, learner, 0.0)
