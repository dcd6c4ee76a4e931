"""Server processes of our own: the fake one or an rcssserver executable, started, watched and stopped."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import shutil
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from rcss_hat.keepaway.report import Episode, read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.errors import one_line
from rcss_hat.protocol.params import Value
from rcss_hat.stage.options import server_options
from rcss_hat.stage.seconds import second_of_its_own
from rcss_hat.system import tether

KWY_NAME = "keepaway"
CONSOLE = "console.log"
"""What a server printed, where its logs are kept."""
STOP_TIMEOUT = 5.0
_TETHER = ("-I", "-S", str(Path(tether.__file__)))
"""Python's arguments to run a command that ends with this process."""
SAYS_SEED_S = 3.0
"""Seconds within which an rcssserver that has started has printed its seed."""
PATIENCE = 5.0
"""Seconds that a seeded fake server waits for a player: on a busy machine, too, the seed decides the match."""


class ServerFailed(RuntimeError):
    """A server could not be started, or ended by itself; the message is one printable line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


def free_ports(n: int = 3) -> int:
    """Return the first of ``n`` UDP ports in a row that nobody uses on this machine."""
    for _ in range(100):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            first = int(probe.getsockname()[1])
            if first + n > 65535:
                continue
            try:
                for offset in range(1, n):
                    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
                        other.bind(("127.0.0.1", first + offset))
            except OSError:
                continue
        return first
    raise ServerFailed(f"found no {n} free UDP ports in a row")


def find_executable(name: str | None = None) -> str | None:
    """Path of an rcssserver executable, or None."""
    return shutil.which(name or "rcssserver")


async def answers(host: str, port: int, patience: float, check: Callable[[], None] = lambda: None) -> bool:
    """Wait until a server answers a datagram; False when it does not in so many seconds.

    Parameters
    ----------
    host : str
    port : int
    patience : float
        Seconds.
    check : callable, optional
        Called every now and then; may raise to end the wait.
    """
    loop = asyncio.get_running_loop()
    give_up = loop.time() + patience
    while loop.time() < give_up:
        check()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.setblocking(False)
            try:
                probe.connect((host, port))
                probe.send(b"(ping)\0")  # not a command: the answer is an error, and nothing changes
                async with asyncio.timeout(0.2):
                    await loop.sock_recv(probe, 1024)
                return True
            except (OSError, TimeoutError):
                await asyncio.sleep(0.05)
    return False


class ServerProcess:
    """A server in a process of its own, playing one task; an asynchronous context manager.

    Parameters
    ----------
    task : Task
    seed : int, optional
        Of the fake server; the original cannot be seeded.
    executable : str, optional
        An rcssserver; by default the fake server of this package.
    folder : Path, optional
        Where logs go; by default a temporary folder.
    **changes : Value
        Further server parameters.

    Attributes
    ----------
    host, port : str, int
    random_seed : str or None
        The seed that the server printed, once it has.
    """

    def __init__(
        self,
        task: Task,
        seed: int | None = None,
        executable: str | None = None,
        folder: Path | None = None,
        **changes: Value,
    ) -> None:
        self.task, self.seed, self.executable = task, seed, executable
        self.host = "127.0.0.1"
        self.port = int(changes.pop("port", 0)) or free_ports()
        self._temporary = None if folder else tempfile.TemporaryDirectory(prefix="rcss-hat-")
        self.folder = folder or Path(self._temporary.name)  # type: ignore[union-attr]
        self._changes = changes
        self._process: asyncio.subprocess.Process | None = None
        self._output: list[str] = []
        self.random_seed: str | None = None
        self._reader: asyncio.Task[None] | None = None

    @property
    def kwy(self) -> Path:
        """The Keepaway log while running and afterwards."""
        return self.folder / f"{KWY_NAME}.kwy"

    def command(self) -> list[str]:
        """Command line that starts this server."""
        options = server_options(
            self.task,
            real=self.executable is not None,
            port=self.port,
            coach_port=self.port + 1,
            olcoach_port=self.port + 2,
            keepaway_logging=True,
            keepaway_log_dir=str(self.folder),
            keepaway_log_fixed=True,
            keepaway_log_fixed_name=KWY_NAME,
            **self._changes,
        )
        if self.executable is not None:
            return [self.executable, *options]
        seeded = [] if self.seed is None else [f"--seed={self.seed}", f"--patience={PATIENCE:g}"]
        return [sys.executable, "-m", "fake_server", *seeded, *options]

    async def start(self) -> None:
        """Start the process, unless it runs; an rcssserver not in the second in which another one here was started.

        It takes its seed from the clock, in whole seconds: two of the same second would play the same noise.

        Raises
        ------
        ServerFailed
            When the executable cannot be run.
        """
        if self._process is not None and self._process.returncode is None:
            return
        if self.executable is None:
            await self._start()
            return
        async with second_of_its_own() as taken:
            await self._start()
            taken(await self._seeded())

    async def _seeded(self) -> int:
        """Return the second that the server took for its seed; the present one where it does not say so."""
        for _ in range(round(SAYS_SEED_S / 0.02)):
            if self.random_seed is not None or (self._process is not None and self._process.returncode is not None):
                break
            await asyncio.sleep(0.02)
        said = self.random_seed or ""
        return int(said) if said.isdecimal() and len(said) < 12 else int(time.time())

    async def _start(self) -> None:
        environment, command = None, self.command()
        if self.executable is not None:
            environment = {**os.environ, "RCSS_CONF_DIR": str(self.folder)}
        try:
            if shutil.which(command[0]) is None:
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
            self._process = await asyncio.create_subprocess_exec(
                sys.executable,
                *_TETHER,
                str(os.getpid()),
                *command,
                stdin=asyncio.subprocess.PIPE,  # closes with this process, whatever ends it
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.STDOUT,
                env=environment,
                cwd=self.folder,
            )
        except OSError as error:
            raise ServerFailed(f"cannot start {command[0]}: {error.strerror}") from error
        self._reader = asyncio.create_task(self._read())

    async def _read(self) -> None:
        assert self._process is not None and self._process.stdout is not None
        kept = contextlib.nullcontext() if self._temporary else (self.folder / CONSOLE).open("ab", buffering=0)
        with kept as console:
            while line := await self._process.stdout.readline():
                if console is not None:
                    with contextlib.suppress(OSError):  # a full disk is no reason to stop listening
                        console.write(line)
                text = line.decode(errors="replace").rstrip()
                if self.random_seed is None and "Seed" in text and ":" in text:
                    self.random_seed = text.rsplit(":", 1)[1].strip()
                self._output.append(text)
                del self._output[:-200]

    def check(self) -> None:
        """Raise ServerFailed when the process has ended."""
        if self._process is not None and self._process.returncode is not None:
            last = "; ".join(self._output[-3:])
            raise ServerFailed(f"the server ended with exit code {self._process.returncode}: {last}")

    async def answers(self, patience: float = 20.0) -> None:
        """Wait until the server answers a datagram.

        Raises
        ------
        ServerFailed
            When it ended, or did not answer in time.
        """
        if not await answers(self.host, self.port, patience, self.check):
            raise ServerFailed(f"the server did not answer on port {self.port} within {patience:.0f} s")

    async def ended(self) -> None:
        """Wait until the process ends, then raise ServerFailed."""
        assert self._process is not None
        await self._process.wait()
        self.check()

    def episodes(self) -> list[Episode]:
        """Episodes the server has logged so far."""
        return read_kwy(self.kwy) if self.kwy.exists() else []

    async def stop(self) -> None:
        """Stop the server cleanly (SIGINT), by force after some seconds."""
        process = self._process
        if process is not None and process.returncode is None:
            if sys.platform == "win32":  # has no signals to send; the watchdog ends the server when its input ends
                assert process.stdin is not None
                process.stdin.close()
            else:
                process.send_signal(signal.SIGINT)
            try:
                async with asyncio.timeout(STOP_TIMEOUT):
                    await process.wait()
            except TimeoutError:
                process.kill()
                await process.wait()
        if self._reader is not None:
            await self._reader

    async def __aenter__(self) -> ServerProcess:
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.stop()

    def clean(self) -> None:
        """Remove the temporary folder, if one was made."""
        if self._temporary is not None:
            self._temporary.cleanup()
