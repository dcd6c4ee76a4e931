"""Real time against synch mode: does our team miss cycles at 100 ms, and does it play as well?

    scripts/bench/real_time.py [--executable RCSSSERVER | --fake] [--matches M] [--episodes N] [--synch-episodes N]

3v2, hand-coded, full vision. A cycle is missed when a player had not decided before the next sense_body came; a
command is lost when the server did not accept it (its counts of kicks, dashes and turns against what was sent): it came
too late and met the next one. When a player sees depends on when it connected, so matches differ, and several are
played. Real time takes its time: 100 hand-coded episodes last about 19 minutes.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
from dataclasses import dataclass, field

import numpy as np

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.records import COUNT_DASH, COUNT_KICK, COUNT_TURN, SENSE_BODY, empty
from rcss_hat.protocol.sense_body import parse_sense_body
from rcss_hat.stage.client import PlayerClient
from rcss_hat.stage.crew import LocalCrew
from rcss_hat.stage.match import Match
from rcss_hat.stage.servers import ServerProcess, find_executable

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


@dataclass
class Played:
    """What some matches came to."""

    durations: list[float] = field(default_factory=list)
    means: list[float] = field(default_factory=list)
    asked: int = 0
    missed: int = 0
    sent: int = 0
    accepted: int = 0

    def text(self) -> str:
        n = len(self.durations)
        interval = 1.96 * float(np.std(self.durations)) / n**0.5
        means = ", ".join(f"{mean:.1f}" for mean in self.means)
        text = f"{n} episodes, mean {np.mean(self.durations):.2f} +/- {interval:.2f} s (matches {means})"
        if self.sent:
            lost = 1.0 - self.accepted / self.sent
            text += f", missed {self.missed / self.asked:.3%} of cycles, lost {lost:.3%} of commands"
        return text


def play(executable: str | None, synch: bool, episodes: int, seed: int, played: Played) -> None:
    """Play a match of so many episodes, and add what it came to."""
    policy = load_policy("hand", TASK.keepers, TASK.takers, seed)
    policy.warm_up()

    async def run() -> tuple[Match, list[Watched], list[float]]:
        async with ServerProcess(TASK, seed, executable, synch_mode=synch) as server:
            await server.answers(300.0)
            crew = LocalCrew(TASK, server.host, server.port, seed, policy)
            match = Match(TASK, (server.host, server.port), seed, None, True, episodes, crew=crew)
            await match.connect()
            watched = [Watched(client) for client in crew.clients]
            await match.play(kick_off=True, server=server)
            durations = [episode.cycles / 10.0 for episode in server.episodes()[:episodes]]
        server.clean()
        return match, watched, durations

    match, watched, durations = asyncio.run(run())
    played.durations += durations
    played.means.append(float(np.mean(durations)))
    played.asked += len(match.crew.seats) * match.cycles
    played.missed += match.missed
    played.sent += sum(player.sent for player in watched)
    played.accepted += sum(player.accepted for player in watched if player.sent)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None, help="an rcssserver [default: the one on PATH]")
    parser.add_argument("--fake", action="store_true", help="the fake server instead")
    parser.add_argument("--matches", type=int, default=4, help="[default: 4]")
    parser.add_argument("--episodes", type=int, default=100, help="in real time [default: 100]")
    parser.add_argument("--synch-episodes", type=int, default=400, help="[default: 400]")
    parser.add_argument("--seed", type=int, default=1, help="of the first match [default: 1]")
    arguments = parser.parse_args()
    executable = None if arguments.fake else find_executable(arguments.executable)
    if executable is None and not arguments.fake:
        raise SystemExit("no rcssserver found; name one by --executable, or take --fake")
    name = "fake" if executable is None else "real"
    for synch, episodes in ((True, arguments.synch_episodes), (False, arguments.episodes)):
        played, each = Played(), episodes // arguments.matches
        for number in range(arguments.matches if each else 0):
            play(executable, synch, each, arguments.seed + number, played)
        if each:
            mode = "synch mode" if synch else "real time"
            print(f"{name}, {mode}: {played.text()} (load {os.getloadavg()[2]:.1f})", flush=True)


if __name__ == "__main__":
    main()
