"""A recorded conversation that breaks a client, as a test: ``python examples/replayed_bug.py``.

A client of somebody's looks for the ball by a regular expression. One evening it stops in the middle of a match. What
the server said was recorded meanwhile,

    rcss-hat record --server localhost:6000 --port 6100 --out bug.jsonl.gz

and is given to the client again here, line by line: no server, no socket, the same fault in a millisecond. What mends
it is a reader of the whole message. ``fake-rcssserver replay bug.jsonl.gz`` serves the same to clients that want a
socket.
"""

from __future__ import annotations

import gzip
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

from rcss_hat.protocol.messages import See, parse
from rcss_hat.protocol.records import BALL, CLOSE_BALL, HAS_DISTANCE

RECORDING = Path(__file__).with_name("replayed_bug.jsonl.gz")
Client = Callable[[str], "float | None"]
"""Takes what a server said, and returns how far away the ball is (m), or None."""


def recorded(path: Path) -> Iterator[str]:
    """What the server said to the client, in order."""
    with gzip.open(path, "rt") as lines:
        for line in lines:
            datagram = json.loads(line)
            if datagram["dir"] == "recv":
                yield datagram["text"]


def naive(said: str) -> float | None:
    """Everybody's first client. A ball behind one's back is not there, and one at one's feet is written ((B) ...)."""
    if not said.startswith("(see "):
        return None
    found = re.search(r"\(\(b\) ([\d.]+)", said)
    return float(found.group(1))  # type: ignore[union-attr]


def mended(said: str) -> float | None:
    """Reads the message as a whole."""
    if not said.startswith("(see "):
        return None
    message = parse(said.encode(), "keepers")
    assert isinstance(message, See)
    see = message.record
    for k in range(int(see["n"][0])):
        if see["code"][0, k] in (BALL, CLOSE_BALL) and see["fields"][0, k] & HAS_DISTANCE:
            return float(see["distance"][0, k])
    return None


def first_fault(client: Client, path: Path = RECORDING) -> str | None:
    """Give a client all that was recorded; None: it read everything."""
    for number, said in enumerate(recorded(path), 1):
        try:
            client(said)
        except Exception as fault:
            return f"message {number}, {said[:40]}...: {type(fault).__name__}: {fault}"
    return None


def main() -> None:
    for client in (naive, mended):
        fault = first_fault(client)
        print(f"{client.__name__}: {fault or 'has read everything'}")


if __name__ == "__main__":
    main()
