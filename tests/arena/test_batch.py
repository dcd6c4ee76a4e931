"""Batches of matches: independent, decided by one seed, whatever the number of processes."""

from __future__ import annotations

import pytest

from rcss_hat.arena.batch import match_seeds, play_batch
from rcss_hat.arena.match import ArenaMatch
from rcss_hat.hat.policy import PolicyError, load_policy
from rcss_hat.keepaway.task import Task

MATCHES, EPISODES = 3, 2


def test_a_seed_decides_all_matches_and_a_match_can_be_played_again() -> None:
    batch = list(play_batch(Task(), "random", 5, MATCHES, EPISODES))
    assert [match.number for match in batch] == list(range(MATCHES))
    assert [match.seed for match in batch] == match_seeds(5, MATCHES)
    assert list(play_batch(Task(), "random", 5, MATCHES, EPISODES)) == batch
    assert len({match.episodes for match in batch}) == MATCHES
    last = batch[-1]
    again = ArenaMatch(Task(), last.seed, load_policy("random", 3, 2, last.seed))
    assert tuple(e for part in again.advance(episodes=EPISODES) for e in part) == last.episodes
    assert last.cycles == last.episodes[-1].end
    assert list(last.durations_s) == [e.cycles / 10 for e in last.episodes]


@pytest.mark.compiled
def test_worker_processes_play_the_same_matches() -> None:
    alone = list(play_batch(Task(), "hand", 1, MATCHES, EPISODES))
    together = list(play_batch(Task(), "hand", 1, MATCHES, EPISODES, processes=2))
    assert sorted(together, key=lambda match: match.number) == alone


def test_seeds_of_a_batch() -> None:
    assert match_seeds(7, 10)[:4] == match_seeds(7, 4)
    assert len({*match_seeds(7, 50), *match_seeds(8, 50)}) == 100


def test_a_policy_that_does_not_exist_is_an_error_before_anything_is_played() -> None:
    with pytest.raises(PolicyError, match="'nothing' is none of hold, random, hand"):
        next(play_batch(Task(), "nothing", 1, 2, 2))
