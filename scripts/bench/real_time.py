"""Real time against synch mode: does our team miss cycles at 100 ms, and does it play as well?

    scripts/bench/real_time.py [--executable RCSSSERVER | --fake] [--episodes N] [--synch-episodes N]

3v2, hand-coded, full vision. A cycle is missed when a player had not decided before the next sense_body came; a
command is lost when the server did not accept it (its counts of kicks, dashes and turns against what was sent): it came
too late and met the next one. Real time takes its time: 100 hand-coded episodes last about 19 minutes.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
from collections.abc import Callable

import numpy as np

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.records import COUNT_DASH, COUNT_KICK, COUNT_TURN, SENSE_BODY, empty
from rcss_hat.protocol.sense_body import parse_sense_body
from rcss_hat.team.client import PlayerClient
from rcss_hat.team.match import Match
from rcss_hat.team.servers import ServerProcess, find_executable

TASK = Task()
_BODY = re.compile(rb"\((kick|dash|turn) ")
_COUNTED = [COUNT_KICK, COUNT_DASH, COUNT_TURN]


class Watched:
    """Counts the body commands a client sends, and those the server says it accepted."""

    def __init__(self, client: PlayerClient) -> None:
        self.sent, self._sense = 0, b""
        self._send, self._receive = client.connection.send_now, client.player.receive
        client.connection.send_now = self._sending  # type: ignore[method-assign]
        client.player.receive = self._receiving  # type: ignore[method-assign]

    def _sending(self, data: bytes) -> None:
        self.sent += bool(_BODY.search(data))
        self._send(data)

    def _receiving(self, data: bytes) -> list[bytes]:
        if data.startswith(b"(sense_body"):
            self._sense = data
        return self._receive(data)

    @property
    def accepted(self) -> int:
        sense = empty(SENSE_BODY)
        parse_sense_body(self._sense, sense)
        return int(sense["counts"][0, _COUNTED].sum())


def play(executable: str | None, synch: bool, episodes: int, say: Callable[[int], None]) -> dict[str, float]:
    policy = load_policy("hand", TASK.keepers, TASK.takers, 1)
    policy.warm_up()

    async def run() -> tuple[Match, list[Watched], list[float]]:
        async with ServerProcess(TASK, 1, executable, synch_mode=synch) as server:
            await server.answers(300.0)
            match = Match(TASK, server.host, server.port, 1, policy, True, episodes, lambda n, cycle: say(n))
            await match.connect()
            watched = [Watched(client) for client in match.clients]
            await match.play(kick_off=True, server=server)
            durations = [episode.cycles / 10.0 for episode in server.episodes()[:episodes]]
        server.clean()
        return match, watched, durations

    match, watched, durations = asyncio.run(run())
    asked = len(match.players) * match.cycles
    sent = sum(player.sent for player in watched)
    return {
        "episodes": len(durations),
        "mean": float(np.mean(durations)),
        "ci": 1.96 * float(np.std(durations)) / len(durations) ** 0.5,
        "missed": match.missed / asked,
        "lost": 1.0 - sum(player.accepted for player in watched) / sent if sent else 0.0,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None, help="an rcssserver [default: the one on PATH]")
    parser.add_argument("--fake", action="store_true", help="the fake server instead")
    parser.add_argument("--episodes", type=int, default=100, help="in real time [default: 100]")
    parser.add_argument("--synch-episodes", type=int, default=400, help="[default: 400]")
    arguments = parser.parse_args()
    executable = None if arguments.fake else find_executable(arguments.executable)
    if executable is None and not arguments.fake:
        raise SystemExit("no rcssserver found; name one by --executable, or take --fake")
    name = "fake" if executable is None else "real"
    for synch, episodes in ((True, arguments.synch_episodes), (False, arguments.episodes)):
        if not episodes:
            continue
        mode = "synch mode" if synch else "real time"
        result = play(executable, synch, episodes, lambda n: print(f"  {n}", end="\r", flush=True))
        load = os.getloadavg()[2]
        line = f"{name}, {mode}: {result['episodes']} episodes, mean {result['mean']:.2f} +/- {result['ci']:.2f} s"
        if not synch:
            line += f", missed {result['missed']:.3%} of cycles, lost {result['lost']:.3%} of commands"
        print(f"{line} (load {load:.1f})", flush=True)


if __name__ == "__main__":
    main()
