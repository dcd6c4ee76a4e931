"""Which episodes count."""

from __future__ import annotations

from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.stage.processes import Mirror
from rcss_hat.stage.tally import NOT_YET, Tally


def heard(*ends: int, first_cycle: int = 0, cycle: int = 0) -> Mirror:
    return Mirror("keepers", first_cycle=first_cycle, cycle=cycle, episodes=[(end, end % 2 == 1) for end in ends])


def test_the_first_match_counts_from_its_kick_off() -> None:
    tally = Tally(heard(30, 71, first_cycle=2, cycle=80), None)
    assert tally.episodes() == [Episode(1, 2, 30, OUT), Episode(2, 30, 71, TAKEN)]
    assert (tally.begun, tally.finished, tally.cycles) == (True, 2, 78)


def test_a_later_match_counts_from_the_first_end_when_everybody_was_there() -> None:
    player = heard(5000, 5001, 5030, 5040, first_cycle=4990, cycle=5050)
    tally = Tally(player, 1)
    tally.after = NOT_YET
    assert (tally.begun, tally.finished, tally.cycles, tally.episodes()) == (False, 0, 0, [])
    tally.after = 5001
    assert tally.episodes() == [Episode(1, 5001, 5030, OUT)]
    assert (tally.begun, tally.finished, tally.cycles) == (True, 2, 49)


def test_episodes_that_end_when_others_have_left_do_not_count() -> None:
    tally = Tally(heard(30, 71, 90, cycle=95), None)
    tally.until = 71
    assert [episode.end for episode in tally.episodes()] == [30, 71]


def test_a_trainer_says_when_the_first_episode_began() -> None:
    tally = Tally(heard(10, 31, cycle=40), None)
    tally.start = 12
    assert tally.episodes() == [Episode(1, 12, 31, TAKEN)]
    assert tally.cycles == 28
