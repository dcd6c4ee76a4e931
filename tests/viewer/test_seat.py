from __future__ import annotations

import pytest

from rcss_hat.viewer.seat import FREE, LEFT, PLAYER, TAKEN, WATCHER, Seat, Visitor


@pytest.fixture
def seat() -> Seat:
    return Seat()


def test_the_first_browser_has_the_seat(seat: Seat) -> None:
    assert seat.state == FREE
    first, second = Visitor("a"), Visitor("b")
    seat.enter(first)
    seat.enter(second)
    assert (seat.role(first), seat.role(second), seat.state) == (PLAYER, WATCHER, TAKEN)
    assert not seat.take("b") and seat.owner == "a"


def test_who_does_not_look_can_be_replaced(seat: Seat) -> None:
    first, again, second = Visitor("a"), Visitor("a"), Visitor("b")
    for visitor in (first, again, second):
        seat.enter(visitor)
    first.looking = False
    assert seat.state == TAKEN, "another page of this browser is seen"
    again.looking = False
    assert (seat.state, seat.occupied, seat.looking) == (LEFT, True, False)
    assert seat.take("b") and seat.role(second) == PLAYER and seat.role(first) == WATCHER
    assert not seat.take("a")


def test_a_seat_is_kept_until_it_is_given_up(seat: Seat) -> None:
    first, second = Visitor("a"), Visitor("b")
    seat.enter(first)
    assert not seat.give_up(), "somebody sits there"
    seat.leave(first)
    seat.enter(second)
    assert (seat.state, seat.role(second)) == (LEFT, WATCHER)
    assert seat.give_up() and seat.state == FREE
    assert seat.role(second) == WATCHER, "who only watched is not seated without asking"
    assert seat.take("b") and seat.role(second) == PLAYER


def test_who_comes_to_a_free_seat_gets_it(seat: Seat) -> None:
    first = Visitor("a")
    seat.enter(first)
    seat.leave(first)
    assert seat.give_up() and not seat.give_up()
    second = Visitor("b")
    seat.enter(second)
    assert seat.role(second) == PLAYER
