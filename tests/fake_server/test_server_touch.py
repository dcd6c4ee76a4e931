"""Goals, the ball beyond the lines, types at the kick-off, and what a general match is told it has to do without."""

from __future__ import annotations

import numpy as np
import pytest
from server_clients import options, serving

from fake_server.game import Game
from fake_server.options import ServerOptions
from fake_server.player_param import PlayerParams
from fake_server.soccer.touch import TouchReferee
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.simulation.state import PLAY_ON

LEFT, RIGHT = 0, 11


def game(player_params: dict[str, Value] | None = None, **changes: Value) -> Game:
    params = ServerParams("19.0", **{"coach_w_referee": True, "ball_rand": 0.0} | changes)
    match = Game(ServerOptions(params=params, player_params=PlayerParams("19.0", **player_params or {})), 1)
    match.join("lefties", 11, False)
    match.join("righties", 11, False)
    return match


def played(x: float, y: float, vx: float, vy: float, touched_by: int | None, mode: str = "play_on") -> Game:
    """A match in which the ball is about to leave the field from a place."""
    match = game()
    match.change_mode(PLAY_MODE_IDS[mode])
    match.move_ball(x, y, (0.0, 0.0))
    match.step()
    match.move_ball(x, y, (vx, vy))
    if touched_by is not None:
        referee(match).touched(touched_by, 1.0)
    return match


def referee(match: Game) -> TouchReferee:
    assert match.touch is not None
    return match.touch


def ball(match: Game) -> list[float]:
    return [round(v, 3) for v in match.match["ball_pos"][0].tolist()]


def test_a_goal_is_counted_and_followed_by_a_kick_off() -> None:
    match = played(51.0, 3.0, 2.5, 0.0, LEFT)
    assert match.step() == ["goal_l_1"]
    assert (match.score, match.mode_name) == ((1, 0), "goal_l")
    announced = [message for _ in range(51) for message in match.step()]
    assert announced == ["kick_off_r"]
    assert ball(match) == [0.0, 0.0] and match.score == (1, 0)


@pytest.mark.parametrize("toucher", [LEFT, RIGHT, None])
def test_own_goals_count_too(toucher: int | None) -> None:
    match = played(-51.0, -3.0, -2.5, 0.0, toucher)
    assert match.step() == ["goal_r_1"]
    assert (match.score, match.mode_name) == ((0, 1), "goal_r")


@pytest.mark.parametrize(
    ("start", "toucher", "mode", "place"),
    [
        ((51.0, 20.0, 2.5, 0.0), LEFT, "goal_kick_r", [47.0, 9.16]),
        ((51.0, -20.0, 2.5, 0.0), RIGHT, "corner_kick_l", [51.5, -33.0]),
        ((-51.0, 20.0, -2.5, 0.0), LEFT, "corner_kick_r", [-51.5, 33.0]),
        ((-51.0, -20.0, -2.5, 0.0), None, "goal_kick_l", [-47.0, -9.16]),
        ((10.0, 33.0, 0.0, 2.5), LEFT, "kick_in_r", [10.0, 34.0]),
        ((10.0, -33.0, 0.0, -2.5), RIGHT, "kick_in_l", [10.0, -34.0]),
    ],
)
def test_the_ball_beyond_a_line(start: tuple[float, ...], toucher: int | None, mode: str, place: list[float]) -> None:
    x, y, vx, vy = start
    match = played(x, y, vx, vy, toucher)
    assert match.step() == [mode]
    assert (match.mode_name, ball(match)) == (mode, place)
    assert match.step() == []


def test_the_ball_is_dropped_when_nobody_has_touched_it() -> None:
    match = played(10.0, 33.0, 0.0, 2.5, None)
    assert match.step() == ["drop_ball", "play_on"]
    assert ball(match) == [10.0, 34.0]


def test_the_goal_line_beside_the_goal_is_no_goal() -> None:
    match = played(51.0, 7.2, 2.5, 1.0, LEFT)
    assert match.step() == ["goal_kick_r"]


def test_an_indirect_free_kick_does_not_score_until_a_second_player_has_kicked() -> None:
    match = played(51.0, 0.0, 2.5, 0.0, LEFT, mode="indirect_free_kick_l")
    assert match.step() == ["play_on", "goal_kick_r"]
    match = played(51.0, 0.0, 0.5, 0.0, LEFT, mode="indirect_free_kick_l")
    assert match.step() == ["play_on"]
    referee(match).touched(RIGHT, 1.0)
    match.move_ball(51.0, 0.0, (2.5, 0.0))
    assert match.step() == ["goal_r_1" if match.score[1] else "goal_l_1"]


def test_a_golden_goal_ends_the_match() -> None:
    match = game(golden_goal=True, nr_normal_halfs=0, nr_extra_halfs=2)
    match.change_mode(PLAY_ON)
    match.move_ball(51.0, 0.0, (2.5, 0.0))
    assert match.step() == ["goal_l_1", "time_over"]


def test_a_goalie_with_the_ball_behind_the_line_has_left_his_area() -> None:
    match = played(51.0, 20.0, 2.5, 0.0, LEFT)
    match.match["catcher"] = RIGHT
    match.match["pos"][0, RIGHT] = (53.5, 20.0)
    assert match.step() == ["catch_fault_r"]


def test_who_collides_with_the_ball_has_touched_it() -> None:
    match = played(10.0, 30.0, 0.0, 0.6, LEFT)
    assert match.step() == []
    match.move_player(RIGHT, 10.0, 31.5)
    match.move_ball(10.0, 30.6, (0.0, 0.6))
    assert match.step() == []
    match.move_player(RIGHT, 0.0, 0.0)
    match.move_ball(10.0, 33.5, (0.0, 1.0))
    assert match.step() == ["kick_in_l"]


def test_nothing_is_judged_in_keepaway_without_referees_and_in_shoot_outs() -> None:
    assert game(keepaway=True).touch is None
    assert game(coach=True, coach_w_referee=False).touch is None
    match = played(51.0, 0.0, 0.0, 0.0, LEFT, mode="penalty_setup_l")
    match.move_ball(53.5, 0.0, (0.0, 0.0))
    assert match.step() == [] and match.score == (0, 0)


def types(match: Game) -> list[tuple[int, int]]:
    changes = match.line_up.at_kick_off()
    for i, kind in changes:
        match.substitute(i, kind)
    return changes


def test_everybody_has_a_type_of_his_own_from_the_kick_off_on() -> None:
    match = game()
    match.join("lefties", 11, True)
    match.join("lefties", 11, False)
    match.join("lefties", 11, False)
    match.substitute(3, 2)
    assert types(match) == [(0, 1), (2, 3)]  # the goalie, number 2, keeps 0
    assert match.match["type"][0, :4].tolist() == [1, 0, 3, 2]
    assert types(match) == []


@pytest.mark.parametrize("most", [1, 2])
def test_no_type_is_played_more_often_than_allowed(most: int) -> None:
    match = game({"pt_max": most, "player_types": 3})
    for _ in range(3):
        match.join("lefties", 11, False)
    match.substitute(0, 1)
    match.substitute(1, 1)
    types(match)
    counts = np.bincount(match.match["type"][0, :4], minlength=3)
    assert counts.max() <= max(most, 2) and counts[1] >= 1


def test_types_stay_where_the_original_leaves_them() -> None:
    assert game(keepaway=True).line_up.at_kick_off() == []
    assert game({"allow_mult_default_type": True}).line_up.at_kick_off() == []
    assert Game(ServerOptions(ServerParams("11.1"), PlayerParams("11.1")), 1).line_up.at_kick_off() == []


def test_players_are_told_types_before_the_kick_off() -> None:
    with serving(options(coach_w_referee=True)) as clients:
        players = [clients.player("a"), clients.player("a"), clients.player("b")]
        clients.trainer().send("(start)")
        told = [[m for m in player.until(r"\(hear 0 referee kick_off_l") if "type 2" in m] for player in players]
        assert told == [["(change_player_type 2 1)"], ["(change_player_type 2 1)"], ["(change_player_type 2)"]]


def test_a_general_match_is_told_once_what_is_not_judged(capfd: pytest.CaptureFixture[str]) -> None:
    with serving(options(coach_w_referee=True, send_comms=True)) as clients:
        clients.player()
        trainer, monitor = clients.trainer(), clients.monitor()
        assert trainer.ask("(start)", r"\(ok") == "(ok start)"
        assert "offside, fouls" in monitor.until(r"\(msg 0 1 \"\(not judged")[-1]
        trainer.ask("(change_mode play_on)", r"\(ok")
    assert capfd.readouterr().err.count("not judged here: offside") == 1


def test_a_drawn_match_is_told_that_no_shoot_out_follows(capfd: pytest.CaptureFixture[str]) -> None:
    wanted = options(coach_w_referee=True, half_time=1, nr_extra_halfs=0, simulator_step=10, synch_mode=False)
    with serving(wanted) as clients:
        player, _ = clients.player("a"), clients.player("b")
        trainer = clients.trainer()
        for _ in range(2):
            trainer.send("(start)")
            player.until(r"\(hear \d+ referee (half_time|time_up)")
    assert "the penalty shoot-out is not simulated here" in capfd.readouterr().err


def test_keepaway_is_told_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    with serving(options(keepaway=True)) as clients:
        clients.player()
        monitor = clients.monitor()
        monitor.send("(dispstart)")
        monitor.until(r"\(show [0-9]+ \(pm 3\)")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(("version", "said"), [(17, False), (18, True), (19, True)])
def test_who_sees_in_step_is_told_so(version: int, said: bool) -> None:
    with serving(options()) as clients:
        player = clients.player(version=version)
        assert ("(ok synch_see)" in player.until(r"\(sense_body")) == said
        again = clients.open()
        player.send("(bye)")
        assert again.join("(reconnect keepers 1)") == "(reconnect l before_kick_off)"
        assert "(ok synch_see)" not in again.until(r"\(sense_body")
