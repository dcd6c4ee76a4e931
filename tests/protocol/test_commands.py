from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.protocol import records
from rcss_hat.protocol.commands import (
    AttentionTo,
    Bye,
    Catch,
    ChangeFocus,
    ChangeMode,
    ChangePlayerType,
    ChangeView,
    CheckBall,
    Clang,
    Command,
    Compression,
    Dash,
    DashLegs,
    DispBye,
    DispCard,
    DispDiscard,
    DispFoul,
    DispInit,
    DispPlayer,
    DispStart,
    Done,
    Ear,
    Eye,
    GaussianSee,
    Init,
    Kick,
    LongKick,
    Look,
    Move,
    MoveBall,
    MovePlayer,
    PointTo,
    Reconnect,
    Recover,
    Refusal,
    Say,
    Score,
    SenseBody,
    Start,
    SynchSee,
    Tackle,
    TeamNames,
    TrainerEar,
    TrainerInit,
    TrainerSay,
    Turn,
    TurnNeck,
    action_to_bytes,
    datagram,
    parse_commands,
    parse_init,
    parse_monitor_command,
    parse_trainer_command,
    parse_trainer_init,
    serialize,
)
from rcss_hat.protocol.errors import LocalProtocolError
from rcss_hat.protocol.play_modes import PLAY_MODES

from .recorded import recorded, sent

power = st.floats(-100, 100)
degrees = st.floats(-180, 180)
metres = st.floats(-1000, 1000)
unums = st.integers(1, 11)
sides = st.sampled_from([1, -1])
sixteenths = st.integers(-10_000, 10_000).map(lambda n: n / 16)
teams = st.sampled_from(["our", "opp", "l", "r", "keepers", "UTAustin-03", "x_1"])
said = st.text("0123456789abcXYZ ().+-*/?<>_", min_size=1, max_size=10)
pairs = st.tuples(metres, metres)
legs = st.tuples(power, degrees)

PLAYER_COMMANDS = st.one_of(
    st.builds(Dash, power),
    st.builds(Dash, power, degrees),
    st.builds(DashLegs, legs),
    st.builds(DashLegs, st.none() | legs, legs),
    st.builds(Turn, degrees),
    st.builds(TurnNeck, degrees),
    st.builds(Kick, power, degrees),
    st.builds(LongKick, power, degrees),
    st.builds(Tackle, degrees),
    st.builds(Tackle, degrees, st.booleans()),
    st.builds(Catch, degrees),
    st.builds(Move, metres, metres),
    st.builds(Say, said),
    st.builds(ChangeView, st.sampled_from(["narrow", "normal", "wide"]), st.none() | st.sampled_from(["low", "high"])),
    st.builds(AttentionTo, teams, unums),
    st.just(AttentionTo()),
    st.builds(PointTo, metres, degrees),
    st.just(PointTo()),
    st.builds(Ear, st.booleans(), st.none() | teams, st.none() | st.sampled_from(["partial", "complete"])),
    st.builds(Clang, st.integers(0, 20), st.integers(0, 2**31 - 1)),
    st.builds(Compression, st.integers(-1, 9)),
    st.builds(ChangeFocus, metres, degrees),
    st.sampled_from([SenseBody(), Score(), Done(), Bye(), SynchSee(), GaussianSee()]),
)
TRAINER_COMMANDS = st.one_of(
    st.builds(ChangeMode, st.sampled_from(list(PLAY_MODES.values()))),
    st.builds(MoveBall, metres, metres, st.none() | pairs),
    st.builds(MovePlayer, st.sampled_from(["keepers", "x_1"]), unums, metres, metres, st.none() | degrees),
    st.builds(MovePlayer, st.just("keepers"), unums, metres, metres, degrees, pairs),
    st.builds(Eye, st.booleans()),
    st.builds(TrainerEar, st.booleans()),
    st.builds(TrainerSay, st.text("abc.+ x", min_size=1, max_size=128).filter(lambda text: text[0] != " ")),
    st.builds(ChangePlayerType, st.just("keepers"), unums, st.integers(0, 17)),
    st.builds(Compression, st.integers(-1, 9)),
    st.sampled_from([Start(), Look(), CheckBall(), Recover(), TeamNames(), Done()]),
)
MONITOR_COMMANDS = st.one_of(
    st.builds(DispFoul, sixteenths, sixteenths, st.sampled_from([-1, 0, 1])),
    st.builds(DispPlayer, sides, unums, sixteenths, sixteenths, st.integers(-180, 180)),
    st.builds(DispDiscard, sides, unums),
    st.builds(DispCard, sides, unums, st.sampled_from(["yellow", "red"])),
    st.builds(Compression, st.integers(-1, 9)),
    st.sampled_from([DispStart(), DispBye()]),
)


@given(st.lists(PLAYER_COMMANDS, min_size=1, max_size=5))
def test_player_commands_are_read_as_they_were_meant(commands: list[Command]) -> None:
    assert parse_commands(datagram(*commands)) == (commands, True)


@given(TRAINER_COMMANDS)
def test_trainer_commands_are_read_as_they_were_meant(command: Command) -> None:
    assert parse_trainer_command(datagram(command)) == command


@given(MONITOR_COMMANDS)
def test_monitor_commands_are_read_as_they_were_meant(command: Command) -> None:
    assert parse_monitor_command(datagram(command)) == command


@given(st.builds(Init, st.from_regex(r"[A-Za-z0-9_-]{1,15}", fullmatch=True), st.integers(1, 19), st.booleans()))
def test_init_is_read_as_it_was_meant(command: Init) -> None:
    assert parse_init(datagram(command)) == command
    assert parse_init(datagram(command), "11.1") == command


def test_other_ways_to_join() -> None:
    assert parse_init(datagram(Reconnect("keepers", 3))) == Reconnect("keepers", 3)
    for version in (1, 2, 5, -1):
        assert parse_init(datagram(DispInit(version))) == DispInit(version)
    assert parse_trainer_init(datagram(TrainerInit(11))) == TrainerInit(11)


def test_texts() -> None:
    # What the server's own documentation and recordings show.
    expected = {
        Dash(56): "(dash 56)",
        Dash(-7.5, 90): "(dash -7.5 90)",
        DashLegs((50, 1), (60, 2)): "(dash (l 50 1) (r 60 2))",
        Turn(1e-05): "(turn 1e-05)",
        Tackle(30, True): "(tackle 30 on)",
        Say("a b"): '(say "a b")',
        ChangeView("wide", "low"): "(change_view wide low)",
        ChangeView("wide"): "(change_view wide)",
        AttentionTo(): "(attentionto off)",
        PointTo(3, 4): "(pointto 3 4)",
        PointTo(): "(pointto off)",
        Ear(False, "opp", "partial"): "(ear (off opp partial))",
        Ear(True): "(ear (on))",
        Clang(7, 8): "(clang (ver 7 8))",
        Init("keepers", 11, True): "(init keepers (version 11) (goalie))",
        Reconnect("keepers", 3): "(reconnect keepers 3)",
        MoveBall(1, 2): "(move (ball) 1 2)",
        MoveBall(1, 2, (3, 4)): "(move (ball) 1 2 0 3 4)",
        MovePlayer("a", 2, 3, 4, 5, (6, 7)): "(move (player a 2) 3 4 5 6 7)",
        TrainerSay("hello all"): "(say hello all)",
        DispInit(): "(dispinit)",
        DispInit(4): "(dispinit version 4)",
        DispFoul(1.5, -2, 0): "(dispfoul 24 -32 0)",
        DispPlayer(-1, 2, 10, 0, 90): "(dispplayer -1 2 160 0 90)",
        Move(3e9, 0): "(move 3000000000.0 0)",
        LongKick(50, 6): "(long_kick 50 6)",
        ChangeFocus(1.5, -6): "(change_focus 1.5 -6)",
        Catch(-9): "(catch -9)",
        Compression(-1): "(compression -1)",
        SenseBody(): "(sense_body)",
        Score(): "(score)",
        Done(): "(done)",
        Bye(): "(bye)",
        SynchSee(): "(synch_see)",
        GaussianSee(): "(gaussian_see)",
        Start(): "(start)",
        Look(): "(look)",
        CheckBall(): "(check_ball)",
        Recover(): "(recover)",
        TeamNames(): "(team_names)",
        TrainerEar(False): "(ear off)",
        Eye(True): "(eye on)",
        ChangeMode("play_on"): "(change_mode play_on)",
        ChangePlayerType("a", 2, 3): "(change_player_type a 2 3)",
        TrainerInit(11): "(init (version 11))",
        DispStart(): "(dispstart)",
        DispBye(): "(dispbye)",
        DispDiscard(1, 2): "(dispdiscard 1 2)",
        DispCard(-1, 2, "red"): "(dispcard -1 2 red)",
    }
    assert {command: serialize(command).decode() for command in expected} == expected


@pytest.mark.parametrize(
    ("command", "hint"),
    [
        (Dash(101), "power must be a number from -100 to 100, not 101"),
        (Dash(math.nan), "power"),
        (Dash(50, 181), "direction"),
        (DashLegs(), "at least one"),
        (DashLegs((101, 0)), "power of leg l"),
        (Turn(-181), "moment"),
        (TurnNeck(math.inf), "moment"),
        (Kick(0, 200), "direction"),
        (LongKick(200, 0), "power"),
        (Tackle(200), "power or direction"),
        (Catch(200), "direction"),
        (Move(math.inf, 0), "x must be a finite number"),
        (Say(""), "not empty"),
        (Say('a"b'), "letters, digits, spaces"),
        (Say("hello world"), "at most 10 characters"),
        (ChangeView("huge"), "one of narrow, normal, wide"),
        (ChangeView("wide", "best"), "one of low, high"),
        (AttentionTo("our", 12), "integer from 1 to 11"),
        (AttentionTo("our team", 1), "team name"),
        (PointTo(3, 181), "direction"),
        (Ear(True, None, "all"), "one of partial, complete"),
        (Clang(-1, 3), "lowest version"),
        (Compression(10), "integer from -1 to 9"),
        (ChangeFocus(1, 300), "direction"),
        (Init("a b"), "team name"),
        (Init("a", 20), "version"),
        (Init("much_too_long_name"), "1 to 15"),
        (Reconnect("a", 0), "uniform number"),
        (TrainerInit(0), "version"),
        (ChangeMode("play"), "one of before_kick_off"),
        (MoveBall(math.nan, 0), "x"),
        (MovePlayer("a", 1, 0, 0, None, (1, 1)), "needs an angle"),
        (MovePlayer("a", 1, 0, 0, 181), "angle"),
        (TrainerSay("x" * 129), "at most 128"),
        (ChangePlayerType("a", 1, -1), "player type"),
        (DispInit(6), "version"),
        (DispInit(math.nan), "version"),
        (DispFoul(0, 0, 2), "1 (left) or -1 (right) or 0 (nobody)"),
        (DispPlayer(0, 1, 0, 0, 0), "1 (left) or -1 (right)"),
        (DispPlayer(1, 1, 1e9, 0, 0), "x"),
        (DispPlayer(1, 1, 0, 0, 1.5), "angle"),  # type: ignore[arg-type]
        (DispDiscard(1, 1.5), "uniform number"),  # type: ignore[arg-type]
        (DispCard(1, 1, "green"), "one of yellow, red"),
    ],
)
def test_illegal_commands_say_what_would_be_right(command: Command, hint: str) -> None:
    with pytest.raises(LocalProtocolError) as error:
        serialize(command)
    assert hint in str(error.value)


def test_longer_messages_for_servers_that_allow_them() -> None:
    assert Say("hello world").text(20) == '(say "hello world")'


def test_datagrams() -> None:
    assert datagram(Kick(56, -12), TurnNeck(3), Say("abc")) == b'(kick 56 -12)(turn_neck 3)(say "abc")\0'
    with pytest.raises(LocalProtocolError, match="at least one"):
        datagram()
    with pytest.raises(LocalProtocolError, match="Init needs a datagram of its own"):
        datagram(Init("a"), Turn(5))
    with pytest.raises(LocalProtocolError, match="at most 8192 bytes"):
        datagram(*[Score()] * 1200)


# --- players' commands as the server reads them; results from its own scanner and parser -----------------------------
@pytest.mark.parametrize(
    ("text", "commands", "complete"),
    [
        ("(say hi)(done)", [Say("hi)(done")], True),
        ("(say one)(say two)(say three)", [Say("one)(say two)(say three")], True),
        ('(say hi)(say "x")', [Say("hi"), Say("x")], True),
        ("(say ))", [Say(")")], True),
        ("( say\thi )", [Say("hi")], True),
        ('(say"x")', [Say("x")], True),
        ("( say 5 )", [], False),
        ("( say left )", [], False),
        ("(say )", [], False),
        ('(say "")', [], False),
        ('(say "a;b")', [], False),
        ('(say (say "x"))', [], False),
        ("(score)(foo)", [Score()], False),
        ("(foo)(score)", [], False),
        ("", [], False),
        (" \t\n", [], False),
        (" ( turn\n5 )\t(done) ", [Turn(5), Done()], True),
        ("(turn 5)\r\n", [Turn(5)], False),
        ("(turn 5))", [Turn(5)], False),
        ("(turn 5", [], False),
        ("(turn 5)x", [Turn(5)], False),
        ("(turn5)", [], False),
        ("(turn+5)", [Turn(5)], True),
        ("(turn nan)", [], False),
        ("(turn inf)", [], False),
        ("(turn 1e400)", [Turn(math.inf)], True),
        ("(turn -1e400)", [Turn(-math.inf)], True),
        ("(turn 1e1)", [Turn(10)], True),
        ("(turn .5)", [Turn(0.5)], True),
        ("(turn 5.)", [], False),
        ("(turn 0x10)", [], False),
        ("(turn 3000000000)", [Turn(-1294967296)], True),
        ("(turn 3000000000.0)", [Turn(3e9)], True),
        ("(turn 99999999999999999999)", [Turn(-1)], True),
        ("(turn -99999999999999999999)", [Turn(0)], True),
        ("(turn 00012)", [Turn(12)], True),
        ("(kick 10-20)", [], False),
        ("(kick 10+20)", [Kick(10, 20)], True),
        ("(kick 1.5.5)", [Kick(1.5, 0.5)], True),
        ("(kick 5)", [], False),
        ("(kick 5 6 7)", [], False),
        ("(dash 50 30)", [Dash(50, 30)], True),
        ("(dash (right 5 6)(left 7 8))", [DashLegs((7, 8), (5, 6))], True),
        ("(dash (l 5 6) foo", [DashLegs((5, 6))], False),
        ("(dash (l 5 6)(l 7 8))", [DashLegs((5, 6))], False),
        ("(dash (l 5 6)(r 7 8) 9)", [DashLegs((5, 6), (7, 8))], False),
        ("(dash (our 5 6))", [], False),
        ("(change_view wide)", [ChangeView("wide")], True),
        ("(change_view low wide)", [], False),
        ("(attentionto left 3)", [AttentionTo("l", 3)], True),
        ("(attentionto our 3.0)", [], False),
        ("(attentionto partial 3)", [], False),
        ('(attentionto "x" 3)', [AttentionTo('"x"', 3)], True),
        ("(ear (on p))", [Ear(True, None, "partial")], True),
        ("(ear (off r c))", [Ear(False, "r", "complete")], True),
        ("(ear (maybe))", [], False),
        ("(ear on)", [], False),
        ("(tackle 5 true)", [Tackle(5, True)], True),
        ("(tackle 5 off)", [Tackle(5, False)], True),
        ("(compression -1)", [Compression(-1)], True),
        ("(compression 1.0)", [], False),
        ("(clang (ver 7 8))", [Clang(7, 8)], True),
        ("(clang (ver 7.0 8))", [], False),
        ("(long_kick 5 6)", [LongKick(5, 6)], True),
        ("(done)\0(turn 5)", [Done()], True),
    ],
)
def test_the_oddities_of_the_servers_grammar(text: str, commands: list[Command], complete: bool) -> None:
    assert parse_commands(text.encode()) == (commands, complete)


def test_the_sign_of_zero_as_the_server_reads_it() -> None:
    commands, _ = parse_commands(b"(turn -0)(turn -0.0)")
    assert [math.copysign(1, command.moment) for command in commands if isinstance(command, Turn)] == [1, -1]


@pytest.mark.parametrize(
    "text",
    [
        "(dash 50 30)",
        "(dash (l 5 6))",
        "(change_view wide)",
        "(tackle 5 on)",
        "(synch_see)",
        "(gaussian_see)",
        "(change_focus 1 2)",
        "(long_kick 1 2)",
    ],
)
def test_what_the_old_server_does_not_know(text: str) -> None:
    assert parse_commands(b"(turn 5)" + text.encode() + b"(turn 6)", "11.1") == ([Turn(5)], False)
    assert parse_commands(text.encode())[1]


def test_what_the_old_server_knows() -> None:
    text = b'(dash 50)(tackle 5)(change_view wide low)(say "x")(attentionto off)'
    assert parse_commands(text, "11.1") == parse_commands(text)


def test_unknown_profiles_are_refused() -> None:
    with pytest.raises(ValueError, match=r"11\.1"):
        parse_commands(b"(done)", "12")
    with pytest.raises(ValueError, match=r"11\.1"):
        parse_init(b"(init a)", "12")


def test_recorded_player_commands() -> None:
    texts = [d.text for d in recorded() if d.dir == "send" and d.client[0] in "kt" and d.client != "trainer"]
    texts = [text for text in texts if not text.startswith(("(init", "(reconnect", "(dispinit"))]
    assert len(texts) > 300
    for text in texts:
        commands, complete = parse_commands(text.encode())
        swallowed = re.search(r"\(say [^\"].*\(bad command\)", text)
        bad = "(bad command)" in text or text == "(foo)"
        assert complete == (not bad or swallowed is not None)
        if complete and "(say " not in text:
            assert len(commands) == text.count("(") - text.count("(ear (") - text.count("(ver")


def test_recorded_trainer_and_monitor_commands() -> None:
    refused = {"(nonsense)", "(bogus)", "(move (nobody) 1 2)", "(change_mode nosuch)", "(bye)"}
    for datagram_ in sent():
        if datagram_.client == "trainer" and not datagram_.text.startswith("(init"):
            parsed: object = parse_trainer_command(datagram_.text.encode())
        elif datagram_.client.startswith("monitor") and not datagram_.text.startswith("(dispinit"):
            parsed = parse_monitor_command(datagram_.text.encode())
        else:
            continue
        assert isinstance(parsed, Refusal) == (datagram_.text in refused), datagram_


# --- init ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("(init )", "(error illegal_teamname)"),
        ("(init (version 9))", "(error illegal_teamname)"),
        ("(init 1234567890123456)", "(error illegal_teamname_or_too_long_teamname)"),
        ("(init a", "(error illegal_teamname_or_too_long_teamname)"),
        ("(init a b)", "(error illegal_teamname_or_too_long_teamname)"),
        ("(init a (versio 9))", "(error illegal_command_form)"),
        ("(init a (version x))", "(error illegal_command_form)"),
        ("(init a (version 9)", "(error illegal_command_form)"),
        ("(init a (version 9)x)", "(error illegal_command_form)"),
        ("(init a (goalie)", "(error illegal_command_form)"),
        ("(reconnect keepers)", "(error illegal_command_form)"),
        ("(initial)", "(error unknown_command)"),
        ("(bye)", "(error unknown_command)"),
        ("", "(error unknown_command)"),
    ],
)
def test_refused_inits(text: str, answer: str) -> None:
    assert parse_init(text.encode()) == Refusal(answer)


def test_odd_inits_that_are_accepted() -> None:
    assert parse_init(b"(init a)") == Init("a", 3.0)
    assert parse_init(b"(init a (goalie)(version 11.9) )\n") == Init("a", 11.9, True)
    assert parse_init(b"(init 123456789012345 (version 1e1))") == Init("123456789012345", 10.0)
    assert parse_init(b"(dispinit) and more") == DispInit(1.0)
    assert parse_init(b" ( dispinit version 2 ") == DispInit(2.0)


def test_the_old_server_allows_fewer_team_names() -> None:
    assert parse_init(b"(init a:b (version 9))") == Init("a:b", 9.0)
    assert parse_init(b"(init a:b (version 9))", "11.1") == Refusal("(error illegal_teamname_or_too_long_teamname)")


@pytest.mark.parametrize(
    ("text", "parsed"),
    [
        ("(init)", TrainerInit(3.0)),
        ("(init (version 7.5))", TrainerInit(7.5)),
        ("(init", Refusal("(error illegal_command_form)")),
        ("(init (version 0))", Refusal("(error illegal_command_form)")),
        ("", Refusal("(error illegal_command_form)")),
        ("(look)", None),
    ],
)
def test_trainer_inits(text: str, parsed: object) -> None:
    assert parse_trainer_init(text.encode()) == parsed


# --- trainer and monitor -----------------------------------------------------------------------------------------
FORM, OBJECT = Refusal("(error illegal_command_form)"), Refusal("(error illegal_object_form)")


@pytest.mark.parametrize(
    ("text", "parsed"),
    [
        ("(bogus)", Refusal("(error unknown_command)")),
        ("(bye)", Refusal("(error unknown_command)")),
        ("()", FORM),
        ("", FORM),
        ("(start) (look)", Start()),
        ("(check_ball", CheckBall()),
        ("(change_mode play_on", ChangeMode("play_on")),
        ("(change_mode nosuch)", Refusal("(error illegal_mode)")),
        ("(change_mode)", FORM),
        ("(say hello all)", TrainerSay("hello all")),
        ('(say "hello")', FORM),
        ("(say (free (form)))", TrainerSay("(free (form))")),
        ("(say " + "x" * 200 + ")", TrainerSay("x" * 128)),
        ("(say)", FORM),
        ("(ear maybe)", FORM),
        ("(eye)", FORM),
        ("(move (ball) 1 2 30)", MoveBall(1, 2)),
        ("(move (ball) 1 2 30 4)", FORM),
        ("(move (ball) 1)", OBJECT),
        ("(move (ball) nan 1)", OBJECT),
        ("(move (ball) 0x10 1)", MoveBall(16, 1)),
        ("(move (ball) 0x 1)", OBJECT),
        ("(move (ball) 1e 2e+ 3)", MoveBall(1, 2)),
        ("(move (ball) infinity -inf 3)", MoveBall(math.inf, -math.inf)),
        ("(move (ball) 0x1p99999 -0x1p99999 3)", MoveBall(math.inf, -math.inf)),
        ("(move (ball) infi 2)", OBJECT),
        ("(move (ball ) 1 2)", OBJECT),
        ("(move (nobody) 0 0)", OBJECT),
        ("(move (player a 12) 0 0)", OBJECT),
        ("(move (player a) 0 0)", OBJECT),
        ("(move (player a 2) 0 0 1 2)", FORM),
        ("(move ( player a 2) 0 0 1", MovePlayer("a", 2, 0, 0, 1)),
        ("(change_player_type a 1 x)", FORM),
        ("(compression 10)", FORM),
        ("(compression x)", FORM),
    ],
)
def test_trainer_commands_as_the_server_reads_them(text: str, parsed: object) -> None:
    assert parse_trainer_command(text.encode()) == parsed


def test_monitors_may_act_as_trainers_only_where_there_may_be_one() -> None:
    for text, command in (
        (b"(start)", Start()),
        (b"(change_mode play_on)", ChangeMode("play_on")),
        (b"(move (ball) 1 2)", MoveBall(1, 2)),
        (b"(recover)", Recover()),
        (b"(check_ball)", CheckBall()),
    ):
        assert parse_monitor_command(text) == FORM
        assert parse_monitor_command(text, coach_mode=True) == command


@pytest.mark.parametrize(
    "text",
    ["", "(dispstart) ", "(dispfoul 1 2)", "(dispplayer 1 2 3)", "(dispcard 1 2 green)", "(dispdiscard)", "(look)"],
)
def test_monitor_commands_that_are_refused(text: str) -> None:
    assert parse_monitor_command(text.encode()) == FORM


# --- no harm -----------------------------------------------------------------------------------------------------
SNIPPETS = st.sampled_from(
    ["(", ")", " ", '"', "say", "dash", "turn", "kick", "move", "ball", "player", "ear", "on", "l", "our", "init",
     "version", "goalie", "dispinit", "dispfoul", "1", "-2.5", "1e400", "nan", "0x", "1e", "\0", "\n", "\xff",
     "x" * 130]
)  # fmt: skip


@given(st.binary(max_size=60) | st.lists(SNIPPETS, max_size=20).map(lambda parts: "".join(parts).encode("latin-1")))
def test_any_bytes_can_be_read(data: bytes) -> None:
    for profile in ("19.0", "11.1"):
        commands, complete = parse_commands(data, profile)
        assert isinstance(complete, bool)
        assert all(isinstance(command, Command) for command in commands)
        parse_init(data, profile)
    for parsed in (parse_trainer_command(data), parse_monitor_command(data, True)):
        assert isinstance(parsed, (Command, Refusal))
    parse_trainer_init(data)


def test_very_long_numbers_can_be_read() -> None:
    digits = b"9" * 8000
    assert parse_commands(b"(turn " + digits + b")") == ([Turn(-1)], True)
    assert parse_commands(b"(turn 0." + digits + b")") == ([Turn(1)], True)
    assert parse_commands(b"(turn " + b"0" * 8000 + b"7)") == ([Turn(7)], True)
    assert parse_monitor_command(b"(dispdiscard 1 " + digits + b")") == DispDiscard(1, -1)


# --- the fast way out ------------------------------------------------------------------------------------------------
def action(**fields: object) -> np.ndarray:
    record = records.empty(records.ACTION)
    for name, value in fields.items():
        if isinstance(value, bytes):
            record[name][0, : len(value)] = list(value)
        else:
            record[name][0] = value
    return record


@given(
    st.sampled_from([None, Dash, Turn, Kick, Tackle, Catch, Move]),
    st.integers(-100, 100),
    st.integers(-100, 100),
    st.none() | st.integers(-180, 180),
    st.none() | said,
)
def test_actions_are_read_as_they_were_meant(
    kind: type[Command] | None, a: int, b: int, neck: int | None, text: str | None
) -> None:
    kinds: list[type[Command] | None] = [None, Dash, Turn, Kick, Tackle, Catch, Move]
    record = action(
        kind=kinds.index(kind),
        a=a,
        b=b,
        turns_neck=int(neck is not None),
        neck=neck or 0,
        say_n=len(text or ""),
        say=(text or "").encode(),
    )
    expected: list[Command] = []
    if kind in (Kick, Move) or (kind is Dash and b != 0):
        expected.append(kind(a, b))  # type: ignore[call-arg, misc]
    elif kind is not None:
        expected.append(kind(a))  # type: ignore[call-arg]
    if neck is not None:
        expected.append(TurnNeck(neck))
    if text is not None:
        expected.append(Say(text))
    data = action_to_bytes(record)
    assert data == (datagram(*expected) if expected else b"")
    assert parse_commands(data) == (expected, bool(expected))


def test_an_action_as_bytes() -> None:
    record = action(kind=records.KICK, a=56.0, b=-12.0, turns_neck=1, neck=3.0, say_n=3, say=b"abc")
    assert action_to_bytes(record) == b'(kick 56 -12)(turn_neck 3)(say "abc")\0'
    assert action_to_bytes(action(a=math.nan, neck=math.nan)) == b""
    assert action_to_bytes(action(kind=records.TURN, a=-0.4)) == b"(turn 0)\0"
    assert action_to_bytes(action(kind=records.MOVE, a=-1e6, b=1e6)) == b"(move -1000000 1000000)\0"


@pytest.mark.parametrize(
    ("fields", "hint"),
    [
        ({"kind": 7}, "kind must be 0 to 6"),
        ({"kind": 1, "a": math.nan}, "field a must be a finite number"),
        ({"kind": 1, "b": math.inf}, "field b"),
        ({"turns_neck": 1, "neck": 1e7}, "field neck"),
        ({"say_n": 11}, "at most 10 characters"),
        ({"say_n": 2, "say": b'a"'}, "letters, digits"),
        ({"say_n": 2, "say": b"a"}, "letters, digits"),
    ],
)
def test_illegal_actions_say_what_would_be_right(fields: dict[str, object], hint: str) -> None:
    with pytest.raises(LocalProtocolError, match=hint):
        action_to_bytes(action(**fields))
