"""Where the time of a simulated cycle goes: ``python scripts/bench/simulation.py [--landmarks N] [--visible-angle A]``.

3 vs 2 Keepaway in compiled loops: every player turns or dashes, turns his neck and speaks in each cycle. Numbers are
processor time, the best of many rounds, in one process on one core; the arena adds the players' own thinking.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rcss_hat.numeric.jit import kernel
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import HEARD, LEFT, RIGHT, SEE, SENSE_BODY, empty
from rcss_hat.simulation import body, clock, commands, cycle, hearing, keepaway, vision
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.state import connect, index, new_match, streams
from rcss_hat.simulation.world import World

ROUNDS = 60
CYCLES = 4000
LETTERS = np.frombuffer(b"0123456789", dtype=np.uint8).copy()

Record = NDArray[np.void]
Bytes = NDArray[np.uint8]


@kernel
def act(world: World, i: int, c: int) -> None:
    if c % 4 == 0:
        commands.turn(world, i, 50.0)
    else:
        commands.dash(world, i, 80.0, 0.0)
    commands.turn_neck(world.match, world.params, i, 5.0)


@kernel
def step(world: World) -> None:
    cycle.play(world)
    cycle.judge(world)


@kernel
def step_idle(world: World, n: int) -> None:
    for _ in range(n):
        step(world)


@kernel
def step_busy(world: World, n: int) -> None:
    for c in range(n):
        for k in range(world.match["n_players"][0]):
            act(world, world.match["players"][0, k], c)
        if c % 10 == 0:
            world.match["ball_vel"][0, 0] = 1.0
        step(world)


@kernel
def look(world: World, landmarks: Bytes, out: Record, n: int) -> None:
    for c in range(n):
        vision.see(world, world.match["players"][0, c % world.match["n_players"][0]], landmarks, False, out)


@kernel
def sense(world: World, out: Record, n: int) -> None:
    for c in range(n):
        body.sense_body(world, world.match["players"][0, c % world.match["n_players"][0]], out)


@kernel
def talk(world: World, letters: Bytes, out: Record, n: int) -> None:
    for _ in range(n):
        for k in range(world.match["n_players"][0]):
            i = world.match["players"][0, k]
            world.match["hear_own"][0, i] = world.match["hear_other"][0, i] = 1.0
            commands.say(world.match, world.params, i, letters, 10)
        hearing.pass_on_messages(world.match)
        for k in range(world.match["n_players"][0]):
            hearing.hear_teammate(world, world.match["players"][0, k], out)


@kernel
def tell_time(world: World, due: Bytes, n: int) -> None:
    for _ in range(n):
        clock.sees_before_think(world.match, world.params, due)
        clock.sees_after_think(world.match, world.params, due)


@kernel
def whole(
    world: World, landmarks: Bytes, letters: Bytes, due: Bytes,
    see_out: Record, sense_out: Record, heard_out: Record, n: int,
) -> None:  # fmt: skip
    for c in range(n):
        step(world)
        for k in range(world.match["n_players"][0]):
            i = world.match["players"][0, k]
            body.sense_body(world, i, sense_out)
            hearing.hear_teammate(world, i, heard_out)
        clock.sees_before_think(world.match, world.params, due)
        for k in range(world.match["n_players"][0]):
            i = world.match["players"][0, k]
            for _ in range(due[i]):
                vision.see(world, i, landmarks, False, see_out)
        for k in range(world.match["n_players"][0]):
            i = world.match["players"][0, k]
            act(world, i, c)
            commands.say(world.match, world.params, i, letters, 10)
        clock.sees_after_think(world.match, world.params, due)
        for k in range(world.match["n_players"][0]):
            i = world.match["players"][0, k]
            for _ in range(due[i]):
                vision.see(world, i, landmarks, False, see_out)


def nanoseconds(run: Callable[[int], None]) -> float:
    """Processor time (ns) per repetition, the best of all rounds."""
    run(1)
    best = float("inf")
    for _ in range(ROUNDS):
        start = time.process_time_ns()
        run(CYCLES)
        best = min(best, (time.process_time_ns() - start) / CYCLES)
    return best


def main() -> None:
    """Measure everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--landmarks", type=int, default=10, help="how many landmarks the players look at (10)")
    parser.add_argument("--visible-angle", type=float, default=360.0)
    options = parser.parse_args()
    server = ServerParams(
        keepaway=1, half_time=-1, use_offside=0, forbid_kick_off_offside=0, stamina_inc_max=3500.0,
        visible_angle=options.visible_angle, synch_mode=1, synch_offset=80,
    )  # fmt: skip
    params = server.record()
    world = World(new_match(params), params, player_types(server, 1), streams(1))
    for side, unum in ((LEFT, 1), (LEFT, 2), (LEFT, 3), (RIGHT, 1), (RIGHT, 2)):
        connect(world.match, params, index(side, unum), 12, False)
    keepaway.kick_off(world)
    due, see_out, sense_out, heard_out = np.zeros(22, np.uint8), empty(SEE), empty(SENSE_BODY), empty(HEARD)

    def wanted(n: int) -> Bytes:
        return np.linspace(0, N_LANDMARKS - 1, n).astype(np.uint8)

    some = wanted(options.landmarks)
    sees = 10.0 / 3.0
    parts: list[tuple[str, float, Callable[[int], None]]] = [
        ("step, nobody moves", 0.0, lambda n: step_idle(world, n)),
        ("commands and step", 1.0, lambda n: step_busy(world, n)),
        ("sense_body, one player", 5.0, lambda n: sense(world, sense_out, n)),
        ("say and hear, all", 1.0, lambda n: talk(world, LETTERS, heard_out, n)),
        ("clock", 1.0, lambda n: tell_time(world, due, n)),
        ("see, no landmarks", 0.0, lambda n: look(world, wanted(0), see_out, n)),
        (f"see, {options.landmarks} landmarks", sees, lambda n: look(world, some, see_out, n)),
        ("see, all landmarks", 0.0, lambda n: look(world, wanted(55), see_out, n)),
    ]
    total = 0.0
    print(f"{'':28}{'ns':>8}{'times/cycle':>13}{'ns/cycle':>10}")
    for name, times, run in parts:
        cost = nanoseconds(run)
        total += times * cost
        share = f"{times:13.2f}{times * cost:10.0f}" if times else ""
        print(f"{name:28}{cost:8.0f}{share}")
    print(f"{'sum':28}{'':21}{total:10.0f}")
    cost = nanoseconds(
        lambda n: whole(
            world, some, LETTERS, due, see_out, sense_out, heard_out, n
        )
    )  # fmt: skip
    print(f"{'whole cycle':28}{cost:8.0f} ns   {1e9 / cost:,.0f} cycles/s")


if __name__ == "__main__":
    main()
