"""Who is on a server: what frames show, and what is made of it."""

from __future__ import annotations

import struct

import pytest

from rcss_hat.keepaway.task import Task
from rcss_hat.stage.survey import Look, WrongServer, is_untouched, look_at, refuse_unfit, seat_is_known

TASK = Task()
BOTH, ONLY_KEEPERS, ONLY_TAKERS = (True, True), (True, False), (False, True)
NAMES = ("keepers", "takers")
NOTHING = "0 0 0 0 0 0 0 0 0 0 0"
MOVED = "0 3 1 0 0 0 0 0 0 0 0"


def player(side: str, unum: int, state: str, counts: str) -> str:
    place = "-3 -37 0 0 0 0 (v h 90) (s 8000 1 1 130600)"
    return f"(({side} {unum}) 0 {state} {place} (f {side} 2) (c {counts}))"


def frame(mode: int, cycle: int, names: str, *players: str) -> bytes:
    return f"(show {cycle} (pm {mode}) (tm {names} 0 0) ((b) 0 0 0 0) {' '.join(players)})\0".encode()


def numbers(*unums: int) -> frozenset[int]:
    return frozenset(unums)


def look(
    cycle: int = 0,
    mode: str = "before_kick_off",
    names: tuple[str, str] = ("", ""),
    present: tuple[int, int] = (0, 0),
    bodies: tuple[int, int] | None = None,
) -> Look:
    """A look at so many players of both sides, numbered from 1."""

    def both(sizes: tuple[int, int]) -> tuple[frozenset[int], frozenset[int]]:
        return numbers(*range(1, sizes[0] + 1)), numbers(*range(1, sizes[1] + 1))

    return Look(cycle, mode, names, both(present), both(present if bodies is None else bodies))


def test_a_frame_tells_mode_names_players_and_who_was_there() -> None:
    shown = look_at(
        frame(
            3,
            117,
            "keepers takers",
            player("l", 1, "0x1", NOTHING),
            player("l", 2, "0", MOVED),
            player("l", 3, "0", NOTHING),
            player("r", 1, "0x9", MOVED),
        )
    )
    assert shown == Look(117, "play_on", NAMES, (numbers(1), numbers(1)), (numbers(1, 2), numbers(1)))
    assert shown.counts == (1, 1)


def test_a_fresh_server_has_no_teams() -> None:
    shown = look_at(frame(1, 0, "null null", player("l", 1, "0", NOTHING)))
    assert shown == look()
    assert shown is not None and is_untouched(shown)


def test_an_old_frame_tells_the_same() -> None:
    entries = [(1, 1, n + 1) for n in range(3)] + [(0, 1, n) for n in range(4, 12)]
    entries += [(1, -1, n + 1) for n in range(2)] + [(0, -1, n) for n in range(3, 12)]
    head = b"\0\1" + bytes([3, 0]) + b"keepers".ljust(18, b"\0") + b"takers".ljust(18, b"\0") + bytes(12)
    players = b"".join(struct.pack(">3h6x", *entry) for entry in entries)
    data = (head + players + struct.pack(">h", 250)).ljust(2052, b"\0")
    assert look_at(data) == look(250, "play_on", NAMES, (3, 2))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"(show",
        b"(show x (pm 3))",
        b"(show 1 (pm 99) ",
        b"(server_param (port 1))",
        b"\0\1",
        b"\0\2" + bytes(2050),
    ],
)
def test_what_is_no_frame_shows_nothing(data: bytes) -> None:
    assert look_at(data) is None


GOOD = {
    "fresh": (look(), BOTH),
    "our match, left": (look(500, "play_on", NAMES, (0, 0), (3, 2)), BOTH),
    "keepers left, takers to come": (look(500, "play_on", NAMES, (0, 2), (3, 2)), ONLY_KEEPERS),
    "takers join keepers": (look(0, "before_kick_off", ("keepers", ""), (3, 0)), ONLY_TAKERS),
    "takers come back to keepers": (look(500, "free_kick_l", NAMES, (3, 0), (3, 2)), ONLY_TAKERS),
    "half time, all left": (look(3000, "before_kick_off", NAMES, (0, 0), (3, 2)), BOTH),
}


@pytest.mark.parametrize("name", GOOD)
def test_what_fits_is_joined(name: str) -> None:
    shown, ours = GOOD[name]
    refuse_unfit(shown, TASK, ours, "localhost:6000")


BAD = {
    "a match is running": (look(500, "play_on", NAMES, (3, 2)), BOTH, "a match is running: 3 keepers and 2 takers"),
    "somebody waits": (look(0, "before_kick_off", ("keepers", ""), (2, 0)), BOTH, "2 keepers and 0 takers .* already"),
    "keepers twice": (look(0, "before_kick_off", ("keepers", ""), (3, 0)), ONLY_KEEPERS, "wait until they leave"),
    "takers twice": (look(9, "play_on", NAMES, (3, 2)), ONLY_TAKERS, "a match is running"),
    "other names": (look(0, "before_kick_off", ("A", "B"), (0, 0)), BOTH, "called 'A' and 'B', not keepers and takers"),
    "takers on the left": (look(0, "before_kick_off", ("takers", ""), (2, 0)), BOTH, r"called 'takers' and \(none\)"),
    "kicked off with four": (look(500, "play_on", NAMES, (0, 0), (4, 3)), BOTH, "kicked off with 4 keepers"),
    "four keepers wait": (look(0, "before_kick_off", ("keepers", ""), (4, 0)), ONLY_TAKERS, "that is not 3v2"),
    "over": (look(6000, "time_over", NAMES, (0, 0), (3, 2)), BOTH, "is over"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_does_not_fit_is_refused_in_a_line(name: str) -> None:
    shown, ours, message = BAD[name]
    with pytest.raises(WrongServer, match=message) as refusal:
        refuse_unfit(shown, TASK, ours, "some.host.example:16001")
    assert len(str(refusal.value)) <= 200 and "\n" not in str(refusal.value)


def test_a_strangers_long_name_does_not_fill_the_screen() -> None:
    with pytest.raises(WrongServer) as refusal:
        refuse_unfit(look(0, "before_kick_off", ("\x1b]0;" * 50, "B")), TASK, BOTH, "h:1")
    assert len(str(refusal.value)) <= 200 and str(refusal.value).isprintable()


def test_numbers_below_a_body_were_given() -> None:
    shown = Look(500, "play_on", NAMES, (numbers(), numbers()), (numbers(1, 3), numbers()))
    assert [seat_is_known(shown, 0, n) for n in (1, 2, 3, 4)] == [True, True, True, False]
    assert not seat_is_known(shown, 1, 1)
