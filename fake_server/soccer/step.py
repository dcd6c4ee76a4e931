"""One simulation step of soccer: play, stoppages, before a kick-off and after the end.

Source: 19.0.0, src/stadium.cpp (step).
"""

from __future__ import annotations

from fake_server.soccer.referee import analyse
from rcss_hat.simulation import cycle
from rcss_hat.simulation.keepaway import analyse_keepaway
from rcss_hat.simulation.motion import stand_still
from rcss_hat.simulation.referee import STOPPED
from rcss_hat.simulation.state import BEFORE_KICK_OFF, PLAY_ON, TIME_OVER
from rcss_hat.simulation.world import World


def step(world: World, referees: bool = True) -> None:
    """Advance a match in any play mode by one simulation step, as `rcss_hat.simulation.cycle.step` does in Keepaway.

    Without ``referees`` nobody judges, moves players or lets the play go on (as with ``coach=1``).
    """
    match, params = world.match, world.params
    mode = match["mode"][0]
    if mode == PLAY_ON and referees and params["half_time"][0] <= 0.0:
        cycle.step(world)
        return
    cycle.begin(world)
    if mode == BEFORE_KICK_OFF:
        for i in match["players"][0, : match["n_players"][0]].tolist():
            stand_still(match, i)
    elif mode != TIME_OVER:
        if STOPPED[mode]:
            match["catcher"][0] = -1
        cycle.move_all(world)
    waits = mode in (BEFORE_KICK_OFF, TIME_OVER) or STOPPED[mode]
    match["time"][0] += not waits
    match["stopped"][0] = match["stopped"][0] + 1 if waits else 0
    if referees and mode != TIME_OVER:
        analyse(world)
    if STOPPED[mode] and match["mode"][0] != mode:
        match["time"][0] += 1
        match["stopped"][0] = 0
    if not waits:
        analyse_keepaway(world)
    cycle.finish(world)
