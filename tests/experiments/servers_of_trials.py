"""What tests do to servers that trials have started."""

from __future__ import annotations

import json
import os
from pathlib import Path


def processes_with(text: str) -> list[int]:
    """Processes whose command line holds a text."""
    found = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if text in place.read_bytes().replace(b"\0", b" ").decode(errors="replace"):
                found.append(int(place.parent.name))
        except OSError:  # it ended just now
            continue
    return found


def signal_servers(folder: Path, number: int) -> int:
    """Send a signal (0: none) to the servers of all running trials under a folder; return how many got it."""
    hit = 0
    for path in folder.rglob("running.json"):
        try:
            port = json.loads(path.read_text())["port"]
        except (OSError, ValueError):
            continue
        for process in processes_with(f"server::port={port} "):
            try:
                os.kill(process, number)
                hit += 1
            except ProcessLookupError:
                continue
    return hit
