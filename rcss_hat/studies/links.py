"""The links of a study in a table, for whoever sends them out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rcss_hat.studies.plan import participant_name
from rcss_hat.system.files import write_text

if TYPE_CHECKING:
    from rcss_hat.studies.server import StudyServer


def write_links(server: StudyServer) -> Path:
    """Write ``keys/links.csv``: every place with its link; returns the file."""
    path = server.folder.path / "keys" / "links.csv"
    rows = [
        f"{participant_name(place)},{server.link(place)}" for place in range(1, server.folder.study.participants + 1)
    ]
    write_text(path, "\n".join(["participant,link", *rows]) + "\n")
    return path
