from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol import messages, records
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.messages import BallState, FullstatePlayer, GlobalPlayer, Hear, ShowPlayer, parse
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS, PLAY_MODES

from .recorded import received


def kinds(event_kind: type[messages.Event]) -> list[messages.Event]:
    return [event for event in (parse(d.text.encode(), d.team) for d in received()) if isinstance(event, event_kind)]


def test_every_recorded_message_is_known() -> None:
    found = set()
    for datagram in received():
        event = parse(datagram.text.encode() + b"\0", datagram.team)
        found.add(type(event))
        if isinstance(event, messages.Unknown):
            # Version 7 lists parameters without names, and has a fullstate of its own.
            assert datagram.client.endswith("_v7")
    everything = {getattr(messages, name) for name in messages.__all__ if isinstance(getattr(messages, name), type)}
    never_sent_alone = {messages.Event, BallState, FullstatePlayer, GlobalPlayer, ShowPlayer}
    only_in_logs = {messages.Team, messages.PlayMode}
    assert found == everything - never_sent_alone - only_in_logs - {messages.OkCompression}


@pytest.mark.parametrize(
    ("text", "event"),
    [
        ("(init l 1 before_kick_off)", messages.Init(side="l", unum=1, mode="before_kick_off")),
        ("(init ok)", messages.InitOk()),
        ("(reconnect r play_on)", messages.Reconnect(side="r", mode="play_on")),
        ("(think)", messages.Think()),
        ("(score 12 1 0)", messages.Score(time=12, ours=1, theirs=0)),
        ("(change_player_type 4 1)", messages.ChangePlayerType(unum=4, player_type=1)),
        ("(change_player_type 4)", messages.ChangePlayerType(unum=4)),
        ("(change_player_type l 4 1)", messages.ChangePlayerType(unum=4, player_type=1, side="l")),
        ("(error no_more_team)", messages.Error(text="no_more_team")),
        ("(error no team with name nobody)", messages.Error(text="no team with name nobody")),
        ("(warning message_not_null_terminated)", messages.Warning(text="message_not_null_terminated")),
        ("(ok start)", messages.Ok(command="start")),
        ("(ok recover)\n", messages.Ok(command="recover")),
        ("(ok eye on)", messages.Ok(command="eye", text="on")),
        ("(ok change_player_type keepers 2 3)", messages.Ok(command="change_player_type", text="keepers 2 3")),
        ("(ok clang (ver 7 8))", messages.OkClang(minimum=7, maximum=8)),
        ("(ok compression -1)", messages.OkCompression(level=-1)),
        ("(ok check_ball 29 in_field)", messages.OkCheckBall(time=29, where="in_field")),
        ("(ok team_names (team l a) (team r b))\n", messages.OkTeamNames(left="a", right="b")),
        ("(ok team_names (team l a))\n", messages.OkTeamNames(left="a", right=None)),
        ("(ok team_names)\n", messages.OkTeamNames(left=None, right=None)),
        ('(msg 65 1 "(referee play_on)")', messages.Msg(time=65, board=1, text="(referee play_on)")),
        ('(msg 3 2 "Recv a_1: (say "x")")\n', messages.Msg(time=3, board=2, text='Recv a_1: (say "x")')),
        ("(playmode 0 play_on)\n", messages.PlayMode(time=0, mode="play_on")),
        ("(team 0 a null 1 0)", messages.Team(time=0, left="a", right="null", left_score=1, right_score=0)),
        ("(team_graphic_l (0 0 x))", messages.Unknown(data=b"(team_graphic_l (0 0 x))")),
        ("(include 3 abc)", messages.Unknown(data=b"(include 3 abc)")),
        ("()", messages.Unknown(data=b"()")),
        ('("think")', messages.Unknown(data=b'("think")')),
    ],
)
def test_small_messages(text: str, event: messages.Event) -> None:
    assert parse(text.encode()) == event


@pytest.mark.parametrize(
    ("text", "event"),
    [
        ("(hear 0 referee play_on)", Hear(time=0, source="referee", text="play_on")),
        ("(hear 9 referee training Keepaway 1)", Hear(time=9, source="referee", text="training Keepaway 1")),
        ('(hear 25 coach "new episode")', Hear(time=25, source="coach", text="new episode")),
        ('(hear 2 online_coach_left "go")', Hear(time=2, source="online_coach_left", text="go")),
        ('(hear 26 self "a)b(")', Hear(time=26, source="self", text="a)b(")),
        ('(hear 26 26 our 2 "def")', Hear(time=26, source="our", text="def", direction=26.0, unum=2)),
        ('(hear 26 -34 opp "def")', Hear(time=26, source="opp", text="def", direction=-34.0)),
        ("(hear 26 our 11)", Hear(time=26, source="our", unum=11)),
        ("(hear 26 opp)", Hear(time=26, source="opp")),
        ('(hear 18 -26 "m19")', Hear(time=18, source="player", text="m19", direction=-26.0)),
        ("(hear referee 0 play_on)", Hear(time=0, source="referee", text="play_on")),
        ('(hear 3 referee "hello all")', Hear(time=3, source="referee", text="hello all")),
        ('(hear 3 (p "left" 4) "m0")', Hear(time=3, source="player", text="m0", unum=4, team="left")),
        (
            '(hear 3 (p "right" 4 goalie) "m0")',
            Hear(time=3, source="player", text="m0", unum=4, team="right", goalie=True),
        ),
    ],
)
def test_hear(text: str, event: Hear) -> None:
    assert parse(text.encode() + b"\0") == event


def test_server_parameters() -> None:
    event = kinds(messages.ServerParam)[0]
    assert isinstance(event, messages.ServerParam)
    assert (event.values["ball_decay"], event.values["keepaway_log_dir"], event.values["half_time"]) == (0.94, "./", -1)
    params = event.to_params()
    assert params["ball_decay"] == 0.94
    assert params["synch_mode"] is bool(event.values["synch_mode"])
    assert params["log_date_format"] == "%Y%m%d%H%M%S-"
    assert event.to_params("11.1").profile == "11.1"


def test_parameters_that_nobody_knows_are_kept_but_not_used() -> None:
    event = parse(b'(server_param (ball_decay 0.9)(brand_new 3)(team_l_start "a (b) c"))')
    assert isinstance(event, messages.ServerParam)
    assert dict(event.values) == {"ball_decay": 0.9, "brand_new": 3, "team_l_start": "a (b) c"}
    assert event.to_params()["team_l_start"] == "a (b) c"


def test_parameters_of_the_wrong_kind_are_the_servers_fault() -> None:
    event = parse(b'(server_param (ball_decay "fast"))')
    assert isinstance(event, messages.ServerParam)
    with pytest.raises(RemoteProtocolError, match="ball_decay"):
        event.to_params()


def test_player_types() -> None:
    types = kinds(messages.PlayerType)
    assert {event.id for event in types if isinstance(event, messages.PlayerType)} >= set(range(3))
    first = next(event for event in types if isinstance(event, messages.PlayerType) and event.id == 0)
    assert (first.values["player_speed_max"], first.values["effort_max"]) == (1.05, 1)


def test_see_and_sense_body_are_records() -> None:
    see = parse(b'(see 12 ((b) 5 6) ((p "a" 2) 7 8))', "a")
    assert isinstance(see, messages.See)
    assert see.record["code"][0, :2].tolist() == [records.BALL, records.PLAYER]
    assert see.record["team"][0, 1] == records.OWN_TEAM
    sense = parse(b"(sense_body 3 (view_mode low wide) (stamina 1 1) (speed 0 0))")
    assert isinstance(sense, messages.SenseBody)
    assert sense.record["width"][0] == records.WIDE


def test_fullstate() -> None:
    text = (
        "(fullstate 60 (pmode play_on) (vmode high normal) (count 0 47 10 0 0 0 0 0) (arm (movable 4) (expires 19)"
        " (target 9.7 21) (count 1)) (score 2 1) ((b) -6 -6.5 0 0.1)"
        " ((p l 1 0) 10.7766 9.19661 0.104538 0.205516 60.0871 0 (stamina 7610 1 1))"
        " ((p r 2 g) 8 -7 0 0 -121.909 90 8 -0.0893112 (stamina 8000 1 1 130600) t)"
        " ((p r 3 g 4) 8 -7 0 0 -1 90 (focus_point 3 4) (stamina 8000 1 1 130600) k y))"
    )
    event = parse(text.encode())
    assert isinstance(event, messages.Fullstate)
    assert (event.time, event.mode, event.quality, event.width) == (60, "play_on", "high", "normal")
    assert event.counts == (0, 47, 10, 0, 0, 0, 0, 0)
    assert event.arm == (4, 19, 9.7, 21, 1)
    assert event.score == (2, 1)
    assert event.ball == BallState(x=-6, y=-6.5, vx=0, vy=0.1)
    first, second, third = event.players
    assert (first.side, first.unum, first.goalie, first.player_type) == ("l", 1, False, 0)
    assert (first.x, first.body, first.stamina, first.capacity, first.arm) == (10.7766, 60.0871, 7610, None, None)
    assert (second.goalie, second.player_type, second.arm) == (True, None, (8, -0.0893112))
    assert (second.capacity, second.marks, second.focus_point) == (130600, ("t",), None)
    assert (third.goalie, third.player_type, third.focus_point, third.marks) == (True, 4, (3, 4), ("k", "y"))


def test_see_global_and_look() -> None:
    body = (
        "12 ((g r) 52.5 0) ((g l) -52.5 0) ((b) 1 2 0.1 0.2)"
        ' ((p "a" 3) 4 5 0 0 90 -10) ((p "b" 1 goalie) 6 7 0 0 1 2 33 t))'
    )
    event = parse(f"(see_global {body}".encode())
    assert isinstance(event, messages.SeeGlobal)
    assert (event.time, event.answer, dict(event.goals)) == (12, False, {"r": (52.5, 0), "l": (-52.5, 0)})
    field, goalie = event.players
    assert (field.team, field.unum, field.goalie, field.body, field.pointing) == ("a", 3, False, 90, None)
    assert (goalie.goalie, goalie.pointing, goalie.marks) == (True, 33, ("t",))
    answer = parse(f"(ok look {body}".encode())
    assert isinstance(answer, messages.SeeGlobal)
    assert answer.answer
    assert answer.players == event.players


@pytest.mark.parametrize(
    ("head", "mode", "team"),
    [
        (
            " (pm 3) (tm keepers null 0 1)",
            "play_on",
            messages.Team(left="keepers", right="null", left_score=0, right_score=1),
        ),
        (
            " (pm 42) (tm a b 0 1 1 2 3 4)",
            "penalty_ready_l",
            messages.Team(left="a", right="b", left_score=0, right_score=1, penalties=(1, 2, 3, 4)),
        ),
        ("", None, None),
    ],
)
def test_show(head: str, mode: str | None, team: messages.Team | None) -> None:
    text = (
        f"(show 3{head} ((b) -6 -6 0 0)"
        " ((l 1) 0 0x1 -8.6741 -9.8157 0 0 0 0 (v h 360) (s 8000 1 1) (c 0 1 2 3 4 5 6 7 8 9 10))"
        " ((r 11) 2 0 8 -7 0 0 17.148 30 14.9 -3.9 (v l 90) (fp 1 2) (s 8000 1 1 130600) (f l 4)"
        " (c 0 1 2 3 4 5 6 7 8 9 10 11)))\n"
    )
    event = parse(text.encode())
    assert isinstance(event, messages.Show)
    assert (event.time, event.mode, event.team) == (3, mode, team)
    assert event.ball == BallState(x=-6, y=-6, vx=0, vy=0)
    first, second = event.players
    assert (first.side, first.unum, first.player_type, first.state, first.x) == ("l", 1, 0, 1, -8.6741)
    assert (first.arm, first.focus_point, first.capacity, first.attention) == (None, None, None, None)
    assert first.counts == tuple(range(11))
    assert (second.side, second.unum, second.state, second.arm) == ("r", 11, 0, (14.9, -3.9))
    assert (second.quality, second.view_angle, second.focus_point) == ("l", 90, (1, 2))
    assert (second.capacity, second.attention, second.counts) == (130600, ("l", 4), tuple(range(12)))


def test_recorded_frames_have_all_players() -> None:
    for event in kinds(messages.Show):
        assert isinstance(event, messages.Show)
        assert [(player.side, player.unum) for player in event.players] == [(s, n) for s in "lr" for n in range(1, 12)]


@pytest.mark.parametrize(
    ("text", "position"),
    [
        ("", 0),
        ("think", 0),
        ('{"type": "show"}', 0),
        ("(think", 6),
        ("(think) x", 7),
        ("(think) (think)", 7),
        ("(think now)", 7),
        ('(foo "bar)', 4),
        ("(foo (bar)", 10),
        ("(init x 1 play_on)", 6),
        ("(init l 12 play_on)", 8),
        ("(init l 1)", 0),
        ('(init l 1 "play_on")', 10),
        ("(score 1 2)", 0),
        ("(score 1 2 x)", 11),
        ("(score 1 2 3 4)", 13),
        ("(server_param (ball_decay))", 14),
        ("(server_param (ball_decay nan))", 26),
        ("(server_param (ball_decay 1e999))", 26),
        ("(server_param ball_decay)", 14),
        ("(player_type (player_speed_max 1))", 0),
        ("(ok)", 0),
        ("(ok clang (version 7 8))", 10),
        ("(ok look 3 ((g l) 1))", 11),
        ("(hear)", 6),
        ("(hear 3 nobody x)", 8),
        ("(hear 3 12 our)", 8),
        ('(hear 3 our 2 "x")', 8),
        ('(hear 3 12 opp 2 "x")', 8),
        ('(hear 3 12 our 12 "x")', 8),
        ('(hear 3 (p "a" 12) "x")', 8),
        ('(msg 1 2 "x)', 5),
        ("(fullstate 3 (pmode play_on) (vmode high big) (count 1))", 0),
        ("(show 3)", 0),
        ("(show 3 (pm 99) ((b) 0 0 0 0))", 12),
        ("(show 3 ((b) 0 0 0))", 13),
        ("(show 3 ((b) 0 0 0 1.2.3))", 13),
        ("(show 3 ((b) 0 0 0 0) ((l 1) 0))", 21),
        ("(show 3 ((b) 0 0 0 0) ((l 12) 0 0 1 2 3 4 5 6 (v h 90) (s 1 1 1) (c 0 0 0 0 0 0 0 0 0 0 0)))", 21),
        ("(show 3 ((b) 0 0 0 0) ((l 1) 0 0 1 2 3 4 5 6 (v h 90) (s 1 1 1e999) (c 0 0 0 0 0 0 0 0 0 0 0)))", 21),
        ("(show 3 ((b) 0 0 0 0) ((l 1) 0 0 1 2 3 4 5 6 (v h 90) (s 1 1 1) (c 0)))", 21),
    ],
)
def test_malformed_messages_name_the_place(text: str, position: int) -> None:
    with pytest.raises(RemoteProtocolError) as error:
        parse(text.encode())
    assert error.value.position == position


def test_deep_nesting_is_read() -> None:
    assert isinstance(parse(b"(" * 4000 + b")" * 4000), messages.Unknown)
    with pytest.raises(RemoteProtocolError):
        parse(b"(" * 8000)


def try_to_parse(text: bytes) -> None:
    try:
        event = parse(text, "keepers")
    except RemoteProtocolError as error:
        assert error.data is not None
        assert 0 <= error.position <= len(text)
    else:
        assert isinstance(event, messages.Event)


WORDS = st.sampled_from(
    [
        "(", ")", " ", '"', "init", "ok", "look", "hear", "show", "fullstate", "server_param", "player_type",
        "id", "l", "r", "b", "p", "g", "c", "s", "v", "1", "-2.5", "1e999", "nan", "0x1", "our", "opp",
        "referee", "\0", "\n", "\xff", "9" * 5000,
    ]
)  # fmt: skip


@given(st.binary(max_size=80) | st.lists(WORDS, max_size=25).map(lambda words: "".join(words).encode("latin-1")))
def test_any_bytes_are_a_message_or_an_error(data: bytes) -> None:
    try_to_parse(data)
    try_to_parse(b"(" + data)


@given(st.data())
def test_mutated_messages_are_a_message_or_an_error(data: st.DataObject) -> None:
    text = bytearray(data.draw(st.sampled_from(received())).text.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, max(0, len(text) - 1)))
        text[place : place + data.draw(st.integers(0, 2))] = data.draw(
            st.sampled_from([b"", b"(", b")", b'"', b"9", b" x"])
        )
        if not text:
            break
    try_to_parse(bytes(text))
    try_to_parse(bytes(text[: data.draw(st.integers(0, len(text)))]))


def test_play_modes() -> None:
    assert len(PLAY_MODES) == 51
    assert list(PLAY_MODES) == list(range(1, 52))
    assert PLAY_MODE_IDS["play_on"] == 3
    assert PLAY_MODES[25] == "foul_charge_r"
    assert PLAY_MODES[51] == "illegal_defense_r"
