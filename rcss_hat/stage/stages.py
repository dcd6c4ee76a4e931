"""One stage for everything that plays: opened from a place, a task, a seed and a policy, wherever it is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

from numpy.typing import NDArray

from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.keepaway.decision import OnDecision, OnFrame
from rcss_hat.keepaway.report import Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.aside import aside
from rcss_hat.stage.place import ARENA, Address, Place
from rcss_hat.stage.terms import Terms

OnEpisodes = Callable[[Sequence[Episode], int], bool | None]
"""Told (episodes that have ended since it was told last, cycles of this match so far); true ends the match."""


@dataclass(frozen=True, slots=True)
class Part:
    """What of a match is to be played, and who is told what happens in it.

    Attributes
    ----------
    episodes, cycles : int, optional
        Enough: so many of this match. A server's match ends with an episode. None: no such limit.
    on_episodes : callable, optional
        See `OnEpisodes`. In the arena it is told once per simulated hour, elsewhere after every episode.
    on_decision : callable, optional
        Told every decision of the keepers: all those of an episode before its end is told.
    on_frame : callable, optional
        Told what there is to see in every cycle, before the decisions of that cycle; a record of
        `rcss_hat.arena.records.FRAME`. Not on servers: who wants to see a match there connects as a monitor.

    Examples
    --------
    >>> from rcss_hat import Part
    >>> Part(episodes=10).cycles is None
    True
    """

    episodes: int | None = None
    cycles: int | None = None
    on_episodes: OnEpisodes | None = None
    on_decision: OnDecision | None = None
    on_frame: OnFrame | None = None


class Stage(ABC):
    """A match that can be played; a context manager, which puts away what the match needed.

    Attributes
    ----------
    report : RunReport
        What happened.
    waits : bool
        Whether the match stands still between two calls of `play`.
    """

    waits = False

    def __init__(self, place: Place, task: Task, seed: int, policy: TeamPolicy | None, terms: Terms) -> None:
        self.place, self.task, self.seed, self.policy, self.terms = place, task, seed, policy, terms
        referee = "server" if terms.trainer is None else "trainer"
        keepers, takers = policy.spec if policy else "-", getattr(terms.orders, "spec", "hand")
        self.report = RunReport.of(str(place), keepers, task, seed, takers, referee)

    @abstractmethod
    def play(self, part: Part) -> RunReport:
        """Play; whatever ends the match early, Ctrl-C as well, is the report's failure.

        Raises
        ------
        ValueError
            When this cannot be played here.
        """

    async def run(self, part: Part) -> RunReport:
        """Play beside an event loop that runs already; see `play`. To be cancelled is to be interrupted."""
        return await aside(self.play, part)

    def play_matches(self, matches: int, jobs: int, episodes: int, told: Callable[[int], object]) -> RunReport:
        """Play a batch of matches; the report's episodes are in the order of the matches.

        Parameters
        ----------
        matches, jobs : int
            How many matches, and how many at a time.
        episodes : int
            Of each match.
        told : callable
            Told how many matches have ended.

        Raises
        ------
        ValueError
            Where there can be but one match.
        """
        raise ValueError(f"many matches are played in the arena, not on {self.place}")

    @property
    def address(self) -> Address | None:
        """Where monitors can watch; None where no server is."""
        return None

    @property
    def cycle(self) -> int:
        """Cycles of this match that were played before; 0 unless `restore` brought it to another."""
        return 0

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything of a match that changes, so that `restore` can go on there; empty where that cannot be."""
        return {}

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:  # noqa: B027 (servers cannot)
        """Go back to what `arrays` returned."""

    def close(self) -> None:  # noqa: B027 (the arena has nothing to put away)
        """Put away what the match needed."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def open_stage(place: Place, task: Task, seed: int, policy: TeamPolicy | None, terms: Terms | None = None) -> Stage:
    """Open a stage; the match begins with `Stage.play`.

    Parameters
    ----------
    place : Place
    task : Task
    seed : int
        In the arena and on the fake server the same seed is the same match.
    policy : TeamPolicy or None
        Of the keepers; a function in Python by `rcss_hat.hat.policy.python_policy`. None: they are somebody else's.
    terms : Terms, optional

    Raises
    ------
    ValueError
        When the terms make no sense there.
    ServerFailed
        When there is no server to start.

    Examples
    --------
    >>> from rcss_hat import Part, Place, Task, load_policy, open_stage
    >>> decisions = []
    >>> with open_stage(Place.parse("arena"), Task(), 1, load_policy("hand", 3, 2, seed=1)) as stage:
    ...     report = stage.play(Part(episodes=2, on_decision=decisions.append))
    >>> len(report.episodes), len(decisions[0].state)
    (2, 13)
    """
    # Imported here, for the arena's loop takes long to import and servers do without, and the other way round.
    if place.name == ARENA:
        from rcss_hat.stage.in_arena import ArenaStage

        return ArenaStage(place, task, seed, policy, terms or Terms())
    from rcss_hat.stage.on_server import ServerStage

    return ServerStage(place, task, seed, policy, terms or Terms())
