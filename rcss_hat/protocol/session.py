"""How a player joins a match over a network that may lose, double, reorder and delay: the handshake, without sockets.

A player asks for a place by ``(init TEAM (version V))``, or for an old one by ``(reconnect TEAM UNUM)``, from one
address. The server (19.0.0, src/stadium.cpp: udp_recv_message, parsePlayerInit) answers from a port that it opens for
this player: the place, ``(init SIDE UNUM MODE)``, and right behind it its parameters, ``(server_param ...)``. It tells
both once. Asking again from the same address makes no second player: the server answers ``(error
only_init_allowed_on_init_port)`` from the player's port, which proves that it knows the player. Refusals come from the
port that was asked.

The states of the conversation and what leads from one to another are table `NEXT`. Any other message leaves the state
as it is: it belongs to the match that has begun, and is kept until the player has joined.
"""

from __future__ import annotations

from enum import Enum

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import Command, Init, Reconnect, datagram
from rcss_hat.protocol.errors import LocalProtocolError, RemoteProtocolError

KNOWN = "only_init_allowed_on_init_port"
"""The server's answer to somebody who has joined already."""
KEPT = 64
"""Messages that are kept until the player has joined; more than two cycles of a match."""


class State(Enum):
    """Where the conversation is."""

    ASKING = "asking"
    PLACED = "placed"
    """The server has told the place, not yet its parameters."""
    TOLD = "told"
    """The server has told its parameters; what told the place is late, or lost."""
    JOINED = "joined"
    REFUSED = "refused"


NEXT: dict[tuple[State, type[messages.Event]], State] = {
    (State.ASKING, messages.Init): State.PLACED,
    (State.ASKING, messages.Reconnect): State.PLACED,
    (State.ASKING, messages.ServerParam): State.TOLD,
    (State.ASKING, messages.Error): State.REFUSED,
    (State.PLACED, messages.ServerParam): State.JOINED,
    (State.TOLD, messages.Init): State.JOINED,
    (State.TOLD, messages.Reconnect): State.JOINED,
}
"""What the server says, and where it leads. In any other state an error is an answer to an init that was repeated, or
doubled on its way."""


class Handshake:
    """One player's way into a match.

    Parameters
    ----------
    team : str
    version : int
        Of the protocol.
    unum : int, optional
        The number of somebody who comes back.

    Attributes
    ----------
    state : State
    request : bytes
        The datagram that asks; to be repeated until the server says anything.
    place : Init or None
        Side, uniform number and play mode.
    params : bytes or None
        The server's ``server_param`` message.
    kept : list of bytes
        What belongs to the match, in the order in which it came.

    Raises
    ------
    LocalProtocolError
        When the team's name is illegal.
    """

    def __init__(self, team: str, version: int, unum: int | None = None) -> None:
        self.team, self.unum = team, unum
        command: Command = Init(team, version) if unum is None else Reconnect(team, unum)
        self.request = datagram(command)
        self.state = State.ASKING
        self.place: messages.Init | None = None
        self.params: bytes | None = None
        self.kept: list[bytes] = []

    @property
    def joined(self) -> bool:
        """Whether everything is known that a player needs."""
        return self.state is State.JOINED

    def receive(self, data: bytes) -> None:
        """Take a datagram from the server.

        Raises
        ------
        RemoteProtocolError
            When the server refuses the player, or its message is malformed.
        """
        event = messages.parse(data, self.team)
        if isinstance(event, messages.Error) and event.text == KNOWN:
            return
        following = NEXT.get((self.state, type(event)))
        if following is State.REFUSED:
            assert isinstance(event, messages.Error)
            self.state = following
            raise RemoteProtocolError(f"the server refuses {self.team!r}: {event.text}")
        if following is not None:
            self.state = following
            self._take(event, data)
        elif not isinstance(event, (messages.Init, messages.Reconnect, messages.ServerParam, messages.Error)):
            self.kept.append(data)
            del self.kept[:-KEPT]

    def _take(self, event: messages.Event, data: bytes) -> None:
        if isinstance(event, messages.Init):
            self.place = event
        elif isinstance(event, messages.Reconnect):
            if self.unum is None:
                raise RemoteProtocolError("the server lets somebody come back who asked for a new place")
            self.place = messages.Init(side=event.side, unum=self.unum, mode=event.mode)
        else:
            self.params = data

    def told(self) -> list[bytes]:
        """Return what a player who has joined takes in before anything else: the parameters, then what was kept.

        Raises
        ------
        LocalProtocolError
            When the player has not joined.
        """
        if self.params is None or not self.joined:
            raise LocalProtocolError(f"{self.team!r} has not joined yet")
        return [self.params, *self.kept]
