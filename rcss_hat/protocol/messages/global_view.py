"""What a trainer sees: everything (19.0.0, src/visualsendercoach.cpp, src/serializercoachstdv7 to v14)."""

from __future__ import annotations

from collections.abc import Mapping

from rcss_hat.protocol.messages.event import SIDES, Event, reads, record
from rcss_hat.protocol.messages.groups import Group
from rcss_hat.protocol.messages.parts import BallState, counted, marks, pair, read_ball
from rcss_hat.protocol.records import MAX_PLAYERS

__all__ = ["GlobalPlayer", "SeeGlobal"]


@record
class GlobalPlayer(Event):
    """A player as a trainer sees it; marks as in `FullstatePlayer`."""

    team: str
    unum: int
    goalie: bool
    x: float
    y: float
    vx: float
    vy: float
    body: float
    neck: float
    pointing: float | None
    marks: tuple[str, ...]

    def to_text(self) -> str:
        """Return ``((p "TEAM" UNUM) X Y VX VY BODY NECK POINTING MARKS)``."""
        goalie = " goalie" * self.goalie
        pointing = "" if self.pointing is None else f" {self.pointing:g}"
        place = f"{self.x:g} {self.y:g} {self.vx:g} {self.vy:g} {self.body:g} {self.neck:g}{pointing}"
        return f'((p "{self.team}" {self.unum}{goalie}) {place}{"".join(f" {mark}" for mark in self.marks)})'


@record
class SeeGlobal(Event):
    """What a trainer sees: every cycle, or as the answer to look.

    Attributes
    ----------
    answer : bool
        Whether it answers look.
    goals : dict
        Position of the goals ``"l"`` and ``"r"``.
    """

    time: int
    answer: bool
    goals: Mapping[str, tuple[float, float]]
    ball: BallState
    players: tuple[GlobalPlayer, ...]

    def to_text(self) -> str:
        """Return ``(see_global TIME GOALS BALL PLAYERS)`` or ``(ok look ...)``."""
        goals = [f"((g {side}) {x:g} {y:g})" for side, (x, y) in self.goals.items()]
        objects = [*goals, self.ball.to_text(), *[player.to_text() for player in self.players]]
        return f"({'ok look' if self.answer else 'see_global'} {self.time} {' '.join(objects)})"


@reads("see_global")
def _see_global(group: Group) -> Event:
    return _global(group, answer=False)


@reads("ok look")
def _ok_look(group: Group) -> Event:
    return _global(group, answer=True)


def _global(group: Group, answer: bool) -> Event:
    time = group.integer()
    goals = {}
    for _ in SIDES:
        entry = group.group()
        goal = entry.group("g")
        goals[goal.word(*SIDES)] = pair(entry)
        goal.finish()
    ball = read_ball(group)
    players = tuple(_global_player(group.group()) for _ in range(len(group.items) - group.next))
    return SeeGlobal(time=time, answer=answer, goals=goals, ball=ball, players=players)


def _global_player(entry: Group) -> GlobalPlayer:
    name = entry.group("p")
    team, unum = name.text(), name.integer(1, MAX_PLAYERS)
    goalie = name.more and name.word("goalie") == "goalie"
    name.finish()
    x, y, vx, vy, body, neck, *pointing = counted(entry, 6, 7)
    return GlobalPlayer(
        team=team,
        unum=unum,
        goalie=goalie,
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        body=body,
        neck=neck,
        pointing=pointing[0] if pointing else None,
        marks=marks(entry),
    )
