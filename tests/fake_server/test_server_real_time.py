"""Real time: cycles of 100 ms, see messages in between, no catching up; who comes and goes meanwhile.

Times are those at which the server simulates a step. A busy machine makes them late, never early; what a client sees
of them may come in bursts.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

from server_clients import keepaway, options, serving, wait_for

from fake_server.clock import RealTimeClock
from fake_server.server import Server
from rcss_hat.keepaway.report import read_kwy

TICK = 0.01
SLACK = 3 * TICK
"""Seconds by which a step may come early: a late one does not put off the next ticks at once."""


def record_steps(server: Server, before: Callable[[int], None] = lambda number: None) -> list[float]:
    """Write down when the server steps; ``before`` is called with the number of each step."""
    step, times = server.step, []

    def timed() -> None:
        before(len(times))
        times.append(time.monotonic())
        step()

    server.step = timed  # type: ignore[method-assign]
    return times


def test_sense_body_and_see_come_at_their_times() -> None:
    with serving(options(visible_angle=360.0)) as clients:
        player = clients.player()
        times = record_steps(clients.server)
        player.until(r"\(sense_body")
        kinds = []
        while kinds.count("sense_body") < 13:
            kinds.append(re.match(r"\((\w+)", player.receive())[1])
        wait_for(lambda: len(times) > 12)
        assert times[12] - times[0] > 1.2 - SLACK
        # normal view: a see every 150 ms
        assert 7 <= kinds.count("see") <= 9


def test_slow_down_factor_stretches_time() -> None:
    with serving(options(slow_down_factor=3)) as clients:
        times = record_steps(clients.server)
        wait_for(lambda: len(times) > 2)
        assert times[2] - times[0] > 2 * 0.3 - 3 * SLACK


def test_lost_time_is_not_caught_up() -> None:
    def stumble(number: int) -> None:
        if number == 2:
            time.sleep(0.7)

    with serving(options()) as clients:
        times = record_steps(clients.server, stumble)
        wait_for(lambda: len(times) > 7)
        assert times[2] - times[1] > 0.7
        assert times[7] - times[2] > 0.5 - SLACK


def test_commands_act_in_the_cycle_in_which_they_come_and_the_first_body_command_wins() -> None:
    with serving(options(coach_w_referee=True, player_rand=0.0)) as clients:
        player, trainer = clients.player(), clients.trainer()
        assert trainer.ask("(change_mode play_on)", r"\((ok|error)") == "(ok change_mode)"
        player.until(r"\(sense_body")
        player.send("(turn 30)(turn 60)(dash 100)")
        told = player.until(r"\(sense_body .*\(turn 1\)")[-1]
        assert "(dash 0) (turn 1)" in told
        player.until(r"\(sense_body")
        assert "1) -3 -37 0 0 30 0)" in trainer.ask("(look)", r"\(ok look")


def test_the_clock_of_a_stopped_server_ends() -> None:
    with serving(options()) as clients:
        clients.server.stop()
        clock = RealTimeClock(clients.server)
        clock.run()
        assert not clients.server.running


def test_a_client_who_vanishes_is_removed_and_time_goes_on() -> None:
    with serving(options()) as clients:
        stays, vanishes = clients.player(), clients.player()
        vanishes.close()
        wait_for(lambda: clients.server.clients.players[1] is None)
        for _ in range(2):
            stays.until(r"\(sense_body")
        again = clients.open()
        assert again.join("(reconnect keepers 2)") == "(reconnect l before_kick_off)"
        assert again.until(r"\(sense_body")


def test_who_comes_back_takes_the_place_of_the_client_who_is_still_there() -> None:
    with serving(options(coach_w_referee=True, player_rand=0.0)) as clients:
        old, new, trainer = clients.player(), clients.open(), clients.trainer()
        assert new.join("(reconnect keepers 1)") == "(reconnect l before_kick_off)"
        assert clients.server.clients.players[0].connection.address == new.socket.getsockname()
        old.send("(turn 90)")  # nobody listens any more
        new.send("(turn 30)")
        new.until(r"\(sense_body .*\(turn 1\)")
        new.until(r"\(sense_body")
        assert "1) -3 -37 0 0 30 0)" in trainer.ask("(look)", r"\(ok look")
        assert old.socket.getsockname() not in clients.server.clients.by_address


def test_who_said_goodbye_may_join_as_another_from_the_same_socket() -> None:
    with serving(options()) as clients:
        player = clients.player()
        player.send("(bye)")
        wait_for(lambda: clients.server.clients.players[0] is None)
        player.send("(init keepers (version 11))", to_door=True)
        assert player.until(r"\((init|error)")[-1] == "(init l 2 before_kick_off)"
        assert player.until(r"\(sense_body")


def test_a_trainer_who_vanishes_makes_room_for_another() -> None:
    with serving(options(coach_w_referee=True)) as clients:
        trainer = clients.trainer()
        assert trainer.ask("(eye on)", r"\(ok eye") == "(ok eye on)"
        trainer.close()
        wait_for(lambda: clients.server.clients.trainer is None)
        assert clients.trainer().ask("(check_ball)", r"\(ok") == "(ok check_ball 0 in_field)"


def test_an_episode_in_real_time(tmp_path: Path) -> None:
    with serving(keepaway(tmp_path, synch_mode=False, coach_w_referee=True)) as clients:
        player, trainer, monitor = clients.player(), clients.trainer(), clients.monitor()
        monitor.send("(dispstart)")
        player.until(r"\(hear \d+ referee play_on\)")
        assert trainer.ask("(move (ball) 30 0)", r"\(ok") == "(ok move)"
        end = int(player.until(r"\(hear \d+ referee training Keepaway 1\)")[-1].split()[1])
        assert [(e.start, e.end, e.reason) for e in read_kwy(tmp_path / "rcssserver.kwy")] == [(0, end, "o")]
        assert player.until(r"\(sense_body")[-1].startswith(f"(sense_body {end} ")
