"""Damage for files, reproducible: what disks, editors, transfers and hostile people do to them."""

from __future__ import annotations

import random

NASTY = (
    b"9" * 400, b"-1", b"1e400", b"NaN", b"Infinity", b"null", b"[" * 60, b'{"a":' * 60, b"\xef\xbb\xbf", b"\xff\xfe",
    b'"', b",", b"\r", b"\n", b"(", b")", b"\x1b[2J", b"0", b"4294967296", b"-9223372036854775809", b"true", b"\0",
    "٣½".encode(),
)  # fmt: skip


def damaged(data: bytes, seed: str) -> bytes:
    """Damage bytes in one to three ways: flipped, cut, doubled, moved, zeroed, or with something nasty put in."""
    rng = random.Random(seed)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = _once(data, rng)
    return data


def _once(data: bytes, rng: random.Random) -> bytes:
    if not data:
        return rng.choice(NASTY)
    a = rng.randrange(len(data))
    b = min(len(data), a + rng.choice((1, 1, 2, 4, 16, 64, 512)))
    way = rng.randrange(7)
    if way == 0:
        return data[:a] + bytes(byte ^ (1 << rng.randrange(8)) for byte in data[a:b]) + data[b:]
    if way == 1:
        return data[:a]
    if way == 2:
        return data[:b] + data[a:]
    if way == 3:
        return data[:a] + bytes(b - a) + data[b:]
    if way == 4:
        return data[:a] + data[b:]
    if way == 5:
        return data[:a] + rng.choice(NASTY) + data[a:]
    return _number_replaced(data, a, rng)


def _number_replaced(data: bytes, near: int, rng: random.Random) -> bytes:
    """Put something nasty in the place of the next number."""
    digits = b"0123456789.-+eE"
    begin = next((k for k in range(near, len(data)) if data[k] in b"0123456789"), None)
    if begin is None:
        return data[:near] + rng.choice(NASTY) + data[near:]
    end = begin
    while end < len(data) and data[end] in digits:
        end += 1
    return data[:begin] + rng.choice(NASTY) + data[end:]
