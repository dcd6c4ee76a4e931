"""The keys of a person that become decisions of keepers; no sockets, clocks or files.

With no key the keeper with the ball holds it, as in the paper. A key is an intention: it is taken up by whichever
keeper has the ball at his next decision, within one cycle. An intention lives as long as the possession in which the
key was pressed; when nobody had the ball, it waits some cycles for the next keeper who gets it, and then lapses, so
that a second press for a pass already on its way does not make the receiver pass at once.

A number is an action: 1 is PASS1, to whomever the keeper takes for the nearest. An arrow or a click means a team mate;
which action that is follows from the order in which the keeper sees its team mates when it decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rcss_hat.viewer.frames import Frame, Player
from rcss_hat.viewer.situation import around, believed_mates

HOLD = 0
GRACE = 5
"""Cycles that an intention waits for somebody to get the ball."""
SHOWN = 8
"""Cycles for which people are shown that a key came too late."""


@dataclass(frozen=True, slots=True)
class Press:
    """A key pressed for a pass.

    Attributes
    ----------
    action : int
    mate : str or None
        Whom the person meant, when he meant somebody and not a number.
    cycle : int
        The newest cycle the person could see.
    holder : str or None
        Who had the ball then.
    at : float or None
        Milliseconds by the page's clock, where it told them.
    """

    action: int
    mate: str | None
    cycle: int
    holder: str | None
    at: float | None = None


PLAYED, LAPSED, REPEATED, REPLACED, TAKEN_BACK, HELD, REFUSED = (
    "played", "lapsed", "repeated", "replaced", "taken back", "hold", "refused",
)  # fmt: skip
"""What becomes of a key: a keeper took it up; nobody did in time; it was pressed again for a pass that was played;
another key came after it; so did Hold; it was Hold itself; there is no such pass."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a key.

    Attributes
    ----------
    press : Press
    fate : str
        One of those above.
    cycle : int
        When that was known.
    """

    press: Press
    fate: str
    cycle: int


class KeyChannel:
    """Between the keys and the keeper with the ball.

    Parameters
    ----------
    actions : sequence of int
        Actions a person may choose; Hold, 0, is always among them.
    grace : int
        Cycles that an intention waits while nobody has the ball.

    Attributes
    ----------
    pending : Press or None
        What no keeper has taken up yet.
    taken : (int, int) or None
        Cycle and action of the last pass that a key started.
    lapsed : (int, int) or None
        Cycle and action of the last key that came too late: nobody took it up.
    presses : int
        How many keys were pressed.
    on_fate : callable or None
        Told what became of every key, once that is known.
    """

    def __init__(self, actions: Sequence[int] = (0, 1, 2), grace: int = GRACE) -> None:
        if not all(isinstance(a, int) and a >= 0 for a in actions) or not any(actions):
            raise ValueError(f"actions are Hold (0) and at least one pass (1, 2, ...), not {list(actions)}")
        self.actions = tuple(sorted({HOLD, *actions}))
        self.grace = grace
        self.pending: Press | None = None
        self.taken: tuple[int, int] | None = None
        self.lapsed: tuple[int, int] | None = None
        self.presses = 0
        self.on_fate: Callable[[Fate], None] | None = None
        self._cycle = 0
        self._holder: str | None = None
        self._mates: dict[str, int] = {}
        self._players: list[dict[str, Any]] = []

    def press(self, action: int, at: float | None = None) -> bool:
        """Ask for an action; Hold takes back what was asked for.

        Parameters
        ----------
        action : int
        at : float, optional
            Milliseconds by the page's clock.

        Returns
        -------
        bool
            Whether this action may be chosen.
        """
        press = Press(action, None, self._cycle, self._holder, at)
        if action not in self.actions:
            self._became(press, REFUSED)
            return False
        self.presses += 1
        if action == HOLD:
            self._instead(None, TAKEN_BACK)
            self._became(press, HELD)
        else:
            self._instead(press, REPLACED)
        return True

    def press_mate(self, mate: str, at: float | None = None) -> bool:
        """Ask for a pass to a team mate (id such as ``l2``)."""
        if mate not in self._mates:
            self._became(Press(HOLD, mate, self._cycle, self._holder, at), REFUSED)
            return False
        self.presses += 1
        self._instead(Press(self._mates[mate], mate, self._cycle, self._holder, at), REPLACED)
        return True

    def release(self) -> None:
        """Forget what was asked for: somebody else decides from now on."""
        self._instead(None, TAKEN_BACK)

    def _instead(self, press: Press | None, fate: str) -> None:
        """Put a key in the place of the one that nobody has taken up yet."""
        before, self.pending = self.pending, press
        if before is not None:
            self._became(before, fate)

    def _became(self, press: Press, fate: str, cycle: int | None = None) -> None:
        if self.on_fate is not None:
            self.on_fate(Fate(press, fate, self._cycle if cycle is None else cycle))

    def observe(self, frame: Frame) -> None:
        """Take the newest frame; what the person can choose and has asked for is written into it."""
        keepers = frame["keepers"] or []
        holder = frame["holder"] if frame["holder"] in keepers else None
        frame["choices"] = [c for c in frame["choices"] if c["action"] in self.actions]
        self._mates = {c["mate"]: c["action"] for c in frame["choices"]}
        self._cycle, self._holder, self._players = frame["time"], holder, frame["players"]
        press = self.pending
        if press is not None:
            lost = press.holder is not None and holder != press.holder
            late = press.holder is None and self._cycle - press.cycle > self.grace
            if lost or late:
                repeats = self._repeats(press)
                self._instead(None, REPEATED if repeats else LAPSED)
                if not repeats:
                    self.lapsed = (self._cycle, press.action)
        frame["pending"] = self.pending.action if self.pending is not None else None
        lapsed = self.lapsed
        frame["lapsed"] = lapsed[1] if lapsed is not None and 0 <= self._cycle - lapsed[0] < SHOWN else None

    def _repeats(self, press: Press) -> bool:
        """Tell whether a key was pressed twice for one pass, which was played."""
        taken = self.taken
        return taken is not None and taken[1] == press.action and 0 <= press.cycle - taken[0] <= self.grace

    def take(self, keeper: int, cycle: int, state: Sequence[float]) -> int:
        """Choose for a keeper (uniform number) who has the ball, at his decision point.

        Parameters
        ----------
        keeper, cycle : int
        state : sequence of float
            State variables as this keeper perceives them.

        Returns
        -------
        int
            What was asked for, which is thereby taken up; Hold when nothing was, or when it was meant for another.
        """
        press = self.pending
        if press is None:
            return HOLD
        if press.holder is None:
            mine = cycle - press.cycle <= self.grace
        else:
            mine = press.holder == f"l{keeper}"
        if not mine:
            return HOLD
        self.pending = None
        action = press.action if press.mate is None else self._action_to(press.mate, keeper, state, press.action)
        if action != HOLD:
            self.taken = (cycle, action)
        self._became(press, PLAYED if action != HOLD else LAPSED, cycle)
        return action

    def _action_to(self, mate: str, keeper: int, state: Sequence[float], otherwise: int) -> int:
        """Action with which a keeper passes to a team mate; Hold when that is the keeper himself."""
        players = [Player.from_dict(p) for p in self._players]
        me = next((p for p in players if p.id == f"l{keeper}"), None)
        if me is None or mate == me.id:
            return HOLD
        mates = believed_mates(around(me, players, None), state)
        action = mates.index(mate) + 1 if mate in mates else otherwise
        return action if action in self.actions else otherwise
