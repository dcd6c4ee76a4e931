"""What a monitor may send, one command per datagram, and how servers read it (19.0.0, src/monitor.cpp)."""

from __future__ import annotations

from typing import Annotated

from rcss_hat.protocol.commands.player import Compression
from rcss_hat.protocol.commands.table import MONITOR, PLAYER, TRAINER, Command, c_text, command
from rcss_hat.protocol.commands.trainer import ChangeMode, CheckBall, Recover, Start, parse_move
from rcss_hat.protocol.commands.values import ILLEGAL_FORM, Refusal, Sixteenths, Unum, side, whole, word

__all__ = ["DispBye", "DispCard", "DispDiscard", "DispFoul", "DispPlayer", "DispStart", "parse_monitor_command"]

Side = Annotated[int, side()]


@command(MONITOR, "(dispstart)")
class DispStart(Command):
    """Kick off."""


@command(MONITOR, "(dispbye)")
class DispBye(Command):
    """Leave."""


@command(MONITOR, "(dispfoul {x} {y} {side})")
class DispFoul(Command):
    """Call a foul at a place (m): free kick for side 1 (left) or -1 (right); 0 drops the ball there."""

    x: Sixteenths
    y: Sixteenths
    side: Annotated[int, side(nobody=True)]


@command(MONITOR, "(dispplayer {side} {unum} {x} {y} {angle})")
class DispPlayer(Command):
    """Place a player of side 1 (left) or -1 (right): metres, and whole degrees of the body."""

    side: Side
    unum: Unum
    x: Sixteenths
    y: Sixteenths
    angle: Annotated[int, whole(-180, 180)]


@command(MONITOR, "(dispdiscard {side} {unum})")
class DispDiscard(Command):
    """Take a player of side 1 (left) or -1 (right) off the field."""

    side: Side
    unum: Unum


@command(MONITOR, "(dispcard {side} {unum} {card})")
class DispCard(Command):
    """Show a player of side 1 (left) or -1 (right) a yellow or red card (server 19)."""

    side: Side
    unum: Unum
    card: Annotated[str, word(("yellow", "red"), conversion="%7[^)]")]


MONITOR.add(*PLAYER.of(Compression))

# --- how servers read them -----------------------------------------------------------------------------------------
_BARE = {form.text: form.record for form in MONITOR.of(DispStart, DispBye)}
_READERS = [(f"({name}", form.reader()) for name, (form, *_) in MONITOR.forms.items() if form.kinds]
_MAY_COACH = TRAINER.of(ChangeMode, Recover, CheckBall)
_COACHES = [
    ("(start)", lambda text: Start()),
    ("(move", parse_move),
    *((f"({form.name}", form.reader()) for form in _MAY_COACH),
]


def parse_monitor_command(data: bytes, coach_mode: bool = False) -> Command | Refusal:
    """Read a monitor's command.

    Parameters
    ----------
    data : bytes
        One datagram.
    coach_mode : bool
        Whether the server allows a trainer; only then monitors may kick off with ``(start)`` and move objects.

    Returns
    -------
    Command or Refusal
        The server sends a refusal as ``(msg TIME 1 "...")``.
    """
    text = c_text(data)
    bare = _BARE.get(text)
    if bare is not None:
        return bare()
    for start, read in [*_READERS, *_COACHES] if coach_mode else _READERS:
        if text.startswith(start):
            return read(text)
    return ILLEGAL_FORM
