"""Recorded data for the tests of the simulation, and matches made from it."""

from __future__ import annotations

import csv
import gzip
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numba import config
from numpy.typing import NDArray

from fake_server.soccer.tackle import tackle
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import LEFT, RIGHT
from rcss_hat.simulation import commands
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.state import PLAY_ON, connect, index, new_match, streams
from rcss_hat.simulation.world import World as State

DATA = Path(__file__).parents[1] / "data" / "simulation"
COMPILED = not config.DISABLE_JIT
"""Without compilation the tests take smaller samples."""

KEEPAWAY = {
    "keepaway": 1, "half_time": -1, "use_offside": 0, "forbid_kick_off_offside": 0, "stamina_inc_max": 3500.0,
    "visible_angle": 360.0, "synch_mode": 1, "synch_offset": 80,
}  # fmt: skip
QUIET = {"player_rand": 0.0, "ball_rand": 0.0, "kick_rand": 0.0}
FREE = {"half_time": -1, "use_offside": 0, "forbid_kick_off_offside": 0}


class World:
    """A match with everything its kernels want."""

    def __init__(self, players: str = "l1 l2 l3 r1 r2", profile: str = "19.0", seed: int = 1, **changes: Any) -> None:
        self.server = ServerParams(profile, **changes)
        self.params = self.server.record()
        self.types = player_types(self.server, 3)
        self.match = new_match(self.params)
        self.streams = streams(seed)
        for name in players.split():
            connect(self.match, self.params, player(name), 11, False)

    @property
    def state(self) -> State:
        return State(self.match, self.params, self.types, self.streams)

    @property
    def rng(self) -> NDArray[np.uint64]:
        return self.streams[0]

    def play(self) -> World:
        self.match["mode"][0] = PLAY_ON
        return self

    def put(self, name: str, x: float, y: float, vx: float = 0.0, vy: float = 0.0, body: float = 0.0) -> World:
        """Put the ball ("b") or a player somewhere; body in degrees."""
        if name == "b":
            self.match["ball_pos"][0] = x, y
            self.match["ball_vel"][0] = vx, vy
            self.match["ball_acc"][0] = 0.0
            return self
        i = player(name)
        self.match["pos"][0, i] = x, y
        self.match["vel"][0, i] = vx, vy
        self.match["acc"][0, i] = 0.0
        self.face(name, body)
        return self

    def face(self, name: str, body: float, neck: float = 0.0) -> World:
        i = player(name)
        self.match["body"][0, i] = self.match["body_pending"][0, i] = math.radians(body)
        self.match["neck"][0, i] = self.match["neck_pending"][0, i] = math.radians(neck)
        return self

    def command(self, name: str, text: str) -> None:
        """Execute the commands of a datagram."""
        i, m, p = player(name), self.match, self.params
        for command in re.findall(r"\(([^()]*)\)", text):
            kind, *words = command.split()
            numbers = [float(word) for word in words]
            if kind == "dash":
                commands.dash(self.state, i, numbers[0], numbers[1] if len(numbers) > 1 else 0.0)
            elif kind == "turn":
                commands.turn(self.state, i, numbers[0])
            elif kind == "kick":
                commands.kick(self.state, i, numbers[0], numbers[1])
            elif kind == "tackle":
                tackle(self.state, i, numbers[0], False)
            elif kind == "turn_neck":
                commands.turn_neck(m, p, i, numbers[0])
            else:
                raise ValueError(f"no kernel for {command}")


def player(name: str) -> int:
    """Index of "l1" .. "r11"."""
    return int(index(LEFT if name[0] == "l" else RIGHT, int(name[1:])))


def rows(name: str) -> Iterator[dict[str, str]]:
    """Read a gzipped CSV file of the test data."""
    with gzip.open(DATA / name, "rt", newline="") as file:
        yield from csv.DictReader(file)


def json_lines(name: str) -> list[dict[str, Any]]:
    with gzip.open(DATA / name, "rt") as file:
        return [json.loads(line) for line in file]
