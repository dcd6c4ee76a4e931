"""The kick-off of a match that is no Keepaway: whether it is time for one, whose it is, and who plays as which type.

Source: 19.0.0, src/stadium.cpp (kickOff) and src/team.cpp (assignPlayerTypes).
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from fake_server.player_param import PlayerParams
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.protocol.records import LEFT, MAX_PLAYERS, RIGHT
from rcss_hat.simulation.placement import place_ball, recover_all
from rcss_hat.simulation.referee import change_play_mode
from rcss_hat.simulation.state import KICK_OFF_LEFT, KICK_OFF_RIGHT
from rcss_hat.simulation.world import World


def kick_off(params: ServerParams, world: World) -> list[str]:
    """Give a kick-off when a half begins; returns what the referee announces, which he does every time."""
    match, time = world.match, int(world.match["time"][0])
    side = _side(params, time)
    if side is None:
        return []
    if time < _cycles(params, "half_time") * int(params.number("nr_normal_halfs")):
        recover_all(match, world.params)
    place_ball(match, 0.0, 0.0, 0.0, 0.0)
    match["kick_off_side"] = side
    mode = KICK_OFF_LEFT if side == LEFT else KICK_OFF_RIGHT
    change_play_mode(world, mode)
    match["events"] = 0
    return [PLAY_MODES[mode]]


def _side(params: ServerParams, time: int) -> int | None:
    """Side that kicks off at a time (cycles); None in the middle of a half."""
    length = _cycles(params, "half_time")
    normal = length * int(params.number("nr_normal_halfs"))
    anytime = length <= 0
    if time > normal:
        time, length = time - normal, _cycles(params, "extra_half_time")
    if not anytime and (length <= 0 or time % length != 0):
        return None
    return LEFT if length <= 0 or time // length % 2 == 0 else RIGHT


def _cycles(params: ServerParams, name: str) -> int:
    """Length of a half in cycles."""
    return int(params.number(name) * 1000.0 / params.number("simulator_step") + 0.5)


def team_size(match: NDArray[np.void], team: int) -> int:
    """Return how many players ever joined the left (0) or right (1) team: they keep their numbers, and versions."""
    return int(np.count_nonzero(match["version"][0, team * MAX_PLAYERS : (team + 1) * MAX_PLAYERS]))


class LineUp:
    """Who plays as which type.

    Parameters
    ----------
    params : ServerParams
    player_params : PlayerParams
    world : World
    """

    def __init__(self, params: ServerParams, player_params: PlayerParams, world: World) -> None:
        self._params, self._player_params, self._world = params, player_params, world
        self._substituted: set[int] = set()

    def substituted(self, i: int) -> None:
        """Note that a player was given a type."""
        self._substituted.add(i)

    def at_kick_off(self) -> list[tuple[int, int]]:
        """Return who gets which type at the first kick-off, as of each type only ``player::pt_max`` may play.

        Those whom nobody gave a type get the first one left, goalies first; not in Keepaway.
        """
        params = self._params
        if params["keepaway"] or params.profile == "11.1" or self._world.match["time"][0] > 0:
            return []
        if self._player_params["allow_mult_default_type"]:
            return []
        most = int(self._player_params["pt_max"])
        return [change for team in (0, 1) for change in self._types_of(team, most)]

    def _types_of(self, team: int, most: int) -> list[tuple[int, int]]:
        match, first = self._world.match, team * MAX_PLAYERS
        players = sorted(range(first, first + team_size(match, team)), key=lambda i: not match["goalie"][0, i])
        current = match["type"][0].tolist()
        used = Counter(current[i] for i in players if i in self._substituted)
        changes = []
        for i in players:
            if i in self._substituted and used[current[i]] <= most:
                continue
            new = next((kind for kind in range(len(self._world.types)) if used[kind] < most), None)
            if new is None:
                continue
            used[new] += 1
            if i in self._substituted:
                used[current[i]] -= 1
            if new != current[i]:
                changes.append((i, new))
        return changes
