"""What a snapshot means in Keepaway: who holds the ball, who is K1, and K1's state variables from true positions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

from rcss_hat.viewer.frames import Player, Setup, Snapshot

ARROWS = {"ArrowRight": (1.0, 0.0), "ArrowDown": (0.0, 1.0), "ArrowLeft": (-1.0, 0.0), "ArrowUp": (0.0, -1.0)}
"""Arrow keys and where they point on the screen: x to the right, y down, as in the server."""
_ARROW_COSINE = math.cos(math.radians(70.0))
"""An arrow means nobody who is farther than this from where it points."""
_FEW = 4
_METRES_PER_DEGREE = 0.1
"""What an angle counts against a distance when team mates are told apart."""


@dataclass(frozen=True, slots=True)
class Situation:
    """Who is who.

    Attributes
    ----------
    holder : Player or None
        The keeper nearest to the ball if he can kick it, else the nearest taker who can.
    keepers, takers : tuple of Player
        K1, K2, ...: nearest to the ball first, then by distance to K1; T1, T2, ...: by distance to K1.
    """

    holder: Player | None
    keepers: tuple[Player, ...]
    takers: tuple[Player, ...]

    @property
    def mates(self) -> tuple[Player, ...]:
        """Whom PASS1, PASS2, ... of K1 go to."""
        return self.keepers[1:]


def around(first: Player, players: Sequence[Player], holder: Player | None) -> Situation:
    """Sort the players of a match as seen from one keeper, who becomes K1."""
    mates = [p for p in players if p.side == first.side and p.id != first.id]
    others = [p for p in players if p.side != first.side]
    nearest = sorted(mates, key=lambda p: _distance(p, first)), sorted(others, key=lambda p: _distance(p, first))
    return Situation(holder, (first, *nearest[0]), tuple(nearest[1]))


def _to_ball(player: Player, snapshot: Snapshot) -> float:
    return math.hypot(player.x - snapshot.ball[0], player.y - snapshot.ball[1])


def _distance(a: Player, b: Player) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def situation(snapshot: Snapshot, setup: Setup) -> Situation:
    """Sort the players of a snapshot; keepers are the left side, takers the right."""
    left = [p for p in snapshot.players if p.side == "l"]
    right = [p for p in snapshot.players if p.side == "r"]
    if not left:
        return Situation(None, (), tuple(right))
    first = min(left, key=lambda p: _to_ball(p, snapshot))
    holder = None
    if _to_ball(first, snapshot) < setup.reach:
        holder = first
    elif right:
        nearest = min(right, key=lambda p: _to_ball(p, snapshot))
        holder = nearest if _to_ball(nearest, snapshot) < setup.reach else None
    return around(first, snapshot.players, holder)


def state_variables(here: Situation) -> list[float] | None:
    """Compute K1's state variables from true positions, in the players' code order (13 numbers in 3v2).

    Returns
    -------
    list of float or None
        Metres, and degrees for the last; None without two keepers and a taker. A keeper's own view differs from these
        by what it perceives imprecisely.
    """
    if len(here.keepers) < 2 or not here.takers:
        return None
    k1, mates, takers = here.keepers[0], here.keepers[1:], here.takers
    return [
        math.hypot(k1.x, k1.y),
        *(_distance(k1, k) for k in mates),
        *(_distance(k1, t) for t in takers),
        *(math.hypot(k.x, k.y) for k in mates),
        *(math.hypot(t.x, t.y) for t in takers),
        *(min(_distance(k, t) for t in takers) for k in mates),
        *(min(_angle(k, k1, t) for t in takers) for k in mates),
    ]


def _angle(a: Player, vertex: Player, b: Player) -> float:
    """Angle at a vertex between the directions to two players, 0 .. 180 degrees."""
    turn = math.atan2(a.y - vertex.y, a.x - vertex.x) - math.atan2(b.y - vertex.y, b.x - vertex.x)
    return abs(math.degrees(math.remainder(turn, 2.0 * math.pi)))


def believed_mates(here: Situation, state: Sequence[float]) -> list[str]:
    """Tell who K2, K3, ... are for a keeper whose own state variables are known.

    A keeper sorts its team mates by distance as it perceives them. Where two are about equally far, its order can
    differ from the true one; then the rest of its state variables tells them apart.

    Parameters
    ----------
    here : Situation
        With true positions, K1 being that keeper.
    state : sequence of float
        That keeper's state variables.

    Returns
    -------
    list of str
        Player ids, K2 first.
    """
    ids = [mate.id for mate in here.mates]
    true = state_variables(here)
    if true is None or len(true) != len(state) or len(ids) > _FEW:
        return ids
    n, m = len(ids), len(here.takers)

    def features(variables: Sequence[float], mate: int) -> tuple[float, ...]:
        centre, taker = 1 + n + m, 1 + 2 * (n + m)
        angle = variables[taker + n + mate] * _METRES_PER_DEGREE
        return variables[1 + mate], variables[centre + mate], variables[taker + mate], angle

    misfit = [[math.dist(features(state, k), features(true, i)) for i in range(n)] for k in range(n)]
    best = min(permutations(range(n)), key=lambda order: sum(misfit[k][i] for k, i in enumerate(order)))
    return [ids[i] for i in best]


def arrow_keys(here: Situation) -> dict[str, str]:
    """Give every team mate of K1 the arrow key that points to him best.

    Every arrow means one team mate at most, every team mate has one arrow at most; pairs that fit best come first.

    Returns
    -------
    dict
        Player id to ``ArrowUp``, ``ArrowDown``, ``ArrowLeft`` or ``ArrowRight``.
    """
    k1 = here.keepers[0]
    fits = []
    for mate in here.mates:
        distance = max(_distance(k1, mate), 1e-6)
        for key, (dx, dy) in ARROWS.items():
            cosine = ((mate.x - k1.x) * dx + (mate.y - k1.y) * dy) / distance
            if cosine > _ARROW_COSINE:
                fits.append((-cosine, mate.id, key))
    given: dict[str, str] = {}
    for _, mate_id, key in sorted(fits):
        if mate_id not in given and key not in given.values():
            given[mate_id] = key
    return given
