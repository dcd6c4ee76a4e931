from __future__ import annotations

import pytest

from rcss_hat.keepaway.report import OUT, TAKEN, Episode, read_kwy
from rcss_hat.protocol import messages
from rcss_hat.viewer.episodes import EpisodeTracker
from rcss_hat.viewer.frames import Setup, Snapshot
from rcss_hat.viewer.shows import read, snapshot_of

from .audience import DATA, SETUP, datagrams, snapshot

CORNERS = {"l1": (-9.0, -9.0), "l2": (9.0, -9.0), "l3": (9.0, 9.0), "r1": (-9.0, 9.0), "r2": (-8.0, 9.0)}
SPOT = (-6.0, -6.0)


def recorded() -> list[Snapshot]:
    events = [read(data) for data in datagrams("monitor-v5.txt.gz")]
    return [snapshot_of(event, "") for event in events if isinstance(event, messages.Show)]


def follow(snapshots: list[Snapshot]) -> list[Episode]:
    tracker = EpisodeTracker(SETUP)
    return [episode for s in snapshots if (episode := tracker.see(s)) is not None]


def test_episodes_are_those_the_server_logged() -> None:
    logged = read_kwy(DATA / "monitor-v5.kwy")
    assert {e.reason for e in logged} == {OUT, TAKEN}
    assert follow(recorded()) == logged


def test_who_comes_in_the_middle_does_not_count_the_episode_under_way() -> None:
    snapshots = [s for s in recorded() if s.time >= 40]
    tracker = EpisodeTracker(SETUP)
    tracker.see(snapshots[0])
    assert (tracker.number, tracker.start) == (0, 40)
    later = [e for e in read_kwy(DATA / "monitor-v5.kwy") if e.start >= 40]
    assert [(e.start, e.end, e.reason) for e in follow(snapshots)] == [(e.start, e.end, e.reason) for e in later]


def test_lost_frames_do_not_hide_an_end() -> None:
    """A reset is seen as long as the frame that shows it came."""
    logged = read_kwy(DATA / "monitor-v5.kwy")
    ends = {e.end for e in logged}
    thinned = [s for s in recorded() if s.time % 3 == 0 or s.time in ends or s.time < 2]
    assert [(e.start, e.end) for e in follow(thinned)] == [(e.start, e.end) for e in logged]


def test_the_fourth_cycle_of_a_taker_ends_the_episode() -> None:
    near = {**CORNERS, "r1": (-1.0, 0.0)}
    play = [snapshot(0, (0.0, 0.0), "before_kick_off", **CORNERS), snapshot(1, SPOT, **CORNERS)]
    play += [snapshot(t, (0.0, 0.0), **near) for t in range(2, 6)]
    assert follow([*play, snapshot(6, SPOT, **CORNERS)]) == [Episode(1, 0, 6, TAKEN)]
    # One cycle of possession less, and only a ball outside can have ended it.
    assert follow([*play[:-1], snapshot(5, SPOT, **CORNERS)]) == [Episode(1, 0, 5, OUT)]


def test_a_keeper_alone_takes_the_count_back_a_loose_ball_does_not() -> None:
    taker, keeper = {**CORNERS, "r1": (-1.0, 0.0)}, {**CORNERS, "l1": (-1.0, 0.0)}
    both = {**taker, "l1": (1.0, 0.0)}
    begin = [snapshot(0, (0.0, 0.0), "before_kick_off", **CORNERS), snapshot(1, SPOT, **CORNERS)]

    def reason(*places: dict[str, tuple[float, float]]) -> str:
        middle = [snapshot(t, (0.0, 0.0), **p) for t, p in enumerate(places, 2)]
        (episode,) = follow([*begin, *middle, snapshot(len(places) + 2, SPOT, **CORNERS)])
        return episode.reason

    assert reason(taker, taker, CORNERS, taker, taker) == TAKEN
    assert reason(taker, taker, both, taker) == TAKEN
    assert reason(taker, taker, taker, keeper, taker) == OUT


def test_a_ball_that_leaves_while_a_taker_has_it_is_out() -> None:
    near = {**CORNERS, "r1": (9.5, 0.5)}
    play = [snapshot(0, (0.0, 0.0), "before_kick_off", **CORNERS), snapshot(1, SPOT, **CORNERS)]
    play += [snapshot(t, (9.5, 0.0, 0.9, 0.0), **near) for t in range(2, 6)]
    assert follow([*play, snapshot(6, SPOT, **CORNERS)]) == [Episode(1, 0, 6, OUT)]


def test_an_interruption_does_not_end_an_episode() -> None:
    play = [snapshot(0, (0.0, 0.0), "before_kick_off", **CORNERS), snapshot(1, SPOT, **CORNERS)]
    play += [snapshot(t, (1.0, 1.0), mode, **CORNERS) for t, mode in ((2, "play_on"), (3, "drop_ball"), (4, "play_on"))]
    assert follow([*play, snapshot(5, (9.0, 0.0), **CORNERS), snapshot(6, SPOT, **CORNERS)]) == [Episode(1, 0, 6, OUT)]


def test_standing_at_the_start_is_no_reset() -> None:
    assert follow([snapshot(t, SPOT, **CORNERS) for t in range(1, 30)]) == []


def test_an_episode_whose_ball_nobody_touched_ends_with_the_reset_of_the_players() -> None:
    near = {**CORNERS, "r1": (-6.5, -6.0)}
    play = [snapshot(0, (0.0, 0.0), "before_kick_off", **CORNERS), snapshot(1, SPOT, **CORNERS)]
    play += [snapshot(t, SPOT, **{**CORNERS, "r1": (-9.0, 10.2 - 1.2 * t)}) for t in range(2, 12)]
    play += [snapshot(t, SPOT, **near) for t in range(13, 17)]
    assert follow([*play, snapshot(17, SPOT, **CORNERS)]) == [Episode(1, 0, 17, TAKEN)]


def test_a_new_match_begins_a_new_episode() -> None:
    tracker = EpisodeTracker(SETUP)
    for time in (1, 2, 50, 1):
        tracker.see(snapshot(time, SPOT, **CORNERS))
    assert (tracker.number, tracker.start) == (2, 0)


@pytest.mark.parametrize("mode", ["play_on", "goal_l"])
def test_an_ordinary_match_has_no_episodes(mode: str) -> None:
    tracker = EpisodeTracker(Setup("match", keepaway=False, length=105.0, width=68.0))
    assert all(tracker.see(snapshot(t, SPOT, mode, **CORNERS)) is None for t in range(1, 5))
    assert tracker.number == 0
