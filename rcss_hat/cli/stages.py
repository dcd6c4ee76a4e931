"""Playing on whatever stage was asked for: the arena, or a server over UDP, ours or somebody's."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING

import click

from rcss_hat.cli.common import ARENA, INTERRUPTED, REAL, stage_text, tell_of_compilation
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value

if TYPE_CHECKING:
    from rcss_hat.team.servers import ServerProcess
    from rcss_hat.team.trainer import TrainerClient

ENDLESS = 10**9


def play_on_stage(
    report: RunReport,
    task: Task,
    seed: int,
    policy: TeamPolicy,
    stage: str | tuple[str, int],
    episodes: int,
    executable: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    trainer: int | None = None,
) -> None:
    """Play a number of episodes with both teams and fill a report.

    Parameters
    ----------
    report : RunReport
        Filled in place; whatever ends the match early is its ``failure``.
    task, seed, policy, episodes
        As in `rcss_hat.arena.match.play` and `rcss_hat.team.match.play`.
    stage : str or (str, int)
    executable : str, optional
        The rcssserver for the stage ``real``.
    progress : callable, optional
        Told (episodes finished, cycle).
    trainer : int, optional
        A trainer of ours referees instead of the server; it connects to this port of a running server (0: the one
        behind the players' port). Not in the arena.

    Raises
    ------
    RuntimeError
        When there is no server to play on.
    """
    if stage == ARENA:
        from rcss_hat.arena.match import play as play_in_arena

        tell_of_compilation("rcss_hat.arena.loop")
        play_in_arena(report, task, seed, policy, episodes, progress)
        return

    def told(finished: int, cycle: int) -> bool:
        if progress is not None:
            progress(finished, cycle)
        return False

    play_over_udp(report, task, seed, policy, stage, told, episodes, executable, trainer)


def play_over_udp(
    report: RunReport,
    task: Task,
    seed: int,
    policy: TeamPolicy,
    stage: str | tuple[str, int],
    episode_ended: Callable[[int, int], bool],
    episodes: int = ENDLESS,
    executable: str | None = None,
    trainer: int | None = None,
) -> None:
    """Play on a server until so many episodes have ended, or a function says that it is enough.

    Parameters
    ----------
    episode_ended : callable
        Told (episodes finished, cycle) after every episode; true ends the match.
    report, task, seed, policy, stage, episodes, executable, trainer
        See `play_on_stage`.
    """
    from rcss_hat.team.match import play
    from rcss_hat.team.options import REFEREED_BY_TRAINER

    tell_of_compilation("rcss_hat.keepaway.agent")
    policy.warm_up()
    server = own_server(task, seed, stage, executable, **(REFEREED_BY_TRAINER if trainer is not None else {}))
    address = stage if isinstance(stage, tuple) else None
    enough = False

    async def run() -> None:
        match = asyncio.current_task()
        assert match is not None

        def ended(finished: int, cycle: int) -> None:
            nonlocal enough
            if not enough and episode_ended(finished, cycle):
                enough = True
                match.cancel()

        whistle = own_trainer(task, seed, server, address, trainer)
        await play(report, task, seed, policy, episodes, server, address, ended, trainer=whistle)

    try:
        asyncio.run(run())
    except KeyboardInterrupt:
        report.failure = report.failure or INTERRUPTED
    finally:
        if server is not None:
            server.clean()
    if enough and report.failure == INTERRUPTED:
        report.failure = None


def own_trainer(
    task: Task, seed: int, server: ServerProcess | None, address: tuple[str, int] | None, port: int | None
) -> TrainerClient | None:
    """Return the trainer that referees instead of the server, not connected yet; None for port None."""
    from rcss_hat.team.trainer import TrainerClient

    if port is None:
        return None
    host, players = (server.host, server.port) if server is not None else address or ("127.0.0.1", 6000)
    return TrainerClient(task, host, port or players + 1, seed)


def own_server(
    task: Task, seed: int | None, stage: str | tuple[str, int], executable: str | None = None, **changes: Value
) -> ServerProcess | None:
    """Return the server of a stage, not started yet; None where somebody else runs it.

    Raises
    ------
    ServerFailed
        For the stage ``real`` where no rcssserver is found.
    """
    from rcss_hat.team.servers import ServerFailed, ServerProcess, find_executable

    if isinstance(stage, tuple):
        return None
    found = find_executable(executable) if stage == REAL else None
    if stage == REAL and found is None:
        raise ServerFailed(
            f"no executable {executable or 'rcssserver'!r} was found; give --executable PATH, or --on fake"
        )
    return ServerProcess(task, seed, found, None, **changes)


def server_pace(stage: str | tuple[str, int], speed: float) -> dict[str, Value]:
    """Return the parameters of a server in real time that is to play so many times faster.

    Raises
    ------
    click.BadParameter
        When servers do not have this speed, or the server is somebody else's.
    """
    from rcss_hat.team.options import option, pace_options

    try:
        pace = pace_options(speed)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--speed") from error
    if pace and isinstance(stage, tuple):
        needed = " ".join(option(name, value) for name, value in {"synch_mode": False, **pace}.items())
        raise click.UsageError(
            f"the server at {stage_text(stage)} runs already, at its own speed; leave out --speed, and start it with "
            f"{needed} ('rcss-hat server --real-time --speed {speed:g}' does)"
        )
    return pace


def play_in_processes_on_stage(
    report: RunReport,
    task: Task,
    seed: int,
    policy: TeamPolicy,
    stage: str | tuple[str, int],
    episodes: int,
    executable: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    trainer: int | None = None,
) -> None:
    """Play over UDP as `play_on_stage` does, every player in a process of its own."""
    from rcss_hat.team.options import REFEREED_BY_TRAINER
    from rcss_hat.team.processes import play_in_processes

    server = own_server(task, seed, stage, executable, **(REFEREED_BY_TRAINER if trainer is not None else {}))
    address = stage if isinstance(stage, tuple) else None

    async def run() -> None:
        whistle = own_trainer(task, seed, server, address, trainer)
        await play_in_processes(report, task, seed, policy, episodes, server, address, progress, whistle)

    try:
        asyncio.run(run())
    except KeyboardInterrupt:
        report.failure = report.failure or INTERRUPTED
    finally:
        if server is not None:
            server.clean()
