from __future__ import annotations

import pytest

from rcss_hat.protocol import messages
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.viewer.frames import TEAMS
from rcss_hat.viewer.shows import read, setup_of, snapshot_of, team_names

from .audience import datagrams

FRAMES = ("monitor-v3.txt.gz", "monitor-v5.txt.gz")


@pytest.mark.parametrize("name", FRAMES)
def test_absent_players_are_left_out_and_nothing_else(name: str) -> None:
    seen = 0
    for data in datagrams(name)[:60]:
        if not data.startswith(b"(show "):
            continue
        whole, read_here = messages.parse(data), read(data)
        assert isinstance(whole, messages.Show) and isinstance(read_here, messages.Show)
        assert read_here.players == tuple(p for p in whole.players if p.state)
        assert (read_here.time, read_here.ball, read_here.team) == (whole.time, whole.ball, whole.team)
        seen += len(read_here.players)
    assert seen > 0


def test_snapshot_tells_what_the_frame_told() -> None:
    data = (
        b"(show 7 (pm 3) (tm keepers null 0 0) ((b) 1.5 -2 0.25 0) "
        b"((l 1) 0 0x3 -8.5 9 0 0 90 -45 (v h 360) (s 7000 1 1) (c 0 0 0 0 0 0 0 0 0 0 0)) "
        b"((l 2) 0 0 -6 -37 0 0 0 0 (v h 360) (s 8000 1 1) (c 0 0 0 0 0 0 0 0 0 0 0)) "
        b"((r 11) 0 0x1 8 -9 0 0 10 20 3 4 (v l 90) (s 8000 1 1) (f r 1) (c 0 0 0 0 0 0 0 0 0 0 0)))\0"
    )
    show = read(data)
    assert isinstance(show, messages.Show)
    snapshot = snapshot_of(show, "before_kick_off")
    assert (snapshot.time, snapshot.mode, snapshot.ball) == (7, "play_on", (1.5, -2.0, 0.25, 0.0))
    assert [p.id for p in snapshot.players] == ["l1", "r11"]
    assert snapshot.players[0].to_dict() == {
        "id": "l1", "side": "l", "unum": 1, "x": -8.5, "y": 9.0, "body": 90.0, "neck": -45.0, "stamina": 7000.0,
        "kicking": True,
    }  # fmt: skip
    assert type(snapshot.players[1]).from_dict(snapshot.players[1].to_dict()) == snapshot.players[1]
    assert team_names(show.team) == ("keepers", "takers")


def test_a_frame_of_a_log_takes_the_mode_of_the_line_before() -> None:
    show = read(b"(show 3 ((b) 0 0 0 0))")
    assert isinstance(show, messages.Show)
    assert snapshot_of(show, "drop_ball").mode == "drop_ball"
    assert team_names(show.team) == TEAMS


def test_half_a_frame_is_refused() -> None:
    whole = datagrams("monitor-v5.txt.gz")[30]
    with pytest.raises(RemoteProtocolError):
        read(whole[: len(whole) // 2])


def test_setup_comes_from_the_server_parameters() -> None:
    params = read(datagrams("monitor-v5.txt.gz")[0])
    assert isinstance(params, messages.ServerParam)
    setup = setup_of(params, "here", messages.Team(left="blue", right="red", left_score=0, right_score=0))
    assert (setup.title, setup.keepaway, setup.length, setup.width) == ("here", True, 20.0, 20.0)
    assert setup.reach == pytest.approx(1.085)
    assert (setup.step_s, setup.teams) == (0.1, ("blue", "red"))


def test_setup_of_an_ordinary_match_is_the_whole_pitch() -> None:
    params = read(b"(server_param (keepaway 0)(simulator_step 50)(some_new_thing 3))")
    assert isinstance(params, messages.ServerParam)
    setup = setup_of(params, "here")
    assert (setup.keepaway, setup.length, setup.width, setup.step_s) == (False, 105.0, 68.0, 0.05)
    assert setup_of(None, "here").keepaway
