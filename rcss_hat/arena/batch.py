"""Many independent matches from one seed, in worker processes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.system.workers import in_parallel


@dataclass(frozen=True, slots=True)
class MatchResult:
    """What came of one match of a batch.

    Attributes
    ----------
    number : int
        Place in the batch, from 0.
    seed : int
        `ArenaMatch` with this seed plays the match again.
    cycles : int
    episodes : tuple of Episode
    """

    number: int
    seed: int
    cycles: int
    episodes: tuple[Episode, ...]

    @property
    def durations_s(self) -> NDArray[np.float64]:
        """Durations of its episodes (s)."""
        return np.array([e.cycles for e in self.episodes]) / 10.0


def match_seeds(seed: int, matches: int) -> list[int]:
    """Seeds of the matches of a batch; a longer batch begins with those of a shorter one."""
    return [derived_seed(seed, number) for number in range(matches)]


def play_batch(
    task: Task, policy: str, seed: int, matches: int, episodes: int, processes: int = 1
) -> Iterator[MatchResult]:
    """Play independent matches.

    Parameters
    ----------
    task : Task
    policy : str
        Of the keepers, as `rcss_hat.hat.policy.load_policy` takes it.
    seed : int
        Decides all matches, whatever the number of processes.
    matches, episodes : int
        Episodes are per match.
    processes : int

    Yields
    ------
    MatchResult
        As they are finished, in any order.

    Raises
    ------
    PolicyError
        When there is no such policy; before anything is played.
    """
    load_policy(policy, task.keepers, task.takers, seed, task)
    seeds = match_seeds(seed, matches)
    if processes == 1 or matches == 1:
        yield from (_play(task, policy, number, own, episodes) for number, own in enumerate(seeds))
        return
    _play(task, policy, 0, seeds[0], 1)  # compiles once, here
    work = ((task, policy, number, own, episodes) for number, own in enumerate(seeds))
    yield from in_parallel(_play, work, processes)


def _play(task: Task, policy: str, number: int, seed: int, episodes: int) -> MatchResult:
    match = ArenaMatch(task, seed, load_policy(policy, task.keepers, task.takers, seed, task))
    played = [episode for part in match.advance(episodes=episodes) for episode in part]
    return MatchResult(number, seed, match.cycle, tuple(played))
