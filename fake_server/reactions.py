"""What clients ask of the server: values that it carries out in the order in which a client returns them.

A command that concerns others than the client who sent it, and that may be carried out as it stands, is such a value
itself; where it has first to be found out whom it means, what was found takes its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rcss_hat.protocol.commands import Command


class Reply(NamedTuple):
    """Tell the client something."""

    text: str


class Complaint(NamedTuple):
    """Tell whoever runs the server, on standard error, of something that a client has sent."""

    text: str


class Placement(NamedTuple):
    """Put a player somewhere: metres, degrees, metres per cycle; what is None stays as it is."""

    i: int
    x: float
    y: float
    angle: float | None
    velocity: tuple[float, float] | None


class Substitution(NamedTuple):
    """Give a player another type."""

    i: int
    player_type: int


class Discard(NamedTuple):
    """Take a player out."""

    i: int


class Card(NamedTuple):
    """Show a player a yellow or red card."""

    i: int
    colour: str


class Arrival(NamedTuple):
    """Take the client in.

    Attributes
    ----------
    welcome : sequence of str and bytes
        What he is told: texts, or datagrams as they are.
    news : str
        What whoever runs the server is told.
    data : bytes
        The datagram with which he came.
    """

    welcome: Sequence[str | bytes]
    news: str
    data: bytes


class Datagram(NamedTuple):
    """Let the client react to a datagram that has come to a known port."""

    data: bytes


Reaction = Reply | Complaint | Placement | Substitution | Discard | Card | Arrival | Datagram | Command
Reactions = Sequence[Reaction]
