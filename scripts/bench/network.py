#!/usr/bin/env python3
"""What a bad network does to a match: is it counted right, or refused?

    scripts/bench/network.py [--executable RCSSSERVER] [--episodes N] [--only WORD ...] [--timeout S]

Five players (3v2, always hold) reach a server through a relay that loses, doubles, reorders or delays datagrams in both
directions, by a seed. They are told the server's address and nothing else, so what they report is what they heard. A
match is *counted* when this is what the server has logged itself (the same episodes, the same cycles); it is *refused*
when the command says that it could not play or count it, and exits 1. Anything else is *WRONG*; then this script exits
1, too. A match that takes longer than ``--timeout`` is *not finished*: that says something about the machine.
"""

from __future__ import annotations

import argparse
import asyncio
import time
from dataclasses import dataclass

from rcss_hat.hat.policy import load_policy
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.relay import Network, Relay
from rcss_hat.stage.servers import ServerProcess, find_executable

TASK = Task()
NETWORKS = {
    "good": Network(),
    "1 % lost": Network(loss=0.01),
    "5 % lost": Network(loss=0.05),
    "20 % lost": Network(loss=0.20),
    "20 % doubled": Network(double=0.20),
    "30 % reordered": Network(reorder=0.30),
    "delays to 150 ms": Network(delay=0.15),
    "all of it": Network(loss=0.05, double=0.20, reorder=0.30, delay=0.15),
}


@dataclass
class Outcome:
    """One match."""

    report: RunReport
    logged: list[Episode]
    seconds: float

    @property
    def verdict(self) -> str:
        heard, logged = ([(e.start, e.end) for e in episodes] for episodes in (self.report.episodes, self.logged))
        same = heard == logged[: len(heard)]
        if self.report.failure == INTERRUPTED:
            return "not finished"
        if self.report.failure is not None:
            return "refused"
        return "counted" if same else "WRONG"

    def row(self, stage: str, mode: str, network: str) -> str:
        r = self.report
        said = f": {r.failure}" if self.verdict == "refused" else ""
        figures = f"{len(r.episodes)} | {r.cycles} | {r.missed} | {self.seconds:.0f}"
        return f"| {stage} | {mode} | {network} | {self.verdict}{said} | {figures} |"


async def match(executable: str | None, synch: bool, network: Network, episodes: int, timeout: float) -> Outcome:
    """Play through a relay, and read what the server has logged."""
    policy = load_policy("hold", TASK.keepers, TASK.takers, 1)
    policy.warm_up()
    report = RunReport("relay", "hold", "hand", TASK.size, TASK.field, TASK.vision, 1)
    # No seed: a seeded fake server is more patient with silent players than the original.
    async with ServerProcess(TASK, None, executable, synch_mode=synch) as server:
        await server.answers(300.0)
        async with Relay(server.host, server.port, None, network=network) as relay:
            began = time.monotonic()
            playing = asyncio.create_task(
                play_match(report, Match(TASK, (relay.bind, relay.port), 1, policy, True, episodes))
            )
            await asyncio.wait([playing], timeout=timeout)
            playing.cancel()  # what it has until then is reported as interrupted
            await asyncio.gather(playing, return_exceptions=True)
            seconds = time.monotonic() - began
        logged = server.episodes()
    server.clean()
    return Outcome(report, logged, seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--executable", default=None, help="an rcssserver [default: the one on PATH, if any]")
    parser.add_argument("--episodes", type=int, default=5, help="of each match [default: 5]")
    parser.add_argument("--only", nargs="*", default=[], help="rows whose name has one of these words")
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds of a match [default: 300]")
    arguments = parser.parse_args()
    executable = find_executable(arguments.executable)
    wrong = 0
    print("| server | mode | network | result | episodes | cycles | missed | seconds |\n" + "|---" * 8 + "|")
    for stage in ("fake",) if executable is None else ("fake", "real"):
        for mode in ("synch", "real time"):
            for name, network in NETWORKS.items():
                if arguments.only and not any(word in f"{stage} {mode} {name}" for word in arguments.only):
                    continue
                where = executable if stage == "real" else None
                outcome = asyncio.run(match(where, mode == "synch", network, arguments.episodes, arguments.timeout))
                wrong += outcome.verdict == "WRONG"
                print(outcome.row(stage, mode, name), flush=True)
    raise SystemExit(1 if wrong else 0)


if __name__ == "__main__":
    main()
