"""Datagrams recorded from rcssserver."""

from __future__ import annotations

import gzip
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

DATA = Path(__file__).parent.parent / "data" / "protocol"


class Datagram(NamedTuple):
    file: str
    client: str
    team: str
    dir: str
    text: str


@cache
def recorded() -> tuple[Datagram, ...]:
    with gzip.open(DATA / "messages.jsonl.gz", "rt") as lines:
        return tuple(Datagram(**json.loads(line)) for line in lines)


def received(start: str = "") -> list[Datagram]:
    """What clients received that begins with a text."""
    return [datagram for datagram in recorded() if datagram.dir == "recv" and datagram.text.startswith(start)]


def sent(start: str = "") -> list[Datagram]:
    return [datagram for datagram in recorded() if datagram.dir == "send" and datagram.text.startswith(start)]
