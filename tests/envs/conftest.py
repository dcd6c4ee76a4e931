"""What the tests of environments share."""

from __future__ import annotations

from pathlib import Path

import pytest
from quick_servers import QuickServer

from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.params import Value
from rcss_hat.stage.place import Place


@pytest.fixture
def quick_servers(monkeypatch: pytest.MonkeyPatch) -> list[QuickServer]:
    """The servers that run, with ``stage="fake"``."""

    def server(place: Place, task: Task, seed: int | None, logs: Path | None = None, **changes: Value) -> QuickServer:
        return QuickServer(task, seed)

    monkeypatch.setattr(Place, "server", server)
    QuickServer.running.clear()
    return QuickServer.running
