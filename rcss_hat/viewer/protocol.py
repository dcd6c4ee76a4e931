"""What pages and the program that serves them say to each other: JSON objects over a WebSocket, told apart by `type`.

A page asks for nothing when it connects: it is told everything it needs, so a page that comes back after a break of the
network, a reload or a restart of the program goes on where it was. Who it is says the request that opened the socket (a
cookie, or a participant's own address); see `rcss_hat.viewer.room`.

Pages say (see the classes below for the fields)

========================= ===========================================================================================
``press``                 a key or button: an action
``mate``                  an arrow, click or tap: a team mate
``demonstration``         a command to the demonstration, one of `COMMANDS`
``correct``               what would have been right in a cycle of the episode that is looked at again
``look``                  whether somebody sees the page
``seat``                  asks to play instead of a page that was left
``playback``              steers a recording
``pace``                  how long the page waited from one picture to the next, in milliseconds
========================= ===========================================================================================

Pages are told

========================= ===========================================================================================
``hello``                 first of all: ``protocol`` (`VERSION`), ``role`` (``player`` or ``watcher``), ``demonstrate``,
                          ``plain`` (no state variables and values), ``language`` (or None: the browser's)
``setup``                 ``setup``: `rcss_hat.viewer.frames.Setup`, ``live``: it cannot be stopped or sought
``frame``                 ``frame``: `rcss_hat.viewer.frames.Frame`; pictures that come too fast are left out
``episodes``, ``episode`` all that have ended, instead of those before; one more
``demonstration``         the state of the demonstration: `rcss_hat.viewer.demonstrator.Demonstrator.status`
``replay``                an episode to be looked at again: `rcss_hat.viewer.replay.Replay`; ``frames`` None: no more
``playback``              where in a recording we are
``notice``                a remark, ``text`` in English; ``code`` and ``values``: for the page's own language, where it
                          has these words; an empty text takes the last one back
``refused``               why something was not done: ``text``, ``code``, ``values`` as above
``seat``                  ``role``, and ``state``: ``free``, ``left`` or ``taken``
``farewell``              the end: ``kept``, ``episodes``, ``file``, ``next`` (a command), ``url`` (where to go on, or
                          None)
========================= ===========================================================================================
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct

VERSION = 1
MAX_MESSAGE = 4096
"""Bytes of the longest message a page may send."""
COMMANDS = ("start", "here", "pause", "resume", "take", "give", "drop", "drop_last", "seen", "stop")
"""Begin; answer whether anybody is there; pause, go on; take over from the learner, give back; drop or keep the running
episode, the last one; go on after looking at an episode again; finish."""

Milliseconds = Annotated[float, Meta(ge=0, le=1e12)]
"""Since the page was loaded, by its own clock."""


class Press(Struct, tag="press"):
    """A person asks for an action: 0 holds, 1 is PASS1, and so on."""

    value: int
    at: Milliseconds | None = None


class Mate(Struct, tag="mate"):
    """A person asks for a pass to a team mate, such as ``l2``."""

    value: str
    at: Milliseconds | None = None


class Command(Struct, tag="demonstration"):
    """A command to the demonstration."""

    value: Literal["start", "here", "pause", "resume", "take", "give", "drop", "drop_last", "seen", "stop"]


class Correct(Struct, tag="correct"):
    """What would have been right in a cycle of the episode looked at again; None takes it back."""

    cycle: int
    action: int | None


class Look(Struct, tag="look"):
    """Whether somebody sees the page, and no dialog covers it."""

    value: bool


class TakeSeat(Struct, tag="seat"):
    """The person in front of this page wants to play."""


class Playback(Struct, tag="playback"):
    """A command to a recording; what is no number counts as 0."""

    name: str
    value: Any = 0


class Pace(Struct, tag="pace"):
    """Milliseconds between pictures since the last such message, as the page got them."""

    intervals: Annotated[list[Annotated[int, Meta(ge=0, le=10**7)]], Meta(max_length=400)]


Message = Press | Mate | Command | Correct | Look | TakeSeat | Playback | Pace
_decoder = msgspec.json.Decoder(Message)


def read_message(text: str | bytes) -> Message | None:
    """Read what a page says; None when it is no such message."""
    try:
        return _decoder.decode(text)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError):
        return None
