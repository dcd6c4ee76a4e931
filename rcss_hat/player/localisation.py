"""Where am I: own position and neck direction from the landmarks of one see message.

Every landmark gives a distance (rounded, error about 0.3 % plus 3 cm) and a direction (whole degrees, error 0.3
degrees). Position and direction follow by weighted least squares, linearised at the predicted pose (Gauss and Newton;
one step is enough unless the pose jumped). The UT Austin players use 100 particles to the same end. The line in view
gives the first direction. The velocities of landmarks are never used.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.angles import DEG, RAD, normalize_degrees
from rcss_hat.numeric.jit import inlined, kernel
from rcss_hat.player.geometry import whole_cos, whole_sin
from rcss_hat.protocol.landmarks import LANDMARK_NAMES, LANDMARK_POSITIONS, N_LANDMARKS
from rcss_hat.protocol.records import CLOSE_FLAG, HAS_DISTANCE, LINE

Record = NDArray[np.void]

FULL_VIEW_LANDMARKS = (
    "f c", "f c t", "f c b", "f p r t", "f p r c", "f p r b", "f p l t", "f p l c", "f p l b",
)  # fmt: skip
"""Used when everything is in view: near, and spread over all directions.

They give the position within 4 cm and the direction within 0.1 degrees (standard deviations).
"""

BEARING_ERROR = DEG / math.sqrt(12.0)
"""Standard deviation of a direction rounded to whole degrees (rad)."""
_LOST = 2.0  # m: a distance that far off says that the player was moved
_X = np.ascontiguousarray(LANDMARK_POSITIONS[:, 0])
_Y = np.ascontiguousarray(LANDMARK_POSITIONS[:, 1])
_LINE_NORMALS = np.array([180.0, 0.0, -90.0, 90.0])


def landmarks_wanted(params: Record) -> NDArray[np.uint8]:
    """Tell which landmarks localisation uses.

    Parameters
    ----------
    params : record
        Server parameters (dtype PARAMS).

    Returns
    -------
    ndarray of uint8, shape (55,)
        1 for landmarks that are used. The others never influence the player.
    """
    wanted = np.zeros(N_LANDMARKS, dtype=np.uint8)
    if params["visible_angle"][0] < 360.0:
        wanted[:] = 1
    else:
        for name in FULL_VIEW_LANDMARKS:
            wanted[LANDMARK_NAMES.index(name)] = 1
    return wanted


@kernel
def line_direction(agent: Record, see: Record) -> float:
    """Neck direction (degrees) from the farthest line in view; 1000 when no line is seen."""
    farthest, neck = -1.0, 1000.0
    for i in range(see["n"][0] - 1, -1, -1):
        code = see["code"][0, i]
        if code < LINE or code >= LINE + 4:
            break
        if see["fields"][0, i] & HAS_DISTANCE and see["distance"][0, i] > farthest:
            farthest = see["distance"][0, i]
            seen = see["direction"][0, i]
            normal = _LINE_NORMALS[code - LINE] + (180.0 if agent["axis"][0] < 0.0 else 0.0)
            neck = normalize_degrees(normal - (seen + 90.0 if seen < 0.0 else seen - 90.0))
    return neck


@kernel
def rough_position(agent: Record, see: Record, c: float, s: float) -> tuple[float, float]:
    """Position as the mean over landmarks of "landmark minus its seen offset", near ones counting more (m).

    ``c`` and ``s`` are cosine and sine of the neck's direction.
    """
    x, y, total = 0.0, 0.0, 0.0
    for i in range(see["n"][0]):
        code = see["code"][0, i]
        if code >= N_LANDMARKS:
            if code >= CLOSE_FLAG:
                continue
            break
        if not agent["wanted"][0, code] or not see["fields"][0, i] & HAS_DISTANCE:
            continue
        distance = see["distance"][0, i]
        weight = 1.0 / (1.0 + distance * distance)
        dc, ds = whole_cos(see["direction"][0, i]), whole_sin(see["direction"][0, i])
        x += weight * (agent["axis"][0] * _X[code] - distance * (dc * c - ds * s))
        y += weight * (agent["axis"][0] * _Y[code] - distance * (dc * s + ds * c))
        total += weight
    if total == 0.0:
        return agent["pos"][0, 0], agent["pos"][0, 1]
    return x / total, y / total


@kernel
def improve(
    agent: Record, see: Record, x: float, y: float, c: float, s: float, neck_error: float
) -> tuple[float, float, float, float]:
    """One Gauss-Newton step.

    Parameters
    ----------
    agent, see : record
    x, y : float
        Position to start from (m).
    c, s : float
        Cosine and sine of the neck's direction to start from.
    neck_error : float
        Standard deviation of that direction (rad).

    Returns
    -------
    tuple of float
        Corrections of x, y (m) and direction (rad), and the largest distance error before the step (m).
    """
    bearing = 1.0 / (BEARING_ERROR * BEARING_ERROR)
    axis = agent["axis"][0]
    # Normal equations; the start counts as a measurement with an error of 1 m, so that one landmark is enough.
    xx, xy, yy = 1.0, 0.0, 1.0
    xa, ya, aa = 0.0, 0.0, 1.0 / (neck_error * neck_error)
    x0, y0, a0 = 0.0, 0.0, 0.0
    worst = 0.0
    for i in range(see["n"][0]):
        code = see["code"][0, i]
        if code >= N_LANDMARKS:
            if code >= CLOSE_FLAG:
                continue
            break
        if not agent["wanted"][0, code] or not see["fields"][0, i] & HAS_DISTANCE:
            continue
        dx, dy = axis * _X[code] - x, axis * _Y[code] - y
        r2 = dx * dx + dy * dy
        if r2 < 1.0:
            continue
        inverse = 1.0 / math.sqrt(r2)
        ux, uy = dx * inverse, dy * inverse
        distance = see["distance"][0, i]
        error = distance - r2 * inverse
        worst = max(worst, abs(error))
        weight = 12.0 / (0.01 + 1e-4 * distance * distance)
        xx += weight * ux * ux
        xy += weight * ux * uy
        yy += weight * uy * uy
        x0 -= weight * ux * error
        y0 -= weight * uy * error
        dc, ds = whole_cos(see["direction"][0, i]), whole_sin(see["direction"][0, i])
        wx, wy = dc * c - ds * s, dc * s + ds * c
        # seen direction minus true one, from this pose: 0 = seen - (landmark's direction) + neck's correction
        off = ux * wy - uy * wx
        bx, by = -uy * inverse, ux * inverse
        xx += bearing * bx * bx
        xy += bearing * bx * by
        yy += bearing * by * by
        xa += bearing * bx
        ya += bearing * by
        aa += bearing
        x0 -= bearing * bx * off
        y0 -= bearing * by * off
        a0 -= bearing * off
    # Symmetric 3 x 3 system by elimination.
    f, g = xa / aa, ya / aa
    xx -= f * xa
    xy -= f * ya
    yy -= g * ya
    x0 -= f * a0
    y0 -= g * a0
    determinant = xx * yy - xy * xy
    step_x = (x0 * yy - y0 * xy) / determinant
    step_y = (y0 * xx - x0 * xy) / determinant
    step_a = a0 / aa - f * step_x - g * step_y
    return step_x, step_y, step_a, worst


@inlined
def rotated(c: float, s: float, angle: float) -> tuple[float, float]:
    """Cosine and sine after a rotation by a small angle (rad), by their series.

    The length is set to 1 again, to the last bit: seen distances such as 5.0 m meet thresholds such as 5 m, and must
    come out a hair above or below without a bias.
    """
    square = angle * angle
    dc, ds = 1.0 - 0.5 * square * (1.0 - square / 12.0), angle * (1.0 - square / 6.0)
    c, s = c * dc - s * ds, s * dc + c * ds
    scale = 1.5 - 0.5 * (c * c + s * s)
    return c * scale, s * scale


@kernel
def locate(agent: Record, see: Record) -> tuple[float, float, float, float, float]:
    """Own pose from a see message.

    Returns
    -------
    tuple of float
        x, y (m), direction of the neck (degrees), its cosine and sine.
    """
    x, y, neck = agent["pos"][0, 0], agent["pos"][0, 1], agent["neck"][0]
    c, s = agent["neck_cos"][0], agent["neck_sin"][0]
    neck_error = 10.0 * DEG
    line = line_direction(agent, see)
    if line < 1000.0:
        neck, c, s, neck_error = line, whole_cos(line), whole_sin(line), BEARING_ERROR
    step_x, step_y, step_a, worst = improve(agent, see, x, y, c, s, neck_error)
    if worst > _LOST:
        x, y = rough_position(agent, see, c, s)
        step_x, step_y, step_a, worst = improve(agent, see, x, y, c, s, neck_error)
    for _ in range(3):
        x += step_x
        y += step_y
        neck += step_a * RAD
        if abs(step_x) + abs(step_y) < 0.4 and abs(step_a) < 2.0 * DEG:
            c, s = rotated(c, s, step_a)
            return x, y, normalize_degrees(neck), c, s
        c, s = math.cos(neck * DEG), math.sin(neck * DEG)
        step_x, step_y, step_a, worst = improve(agent, see, x, y, c, s, neck_error)
    return x, y, normalize_degrees(neck), c, s
