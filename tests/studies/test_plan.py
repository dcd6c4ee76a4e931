"""Who is assigned to what: balanced, random, and the same for the same seed."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from rcss_hat.studies.parts import Condition, PeopleStudy
from rcss_hat.studies.people_file import PeopleError, parse_people
from rcss_hat.studies.plan import assigned, plan_of

from .conftest import SMALL


def with_conditions(study: PeopleStudy, n: int, design: str) -> PeopleStudy:
    conditions = tuple(Condition(name=f"c{k}") for k in range(n))
    return msgspec.structs.replace(study, conditions=conditions, design=design)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7])
def test_every_block_has_each_condition_once(small: PeopleStudy, n: int) -> None:
    study = with_conditions(small, n, "between")
    for block in range(5):
        mine = [assigned(study, block * n + k + 1) for k in range(n)]
        assert sorted(mine) == [(f"c{k}",) for k in range(n)]


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_within_subjects_positions_and_neighbours_are_balanced(small: PeopleStudy, n: int) -> None:
    study = with_conditions(small, n, "within")
    rows = {2: 2, 3: 6, 4: 4, 5: 10, 6: 6}[n]
    orders = [assigned(study, k + 1) for k in range(rows)]
    assert len(set(orders)) == rows
    positions = Counter((k, name) for order in orders for k, name in enumerate(order))
    assert set(positions.values()) == {rows // n}
    neighbours = Counter(pair for order in orders for pair in pairwise(order))
    assert len(neighbours) == n * (n - 1)
    assert len(set(neighbours.values())) == 1


def test_blocks_differ_and_the_seed_decides(small: PeopleStudy) -> None:
    first = [assigned(small, k) for k in range(1, 61)]
    assert len({tuple(first[k : k + 3]) for k in range(0, 60, 3)}) > 2
    assert first == [assigned(msgspec.structs.replace(small, participants=99), k) for k in range(1, 61)]
    assert first != [assigned(msgspec.structs.replace(small, seed=6), k) for k in range(1, 61)]


def test_steps_per_condition_are_gone_through_in_the_assigned_order(small: PeopleStudy) -> None:
    study = msgspec.structs.replace(small, design="within")
    names = [planned.name for planned in plan_of(study, 1)]
    order = assigned(study, 1)
    middle = [f"{step}-{name}" for name in order for step in ("play", "load")]
    assert names == ["consent", "practice", *middle, "about", "thanks"]


def test_conditions_change_the_game(small: PeopleStudy) -> None:
    study = msgspec.structs.replace(small, design="within")
    games = {planned.condition: planned.game for planned in plan_of(study, 1) if planned.kept}
    assert games["fast"].speed == 5.0 and games["normal"].speed == 1.0  # type: ignore[union-attr]
    assert games["limited"].actions == (0, 1) and games["normal"].actions == (0, 1, 2)  # type: ignore[union-attr]
    assert len({game.seed for game in games.values()}) == 3  # type: ignore[union-attr]


def test_matches_are_ones_own_or_the_same_for_all(small: PeopleStudy) -> None:
    def seeds(study: PeopleStudy) -> list[int]:
        return [plan_of(study, place)[1].game.seed for place in range(1, 9)]  # type: ignore[union-attr]

    assert len(set(seeds(small))) == 8
    same = msgspec.structs.replace(small, game=msgspec.structs.replace(small.game, seeds="same"))
    assert len(set(seeds(same))) == 1


def test_a_way_can_be_too_long() -> None:
    text = SMALL.read_text().replace("participants = 12", 'participants = 12\ndesign = "within"')
    many = "".join(f'[[condition]]\nname = "c{k}"\n' for k in range(100))
    with pytest.raises(PeopleError, match="200 are the limit"):
        parse_people(text.replace("[[step]]", many + "[[step]]", 1), Path())
