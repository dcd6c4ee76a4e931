"""A fake server for tests in which a process of its own is not the subject."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fake_server.clock import Timing
from fake_server.options import parse_options
from fake_server.running import running_server
from fake_server.server import Server
from rcss_hat.keepaway.report import Episode, read_kwy
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.options import server_options
from rcss_hat.stage.servers import KWY_NAME, PATIENCE


@dataclass(frozen=True)
class Served:
    """A server in a thread of this process, and what it logs."""

    server: Server
    folder: Path
    host: str = "127.0.0.1"

    @property
    def port(self) -> int:
        return self.server.port

    def episodes(self) -> list[Episode]:
        """Episodes the server has logged so far."""
        log = self.folder / f"{KWY_NAME}.kwy"
        return read_kwy(log) if log.exists() else []


@contextlib.contextmanager
def serving(task: Task, seed: int | None = None, **changes: Value) -> Iterator[Served]:
    """Run a server as patient as the one that `ServerProcess` starts, without the seconds which that takes."""
    ports: dict[str, Value] = dict.fromkeys(("port", "coach_port", "olcoach_port"), 0)
    with tempfile.TemporaryDirectory() as folder:
        logs: dict[str, Value] = {
            "keepaway_log_dir": folder, "keepaway_log_fixed": True, "keepaway_log_fixed_name": KWY_NAME,
        }  # fmt: skip
        options = parse_options(server_options(task, real=False, **ports, **logs, **changes))
        timing = None if seed is None else Timing(patience=PATIENCE)
        with running_server(options, seed, timing=timing) as server:
            yield Served(server, Path(folder))
