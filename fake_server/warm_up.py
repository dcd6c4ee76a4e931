"""Compile everything a match needs before any client waits for an answer."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from fake_server import text
from fake_server.game import Game
from fake_server.options import ServerOptions
from fake_server.perception import Perception
from fake_server.show import monitor_head, show_2, write_show
from fake_server.soccer.catch import catch_ball
from fake_server.soccer.tackle import tackle
from rcss_hat.numeric.compiling import compiling
from rcss_hat.protocol.commands import MAX_DATAGRAM
from rcss_hat.protocol.commands.action import read_action
from rcss_hat.protocol.digits import ascii_bytes
from rcss_hat.protocol.messages.frame import arm_target
from rcss_hat.protocol.messages.show import MAX_SHOW
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import ACTION, SENSE_BODY, empty
from rcss_hat.simulation import body, clock, commands
from rcss_hat.simulation.state import N_PLAYERS, PLAY_ON

NEWEST = 19
"""A protocol version whose messages have all parts."""
KERNELS = (
    "fake_server.text",
    "fake_server.show",
    *(f"rcss_hat.simulation.{name}" for name in ("body", "clock", "commands", "cycle")),
)


def warm_up(quiet: bool = False) -> None:
    """Compile the simulation and its texts, or load them from the cache, by playing some steps of a match of its own.

    Parameters
    ----------
    quiet : bool
        Say nothing of it on standard error.
    """
    with compiling(_unsaid if quiet else _say, "the simulation", *KERNELS):
        _play()


def _say(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


def _unsaid(message: str) -> None:
    return


def _play() -> None:
    values = {"keepaway": True, "synch_mode": True, "visible_angle": 360.0}
    game = Game(replace(ServerOptions(), params=ServerParams("19.0", **values)), seed=0)
    players = [game.join("left", NEWEST, True), game.join("right", 11, False)]
    _command(game, players[0])
    game.step()
    game.kick_off()
    for _ in range(3):
        game.step()
        _perceive(game, players)
        _command(game, players[0])
        _command(game, players[1])
    _referee(game, players[1])
    game.leave(players[0])


def _referee(game: Game, i: int) -> None:
    """Do what trainers and monitors may do."""
    game.call_foul(0, 0.0, 0.0)
    game.call_foul(1, 0.0, 0.0)
    game.step()
    game.change_mode(PLAY_ON)
    game.move_ball(0.0, 0.0, (0.0, 0.0))
    game.move_player(i, 1.0, 1.0, 0.0, (0.0, 0.0))
    game.recover()
    game.substitute(i, 0)
    arm_target(game.match, i)
    show_2(game.match, game.kernel, game.teams)


def _perceive(game: Game, players: list[int]) -> None:
    sense, due = empty(SENSE_BODY), np.zeros(N_PLAYERS, dtype=np.uint8)
    buffer, frame = np.zeros(MAX_DATAGRAM, dtype=np.uint8), np.zeros(MAX_SHOW, dtype=np.uint8)
    i = players[0]
    body.sense_body(game.world, i, sense)  # which a player may ask for
    text.write_sense_body(sense, game.match, i, buffer)
    text.write_fullstate(game.match, i, ascii_bytes(game.mode_name), buffer)
    perception = Perception(game)
    due[players] = 1
    for told in (perception.sense_body(players), perception.hear(players), perception.see(due)):
        for _ in told:
            pass
    write_show(game.match, game.kernel, 5, ascii_bytes(monitor_head(game.mode, game.teams, game.score)), frame)
    clock.sees_before_think(game.match, game.kernel, due)
    clock.sees_after_think(game.match, game.kernel, due)
    clock.tick(game.match, game.kernel, due)


def _command(game: Game, i: int) -> None:
    world, match, params = game.world, game.match, game.kernel
    commands.move(world, i, -5.0, 0.0)
    commands.dash(world, i, 50.0, 0.0)
    commands.dash_legs(match, params, i, commands.LEFT_LEG, 50.0, 0.0)
    commands.turn(world, i, 10.0)
    commands.kick(world, i, 10.0, 0.0)
    tackle(world, i, 0.0, False)
    catch_ball(world, i, 0.0)
    commands.too_many_moves(match, params, i)
    commands.turn_neck(match, params, i, 5.0)
    action = empty(ACTION)
    read_action(b"(turn 1)\0", action)
    commands.act(world, i, action)
    commands.say(match, params, i, np.frombuffer(b"hello", dtype=np.uint8), 5)
    commands.change_view(match, i, 1, 1)
    commands.point_to(match, params, i, 5.0, 0.0)
    commands.point_to_off(match, params, i)
    commands.attention_to(match, i, 1, 1)
    commands.attention_off(match, i)
    commands.change_focus(match, params, i, 1.0, 1.0)
    commands.synch_see(match, i)
    commands.gaussian_see(match, i)
