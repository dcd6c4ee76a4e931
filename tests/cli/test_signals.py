"""Commands that are terminated end as by Ctrl-C: files are whole, and servers do not stay behind."""

from __future__ import annotations

import gzip
import json
import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from rcss_hat.stage.servers import free_ports

COMMAND = [sys.executable, "-m", "rcss_hat"]


def started(*arguments: str, ready: str, ignore: bool = False) -> tuple[subprocess.Popen[str], str]:
    """Start a command and wait for a line on stderr; ``ignore``: as a shell's background job, without Ctrl-C."""
    before = (lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)) if ignore else None
    process = subprocess.Popen([*COMMAND, *arguments], stderr=subprocess.PIPE, text=True, preexec_fn=before)
    assert process.stderr is not None
    for line in process.stderr:
        if re.search(ready, line):
            return process, line
    raise AssertionError(f"{arguments} ended before it said {ready!r}")


@pytest.mark.parametrize("ignore", [False, True])
def test_a_terminated_recording_is_whole(tmp_path: Path, ignore: bool) -> None:
    out = tmp_path / "t.jsonl.gz"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server:
        server.bind(("127.0.0.1", 0))
        server.settimeout(20.0)
        address = f"127.0.0.1:{server.getsockname()[1]}"
        process, line = started(
            "record", "--server", address, "--port", "0", "--out", str(out), ready="Recording", ignore=ignore
        )
        port = int(re.search(r":(\d+);", line)[1])  # type: ignore[index]
        server.sendto(b"(init keepers (version 11))\0", ("127.0.0.1", port))
        server.recv(8192)  # relayed back to us, who are the server as well
    process.send_signal(signal.SIGTERM)
    assert process.wait(20) == (1 if ignore else 0)
    with gzip.open(out, "rt") as lines:
        assert [json.loads(line)["text"] for line in lines] == ["(init keepers (version 11))"]


def test_a_terminated_server_command_takes_its_server_along() -> None:
    process, line = started("server", "--fake", "--seed", "1", "--port", str(free_ports()), ready="answers on port")
    port = int(line.split()[-1])
    process.send_signal(signal.SIGTERM)
    assert process.wait(20) == 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
        again.bind(("127.0.0.1", port))  # nobody holds it any more
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, 0)
