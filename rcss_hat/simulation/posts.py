"""Goal posts: four discs from which objects bounce without loss.

Source: 19.0.0, src/object.cpp (_inc, nearestPost, intersect). Outside any Keepaway region; a move whose swept circle
cannot touch the nearest posts costs two comparisons.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.numeric.rng import uniform
from rcss_hat.protocol.landmarks import PITCH_LENGTH

POST_RADIUS = 0.06
"""Radius of a goal post (m); a constant of the server."""
_POST_X = 0.5 * PITCH_LENGTH - POST_RADIUS
_EPS = 1e-10
_MAX_BOUNCES = 20


@kernel
def post_center(goal_width: float, x: float, y: float) -> tuple[float, float]:
    """Centre of the goal post nearest to a point."""
    post_y = 0.5 * goal_width + POST_RADIUS
    return (_POST_X if x > 0.0 else -_POST_X), (post_y if y > 0.0 else -post_y)


@inlined
def near_posts(goal_width: float, x: float, y: float, dx: float, dy: float, size: float) -> bool:
    """Tell whether a move by (dx, dy) could touch a post."""
    reach = POST_RADIUS + size + math.sqrt(dx * dx + dy * dy)
    if abs(abs(x) - _POST_X) > reach:
        return False
    return abs(abs(y) - 0.5 * goal_width - POST_RADIUS) <= reach


@kernel
def _reflected(dx: float, dy: float, nx: float, ny: float) -> tuple[float, float]:
    """Mirror a vector at the plane with a normal of any length."""
    norm = nx * nx + ny * ny
    if norm == 0.0:
        return dx, dy
    along = 2.0 * (dx * nx + dy * ny) / norm
    return dx - along * nx, dy - along * ny


@kernel
def _share_until(x: float, y: float, dx: float, dy: float, cx: float, cy: float, radius: float) -> float:
    """Share of a move after which it enters a circle from outside; 2 when it does not."""
    px, py = x - cx, y - cy
    a = dx * dx + dy * dy
    b = px * dx + py * dy
    c = px * px + py * py - radius * radius
    if a == 0.0 or b >= 0.0:
        return 2.0
    root = b * b - a * c
    if root <= 0.0:
        return 2.0
    share = (-b - math.sqrt(root)) / a
    return share if 0.0 <= share <= 1.0 else 2.0


@kernel
def move_past_posts(
    goal_width: float, x: float, y: float, vx: float, vy: float, size: float, rng: NDArray[np.uint64]
) -> tuple[float, float, float, float, bool]:
    """Move an object by its velocity, bouncing from goal posts.

    Parameters
    ----------
    goal_width : float
        Metres.
    x, y, vx, vy : float
        Position (m) and velocity (m/cycle).
    size : float
        Radius of the object (m).
    rng : ndarray of uint64, shape (4,)
        Used only when the object stands in the very centre of a post.

    Returns
    -------
    tuple
        Position and velocity afterwards, and whether a post was touched.
    """
    radius = POST_RADIUS + size
    touched = False
    cx, cy = post_center(goal_width, x, y)
    if math.hypot(x - cx, y - cy) < radius:
        # It was put or pushed there: out to the edge.
        touched = True
        nx, ny = x - cx, y - cy
        if math.hypot(nx, ny) < _EPS:
            angle = uniform(rng, -math.pi, math.pi)
            nx, ny = math.cos(angle), math.sin(angle)
        scale = radius * (1.0 + 1e-12) / math.hypot(nx, ny)
        x, y = cx + nx * scale, cy + ny * scale
        vx, vy = _reflected(vx, vy, nx, ny)
    dx, dy = vx, vy
    for _ in range(_MAX_BOUNCES):
        cx, cy = post_center(goal_width, x, y)
        share = _share_until(x, y, dx, dy, cx, cy, radius)
        if share > 1.0:
            cx, cy = post_center(goal_width, x + dx, y + dy)
            share = _share_until(x, y, dx, dy, cx, cy, radius)
        if share > 1.0:
            break
        touched = True
        x, y = x + share * dx, y + share * dy
        nx, ny = x - cx, y - cy
        dx, dy = _reflected((1.0 - share) * dx, (1.0 - share) * dy, nx, ny)
        vx, vy = _reflected(vx, vy, nx, ny)
        # A little away from the post, or the next round would find the same point.
        scale = _EPS / max(math.hypot(nx, ny), _EPS)
        x, y = x + nx * scale, y + ny * scale
    return x + dx, y + dy, vx, vy, touched
