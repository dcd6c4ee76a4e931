"""Compiling the protocol's kernels before a server waits for an answer."""

from __future__ import annotations

from rcss_hat.protocol.commands import action_to_bytes
from rcss_hat.protocol.hear import parse_hear_fast
from rcss_hat.protocol.records import ACTION, HEARD, SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body


def warm_up() -> None:
    """Compile, or load from the cache, what reads and writes players' messages; call it before ``(init ...)``."""
    parse_see(b"(see 0 ((b) 1 0))", b"keepers", empty(SEE))
    parse_sense_body(b"(sense_body 0 (view_mode high normal) (stamina 1 1) (speed 0 0))", empty(SENSE_BODY))
    parse_hear_fast(b"(hear 0 referee play_on)", empty(HEARD))
    action_to_bytes(empty(ACTION))
