"""The recorded dialogues are still what a real rcssserver tells; DIALOGUES=FOLDER writes them anew."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rcss_hat.protocol.params import Value
from rcss_hat.stage.servers import find_executable

sys.path.append(str(Path(__file__).parents[1] / "fake_server"))

from dialogue_scripts import DIALOGUES
from dialogues import PLAYER_PARAMETERS, QUIET, Conversation, Dialogue, Told, differences, read, write

DATA = Path(__file__).parent.parent / "data" / "fake_server"
EXECUTABLE = find_executable(os.environ.get("RCSSSERVER"))
pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(EXECUTABLE is None, reason="no rcssserver on PATH; name one by the variable RCSSSERVER"),
]


def _free_ports() -> list[int]:
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
    for opened in sockets:
        opened.bind(("127.0.0.1", 0))
    ports = [int(opened.getsockname()[1]) for opened in sockets]
    for opened in sockets:
        opened.close()
    return ports


def _arguments(dialogue: Dialogue, ports: list[int]) -> list[str]:
    server: dict[str, Value] = QUIET | dialogue.server
    server |= dict(zip(("port", "coach_port", "olcoach_port"), ports, strict=True))
    named = [f"server::{name}={int(value) if isinstance(value, bool) else value}" for name, value in server.items()]
    return named + [f"player::{name}={int(value)}" for name, value in PLAYER_PARAMETERS.items()]


def converse(dialogue: Dialogue, folder: Path) -> list[Told]:
    ports = _free_ports()
    with subprocess.Popen(
        [str(EXECUTABLE), *_arguments(dialogue, ports)],
        cwd=folder, env=os.environ | {"HOME": str(folder)}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as server:  # fmt: skip
        try:
            time.sleep(1.0)
            return Conversation(dialogue, (ports[0], ports[1])).run()
        finally:
            server.kill()


@pytest.mark.parametrize("script", DIALOGUES)
def test_the_recorded_dialogues_are_those_of_the_original(script: Callable[[], Dialogue], tmp_path: Path) -> None:
    dialogue = script()
    told = converse(dialogue, tmp_path)
    folder = os.environ.get("DIALOGUES")
    if folder:
        write(Path(folder) / f"dialogue-{dialogue.name}.json.gz", told)
    assert differences(dialogue, read(Path(folder or DATA) / f"dialogue-{dialogue.name}.json.gz"), told) == []
