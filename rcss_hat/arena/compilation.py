"""First start: compile the loop's two halves, players and the rest, in two processes at a time.

Compilation takes some twenty seconds of processor time, and numba compiles one function at a time. Both processes write
to the cache of compiled kernels; afterwards the loop itself is compiled from what they left there.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.records import Team
from rcss_hat.hat.brains import choose, finish
from rcss_hat.keepaway import agent as players
from rcss_hat.keepaway.taker_state import taker_state_variables
from rcss_hat.numeric.cache_folders import is_cached
from rcss_hat.numeric.compiling import listen_to
from rcss_hat.numeric.jit import compile_part
from rcss_hat.simulation import body, clock, commands, cycle, hearing, vision

if TYPE_CHECKING:
    from rcss_hat.arena.match import ArenaMatch

_LOOP = "rcss_hat.arena.loop"
_OTHER_HALF = (
    "import sys; from rcss_hat.system.workers import end_with; end_with(int(sys.argv[1])); "
    "from rcss_hat.numeric.compiling import tell_parent; tell_parent(); "
    "from rcss_hat.arena.match import prepare_players; prepare_players()"
)
_PATIENCE_S = 600.0


@contextmanager
def other_half() -> Iterator[None]:
    """Compile the players in another process meanwhile, unless the loop is cached or there is a single processor.

    At the end all is in the cache that either has compiled.
    """
    if is_cached(_LOOP) or (os.cpu_count() or 1) < 2:
        yield
        return
    command = [sys.executable, "-c", _OTHER_HALF, str(os.getpid())]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as other:
        try:
            listener = listen_to(other)
            yield
            listener.join(_PATIENCE_S)  # whatever went wrong there: the loop compiles what it does not find
        finally:
            other.kill()


def compile_rest(match: ArenaMatch) -> None:
    """Compile what the loop calls of the simulation and of policies, with the types it calls it with."""
    world, team = match.world, match.team
    state, params = world.match, world.params
    seat, see = int(team.seats[0]), team.sees[:1]
    compile_part(cycle.play, world)
    compile_part(cycle.judge, world)
    compile_part(clock.sees_before_think, state, params, team.due)
    compile_part(body.sense_body, world, seat, team.sense)
    compile_part(hearing.hear_teammate, world, seat, team.heard)
    compile_part(vision.see, world, seat, team.landmarks, False, see)
    compile_part(commands.act, world, seat, team.actions[:1])
    compile_part(clock.sees_after_think, state, params, team.due)
    compile_part(choose, match.brains, 0, True, 0.0, team.state)
    compile_part(finish, match.brains, 0, 0.0)


def compile_players(team: Team, params: NDArray[np.void]) -> None:
    """Compile what the loop calls of players, with the types it calls it with."""
    agent, see = team.agents[:1], team.sees[:1]
    compile_part(players.perceive, agent, params, team.sense, see, True, team.heard, True)
    compile_part(players.decide, agent, team.state)
    compile_part(players.act, agent, params, 0, 0, team.actions[:1])
    compile_part(taker_state_variables, agent, team.taker_state)
