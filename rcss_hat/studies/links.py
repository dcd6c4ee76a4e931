"""The links of a study in a table, for whoever sends them out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rcss_hat.studies.plan import participant_name
from rcss_hat.system.files import write_text

if TYPE_CHECKING:
    from rcss_hat.studies.server import StudyServer


def last_port(folder: Path) -> int:
    """Return the port at which a study was served last, so that its links stay; 0: none is known."""
    try:
        text = (folder / "keys" / "port").read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        return 0
    return int(text) if text.isdecimal() and len(text) < 6 and int(text) < 65536 else 0


def write_links(server: StudyServer) -> Path:
    """Write ``keys/links.csv``: every place with its link; returns the file."""
    path = server.folder.path / "keys" / "links.csv"
    rows = [
        f"{participant_name(place)},{server.link(place)}" for place in range(1, server.folder.study.participants + 1)
    ]
    write_text(path.with_name("port"), f"{server.port}\n")
    write_text(path, "\n".join(["participant,link", *rows]) + "\n")
    return path
