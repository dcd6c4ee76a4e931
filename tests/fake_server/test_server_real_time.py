"""Real time: cycles of 100 ms, see messages in between, no catching up."""

from __future__ import annotations

import re
import time

from server_clients import options, serving

from fake_server.clock import RealTimeClock


def test_sense_body_and_see_come_at_their_times() -> None:
    with serving(options(visible_angle=360.0)) as clients:
        player = clients.player()
        player.until(r"\(sense_body")
        kinds, senses = [], []
        while len(senses) < 13:
            kinds.append(re.match(r"\((\w+)", player.receive())[1])
            if kinds[-1] == "sense_body":
                senses.append(time.monotonic())
        # every 100 ms; on a busy machine later, never earlier on average
        assert senses[-1] - senses[0] > 1.15
        # normal view: a see every 150 ms
        assert 7 <= kinds.count("see") <= 9


def test_slow_down_factor_stretches_time() -> None:
    with serving(options(slow_down_factor=3)) as clients:
        player = clients.player()
        player.until(r"\(sense_body")
        started = time.monotonic()
        for _ in range(2):
            player.until(r"\(sense_body")
        assert time.monotonic() - started > 0.5


def test_lost_time_is_not_caught_up() -> None:
    with serving(options()) as clients:
        monitor = clients.monitor()
        monitor.until(r"\(show ")
        server = clients.server
        step, slow = server.step, []

        def stumble() -> None:
            if len(slow) == 0:
                slow.append(time.sleep(0.7))
            step()

        server.step = stumble  # type: ignore[method-assign]
        stopped = [int(server.game.match["stopped"][0])]
        while not slow:
            time.sleep(0.01)
        time.sleep(0.5)
        stopped.append(int(server.game.match["stopped"][0]))
        assert stopped[1] - stopped[0] <= 8  # 1.2 s and more have gone by


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
