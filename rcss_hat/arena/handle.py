"""The compiled loop called by one handle, for callers in Python who come back to it at every decision.

The loop works on some forty arrays. To take them from Python objects costs as much as a fifth of a cycle, so a handle
holds their addresses, and compiled code makes the arrays of these.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.loop import run
from rcss_hat.arena.match import ArenaMatch
from rcss_hat.arena.records import CONTROL, DECISION, FRAME, ORDER, Logs, Team
from rcss_hat.hat.brains import Brains
from rcss_hat.hat.policy import load_policy
from rcss_hat.hat.rule_rows import RULE_ROW
from rcss_hat.keepaway.state import state_variables
from rcss_hat.keepaway.taker_state import taker_state_variables
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.addresses import address_of, array_at
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.player.records import AGENT
from rcss_hat.protocol.params import PARAMS
from rcss_hat.protocol.records import ACTION, HEARD, SEE, SENSE_BODY
from rcss_hat.simulation.player_types import PLAYER_TYPE
from rcss_hat.simulation.state import EPISODE, MATCH
from rcss_hat.simulation.world import World

Numbers = NDArray[np.int64]
Records = NDArray[np.void]
Views = NDArray[np.float64]
NO_CHOICE = -1
"""Nobody was asked."""
_F8, _F4, _I8, _U8, _U1 = np.dtype("f8"), np.dtype("f4"), np.dtype("i8"), np.dtype("u8"), np.dtype("u1")
N_TOLD = 5


class Lens(NamedTuple):
    """What a keeper observes: ``minimum(state * scale, high)``, and where it is written to; shape (variables,)."""

    scale: NDArray[np.float64]
    high: NDArray[np.float64]
    seen: NDArray[np.float32]


@inlined
def _world(h: Numbers) -> World:
    return World(
        array_at(h[14], (1,), MATCH),
        array_at(h[15], (1,), PARAMS),
        array_at(h[16], (h[0],), PLAYER_TYPE),
        array_at(h[17], (h[1], 4), _U8),
    )


@inlined
def _team(h: Numbers) -> Team:
    n = h[2]
    return Team(
        array_at(h[18], (n,), AGENT),
        array_at(h[19], (n,), _I8),
        array_at(h[20], (n,), _U1),
        array_at(h[21], (1,), SENSE_BODY),
        array_at(h[22], (1,), HEARD),
        array_at(h[23], (n,), SEE),
        array_at(h[24], (n,), _U1),
        array_at(h[25], (h[3],), _U1),
        array_at(h[26], (h[4],), _U1),
        array_at(h[27], (n,), ACTION),
        array_at(h[28], (h[5],), _F8),
        array_at(h[29], (n,), ORDER),
        array_at(h[30], (h[6],), _F8),
        array_at(h[31], (1,), _U1),
    )


@inlined
def _brains(h: Numbers) -> Brains:
    keepers = h[8]
    rules, streams = array_at(h[32], (h[12],), RULE_ROW), array_at(h[33], (keepers, 4), _U8)
    return Brains(h[7], keepers, h[9], rules, streams, array_at(h[34], (h[13],), _I8))


@inlined
def _logs(h: Numbers) -> Logs:
    return Logs(
        array_at(h[35], (1,), EPISODE),
        array_at(h[36], (h[10],), DECISION),
        array_at(h[37], (h[10], h[5]), _F8),
        array_at(h[38], (h[11],), FRAME),
    )


@kernel
def _go_on(world: World, team: Team, brains: Brains, control: Records, logs: Logs, choice: int) -> int:
    """Let the loop go on with an answer, the episode that ended last being known by now."""
    control["logged"][0] = 0
    if choice != NO_CHOICE:
        control["choice"][0] = choice
        control["has_choice"][0] = 1
    return run(world, team, brains, control, logs)


@kernel
def _tell(world: World, team: Team, control: Records, lens: Lens, told: Numbers) -> None:
    """Write down where the loop came back, and what a keeper that asks observes."""
    match = world.match
    told[0], told[1], told[2] = match["time"][0], control["player"][0], control["status"][0]
    told[3], told[4] = match["episode"][0], match["episode_start"][0]
    for i in range(team.state.shape[0]):
        lens.seen[i] = min(team.state[i] * lens.scale[i], lens.high[i])


@kernel
def _resume(h: Numbers, choice: int) -> int:
    world, team, control = _world(h), _team(h), array_at(h[39], (1,), CONTROL)
    reason = _go_on(world, team, _brains(h), control, _logs(h), choice)
    n = h[5]
    lens = Lens(array_at(h[41], (n,), _F8), array_at(h[42], (n,), _F8), array_at(h[43], (n,), _F4))
    _tell(world, team, control, lens, array_at(h[40], (N_TOLD,), _I8))
    return reason


@kernel
def _look_around(team: Team, keepers: int, scratch: Records, views: Views, known: NDArray[np.uint8]) -> None:
    """Compute the state variables of everybody, on a copy of each record, in which there is room to sort in."""
    for p in range(team.agents.shape[0]):
        scratch[0] = team.agents[p]
        if p < keepers:
            known[p] = state_variables(scratch, views[p])
        else:
            known[p] = taker_state_variables(scratch, views[p])


@kernel
def _look(h: Numbers) -> None:
    n, width = h[2], max(h[5], h[6])
    scratch = array_at(h[44], (1,), AGENT)
    _look_around(_team(h), h[8], scratch, array_at(h[45], (n, width), _F8), array_at(h[46], (n,), _U1))


class Handle:
    """One match's loop, ready to go on.

    Parameters
    ----------
    match : ArenaMatch
        Its arrays must stay where they are: who lets its logs grow makes a new handle.
    scale, high : ndarray of float64, shape (variables,)
        What a keeper observes is ``minimum(state * scale, high)``.

    Attributes
    ----------
    resume : callable
        Lets the loop go on to the next reason for which it comes back (see `rcss_hat.arena.loop.run`), which it
        returns; takes the answer to NEEDS_ACTION, or NO_CHOICE.
    told : ndarray of int64, shape (N_TOLD,)
        Where the loop came back: cycle, player and status of the decision, the running episode's number and its start.
    seen : ndarray of float32, shape (variables,)
        What the keeper observes that asks.
    views : ndarray of float64, shape (players, most variables)
        After `look_around`: the state variables of everybody, keepers before takers, as they believe them to be.
    known : ndarray of uint8, shape (players,)
        Whether they do; where somebody is unknown to a player, its row means nothing.
    """

    def __init__(self, match: ArenaMatch, scale: NDArray[np.float64], high: NDArray[np.float64]) -> None:
        self.told, self.seen = np.zeros(N_TOLD, dtype=np.int64), np.zeros(len(scale), dtype=np.float32)
        lens = Lens(np.ascontiguousarray(scale), np.ascontiguousarray(high), self.seen)
        world, team, brains, logs = match.world, match.team, match.brains, match.logs
        sizes = [
            len(world.types), len(world.streams), len(team.agents), len(team.due), len(team.landmarks), len(team.state),
            len(team.taker_state), brains.kind, brains.keepers, brains.takers, len(logs.decisions), len(logs.frames),
            len(brains.rules), len(brains.learners),
        ]  # fmt: skip
        self.views = np.zeros((len(team.agents), max(len(team.state), len(team.taker_state))))
        self.known = np.zeros(len(team.agents), dtype=np.uint8)
        looks = [np.zeros(1, dtype=AGENT), self.views, self.known]
        self._arrays = [*world, *team, *brains[3:], *logs, match.control, self.told, *lens, *looks]
        self._numbers = np.array([*sizes, *map(address_of, self._arrays)], dtype=np.int64)
        self.resume: Callable[[int], int] = partial(_resume, self._numbers)

    def look_around(self) -> None:
        """Compute what everybody believes: ``views`` and ``known``."""
        _look(self._numbers)


def warm_up() -> None:
    """Compile what a handle calls, or load it from the cache; the loop must be compiled, see `prepare`."""
    spare = ArenaMatch(Task(), 0, load_policy("hold", 3, 2, 0))
    handle = Handle(spare, np.ones(len(spare.team.state)), np.ones(len(spare.team.state)))
    handle.resume(NO_CHOICE)  # to its last cycle, which is 0
    handle.look_around()
