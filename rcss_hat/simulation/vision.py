"""What a player sees.

Source: 19.0.0, src/visualsenderplayer.cpp. An object is seen when it is within the view cone, and nearer than the
diagonal of the pitch (19); when it is outside the cone but within visible_distance, it is seen without a name. Of far
objects velocity, number and team are lost, with a probability that grows with the distance. For clients of version 7
and later; from version 18 on (19) the team is never lost and the focus point and Gaussian noise count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, normalize_radians
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import bernoulli, next_uint64, normal
from rcss_hat.numeric.wire import six_digits
from rcss_hat.protocol.landmarks import LANDMARK_NAMES, LANDMARK_POSITIONS, N_LANDMARKS
from rcss_hat.protocol.records import (
    BALL,
    CLOSE_BALL,
    CLOSE_FLAG,
    CLOSE_GOAL,
    CLOSE_PLAYER,
    HAS_CHANGE,
    HAS_DISTANCE,
    HAS_FACING,
    HAS_POINTING,
    HIGH,
    IS_KICKING,
    IS_TACKLING,
    OTHER_TEAM,
    OWN_TEAM,
    PLAYER,
)
from rcss_hat.simulation.clock import view_angle
from rcss_hat.simulation.lines import see_lines
from rcss_hat.simulation.observation import (
    FAR,
    TEAM_FAR,
    TEAM_TOO_FAR,
    TOO_FAR,
    direction_change,
    distance_change,
    focused_tenths,
    gaussian_distance_change,
    landmark_uniform,
    lost_with,
    put_object,
    put_place,
    quantized_tenths,
    relative_direction,
    whole_degrees,
)
from rcss_hat.simulation.state import LANDMARKS, PERCEPTION, side_of, unum_of
from rcss_hat.simulation.world import World

_CLOSE_CODE = np.array([CLOSE_GOAL if name in ("g l", "g r") else CLOSE_FLAG for name in LANDMARK_NAMES])
_POINT_NOISE = 1.25 * DEG
"""Standard deviation (radians) of a near player's pointing direction."""
_POINT_RANGE_11 = 60.0
_EVERYWHERE = 1e300
_AT_REST = (0.0, 0.0)


class Observer(NamedTuple):
    """The player who looks: what stays the same for all objects of a see message."""

    x: float  # m
    y: float
    vx: float  # m/cycle
    vy: float
    body: float  # rad
    neck: float
    half: float  # half the angle of the view cone, rad
    near: float  # visible_distance, m
    reach: float  # farthest that is seen at all, m
    high: bool  # quality
    special: bool  # has a focus point or Gaussian noise
    gaussian: bool
    focus_x: float
    focus_y: float


class Sight(NamedTuple):
    """Where an object is, as the observer has it before him."""

    x: float  # m
    y: float
    dx: float  # m, from the observer
    dy: float
    dist: float  # m
    direction: float  # rad, from the face
    in_view: bool
    seen: bool  # at least without a name


@inlined
def _observer(world: World, i: int) -> Observer:
    match, params, types = world.match, world.params, world.types
    x, y = match["pos"][0, i, 0], match["pos"][0, i, 1]
    body, neck = match["body"][0, i], match["neck"][0, i]
    gaussian = match["gaussian_see"][0, i] != 0
    focus = match["focus_dist"][0, i] if match["version"][0, i] >= 18 else 0.0
    face = body + neck + match["focus_dir"][0, i]
    old = params["version_11"][0] != 0
    return Observer(
        x,
        y,
        match["vel"][0, i, 0],
        match["vel"][0, i, 1],
        body,
        neck,
        view_angle(match, params, i) * DEG * 0.5,
        params["visible_distance"][0],
        _EVERYWHERE if old else types["player_max_observation_length"][match["type"][0, i]],
        match["quality"][0, i] == HIGH,
        gaussian or focus != 0.0,
        gaussian,
        x + focus * math.cos(face) if focus != 0.0 else x,
        y + focus * math.sin(face) if focus != 0.0 else y,
    )


@inlined
def _look_at(o: Observer, x: float, y: float) -> Sight:
    dx, dy = x - o.x, y - o.y
    dist = math.sqrt(dx * dx + dy * dy)
    direction = relative_direction(dx, dy, o.body, o.neck)
    in_view = abs(direction) < o.half and dist < o.reach
    return Sight(x, y, dx, dy, dist, direction, in_view, in_view or dist <= o.near)


@kernel
def _special_tenths(o: Observer, at: Sight, step: float, rate: float, focus_rate: float, noise: float) -> float:
    """Reported distance in tenths with a focus point or Gaussian noise; noise is from the normal distribution."""
    focus_dist = math.sqrt((at.x - o.focus_x) ** 2 + (at.y - o.focus_y) ** 2)
    if o.gaussian:
        return 10.0 * max(0.0, at.dist + noise * (at.dist * rate + focus_dist * focus_rate))
    return focused_tenths(at.dist, focus_dist, step)


@inlined
def _put_nameless(out: NDArray[np.void], n: int, code: int, at: Sight) -> None:
    """Write an object of which nothing but the direction is seen."""
    put_object(out, n, code, 0, 0.0, whole_degrees(at.direction), 0.0, 0.0)


@inlined
def _shown(o: Observer, tenths: float) -> float:
    """Distance (m) as a client reads it."""
    return six_digits(0.1 * tenths) if o.gaussian else tenths / 10.0


@inlined
def _put_seen(
    o: Observer,
    out: NDArray[np.void],
    n: int,
    code: int,
    at: Sight,
    tenths: float,
    with_change: bool,
    velocity: tuple[float, float],
) -> None:
    """Write an object seen with its distance, and with its motion in the world unless that is lost."""
    radial = tangential = 0.0
    fields = HAS_DISTANCE
    if with_change:
        fields |= HAS_CHANGE
        dvx, dvy = velocity[0] - o.vx, velocity[1] - o.vy
        tangential = direction_change(at.dx, at.dy, at.dist, dvx, dvy)
        if o.gaussian:
            radial = gaussian_distance_change(0.1 * tenths, at.dx, at.dy, at.dist, dvx, dvy)
        else:
            radial = distance_change(tenths, at.dx, at.dy, at.dist, dvx, dvy)
    put_object(out, n, code, fields, _shown(o, tenths), whole_degrees(at.direction), radial, tangential)


@inlined
def _see_landmarks(
    o: Observer, world: World, kind: int, landmarks: NDArray[np.uint8], in_motion: bool, out: NDArray[np.void]
) -> int:
    """Write those of some landmarks that are seen; return their number."""
    n, types, key = 0, world.types, next_uint64(world.streams[LANDMARKS])
    step = world.params["quantize_step_l"][0]
    for k in landmarks:
        at = _look_at(o, LANDMARK_POSITIONS[k, 0], LANDMARK_POSITIONS[k, 1])
        if not at.seen:
            continue
        code = k if at.in_view else _CLOSE_CODE[k]
        if not o.high:
            _put_nameless(out, n, code, at)
        else:
            if o.special:
                noise = _landmark_normal(key, k)
                rate, focus_rate = types["land_dist_noise_rate"][kind], types["land_focus_dist_noise_rate"][kind]
                tenths = _special_tenths(o, at, step, rate, focus_rate, noise)
            else:
                tenths = quantized_tenths(at.dist, step)
            if in_motion:
                lost = lost_with(tenths * 0.1, FAR, TOO_FAR)
                with_change = at.in_view and (lost <= 0.0 or (lost < 1.0 and landmark_uniform(key, k) >= lost))
                _put_seen(o, out, n, code, at, tenths, with_change, _AT_REST)
            else:
                put_place(out, n, code, HAS_DISTANCE, _shown(o, tenths), whole_degrees(at.direction))
        n += 1
    return n


@kernel
def _landmark_normal(key: np.uint64, k: int) -> float:
    """Number from the standard normal distribution that hangs on key and landmark alone."""
    radius = math.sqrt(-2.0 * math.log(1.0 - landmark_uniform(key, k + N_LANDMARKS)))
    return radius * math.cos(2.0 * math.pi * landmark_uniform(key, k + 2 * N_LANDMARKS))


@inlined
def _moving_tenths(o: Observer, world: World, kind: int, at: Sight) -> float:
    """Reported distance of ball or player in tenths."""
    types, rng, step = world.types, world.streams[PERCEPTION], world.params["quantize_step"][0]
    if not o.special:
        return float(quantized_tenths(at.dist, step))
    noise = normal(rng) if o.gaussian else 0.0
    rate, focus_rate = types["dist_noise_rate"][kind], types["focus_dist_noise_rate"][kind]
    return float(_special_tenths(o, at, step, rate, focus_rate, noise))


@inlined
def _see_ball(o: Observer, world: World, kind: int, n: int, out: NDArray[np.void]) -> int:
    """Write the ball when it is seen; return the number of objects so far."""
    match = world.match
    at = _look_at(o, match["ball_pos"][0, 0], match["ball_pos"][0, 1])
    if not at.seen:
        return n
    code = BALL if at.in_view else CLOSE_BALL
    if not o.high:
        _put_nameless(out, n, code, at)
        return n + 1
    tenths = _moving_tenths(o, world, kind, at)
    with_change = at.in_view and not bernoulli(world.streams[PERCEPTION], lost_with(tenths * 0.1, FAR, TOO_FAR))
    _put_seen(o, out, n, code, at, tenths, with_change, (match["ball_vel"][0, 0], match["ball_vel"][0, 1]))
    return n + 1


@inlined
def _team_lost(params: NDArray[np.void], version: int, dist: float, rng: NDArray[np.uint64]) -> bool:
    """Decide whether the team of a player at a reported distance (m) is lost."""
    if params["version_11"][0]:
        return dist >= TEAM_TOO_FAR
    return version < 18 and bernoulli(rng, lost_with(dist, TEAM_FAR, TEAM_TOO_FAR))


@kernel
def _pointing(o: Observer, world: World, kind: int, j: int, dist: float) -> float:
    """Direction (whole degrees, relative to the observer's face) in which player j points, with noise.

    sigma = 1.25 degrees + (d/L)^4 (180 - 1.25) degrees; L is the diagonal of the pitch, in 11.1 60 m.
    """
    match, params, types, rng = world.match, world.params, world.types, world.streams[PERCEPTION]
    dx = match["arm_pos"][0, j, 0] - match["pos"][0, j, 0]
    dy = match["arm_pos"][0, j, 1] - match["pos"][0, j, 1]
    length = _POINT_RANGE_11 if params["version_11"][0] else types["team_too_far_length"][kind]
    sigma = (dist / length) ** 4 * (math.pi - _POINT_NOISE) + _POINT_NOISE
    return whole_degrees(normalize_radians(math.atan2(dy, dx) - o.body - o.neck + sigma * normal(rng)))


@inlined
def _mark_player(
    o: Observer, world: World, i: int, j: int, dist: float, with_facing: bool, n: int, out: NDArray[np.void]
) -> None:
    """Add to object n what is seen of a player's posture: arm, body and head, tackle, kick."""
    match = world.match
    if match["arm_expires"][0, j] > 0:
        out["fields"][0, n] |= HAS_POINTING
        out["pointing"][0, n] = _pointing(o, world, match["type"][0, i], j, dist)
    if with_facing:
        out["fields"][0, n] |= HAS_FACING
        body, neck = match["body"][0, j], match["neck"][0, j]
        out["body"][0, n] = whole_degrees(normalize_radians(body - o.body - o.neck))
        out["head"][0, n] = whole_degrees(normalize_radians(neck + body - o.body - o.neck))
    if match["tackle_cycles"][0, j] > 0:
        out["fields"][0, n] |= IS_TACKLING
    elif match["kick_cycles"][0, j] > 0 and match["version"][0, i] >= 13:
        out["fields"][0, n] |= IS_KICKING


@inlined
def _see_player(o: Observer, world: World, i: int, j: int, n: int, out: NDArray[np.void]) -> int:
    """Write player j when he is seen; return the number of objects so far."""
    match, rng = world.match, world.streams[PERCEPTION]
    at = _look_at(o, match["pos"][0, j, 0], match["pos"][0, j, 1])
    if not at.seen:
        return n
    if not at.in_view and not o.high:
        _put_nameless(out, n, CLOSE_PLAYER, at)
        return n + 1
    tenths = _moving_tenths(o, world, match["type"][0, i], at)
    if not at.in_view:
        _put_seen(o, out, n, CLOSE_PLAYER, at, tenths, False, _AT_REST)
        return n + 1
    seen = tenths * 0.1
    with_team = not _team_lost(world.params, match["version"][0, i], seen, rng)
    with_unum = with_team and not bernoulli(rng, lost_with(seen, FAR, TOO_FAR))
    if o.high:
        _put_seen(o, out, n, PLAYER, at, tenths, with_unum, (match["vel"][0, j, 0], match["vel"][0, j, 1]))
    else:
        _put_nameless(out, n, PLAYER, at)
    if with_team:
        out["team"][0, n] = OWN_TEAM if side_of(i) == side_of(j) else OTHER_TEAM
        if with_unum:
            out["unum"][0, n] = unum_of(j)
            out["goalie"][0, n] = match["goalie"][0, j]
        if o.high:
            _mark_player(o, world, i, j, at.dist, with_unum, n, out)
    return n + 1


@kernel
def see(world: World, i: int, landmarks: NDArray[np.uint8], in_motion: bool, out: NDArray[np.void]) -> None:
    """Write the see message of a player as a client would read it.

    Parameters
    ----------
    world : World
        PERCEPTION decides what is lost of ball and players; one draw from LANDMARKS decides what is lost of landmarks.
    i : int
        Index of the player.
    landmarks : ndarray of uint8
        Numbers of the landmarks to look at, rising; leaving out others changes nothing else in the message nor in later
        ones.
    in_motion : bool
        Whether to tell how landmarks move before the observer, too, and not only their places: our players do not look
        at it.
    out : ndarray of SEE, shape (1,)
        Landmarks, ball, left players, right players, lines. All fields of its first n objects are set; of landmarks
        that are not wanted in motion only code, fields, distance and direction.
    """
    match, o = world.match, _observer(world, i)
    kind = match["type"][0, i]
    n = _see_landmarks(o, world, kind, landmarks, in_motion, out)
    n = _see_ball(o, world, kind, n, out)
    for k in range(match["n_players"][0]):
        j = match["players"][0, k]
        if j != i:
            n = _see_player(o, world, i, j, n, out)
    out["time"][0] = match["time"][0]
    out["n"][0] = see_lines(o.x, o.y, o.body, o.neck, world.params["quantize_step_l"][0], o.high, n, out)
