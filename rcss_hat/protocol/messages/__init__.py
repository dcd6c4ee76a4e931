"""Everything a server may say: one kind of event per kind of message, and `parse` (19.0.0, src/serializer*.cpp).

Events are read from the text forms of versions 7 to 19. Times are cycles, distances metres, angles degrees, velocities
metres per cycle, sides ``"l"`` and ``"r"``.
"""

from __future__ import annotations

import re

from rcss_hat.protocol.messages import answers, fullstate, global_view, parameters, perceived, show
from rcss_hat.protocol.messages.answers import *  # noqa: F403
from rcss_hat.protocol.messages.event import BY_BYTES, BY_GROUP, Event
from rcss_hat.protocol.messages.fullstate import *  # noqa: F403
from rcss_hat.protocol.messages.global_view import *  # noqa: F403
from rcss_hat.protocol.messages.groups import is_number, read_group
from rcss_hat.protocol.messages.parameters import *  # noqa: F403
from rcss_hat.protocol.messages.parameters import NAMELESS_IN_7
from rcss_hat.protocol.messages.parts import BallState
from rcss_hat.protocol.messages.perceived import *  # noqa: F403
from rcss_hat.protocol.messages.show import *  # noqa: F403

__all__ = ["BallState", "Event", "parse"]
__all__ += answers.__all__ + fullstate.__all__ + global_view.__all__ + parameters.__all__ + perceived.__all__
__all__ += show.__all__

_NAME = re.compile(rb"\(([a-z_]+)[ )]")


def parse(data: bytes, team: str = "") -> Event:
    """Read a message from a server.

    Parameters
    ----------
    data : bytes
        One datagram, with or without its NUL; or a line of a game log.
    team : str
        Name of the receiver's team; only see messages need it.

    Returns
    -------
    Event
        `Unknown` for a well-formed message of a kind not known here. Version 7's parameter lists, which have no names,
        and its fullstate are among those.

    Raises
    ------
    RemoteProtocolError
        When the message is malformed; names the place.
    """
    match = _NAME.match(data)
    name = match.group(1) if match else b""
    by_bytes = BY_BYTES.get(name)
    if by_bytes is not None:
        return by_bytes(data, team)
    group = read_group(data)
    read = BY_GROUP.get(name)
    if read is None or (name in NAMELESS_IN_7 and len(group.items) > 1 and is_number(group.items[1])):
        return answers.Unknown(data=data)
    group.next = 1
    event = read(group)
    group.finish()
    return event
