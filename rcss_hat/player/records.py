"""The record of one player: what it believes, remembers and has asked the server for.

All geometry is in the player's own frame: metres and degrees, x towards the opponents' goal, y to the right of that.
For the left side this is the server's frame, for the right side the server's frame rotated by 180 degrees. Players
are kept in slots: 0 .. 10 the own team by uniform number, 11 .. 21 the opponents.
"""

from __future__ import annotations

import numpy as np

from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.records import MAX_PLAYERS, N_COUNTS

N_SLOTS = 2 * MAX_PLAYERS
OPPONENTS = MAX_PLAYERS
"""Slot of the opponents' number 1."""
NOBODY = -1
NEVER = -1000
"""A time before every other."""
N_GRID = 25
N_AHEAD = 104
"""Cycles for which motion is tabulated."""

_S = (N_SLOTS,)

AGENT = np.dtype(
    [
        # who
        ("side", "u1"),
        ("unum", "u1"),
        ("me", "i4"),  # own slot
        ("n_own", "i4"),  # players of the own team, of the other
        ("n_other", "i4"),
        ("top_own", "i4"),  # slots in use: 0 .. top_own-1 and 11 .. top_other-1
        ("top_other", "i4"),
        ("n_keepers", "i4"),
        ("n_takers", "i4"),
        ("axis", "f8"),  # own frame: 1 as the server's, -1 rotated
        ("wanted", "u1", (N_LANDMARKS,)),  # landmarks used for localisation
        ("rng", "u8", (4,)),
        # what follows from the server's parameters
        ("kick_dist", "f8"),  # m
        ("roll", "f8", (N_AHEAD,)),  # player rolling c cycles: distance over first speed
        ("first_share", "f8", (N_AHEAD,)),  # first speed over distance when rolling c cycles
        ("ball_roll", "f8", (N_AHEAD,)),  # ball rolling c cycles: distance over first speed
        ("sprint", "f8", (N_AHEAD,)),  # distance of c cycles of full dashes from rest: nobody runs farther (m)
        ("grid", "f8", (2, N_GRID)),  # points among which a keeper gets open (m)
        # when
        ("now", "i4"),  # cycle of the last sense_body
        ("see_time", "i4"),  # cycle of the last see
        ("hear_time", "i4"),  # cycle in which a heard message last changed a belief
        # own pose
        ("pos", "f8", (2,)),
        ("vel", "f8", (2,)),  # after decay
        ("neck", "f8"),  # global directions, degrees
        ("body", "f8"),
        ("neck_cos", "f8"),
        ("neck_sin", "f8"),
        ("body_cos", "f8"),
        ("body_sin", "f8"),
        ("head", "f8"),  # neck relative to body, degrees, as sensed
        ("speed", "f8"),  # as sensed: m/cycle, and degrees relative to the face
        ("speed_direction", "f8"),
        ("effort", "f8"),
        ("shift", "f8", (2,)),  # correction of the own position by the last see
        ("counts", "i4", (N_COUNTS,)),
        ("collided", "u1"),  # with the ball or a player in the last step
        ("collision_time", "i4"),
        # the commands last given
        ("sent_time", "i4"),
        ("sent_kind", "u1"),
        ("sent_a", "f8"),
        ("sent_b", "f8"),
        ("sent_neck", "f8"),  # 0 when the neck was left alone
        ("withheld", "u1"),  # 1: no command in this cycle, the last one may still be under way
        # ball
        ("ball_pos", "f8", (2,)),
        ("ball_vel", "f8", (2,)),
        ("ball_seen", "i4"),  # cycle of the newest information, NEVER when lost
        ("ball_change", "i4"),  # cycle of the last seen velocity
        ("ball_see_pos", "f8", (2,)),  # when last seen
        ("ball_see_time", "i4"),
        ("kicked", "u1"),  # the last sense_body confirmed an own kick
        # players, own slot included
        ("player_pos", "f8", (N_SLOTS, 2)),
        ("player_vel", "f8", (N_SLOTS, 2)),
        ("player_body", "f8", _S),
        ("player_seen", "i4", _S),  # cycle of the newest information, NEVER when unknown
        ("player_time", "i4", _S),  # cycle for which player_pos holds
        ("player_change", "i4", _S),  # cycle of the last seen velocity
        ("player_angles", "i4", _S),  # cycle of the last seen body angle
        ("player_known", "u1", _S),  # 0: put into this slot without its number having been read
        ("guessed", "u1"),  # in this episode somebody was
        ("player_see_pos", "f8", (N_SLOTS, 2)),  # when last seen
        ("player_see_time", "i4", _S),
        ("player_see_vel", "f8", (N_SLOTS, 2)),
        ("player_see_body", "f8", _S),
        # who is fastest to the ball, kept until news come
        ("fast_see", "i4"),  # see_time and hear_time when computed
        ("fast_hear", "i4"),
        ("fast_own", "i4"),  # slot; NOBODY - 1: not computed yet
        ("fast_other", "i4"),
        # interception and search
        ("aim", "f8", (2,)),  # interception point chosen last
        ("aim_time", "i4"),
        ("search_time", "i4"),
        ("search_sign", "f8"),
        ("say_time", "i4"),
        # room to sort players in
        ("order", "i8", _S),
        ("distance", "f8", _S),
        ("crowd", "f8", (N_GRID,)),  # how crowded those points are
        # Keepaway
        ("hold_cycles", "i4"),  # from one Hold to the next decision
        ("last_action", "i4"),
        ("last_action_time", "i4"),  # NEVER: none in this episode
        ("episodes", "i4"),  # beginnings heard of
        ("new_episode", "u1"),  # an end not yet told to the learner
        ("taken_guess", "u1"),  # an episode that ended now would have been "taken"
    ],
)
"""One player, shape ``(1,)``."""

NOT_COMPUTED = NOBODY - 1
