"""Parts of more than one message: numbers, the ball, the marks of players."""

from __future__ import annotations

from rcss_hat.protocol.messages.event import Event, record
from rcss_hat.protocol.messages.groups import Group


@record
class BallState(Event):
    """Position and velocity of the ball."""

    x: float
    y: float
    vx: float
    vy: float

    def to_text(self) -> str:
        """Return ``((b) X Y VX VY)``."""
        return f"((b) {self.x:g} {self.y:g} {self.vx:g} {self.vy:g})"


def read_ball(group: Group) -> BallState:
    """Take ``((b) X Y VX VY)``."""
    entry = group.group()
    entry.group("b").finish()
    ball = BallState(x=entry.number(), y=entry.number(), vx=entry.number(), vy=entry.number())
    entry.finish()
    return ball


def counted(group: Group, *allowed: int) -> list[float]:
    """Take all numbers up to something else; refuse them unless there are so many as allowed."""
    values = group.numbers()
    if len(values) not in allowed:
        group.fail(f"expected {' or '.join(map(str, allowed))} numbers, not {len(values)}")
    return values


def pair(group: Group) -> tuple[float, float]:
    """Take two numbers, and nothing else."""
    first, second = counted(group, 2)
    group.finish()
    return first, second


def marks(entry: Group) -> tuple[str, ...]:
    """Take the marks of a player: t tackling, k kicking, f fouled, r red card, y yellow card."""
    found = []
    while entry.more:
        found.append(entry.word("t", "k", "f", "r", "y"))
    return tuple(found)
