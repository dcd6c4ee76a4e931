"""Compile everything a match needs before any client waits for an answer."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from fake_server import binary, text
from fake_server.digits import ascii_bytes
from fake_server.game import Game
from fake_server.options import ServerOptions
from fake_server.show import MAX_SHOW, monitor_head, write_show
from fake_server.simulation import body, clock, commands, hearing, vision
from fake_server.simulation.state import MAX_MESSAGES, N_PLAYERS, PHYSICS, PLAY_ON
from rcss_hat.numeric.jit import is_cached
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import SEE, SENSE_BODY, empty

NEWEST = 19
"""A protocol version whose messages have all parts."""


def warm_up(quiet: bool = False) -> None:
    """Compile the simulation and its texts, or load them from the cache, by playing some steps of a match of its own.

    Parameters
    ----------
    quiet : bool
        Say nothing of it on standard error.
    """
    if not quiet and not is_cached("fake_server.simulation.cycle"):
        print("Compiling the simulation (once per installation, up to a minute) ...", file=sys.stderr, flush=True)
    values = {"keepaway": True, "synch_mode": True, "visible_angle": 360.0}
    game = Game(replace(ServerOptions(), params=ServerParams("19.0", **values)), seed=0)
    players = [game.join("left", NEWEST, True), game.join("right", 11, False)]
    _command(game, players[0])
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
    game.change_mode(PLAY_ON)
    game.move_ball(0.0, 0.0, (0.0, 0.0))
    game.move_player(i, 1.0, 1.0, 0.0, (0.0, 0.0))
    game.recover()
    game.substitute(i, 0)
    text.arm_target(game.match, i)
    binary.show_2(game.match, game.kernel, game.teams)


def _perceive(game: Game, players: list[int]) -> None:
    see, sense, due = empty(SEE), empty(SENSE_BODY), np.zeros(N_PLAYERS, dtype=np.uint8)
    buffer, frame = np.zeros(text.MAX_MESSAGE, dtype=np.uint8), np.zeros(MAX_SHOW, dtype=np.uint8)
    names, sizes = text.team_names("left", "right")
    order = np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
    ends = np.zeros(MAX_MESSAGES, dtype=np.int64)
    wanted = np.ones(N_LANDMARKS, dtype=np.uint8)
    for i in players:
        body.sense_body(game.match, game.kernel, game.types, i, sense)
        text.write_sense_body(sense, game.match, i, buffer)
        text.write_fullstate(game.match, i, ascii_bytes(game.mode_name), buffer)
        n = hearing.deliver(game.match, game.kernel, i, game.streams, order)
        text.write_hear(game.match, i, order, n, buffer, ends)
        vision.see(game.match, game.kernel, game.types, i, game.streams, wanted, see)
        text.write_see(see, names, sizes, buffer)
    write_show(game.match, game.kernel, 5, ascii_bytes(monitor_head(game.mode, game.teams, game.score)), frame)
    clock.sees_before_think(game.match, game.kernel, due)
    clock.sees_after_think(game.match, game.kernel, due)
    clock.tick(game.match, game.kernel, due)


def _command(game: Game, i: int) -> None:
    match, params, types, rng = game.match, game.kernel, game.types, game.streams[PHYSICS]
    commands.move(match, params, types, i, -5.0, 0.0, rng)
    commands.dash(match, params, types, i, 50.0, 0.0)
    commands.dash_legs(match, params, i, commands.LEFT_LEG, 50.0, 0.0)
    commands.turn(match, params, types, i, 10.0, rng)
    commands.kick(match, params, types, i, 10.0, 0.0, rng)
    commands.tackle(match, params, types, i, 0.0, False, rng)
    commands.catch_ball(match, params, types, i, 0.0, rng)
    commands.too_many_moves(match, params, i)
    commands.turn_neck(match, params, i, 5.0)
    commands.say(match, params, i, np.frombuffer(b"hello", dtype=np.uint8), 5)
    commands.change_view(match, i, 1, 1)
    commands.point_to(match, params, i, 5.0, 0.0)
    commands.point_to_off(match, params, i)
    commands.attention_to(match, i, 1, 1)
    commands.attention_off(match, i)
    commands.change_focus(match, params, i, 1.0, 1.0)
    commands.synch_see(match, i)
    commands.gaussian_see(match, i)
