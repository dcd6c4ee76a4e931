"""The same match with one process per player, as the original players run."""

from __future__ import annotations

import asyncio
import multiprocessing
import time
from multiprocessing.connection import Connection as Pipe
from typing import Any

from rcss_hat.hat.policy import TeamPolicy, load_policy
from rcss_hat.keepaway.report import OUT, TAKEN, Episode, RunReport
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.team.client import PlayerClient
from rcss_hat.team.connection import ServerGone
from rcss_hat.team.kickoff import Referee
from rcss_hat.team.match import (
    COMPILING,
    KEEPERS,
    TAKERS,
    Progress,
    check_keepaway,
    cycles_played,
    never,
    refereed,
)
from rcss_hat.team.refereeing import WrongServer
from rcss_hat.team.servers import ServerFailed, ServerProcess
from rcss_hat.team.trainer import TrainerClient, unless_one_fails

PATIENCE = 120.0
"""Seconds for a process to import, compile and connect."""


class PlayerDied(RuntimeError):
    """A player's process ended by itself."""


def _run_player(pipe: Pipe, task: Task, host: str, port: int, seed: int, policy: str, number: int) -> None:
    """Body of a player's process: keeper ``number`` from 0, or taker ``number - task.keepers``."""
    if number < task.keepers:
        team = load_policy(policy, task.keepers, task.takers, seed)
        team.warm_up()
        decide, ended = team(number)
        player = KeepawayPlayer(KEEPERS, task.keepers, task.takers, seed, decide, ended, team.hold_cycles)
    else:
        player = KeepawayPlayer(TAKERS, task.keepers, task.takers, seed, never)
    player.prepare()
    pipe.send(("ready", player.team))
    pipe.recv()

    async def play() -> None:
        client = PlayerClient(player, host, port)
        await client.connect()
        pipe.send(("connected", player.name))
        told = 0

        def report(player: KeepawayPlayer) -> None:
            nonlocal told
            check_keepaway(player)
            if len(player.episodes) > told:
                told = len(player.episodes)
                pipe.send(("episodes", player.first_cycle, cycles_played(player), player.missed, player.episodes[-1]))

        client.on_message = report if number == 0 else None
        await client.run()

    try:
        asyncio.run(play())
    except (ServerGone, WrongServer, RemoteProtocolError) as error:
        pipe.send(("failed", str(error)))
    except KeyboardInterrupt:
        return


class _Players:
    """The processes of all players and what they say."""

    def __init__(self, task: Task, host: str, port: int, seed: int, policy: TeamPolicy) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipes: list[Pipe] = []
        self.processes: list[Any] = []
        for number in range(task.keepers + task.takers):
            ours, theirs = context.Pipe()
            arguments = (theirs, task, host, port, seed, policy.spec, number)
            process = context.Process(target=_run_player, args=arguments, daemon=True)
            process.start()
            theirs.close()
            self.pipes.append(ours)
            self.processes.append(process)

    async def hear(self, number: int, patience: float | None) -> tuple[Any, ...]:
        """Wait for the next word of a player."""
        try:
            there = await asyncio.to_thread(self.pipes[number].poll, patience)
            message: tuple[Any, ...] = self.pipes[number].recv() if there else ("silent",)
        except (EOFError, OSError):
            raise PlayerDied(f"the process of player {number + 1} died (exit code {self.exit_code(number)})") from None
        if message[0] == "failed":
            raise PlayerDied(str(message[1]))
        return message

    def exit_code(self, number: int) -> int | None:
        self.processes[number].join(1.0)
        code: int | None = self.processes[number].exitcode
        return code

    def check(self) -> None:
        for number, process in enumerate(self.processes):
            if not process.is_alive():
                raise PlayerDied(f"the process of player {number + 1} died (exit code {self.exit_code(number)})")

    def stop(self) -> None:
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            process.join(2.0)


async def _connect(players: _Players, n: int) -> None:
    for number in range(n):
        if (await players.hear(number, PATIENCE))[0] == "silent":
            raise PlayerDied(f"the process of player {number + 1} was not ready within {PATIENCE:.0f} s")
    for number in range(n):  # in order: keepers first, for the server gives the left side to them
        players.pipes[number].send("connect")
        await players.hear(number, PATIENCE)


async def _kick_off(task: Task, host: str, port: int) -> None:
    referee = Referee(host, port)
    await referee.connect()
    await referee.wait_for(task.keepers, task.takers)
    await referee.kick_off()
    await referee.leave()


async def play_in_processes(
    report: RunReport,
    task: Task,
    seed: int,
    policy: TeamPolicy,
    episodes: int,
    server: ServerProcess | None,
    address: tuple[str, int] | None,
    progress: Progress | None = None,
    trainer: TrainerClient | None = None,
) -> None:
    """Play as `rcss_hat.team.match.play` does, every player in a process of its own."""
    host, port = (server.host, server.port) if server is not None else address or ("127.0.0.1", 6000)
    players = _Players(task, host, port, seed, policy)
    ends: list[tuple[int, bool]] = []
    refereeing: list[asyncio.Task[None]] = []
    first, begun = 0, None
    try:
        if server is not None:
            await server.start()
            await server.answers(COMPILING)
        await _connect(players, task.keepers + task.takers)
        if trainer is not None:
            await trainer.connect()
            refereeing.append(asyncio.create_task(trainer.run()))
            await unless_one_fails(trainer.wait_for_start(), refereeing)
        else:
            await _kick_off(task, host, port)
        begun = time.monotonic()
        while len(ends) < episodes:
            message = await players.hear(0, 1.0)
            players.check()
            for running in refereeing:
                if running.done():
                    running.result()
            if server is not None:
                server.check()
            if message[0] == "episodes":
                _, first, report.cycles, report.missed, end = message
                ends.append(end)
                if progress is not None:
                    progress(len(ends), report.cycles)
    except (PlayerDied, ServerFailed, ServerGone, WrongServer, RemoteProtocolError) as error:
        report.failure = str(error)
    except asyncio.CancelledError:
        report.failure = "interrupted"
    finally:
        report.wall_s = time.monotonic() - begun if begun else 0.0
        players.stop()
        for running in refereeing:
            running.cancel()
        await asyncio.gather(*refereeing, return_exceptions=True)
        if trainer is not None:
            trainer.close()
        starts = [first, *(end for end, _ in ends)]
        report.episodes = [
            Episode(k + 1, starts[k], end, TAKEN if taken else OUT) for k, (end, taken) in enumerate(ends)
        ]
        if server is not None:
            await server.stop()
        report.episodes = refereed(report.episodes, server, trainer, episodes)
