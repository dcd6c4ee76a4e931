"""Players seen without number or team: who they are, as far as it can be told.

The see message names the left players and then the right ones, each by number. So the players before and after a
stranger bound its number; else it is taken for a known player near by who was not seen, or put into a free slot.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel
from rcss_hat.player.geometry import whole_cos, whole_sin
from rcss_hat.player.objects import PLAYER_MEMORY, distance2_to, is_known
from rcss_hat.player.records import N_SLOTS, NEVER, NOBODY, OPPONENTS
from rcss_hat.protocol.records import CLOSE_PLAYER, HAS_DISTANCE, LEFT, OTHER_TEAM, OWN_TEAM, PLAYER, UNKNOWN_TEAM

Record = NDArray[np.void]

SAME_PLAYER = 7.5
"""A stranger farther than this from a player is not that player (m)."""
NO_ANGLE = -1000.0
N_TEAMS = 3
"""Unknown, own, other."""


@kernel
def forget_strangers_near(agent: Record, params: Record, slot: int, x: float, y: float) -> None:
    """Drop a guessed entry of the same team that must have been the player now seen with number at a point."""
    first = OPPONENTS if slot >= OPPONENTS else 0
    end = agent["top_other"][0] if slot >= OPPONENTS else agent["top_own"][0]
    best, best2 = NOBODY, SAME_PLAYER * SAME_PLAYER
    for o in range(end - 1, first - 1, -1):
        if agent["player_known"][0, o] or o == slot or o == agent["me"][0] or not is_known(agent, o):
            continue
        d2 = distance2_to(agent, o, x, y)
        if d2 < best2:
            best, best2 = o, d2
    if best != NOBODY and math.sqrt(best2) < _most_travelled(agent, params, best):
        agent["player_seen"][0, best] = NEVER


@kernel
def _most_travelled(agent: Record, params: Record, slot: int) -> float:
    """How far a player can have gone since it was last seen (m)."""
    return (agent["now"][0] - agent["player_seen"][0, slot]) * params["player_speed_max"][0]


@kernel
def _seen_slot(see: Record, i: int) -> int:
    """Slot of a player seen with number, else NOBODY."""
    if see["code"][0, i] != PLAYER or see["unum"][0, i] == 0 or see["team"][0, i] == UNKNOWN_TEAM:
        return NOBODY
    slot = int(see["unum"][0, i]) - 1
    return slot if see["team"][0, i] == OWN_TEAM else slot + OPPONENTS


@kernel
def _is_player(see: Record, i: int) -> bool:
    return see["code"][0, i] == PLAYER or see["code"][0, i] == CLOSE_PLAYER


@kernel
def _team_of(see: Record, i: int) -> int:
    return UNKNOWN_TEAM if see["code"][0, i] == CLOSE_PLAYER else int(see["team"][0, i])


@kernel
def _lowest(agent: Record, team: int, before: int) -> int:
    """Lowest slot a stranger can have, after the player before it in the message (a slot or NOBODY)."""
    if team == OWN_TEAM and (before == NOBODY or before >= OPPONENTS):
        slot = 0
    elif team == OTHER_TEAM and (before == NOBODY or before < OPPONENTS):
        slot = OPPONENTS
    elif before == NOBODY:
        slot = 0 if agent["side"][0] == LEFT else OPPONENTS
    else:
        slot = (before + 1) % N_SLOTS
    return (slot + 1) % N_SLOTS if slot == agent["me"][0] else slot


@kernel
def _highest(agent: Record, see: Record, i: int) -> int:
    """Highest slot the stranger at index i can have, from the players after it in the message."""
    slot = N_SLOTS - 1 if agent["side"][0] == LEFT else OPPONENTS - 1
    for j in range(see["n"][0] - 1, i, -1):
        if not _is_player(see, j):
            continue
        known = _seen_slot(see, j)
        if known != NOBODY:
            slot = known
        elif _team_of(see, j) == OTHER_TEAM and slot < OPPONENTS:
            slot = N_SLOTS - 1
        elif _team_of(see, j) == OWN_TEAM and slot >= OPPONENTS:
            slot = OPPONENTS - 1
        slot = (slot - (2 if slot == agent["me"][0] else 1)) % N_SLOTS
    return slot


@kernel
def recognise(agent: Record, params: Record, see: Record) -> None:
    """Find out who the players seen without number are, and take over where they are."""
    places, n, before = agent["order"], 0, NOBODY
    for i in range(see["n"][0]):
        if not _is_player(see, i) or not see["fields"][0, i] & HAS_DISTANCE:
            continue
        known = _seen_slot(see, i)
        if known != NOBODY:
            before = known
            continue
        team = _team_of(see, i)
        before = _lowest(agent, team, before)
        highest = _highest(agent, see, i)
        if before == highest:
            _place(agent, see, i, before, True)
        elif n < N_SLOTS:
            if (before < OPPONENTS) == (highest < OPPONENTS):
                team = OWN_TEAM if before < OPPONENTS else OTHER_TEAM
            places[0, n] = N_TEAMS * i + team
            n += 1
    for k in range(n):
        place = places[0, k]
        _guess(agent, params, see, place // N_TEAMS, place % N_TEAMS)


@kernel
def _position(agent: Record, see: Record, i: int) -> tuple[float, float]:
    dc, ds = whole_cos(see["direction"][0, i]), whole_sin(see["direction"][0, i])
    c, s = agent["neck_cos"][0], agent["neck_sin"][0]
    distance = see["distance"][0, i]
    return agent["pos"][0, 0] + distance * (dc * c - ds * s), agent["pos"][0, 1] + distance * (dc * s + ds * c)


@kernel
def _place(agent: Record, see: Record, i: int, slot: int, sure: bool) -> None:
    """Believe that the stranger at index i is a certain player."""
    x, y = _position(agent, see, i)
    if not sure:
        agent["guessed"][0] = 1
        agent["player_vel"][0, slot, 0] = 0.0
        agent["player_vel"][0, slot, 1] = 0.0
        agent["player_see_vel"][0, slot, 0] = 0.0
        agent["player_see_vel"][0, slot, 1] = 0.0
        agent["player_body"][0, slot] = NO_ANGLE
        agent["player_angles"][0, slot] = NEVER
        agent["player_change"][0, slot] = NEVER
    agent["player_known"][0, slot] = sure
    agent["player_pos"][0, slot, 0] = x
    agent["player_pos"][0, slot, 1] = y
    agent["player_see_pos"][0, slot, 0] = x
    agent["player_see_pos"][0, slot, 1] = y
    time = see["time"][0]
    agent["player_time"][0, slot] = time
    agent["player_see_time"][0, slot] = time
    agent["player_seen"][0, slot] = time
    if slot >= OPPONENTS:
        agent["top_other"][0] = max(agent["top_other"][0], slot + 1)
    else:
        agent["top_own"][0] = max(agent["top_own"][0], slot + 1)


@kernel
def _guess(agent: Record, params: Record, see: Record, i: int, team: int) -> None:
    """Take a stranger for the nearest known player not yet seen, or for one not known at all."""
    x, y = _position(agent, see, i)
    best, best2 = NOBODY, 1000.0 * 1000.0
    for o in range(N_SLOTS):
        if (team == OTHER_TEAM and o < OPPONENTS) or (team == OWN_TEAM and o >= OPPONENTS) or o == agent["me"][0]:
            continue
        age = agent["now"][0] - agent["player_seen"][0, o]
        if age < 0 or age >= PLAYER_MEMORY or agent["player_seen"][0, o] == see["time"][0]:
            continue
        d2 = distance2_to(agent, o, x, y)
        if d2 < best2:
            best, best2 = o, d2
    distance = math.sqrt(best2)
    travelled = (agent["now"][0] + 1) * params["player_speed_max"][0]
    if best != NOBODY:
        travelled = _most_travelled(agent, params, best)
        if distance < SAME_PLAYER and distance < travelled + 2.0:
            _place(agent, see, i, best, False)
            return
    if team == UNKNOWN_TEAM:
        if see["distance"][0, i] >= params["visible_distance"][0] and distance - travelled <= 10.0:
            return
        team = OTHER_TEAM
    slot = _free_slot(agent, team)
    if slot != NOBODY:
        _place(agent, see, i, slot, False)


@kernel
def _free_slot(agent: Record, team: int) -> int:
    """First slot of a team without a good entry: slot or NOBODY."""
    first = OPPONENTS if team == OTHER_TEAM else 0
    for o in range(first, first + OPPONENTS):
        age = agent["now"][0] - agent["player_seen"][0, o]
        if (age < 0 or age >= PLAYER_MEMORY) and o != agent["me"][0]:
            return o
    return NOBODY
