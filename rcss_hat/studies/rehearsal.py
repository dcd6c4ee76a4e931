"""A rehearsal of a study: scripted participants go through it by its own pages, so that everything is tried before."""

from __future__ import annotations

import asyncio
import csv
import io
import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.studies.address import Address
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.parts import PeopleStudy
from rcss_hat.studies.plan import participant_name
from rcss_hat.studies.scripted import person
from rcss_hat.studies.server import StudyServer
from rcss_hat.system.files import write_text

STYLES = ("A", "B", "C")
"""Teachers in whose manner participants play, block by block, so that every condition meets each equally often."""
AT_A_TIME = 20
_PEOPLE = 3
"""What seeds are drawn for."""
LOOK = 1.0
"""Seconds between two looks how far it is."""


class RehearsalFailed(RuntimeError):
    """The scripted participants did not come to the end."""


def cast(study: PeopleStudy, place: int) -> tuple[str, int]:
    """Return in whose manner the scripted participant of a place plays, and his seed."""
    block = (place - 1) // max(len(study.conditions), 1)
    return STYLES[block % len(STYLES)], derived_seed(study.seed, _PEOPLE, place)


async def rehearse(
    study: PeopleStudy,
    out: Path,
    participants: int,
    jobs: int,
    hurry: float,
    say: Callable[[str], None],
    told: Callable[[int], None],
) -> list[dict[str, Any]]:
    """Let scripted participants go through a study; those who had finished before are left out.

    Parameters
    ----------
    study : PeopleStudy
    out : Path
        Its folder.
    participants : int
        How many, instead of the study's.
    jobs : int
        Processes for games.
    hurry : float
        How much faster than real time everything is; reaction times are in the game's time.
    say, told : callable
        Told what people should know, and how many have come to the end.

    Returns
    -------
    list of dict
        What each told, see `rcss_hat.studies.scripted.Told`.

    Raises
    ------
    RehearsalFailed
    """
    folder = StudyFolder.begin(out, replace(study, participants=participants), rehearsal=True)
    _write_cast(folder)
    async with StudyServer(folder, Address(), jobs, say, hurry) as server:
        people = []
        for place in range(1, participants + 1):
            known = server.participants.get(place)
            if known is None or not known.progress.finished:
                style, seed = cast(folder.study, place)
                people.append({"link": server.link(place), "teacher": style, "seed": seed, "hurry": hurry})
        watching = asyncio.create_task(_watch(server, told))
        try:
            return await crowd(people)
        finally:
            watching.cancel()
            told(_finished(server))


async def crowd(people: list[dict[str, Any]], at_a_time: int = AT_A_TIME) -> list[dict[str, Any]]:
    """Let scripted participants play, in a process of their own; see `rcss_hat.studies.crowd`.

    Raises
    ------
    RehearsalFailed
    """
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "rcss_hat.studies.crowd", str(at_a_time),
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, env=dict(os.environ),
    )  # fmt: skip
    try:
        answer, _ = await process.communicate(json.dumps(people).encode())
    except asyncio.CancelledError:
        process.kill()
        raise
    if process.returncode:
        raise RehearsalFailed(f"the scripted participants ended early (exit code {process.returncode})")
    told: list[dict[str, Any]] = json.loads(answer)
    return told


async def _watch(server: StudyServer, told: Callable[[int], None]) -> None:
    while True:
        told(_finished(server))
        await asyncio.sleep(LOOK)


def _finished(server: StudyServer) -> int:
    return sum(participant.progress.finished for participant in server.participants.values())


def _write_cast(folder: StudyFolder) -> None:
    """Write down who plays how: ``rehearsal.csv``."""
    text = io.StringIO()
    rows = []
    for place in range(1, folder.study.participants + 1):
        style, seed = cast(folder.study, place)
        habits = {name: round(value, 4) for name, value in asdict(person(style, seed)).items()}
        rows.append({"participant": participant_name(place), "teacher": style, "seed": seed, **habits})
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(folder.path / "rehearsal.csv", text.getvalue())
