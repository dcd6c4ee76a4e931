"""From snapshots to frames: adds what a snapshot means and what the keepers are known to think."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rcss_hat.keepaway.decision import Decision, action_name
from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer.episodes import EpisodeTracker
from rcss_hat.viewer.frames import Choice, Frame, Setup, Snapshot
from rcss_hat.viewer.situation import Situation, arrow_keys, believed_mates, situation, state_variables

Values = Callable[[int, Sequence[float]], Sequence[float] | None]
"""Q-values of a keeper: (uniform number, state variables) -> one value per action, or None."""
_FRESH = 2
"""A thought is shown for so many cycles; the frame of a cycle comes before the decisions of that cycle."""


class Insight:
    """What is known of the keepers' minds, from whoever runs them in this process.

    Parameters
    ----------
    values : callable, optional
        Q-values, where keepers have any.
    """

    def __init__(self, values: Values | None = None) -> None:
        self.values = values
        self._thoughts: dict[int, Decision] = {}

    def decided(self, decision: Decision) -> None:
        """Take note of a decision."""
        self._thoughts[decision.keeper] = decision

    def thought(self, keeper: int, time: int) -> Decision | None:
        """Return what a keeper thought just before a cycle, or None when that is too long ago."""
        thought = self._thoughts.get(keeper)
        return thought if thought is not None and 0 <= time - thought.cycle <= _FRESH else None


def make_frame(
    snapshot: Snapshot,
    setup: Setup,
    episode: int,
    start: int,
    thought: Callable[[int, int], Decision | None] | None = None,
    values: Values | None = None,
) -> Frame:
    """Make the frame of a snapshot.

    Parameters
    ----------
    snapshot : Snapshot
    setup : Setup
    episode, start : int
        Number and first cycle of the running episode.
    thought : callable, optional
        (uniform number, cycle) -> what that keeper thinks.
    values : callable, optional
        Q-values.
    """
    here = situation(snapshot, setup)
    frame: Frame = {
        "time": snapshot.time,
        "mode": snapshot.mode,
        "ball": [round(v, 4) for v in snapshot.ball],
        "players": [p.to_dict() for p in snapshot.players],
        "holder": here.holder.id if here.holder else None,
        "keepers": None,
        "takers": None,
        "state": None,
        "seen": False,
        "values": None,
        "action": None,
        "episode": episode,
        "start": start,
        "choices": [],
        "score": None if setup.keepaway or snapshot.score is None else list(snapshot.score),
        "pending": None,
        "lapsed": None,
    }
    if setup.keepaway and here.keepers:
        _add_keepaway(frame, snapshot, here, thought, values)
    return frame


def _add_keepaway(
    frame: Frame,
    snapshot: Snapshot,
    here: Situation,
    thought: Callable[[int, int], Decision | None] | None,
    values: Values | None,
) -> None:
    frame["keepers"] = [p.id for p in here.keepers]
    frame["takers"] = [p.id for p in here.takers]
    k1 = here.keepers[0]
    known = thought(k1.unum, snapshot.time) if thought is not None else None
    frame["choices"] = choices(here, known)
    state: Sequence[float] | None = known.state if known is not None else state_variables(here)
    if known is not None:
        frame["seen"], frame["action"] = True, known.action
    if state is not None:
        frame["state"] = [round(v, 2) for v in state]
        found = values(k1.unum, state) if values is not None else None
        frame["values"] = None if found is None else [round(float(v), 3) for v in found]


def choices(here: Situation, thought: Decision | None = None) -> list[Choice]:
    """List the passes that K1 can play, in the order in which K1 itself sees its team mates where that is known."""
    arrows = arrow_keys(here)
    mates = [mate.id for mate in here.mates] if thought is None else believed_mates(here, thought.state)
    return [
        {"action": k, "name": action_name(k), "mate": mate, "arrow": arrows.get(mate)}
        for k, mate in enumerate(mates, 1)
    ]


class Narrator:
    """Makes the frames of a running match and keeps its episodes.

    Parameters
    ----------
    setup : Setup
    insight : Insight, optional

    Attributes
    ----------
    episodes : list of Episode
        Those that ended and whose begin was seen.
    """

    def __init__(self, setup: Setup, insight: Insight | None = None) -> None:
        self.setup, self.insight = setup, insight
        self.episodes: list[Episode] = []
        self._tracker = EpisodeTracker(setup)

    def tell(self, snapshot: Snapshot) -> tuple[Frame, Episode | None]:
        """Take the next snapshot; returns its frame, and the episode that ended with it."""
        ended = self._tracker.see(snapshot)
        if ended is not None:
            self.episodes.append(ended)
        insight = self.insight
        thought, values = (insight.thought, insight.values) if insight is not None else (None, None)
        return make_frame(snapshot, self.setup, self._tracker.number, self._tracker.start, thought, values), ended
