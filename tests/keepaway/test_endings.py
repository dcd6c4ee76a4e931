"""The ledger of episode ends: each once, and whether one is missing."""

from __future__ import annotations

import pytest

from rcss_hat.keepaway.agent import new_agent
from rcss_hat.keepaway.endings import Endings
from rcss_hat.keepaway.moved import NEVER, forget_sightings, new_sightings, somebody_was_moved
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import HAS_DISTANCE, LEFT, OTHER_TEAM, PLAYER, SEE, empty


def test_an_end_counts_once_and_in_its_place() -> None:
    endings = Endings()
    for cycle, taken in ((50, True), (20, False), (50, False)):
        endings.add(cycle, taken)
    assert endings.cycles == [20, 50]
    assert endings.taken(50) and not endings.taken(20)


@pytest.mark.parametrize("end", [18, 20, 21, 23, 25])
def test_a_move_that_an_end_explains_is_nothing(end: int) -> None:
    endings = Endings()
    endings.add(end, True)
    endings.suspect(19, 22)
    assert endings.suspected == [] == endings.unheard()


def test_a_late_word_explains_what_was_seen() -> None:
    endings = Endings()
    endings.suspect(19, 21)
    assert endings.unheard() == [(19, 21)]
    endings.add(20, False)
    assert endings.unheard() == []


def test_a_dropped_ball_explains_why_players_were_moved() -> None:
    """Also to those who were not told of it."""
    saw, heard = Endings(), Endings()
    heard.drop(100)
    heard.suspect(99, 101)
    assert heard.unheard() == [] and heard.cycles == []
    saw.suspect(99, 101)
    saw.suspect(150, 151)
    assert saw.unheard() == [(99, 101), (150, 151)]
    saw.learn(heard.evidence())
    saw.learn(([(150, 152)], [100]))
    assert saw.unheard() == [(150, 151)] and saw.dropped == [100]


def test_what_several_saw_is_one_end() -> None:
    endings = Endings()
    for span in ((19, 22), (20, 21), (20, 21), (40, 42), (41, 43)):
        endings.suspect(*span)
    assert endings.unheard() == [(20, 21), (41, 42)]


def looks(places: list[tuple[int, int, float, float]], forget: bool = False) -> list[int]:
    """Let a keeper, at the origin, see a player (slot 0: himself) in some cycles, and say whether he was moved."""
    record = ServerParams().record()
    agent, sightings, seen = new_agent(LEFT, 1, 3, 2, record, 1), new_sightings(), empty(SEE)
    said = []
    for cycle, slot, x, y in places:
        agent["see_time"] = seen["time"][0] = cycle
        agent["player_see_pos"][0, slot] = x, y
        seen["n"] = 1 if slot else 0
        seen["code"][0, 0], seen["fields"][0, 0] = PLAYER, HAS_DISTANCE
        seen["team"][0, 0], seen["unum"][0, 0] = OTHER_TEAM, slot - 10 if slot else 0
        said.append(int(somebody_was_moved(agent, record, seen, sightings)))
        if forget:
            forget_sightings(sightings)
    return said


MOVES = [
    (1.2, 1, 0, False),
    (2.0, 1, 0, False),
    (3.0, 1, 0, True),
    (3.0, 2, 0, False),
    (14.0, 1, 12, True),
    (14.0, 12, 12, False),
    (3.5, 1, 12, False),
]


@pytest.mark.parametrize(("way", "cycles", "slot", "moved"), MOVES)
def test_who_is_farther_away_than_anybody_runs_was_moved(way: float, cycles: int, slot: int, moved: bool) -> None:
    y = 8.0 if slot else 0.0
    said = looks([(10, slot, 0.0, y), (10 + cycles, slot, way, y), (11 + cycles, slot, way, y)])
    assert said == [NEVER, 10 if moved else NEVER, NEVER]


def test_who_begins_anew_remembers_nobody() -> None:
    assert looks([(10, 0, 0.0, 0.0), (11, 0, 20.0, 0.0)], forget=True) == [NEVER, NEVER]
