"""Stamina, effort, recovery and capacity of a player at the end of a step.

Source: 19.0.0, src/player.cpp (updateStamina, updateCapacity); 11.1 lets effort recover from effort_dec_thr on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined
from rcss_hat.simulation.world import World


@inlined
def update_stamina(world: World, i: int) -> None:
    """Lower recovery and effort of the tired, raise effort of the rested, then refill stamina.

    ``inc = min(recovery stamina_inc_max, stamina_max - stamina, capacity)``; a negative ``stamina_capacity`` parameter
    means that stamina never runs out for good.
    """
    match, params, types = world.match, world.params, world.types
    k = match["type"][0, i]
    stamina = match["stamina"][0, i]
    top = params["stamina_max"][0]
    if stamina <= params["recover_dec_thr"][0] * top:
        lowest = params["recover_min"][0]
        recovery = match["recovery"][0, i]
        if recovery > lowest:
            recovery -= params["recover_dec"][0]
        match["recovery"][0, i] = max(recovery, lowest)
    if stamina <= params["effort_dec_thr"][0] * top:
        lowest = types["effort_min"][k]
        effort = match["effort"][0, i]
        if effort > lowest:
            effort -= params["effort_dec"][0]
        match["effort"][0, i] = max(effort, lowest)
    rested = params["effort_dec_thr"][0] if params["version_11"][0] else params["effort_inc_thr"][0]
    if stamina >= rested * top:
        highest = types["effort_max"][k]
        effort = match["effort"][0, i]
        if effort < highest:
            match["effort"][0, i] = min(effort + params["effort_inc"][0], highest)
    inc = min(match["recovery"][0, i] * types["stamina_inc_max"][k], top - stamina)
    if params["stamina_capacity"][0] >= 0.0:
        capacity = match["capacity"][0, i]
        inc = min(inc, capacity)
        match["capacity"][0, i] = max(0.0, capacity - inc)
    match["stamina"][0, i] = min(stamina + inc, top)


@inlined
def update_hearing(match: NDArray[np.void], params: NDArray[np.void], i: int) -> None:
    """Refill the hearing capacities, and let a goalie's catch ban run off."""
    inc, most = params["hear_inc"][0], params["hear_max"][0]
    match["hear_own"][0, i] = min(match["hear_own"][0, i] + inc, most)
    match["hear_other"][0, i] = min(match["hear_other"][0, i] + inc, most)
    if match["catch_ban"][0, i] > 0:
        match["catch_ban"][0, i] -= 1
