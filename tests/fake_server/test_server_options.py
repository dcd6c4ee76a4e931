"""The command line: what is understood, and how clearly the rest is refused."""

from __future__ import annotations

import shlex

import pytest

from fake_server.options import HelpRequested, UsageError, parse_options, without_effect


def test_options_of_the_keepaway_start_script() -> None:
    line = """server::port=5800 server::coach_port=5801 server::olcoach_port=5802 server::half_time=-1
        server::forbid_kick_off_offside=0 server::use_offside=0 server::stamina_inc_max=3500 server::synch_mode=0
        server::synch_offset=80 server::keepaway=1 server::keepaway_start=8 server::keepaway_width=20
        server::keepaway_length=20 server::keepaway_logging=1 server::keepaway_log_dir=/var/logs
        server::keepaway_log_fixed=1 server::keepaway_log_fixed_name=202611221200-host server::game_logging=0
        server::game_log_dir=/var/logs server::game_log_compression=0 server::game_log_version=5
        server::game_log_fixed=1 server::game_log_fixed_name=202611221200-host server::text_logging=0
        server::text_log_dir=/var/logs server::text_log_compression=0 server::text_log_fixed=1
        server::text_log_fixed_name=202611221200-host server::visible_angle=360 server::coach=0"""
    params = parse_options(line.split()).params
    assert (params["port"], params["half_time"], params["visible_angle"]) == (5800, -1, 360.0)
    assert params["keepaway"] is True
    assert params["keepaway_log_fixed_name"] == "202611221200-host"


def test_own_options_may_stand_anywhere() -> None:
    line = "server::kick_rand=0.2 --profile 11.1 --seed=7 --bind 0.0.0.0 player::player_types=3 --episodes 5 --quiet"
    options = parse_options([*line.split(), "--patience", "2.5"])
    assert (options.seed, options.bind, options.episodes, options.quiet) == (7, "0.0.0.0", 5, True)
    assert (options.patience, parse_options([]).patience) == (2.5, 1.25)
    assert options.params.profile == "11.1"
    assert options.params["kick_rand"] == 0.2
    assert options.params["stamina_max"] == 4000.0
    assert options.player_params["player_types"] == 3
    assert options.player_params["pt_max"] == 3


@pytest.mark.parametrize(("text", "value"), [("1", True), ("ON", True), ("true", True), ("0", False), ("off", False)])
def test_booleans(text: str, value: bool) -> None:
    assert parse_options([f"server::keepaway={text}"]).params["keepaway"] is value


def test_texts_may_be_quoted() -> None:
    params = parse_options(["server::keepaway_log_dir='a b'", 'server::game_log_dir="c"']).params
    assert (params["keepaway_log_dir"], params["game_log_dir"]) == ("a b", "c")


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("server::prt=1", "unknown parameter server::prt; did you mean server::port?"),
        ("player::random_sed=1", "did you mean player::random_seed?"),
        ("server::random_seed=1", "the seed of the simulation is --seed N"),
        ("server::port=abc", "server::port takes an integer, not 'abc'"),
        ("server::port=70000", "takes a port, 0 to 65535"),
        ("server::half_time=1.5", "takes an integer, not '1.5'"),
        ("server::keepaway=2", "takes 0, 1, true, false, on or off, not '2'"),
        ("server::ball_decay=nan", "takes a number, not 'nan'"),
        ("server::ball_decay=1_0", "takes a number, not '1_0'"),
        ("server::keepaway", "server::keepaway needs a value: server::keepaway=1"),
        ("CSVSavr::save=1", "unknown name space in 'CSVSavr::save=1'; did you mean CSVSaver"),
        ("SERVER::port=1", "unknown name space in 'SERVER::port=1'; did you mean server?"),
        ("nothing::port=1", "there are server, player, CSVSaver, MySQLSaver, STDOUTSaver"),
        ("CSVSaver::sav=1", "unknown parameter CSVSaver::sav; did you mean CSVSaver::save?"),
        ("keepaway=1", "unknown option 'keepaway=1'; did you mean server::keepaway?"),
        ("server::port = server::keepaway=1", "cannot read 'server::keepaway=1': server::port needs '=' and a value"),
        ("server::port=", "server::port needs a value: server::port=6000"),
        ("server::port=99999999999", "server::port takes an integer"),
        ("server::fixed_teamname_l='A B'", "takes up to 15 of letters, digits, +, - and _, not 'A B'"),
        ("server::fixed_teamname_l=A server::fixed_teamname_r=A", "are both 'A'; they must differ"),
        ("server::game_log_version=0", "takes a version, 1 to 6, or -1 for JSON, not 0"),
        ("--profile=11.1 server::game_log_version=-1", "takes a version, 1 to 6, not -1"),
        ("--sed 3", "did you mean --seed?"),
        ("--seed", "--seed needs a value"),
        ("--seed -1", "--seed takes an integer of at least 0, not '-1'"),
        ("--episodes 0", "--episodes takes an integer of at least 1"),
        ("--patience 0", "--patience takes seconds, more than 0 and at most 3600, not '0'"),
        ("--patience long", "not 'long'"),
        ("--profile 12", "--profile takes 19.0 or 11.1, not '12'"),
        ("server::say_msg_size=20", "at most 10"),
        ("server::game_log_version=7", "at most 6"),
        ("server::simulator_step=0", "at least"),
        ("server::game_log_compression=10", "at most 9"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(line: str, complaint: str) -> None:
    with pytest.raises(UsageError) as error:
        parse_options(shlex.split(line))
    assert complaint in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("word", ["--help", "-h", "help", "--HELP"])
def test_help(word: str) -> None:
    with pytest.raises(HelpRequested):
        parse_options(["server::keepaway=1", word])


def test_parameters_that_change_nothing_are_named() -> None:
    line = "server::wind_force=3 server::verbose=0 player::subs_max=5 server::keepaway=1"
    assert without_effect(parse_options(line.split())) == ["player::subs_max", "server::wind_force"]
    assert without_effect(parse_options(["--profile=11.1"])) == []


def test_other_name_spaces_are_named_when_they_ask_for_something() -> None:
    line = "CSVSaver::save = true CSVSaver::filename=a.csv MySQLSaver::host=db CSVSaver::version='19.0.0'"
    assert without_effect(parse_options(line.split())) == ["CSVSaver::filename", "CSVSaver::save", "MySQLSaver::host"]
    assert without_effect(parse_options(["CSVSaver::save=off", "CSVSaver::filename='rcssserver.csv'"])) == []


@pytest.mark.parametrize(
    "switched_off", ["penalty_shoot_outs=0", "back_passes=0", "free_kick_faults=off", "wind_none=1"]
)
def test_what_is_not_done_here_may_be_switched_off(switched_off: str) -> None:
    assert without_effect(parse_options([f"server::{switched_off}"])) == []
