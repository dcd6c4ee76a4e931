"""Microseconds per message, read and written: ``python scripts/bench/protocol.py [--messages FILE]``.

The messages are those recorded for the tests. Every number is the best of several rounds, in one process.
"""

from __future__ import annotations

import argparse
import gzip
import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rcss_hat.protocol import messages, records
from rcss_hat.protocol.commands import Kick, Say, TurnNeck, action_to_bytes, datagram, parse_commands
from rcss_hat.protocol.hear import parse_hear_fast
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body

RECORDED = Path(__file__).parents[2] / "tests" / "data" / "protocol" / "messages.jsonl.gz"
ROUNDS = 7
CALLS = 2000
FULL_SEE = 58
"""A see message of a 360 degree view has at least so many objects."""


def best(call: Callable[[bytes], Any], inputs: Sequence[bytes]) -> float:
    """Return microseconds per call, the best of all rounds."""
    repeats = max(1, CALLS // len(inputs))
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(repeats):
            for data in inputs:
                call(data)
        times.append((time.perf_counter() - start) / (repeats * len(inputs)))
    return min(times) * 1e6


def report(name: str, call: Callable[[bytes], Any], inputs: Sequence[bytes]) -> None:
    """Measure and print one line."""
    call(inputs[0])
    size = sum(map(len, inputs)) / len(inputs)
    print(f"{name:42} {best(call, inputs):8.2f} us {size:8.0f} bytes {len(inputs):6} messages")


def main() -> None:
    """Measure everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=Path, default=RECORDED, help="recorded datagrams, .jsonl.gz")
    with gzip.open(parser.parse_args().messages, "rt") as lines:
        rows = [json.loads(line) for line in lines]
    received = [row["text"].encode() + b"\0" for row in rows if row["dir"] == "recv"]
    sent = [row["text"].encode() + b"\0" for row in rows if row["dir"] == "send" and row["client"][0] in "kt"]
    sent = [data for data in sent if data.startswith((b"(dash", b"(turn", b"(kick", b"(move", b"(say"))]

    def of(start: bytes) -> list[bytes]:
        return [data for data in received if data.startswith(start)]

    see, sense, heard = (records.empty(kind) for kind in (records.SEE, records.SENSE_BODY, records.HEARD))
    sees = of(b"(see ")
    report("see, 360 degrees", lambda d: parse_see(d, b"keepers", see), [d for d in sees if d.count(b"((") >= FULL_SEE])
    report("see, all", lambda data: parse_see(data, b"keepers", see), sees)
    report("sense_body", lambda data: parse_sense_body(data, sense), of(b"(sense_body "))
    report("hear, fast", lambda data: parse_hear_fast(data, heard), of(b"(hear "))
    report("hear, as an event", messages.parse, of(b"(hear "))
    report("think, as an event", messages.parse, of(b"(think)"))
    report("show (monitor), as an event", messages.parse, of(b"(show "))
    report("fullstate, as an event", messages.parse, of(b"(fullstate "))
    report("server_param, as an event", messages.parse, of(b"(server_param (a"))

    report("player's commands, recorded", parse_commands, sent)
    report("(kick)(turn_neck)(say)", parse_commands, [b'(kick 56 -12)(turn_neck 3)(say "abc")\0'])
    commands = Kick(56, -12), TurnNeck(3), Say("abc")
    report("the same, written from commands", lambda data: datagram(*commands), [datagram(*commands)])
    action = records.empty(records.ACTION)
    action["kind"], action["a"], action["b"] = records.KICK, 56, -12
    action["turns_neck"], action["neck"] = 1, 3
    action["say_n"] = 3
    action["say"][0, :3] = list(b"abc")
    report("the same, written from an action", lambda data: action_to_bytes(action), [action_to_bytes(action)])


if __name__ == "__main__":
    main()
