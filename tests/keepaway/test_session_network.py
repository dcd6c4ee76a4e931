"""A player behind a network that loses, doubles and reorders."""

from __future__ import annotations

import pytest

from rcss_hat.keepaway.endings import Endings
from rcss_hat.keepaway.patience import KEPT, KEPT_BYTES, OVERDUE, SILENT
from rcss_hat.keepaway.session import DONE, KeepawayPlayer
from rcss_hat.keepaway.whereabouts import Whereabouts
from rcss_hat.protocol import messages

pytestmark = pytest.mark.compiled
PARAMS = b"(server_param (synch_mode 1)(visible_angle 360))\0"
PLAY_ON = b"(hear 0 referee play_on)\0"
THINK = b"(think)\0"


def sense(cycle: int) -> bytes:
    return b"(sense_body %d (view_mode high normal) (stamina 8000 1) (speed 0 0) (head_angle 0))\0" % cycle


def see(cycle: int) -> bytes:
    return b"(see %d ((f c) 10 0) ((b) 5 3))\0" % cycle


def end(cycle: int) -> bytes:
    return b"(hear %d referee training Keepaway 1)\0" % cycle


def joined(endings: Endings | None = None) -> KeepawayPlayer:
    player = KeepawayPlayer("keepers", 3, 2, 1, lambda *_: 0, endings=endings)
    player.initialised(messages.Init(side="l", unum=1, mode="before_kick_off"))
    player.receive(PARAMS)
    return player


def playing(cycles: int, endings: Endings | None = None) -> KeepawayPlayer:
    """A player who has played so many cycles on a good network."""
    player = joined(endings)
    told(player, sense(0), see(0), THINK, PLAY_ON)
    for cycle in range(1, cycles + 1):
        told(player, sense(cycle), see(cycle), THINK)
    assert (player.cycle, player.missed, player.troubled, player.wait()) == (cycles, 0, False, None)
    return player


def told(player: KeepawayPlayer, *datagrams: bytes) -> list[bytes]:
    return [answer for data in datagrams for answer in player.receive(data)]


def test_a_player_answers_once_however_often_it_is_asked() -> None:
    player = playing(3)
    answers = told(player, sense(4), see(4), THINK, THINK, THINK)
    assert len(answers) == 1 and answers[0].endswith(DONE)
    assert told(player, sense(4), see(4), THINK) == []
    assert player.missed == 0


def test_messages_that_come_twice_or_late_change_nothing() -> None:
    plain, doubled = playing(3), playing(3)
    for cycle in range(4, 9):
        expected = told(plain, sense(cycle), see(cycle), THINK)
        got = told(doubled, sense(cycle), sense(cycle), see(cycle), see(cycle), sense(cycle - 1), see(cycle - 2), THINK)
        assert got == expected
        told(doubled, sense(cycle), see(cycle), PLAY_ON, PARAMS)
    assert (doubled.cycle, doubled.missed, doubled.first_cycle) == (8, 0, 0)


def test_the_end_of_an_episode_counts_once() -> None:
    player = playing(8)
    told(player, end(9), end(9), sense(9), end(9), THINK, sense(10), end(9), THINK)
    assert [cycle for cycle, _ in player.episodes] == [9]
    told(player, end(20), sense(20), THINK, end(15))
    assert [cycle for cycle, _ in player.episodes] == [9, 15, 20], "one that was overtaken is filed in its place"


def test_an_end_that_one_was_not_told_of_is_learnt_from_a_team_mate() -> None:
    endings = Endings()
    deaf, hearing = playing(8, endings), playing(8, endings)
    told(hearing, end(9))
    told(deaf, see(8))
    assert deaf.episodes == [], "its own message may be under way"
    told(deaf, sense(9))
    assert [cycle for cycle, _ in deaf.episodes] == [9]
    told(deaf, end(9), THINK)
    assert len(deaf.episodes) == 1 and endings.cycles == [9]


def test_a_kick_off_that_one_was_not_told_of_shows_in_the_cycles() -> None:
    player = joined()
    told(player, sense(0), THINK, sense(0), THINK)
    assert not player.playing
    told(player, sense(1))
    assert player.playing and player.first_cycle == 0
    assert told(player, THINK)[-1].endswith(DONE)


def test_a_later_match_begins_where_time_stood() -> None:
    player = joined()
    told(player, sense(700), THINK, sense(700), THINK, sense(701))
    assert player.first_cycle == 700


def test_cycles_that_were_lost_are_counted() -> None:
    player = playing(3)
    told(player, sense(7), THINK)
    assert player.missed == 3  # 4, 5, 6
    told(player, sense(8), sense(9))
    assert player.missed == 4


def test_who_was_not_asked_answers_after_silence() -> None:
    player = playing(3)
    told(player, sense(4), sense(4))  # one sees that the network makes mistakes
    assert player.wait() == SILENT
    answers = player.deadline()
    assert len(answers) == 1 and answers[0].endswith(DONE)
    assert player.deadline() == [DONE], "the answer may have been lost"
    told(player, sense(5))
    assert player.missed == 0


def test_a_request_that_overtook_the_cycle_is_answered_soon() -> None:
    player = playing(3)
    assert told(player, THINK) == []  # of cycle 4, or of 3 again
    told(player, sense(4))
    assert player.wait() == OVERDUE
    assert player.deadline()[-1].endswith(DONE)


def test_words_of_a_cycle_that_is_over_are_not_heard_again() -> None:
    player = playing(3)
    words = b'(hear 4 90 our 2 "0GI")\0'
    told(player, sense(4), words, THINK, words)
    assert player._heard["time"][0] == -1


def test_messages_that_a_player_does_not_know_are_counted_and_few_are_kept() -> None:
    player = playing(1)
    for number in range(1000):
        told(player, b"(nonsense %d %s)\0" % (number, b"x" * 60_000))
    assert player.unknown == 1000
    assert len(player.odd) == KEPT
    assert sum(map(len, player.odd)) <= KEPT * KEPT_BYTES


def test_a_clock_that_was_set_back_is_believed() -> None:
    player = playing(3)
    told(player, sense(50_000), THINK)
    assert told(player, sense(4), see(4), THINK)[-1].endswith(DONE)
    assert player.cycle == 4


def test_a_number_is_found_only_by_sight() -> None:
    where = Whereabouts("keepers")
    assert where.unum(sense(0)) is None
    assert where.unum(b"(see 0)\0") is None
    assert where.unum(b"(see 0 ((f c) 12.4 -15) ((f c t) 30 20))\0") is None, "not beside the pitch"
