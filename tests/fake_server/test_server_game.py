"""A match without sockets: commands by name, the referee's announcements, what a seed decides."""

from __future__ import annotations

import numpy as np
import pytest

from fake_server.announcements import EPISODE_END
from fake_server.apply import apply
from fake_server.game import Game, JoinError
from fake_server.options import ServerOptions
from rcss_hat.protocol.commands import parse_commands
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.protocol.records import LEFT, NARROW, RIGHT
from rcss_hat.simulation.state import (
    BEFORE_KICK_OFF,
    C_ATTENTIONTO,
    C_CATCH,
    C_CHANGE_FOCUS,
    C_CHANGE_VIEW,
    C_DASH,
    C_KICK,
    C_MOVE,
    C_POINTTO,
    C_SAY,
    C_TACKLE,
    C_TURN,
    C_TURN_NECK,
    DROP_BALL,
    EAR_OTHER_PARTIAL,
    EAR_OWN_PARTIAL,
    FREE_KICK_LEFT,
    GOAL_LEFT,
    PLAY_ON,
    TIME_OVER,
)


def game(profile: str = "19.0", seed: int = 1, **changes: Value) -> Game:
    return Game(ServerOptions(params=ServerParams(profile, **changes)), seed)


def playing(profile: str = "19.0", **changes: Value) -> tuple[Game, int]:
    """A match in play_on with a goalie at the ball, and one opponent."""
    match = game(profile, coach_w_referee=True, **changes)
    i, _ = match.join("keepers", 11, True), match.join("takers", 11, False)
    match.change_mode(PLAY_ON)
    match.move_ball(0.5, 0.0, (0.0, 0.0))
    match.move_player(i, 0.0, 0.0, 0.0)
    return match, i


def do(match: Game, i: int, text: str) -> list[bool]:
    commands, complete = parse_commands(text.encode(), match.params.profile)
    assert complete
    return [apply(match, match.world, i, command) for command in commands]


@pytest.mark.parametrize(
    ("text", "counter"),
    [
        ("(dash 50)", C_DASH), ("(dash 50 90)", C_DASH), ("(dash (l 50 10) (r 30 10))", C_DASH), ("(turn 30)", C_TURN),
        ("(kick 50 10)", C_KICK), ("(tackle 50)", C_TACKLE), ("(tackle 50 on)", C_TACKLE), ("(catch 0)", C_CATCH),
        ("(turn_neck 30)", C_TURN_NECK), ("(say \"hi\")", C_SAY), ("(change_view wide)", C_CHANGE_VIEW),
        ("(pointto 5 30)", C_POINTTO), ("(pointto off)", C_POINTTO), ("(attentionto opp 1)", C_ATTENTIONTO),
        ("(attentionto off)", C_ATTENTIONTO), ("(change_focus 5 10)", C_CHANGE_FOCUS),
    ],
)  # fmt: skip
def test_commands_reach_their_kernels(text: str, counter: int) -> None:
    match, i = playing()
    assert do(match, i, text) == [True]
    match.step()
    counts = match.match["counts"][0, i]
    assert counts[counter] == 1 and counts.sum() == 1


def test_arguments_arrive_in_their_places() -> None:
    match, i = playing(player_rand=0.0, kick_rand=0.0)
    do(match, i, "(turn_neck 30)(change_view narrow high)(attentionto takers 1)(pointto 10 0)(turn 90)(synch_see)")
    match.step()
    row = match.match[0]
    assert np.degrees([row["body"][i], row["neck"][i]]) == pytest.approx([90.0, 30.0])
    assert (row["width"][i], row["synch_see"][i]) == (NARROW, 1)
    assert (row["focus_side"][i], row["focus_unum"][i]) == (RIGHT, 1)
    assert row["arm_pos"][i] == pytest.approx([10.0, 0.0])
    do(match, i, "(attentionto off)(gaussian_see)(dash 100)")
    assert (row["focus_side"][i], row["gaussian_see"][i]) == (0, 1)
    match.step()
    assert row["vel"][i][1] > 0.1 > abs(row["vel"][i][0])


def test_move_is_mirrored_for_the_right_side() -> None:
    match = game()
    i, j = match.join("keepers", 11, False), match.join("takers", 11, False)
    for player in (i, j):
        assert do(match, player, "(move -10 5)(move -20 5)") == [True, False]
    assert match.match["pos"][0, [i, j]].tolist() == [[-10.0, 5.0], [10.0, -5.0]]
    assert match.match["counts"][0, [i, j], C_MOVE].tolist() == [1, 1]


@pytest.mark.parametrize(
    "text", ["(attentionto our 1)", "(attentionto opp 2)", "(attentionto nobody 1)", "(ear (off nobody))", "(score)"]
)
def test_what_has_no_effect_is_not_accepted(text: str) -> None:
    match, i = playing()
    before = match.match.copy()
    assert do(match, i, text) == [False]
    assert match.match.tobytes() == before.tobytes()


@pytest.mark.parametrize(
    ("text", "bits"),
    [
        ("(ear (off))", 15), ("(ear (off our))", 3), ("(ear (off opp))", 12), ("(ear (off l p))", 2),
        ("(ear (off takers complete))", 4), ("(ear (off))(ear (on our partial))", 13), ("(ear (off p))", 10),
    ],
)  # fmt: skip
def test_ears(text: str, bits: int) -> None:
    match, i = playing()
    assert match.match["ear_off"][0, i] == EAR_OWN_PARTIAL | EAR_OTHER_PARTIAL  # until somebody asks for more
    assert all(do(match, i, "(ear (on))" + text))
    assert match.match["ear_off"][0, i] == bits


def test_11_1_reads_and_plays_its_own_way() -> None:
    match, i = playing("11.1")
    match.move_ball(30.0, 0.0, (0.0, 0.0))
    assert do(match, i, "(kick 10 10)(dash -50)") == [False, True]  # a failed kick leaves the cycle free there
    assert match.match["vel"][0, i, 0] == 0.0
    match.step()
    assert match.match["vel"][0, i, 0] < -0.05
    assert not parse_commands(b"(dash 50 90)", "11.1")[1]


def test_teams_are_left_and_right_in_the_order_of_joining() -> None:
    match = game(fixed_teamname_l="Fixed")
    assert [match.join(name, 11, False) for name in ("b", "a", "b", "a")] == [0, 11, 1, 12]
    assert match.teams == ("b", "a")
    assert [match.team_size(0), match.team_size(1)] == [2, 2]
    with pytest.raises(JoinError, match="conflict_with_fixed_teamname"):
        match.join("Fixed", 11, False)


def test_announcements_of_keepaway() -> None:
    match = game(keepaway=True, half_time=-1)
    i, _ = match.join("keepers", 11, False), match.join("takers", 11, False)
    assert match.step() == []
    assert match.kick_off() == ["play_on"]
    assert match.step() == []
    match.move_ball(30.0, 0.0, (0.0, 0.0))
    assert match.step() == [EPISODE_END]
    assert match.last_episode() == (1, 0, 2, False)
    for _ in range(110):
        match.move_player(i, 0.0, 0.0)
        match.move_ball(0.0, 0.5, (0.0, 0.0))
        announced = match.step()
        if announced:
            break
    assert announced == ["drop_ball", "play_on"]


def test_announcements_of_halves_and_the_end() -> None:
    match = game(half_time=1, nr_normal_halfs=2, nr_extra_halfs=0)
    match.join("keepers", 11, False), match.join("takers", 11, False)
    assert match.kick_off() == ["kick_off_l"]
    assert match.change_mode(PLAY_ON) == ["play_on"]
    assert match.kick_off() == ["kick_off_l"]
    match.change_mode(PLAY_ON)
    announced = [match.step() for _ in range(10)]
    assert announced[:-1] == [[]] * 9 and announced[-1] == ["half_time", "before_kick_off"]
    assert match.kick_off() == ["kick_off_r"]
    match.change_mode(PLAY_ON)
    match.step()
    assert match.kick_off() == []  # in the middle of a half
    announced = [match.step() for _ in range(9)]
    assert announced[-1] == ["time_up", "time_over"] and match.mode == TIME_OVER


def test_a_catch_is_announced_and_shown() -> None:
    match, i = playing()
    match.move_ball(-44.5, 0.0, (0.0, 0.0))
    match.move_player(i, -45.0, 0.0)
    assert do(match, i, "(catch 0)") == [True]
    assert match.mode == FREE_KICK_LEFT
    assert match.mode_with_catch == "goalie_catch_ball_l"
    assert match.mode_name == "free_kick_l"


def test_modes_set_by_a_trainer() -> None:
    match, _ = playing()
    assert match.change_mode(GOAL_LEFT) == []
    assert match.change_mode(DROP_BALL) == ["drop_ball"]
    assert match.change_mode(BEFORE_KICK_OFF) == ["before_kick_off"]


def test_fouls_called_by_a_monitor() -> None:
    match, _ = playing()
    assert match.call_foul(1, 10.0, 5.0) == ["foul_r", "free_kick_l"]
    assert match.call_foul(-1, 10.0, 5.0) == ["foul_l", "free_kick_r"]
    assert match.call_foul(0, 1.0, 1.0) == ["drop_ball", "play_on"]
    assert match.match["ball_pos"][0].tolist() == [1.0, 1.0]


def test_substitution_takes_the_values_of_the_type() -> None:
    match, i = playing()
    match.match["stamina"][0, i] = 100.0
    match.substitute(i, 4)
    row = match.match[0]
    assert row["type"][i] == 4 and row["stamina"][i] == 8000.0
    assert row["size"][i] == match.types["player_size"][4]
    assert row["effort"][i] == row["effort_max"][i] == match.types["effort_max"][4]


def test_player_types_hang_on_their_own_seed() -> None:
    first, second = game(seed=1), game(seed=2)
    assert first.player_params["random_seed"] == 1
    assert not np.array_equal(first.types, second.types)
    options = ServerOptions()
    options.player_params.set("random_seed", 7)
    assert Game(options, 3).player_params["random_seed"] == 7


def test_the_wait_for_the_first_kick_off_decides_nothing() -> None:
    matches = []
    for waited in (1, 40):
        match = game(keepaway=True, synch_mode=True, half_time=-1, seed=9)
        players = [match.join("keepers", 11, False) for _ in range(3)] + [match.join("takers", 11, False)]
        for _ in range(waited):
            match.step()
            do(match, players[0], "(turn 30)")
        match.step()
        match.match["body"][0] = match.match["body_pending"][0] = 0.0
        match.kick_off()
        match.step()
        matches.append(match)
    first, second = (m.match for m in matches)
    for name in ("pos", "vel", "ball_pos", "see_ticks", "clock"):
        assert np.array_equal(first[name], second[name]), name
    assert np.array_equal(matches[0].streams, matches[1].streams)


def test_players_are_found_by_side_and_number() -> None:
    match = game()
    assert [match.player_index(*who) for who in ((1, 1), (-1, 11), (0, 1), (1, 0), (1, 12))] == [
        0,
        21,
        None,
        None,
        None,
    ]
    i = match.join("a", 11, True)
    assert (match.team_name(i), match.unum(i), bool(match.match["goalie"][0, i])) == ("a", 1, True)
    match.leave(i)
    assert match.match["flags"][0, i] == 0 and not match.enabled(i)
    assert match.match["focus_side"][0, i] != LEFT


@pytest.mark.parametrize(("referees", "moved"), [(True, True), (False, False)])
def test_opponents_leave_the_centre_circle_only_where_there_are_referees(referees: bool, moved: bool) -> None:
    match = game(coach=True, coach_w_referee=referees)
    i = [match.join(team, 19, False) for team in ("left", "right")][1]
    match.match["pos"][0, i] = 3.0, 0.0
    match.step()
    assert (list(match.match["pos"][0, i]) != [3.0, 0.0]) == moved
