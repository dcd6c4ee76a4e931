"""Server parameters that the players can calculate with.

A server may be started with any numbers. Where a decay is 0 or 1, a turn has no moment or a size is not positive, the
formulas of the players divide by zero or never come to an end; then it is better to say so than to play.
"""

from __future__ import annotations

from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.params import ServerParams

_SMALL, _MOST = 1e-4, 1e4
LIMITS: dict[str, tuple[float, float]] = {
    "ball_accel_max": (_SMALL, _MOST), "ball_decay": (0.01, 0.999), "ball_rand": (0.0, 1.0),
    "ball_size": (_SMALL, 10.0),
    "ball_speed_max": (_SMALL, 1000.0), "dash_power_rate": (_SMALL, 10.0), "hear_decay": (0.0, _MOST),
    "inertia_moment": (0.0, 1000.0), "keepaway_length": (1.0, 1000.0), "keepaway_width": (1.0, 1000.0),
    "kick_power_rate": (_SMALL, 10.0), "kickable_margin": (0.0, 10.0), "maxmoment": (1.0, 360.0),
    "maxneckang": (0.0, 180.0), "maxpower": (1.0, _MOST), "minmoment": (-360.0, -1.0), "minneckang": (-180.0, 0.0),
    "minpower": (-_MOST, 0.0), "player_decay": (0.01, 0.999), "player_rand": (0.0, 1.0), "player_size": (_SMALL, 10.0),
    "player_speed_max": (_SMALL, 100.0), "simulator_step": (1.0, 1e6), "visible_angle": (_SMALL, 360.0),
    "visible_distance": (0.0, 1000.0),
}  # fmt: skip
"""Least and greatest value of every parameter that the players' formulas contain."""


def check_limits(params: ServerParams) -> None:
    """Make sure that players can play with a server's parameters.

    Raises
    ------
    RemoteProtocolError
        When they cannot; names the parameter, its value and what would be right.
    """
    for name, (least, most) in LIMITS.items():
        value = params.number(name)
        if not least <= value <= most:
            raise RemoteProtocolError(
                f"the server's parameter {name} is {value:g}; our players can play with {least:g} to {most:g}"
            )
