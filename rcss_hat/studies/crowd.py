"""Many scripted participants in one process: ``python -m rcss_hat.studies.crowd AT_A_TIME < PEOPLE.json > TOLD.json``.

Reads a JSON list of participants, each with ``link``, ``teacher``, ``seed`` and ``hurry``, and writes what each tells
of his way, when all have come to the end.
"""

from __future__ import annotations

import asyncio
import json
import sys
from typing import Any

import aiohttp

from rcss_hat.hat.teachers import ScriptedTeacher
from rcss_hat.studies.scripted import ScriptedParticipant

APART = 0.1
"""Seconds between two participants who begin."""


async def play(people: list[dict[str, Any]], at_a_time: int) -> list[dict[str, Any]]:
    """Let them all go through the study, so many at the same time."""
    room = asyncio.Semaphore(at_a_time)
    ScriptedTeacher("A", 0)(0, (0.0, 0.0), [(0.0, 0.0), (5.0, 0.0), (0.0, 5.0)], [(5.0, 5.0), (6.0, 5.0)])  # compiles

    async def one(k: int, about: dict[str, Any]) -> dict[str, Any]:
        await asyncio.sleep(min(k, at_a_time) * APART)
        async with room, aiohttp.ClientSession() as session:
            return (await ScriptedParticipant(**about).run(session)).to_dict()

    return await asyncio.gather(*(one(k, about) for k, about in enumerate(people)))


if __name__ == "__main__":
    json.dump(asyncio.run(play(json.load(sys.stdin), int(sys.argv[1]))), sys.stdout)
