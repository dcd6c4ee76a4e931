"""Where the matches of a trial are played: in the arena, or on servers, of which each may fail and is replaced.

What became of every server stands in the trial's folder:

=======================  ==========================================================================================
``servers/NNN/``         what the server of the NNN-th match wrote: ``console.log``, ``keepaway.kwy``
``servers.jsonl``        one line for every match, see `MatchNote`
``running.json``         where the match is that is being played, for those who want to watch it
=======================  ==========================================================================================
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from rcss_hat.experiments.run_folder import TrainingError
from rcss_hat.inputs import FileFormatError, load_json, read_text
from rcss_hat.keepaway.conditions import SETTINGS
from rcss_hat.keepaway.report import RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.schema import read
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.servers import answers, free_ports
from rcss_hat.stage.terms import Terms, silent
from rcss_hat.system.files import append, write_text
from rcss_hat.system.locks import InUse, SoleWriter

LOGS, MATCHES, RUNNING = "servers", "servers.jsonl", "running.json"
MOST_FUTILE = 5
"""Servers in a row on which no episode was finished, after which a trial is given up."""
HERE = "127.0.0.1"
GLANCE_S, BACK_S = 1.0, 60.0
"""Seconds for a server to answer, and for one of several to come back when none does."""
Match = Callable[[Place, Terms], tuple[RunReport, bool]]
"""Plays a match, or the rest of one, on a place; returns what happened and whether that was all there was to play."""


class NotRunning(ValueError):
    """No trial is being played on a server; the message says where was looked."""


class Running(Struct, frozen=True):
    """What ``running.json`` says: which match of a trial is being played, and where."""

    what: str
    host: str
    port: int
    since: float


class MatchNote(Struct, frozen=True, kw_only=True):
    """A line of ``servers.jsonl``: a match of a trial; see `rcss_hat.keepaway.report.RunReport` for the figures."""

    what: str
    server: str
    profile: str
    speed: str
    seed: str | None
    episodes: int
    cycles: int
    missed: int
    unheard: int
    wall_s: float
    failure: str | None
    logs: str | None


@dataclass(frozen=True, slots=True)
class Supply:
    """Servers for trials.

    Attributes
    ----------
    executable : str or None
        The rcssserver that trials on ``real`` start; None: the one on the PATH.
    addresses : tuple of str
        ``HOST:PORT`` of servers that run already, instead of starting some: each is used by one trial at a time.
    locks : Path or None
        Folder, common to all trials on this machine, for the locks that see to this.
    """

    executable: str | None = None
    addresses: tuple[str, ...] = ()
    locks: Path | None = None


def terms_for(task: Task, say: Callable[[str], None] = silent) -> Terms:
    """Return what a server must play that trains or tests learners of a task: all that their folder says."""
    return Terms(SETTINGS if task.profile != Task().profile else SETTINGS - {"profile"}, say)


class Venue:
    """The arena, where matches do not fail.

    Parameters
    ----------
    task : Task
    """

    def __init__(self, task: Task) -> None:
        self.terms = terms_for(task)

    def play(self, what: str, match: Match) -> None:
        """Play a match until all of it has been played.

        Parameters
        ----------
        what : str
            What it is for.
        match : callable
            See `Match`; called again for what is missing when the server failed.

        Raises
        ------
        KeyboardInterrupt
            When it was interrupted.
        TrainingError
            When it cannot be played.
        """
        if not match(Place(ARENA), self.terms)[1]:  # Ctrl-C: nothing else ends a match here
            raise KeyboardInterrupt

    def account(self) -> dict[str, Any]:
        """Return what a trial's result says of its servers; nothing where there were none."""
        return {}


class ServerVenue(Venue):
    """Servers, one for every match; one that fails is replaced by another, and the match goes on there.

    Parameters
    ----------
    task : Task
    place : Place
        Of the servers that are started, when the supply has no addresses.
    folder : Path
        Of the trial.
    supply : Supply
    """

    def __init__(self, task: Task, place: Place, folder: Path, supply: Supply) -> None:
        super().__init__(task)
        self._task, self._place, self._folder, self._supply = task, place, folder, supply

    def play(self, what: str, match: Match) -> None:
        """Play a match; see `Venue.play`."""
        futile = 0
        while True:
            with self._server(what) as (place, terms):
                report, done = match(place, terms)
                self._note(what, place, terms, report)
            if done:
                return
            if report.interrupted:
                raise KeyboardInterrupt
            futile = 0 if report.episodes else futile + 1
            if futile == MOST_FUTILE:
                why = f"no episode was finished on {MOST_FUTILE} servers in a row: {report.failure}"
                raise TrainingError(f"{self._folder}: {what}: {why}")

    def account(self) -> dict[str, Any]:
        """Return matches, servers replaced, cycles, missed cycles, their share, unheard ends, and seeds."""
        matches = read_matches(self._folder)
        cycles, missed = sum(m.cycles for m in matches), sum(m.missed for m in matches)
        players = self._task.keepers + self._task.takers
        return {
            "servers": {
                "matches": len(matches),
                "replaced": sum(m.failure is not None for m in matches),
                "cycles": cycles,
                "missed": missed,
                "missed_share": missed / (cycles * players) if cycles else 0.0,
                "unheard": sum(m.unheard for m in matches),
                "profiles": sorted({m.profile for m in matches if m.profile}),
                "seeds": [m.seed for m in matches],
            }
        }

    @contextlib.contextmanager
    def _server(self, what: str) -> Iterator[tuple[Place, Terms]]:
        with self._free_one() if self._supply.addresses else self._new_one() as (place, terms, port):
            where = Running(what, place.address[0] if place.address else HERE, port, time.time())
            write_text(self._folder / RUNNING, msgspec.json.encode(where).decode() + "\n")
            try:
                yield place, terms
            finally:
                (self._folder / RUNNING).unlink(missing_ok=True)

    @contextlib.contextmanager
    def _new_one(self) -> Iterator[tuple[Place, Terms, int]]:
        """Start a server, or rather say how: the match does."""
        port = free_ports()
        number = len(list((self._folder / LOGS).glob("[0-9]*"))) + 1
        logs = self._folder / LOGS / f"{number:03d}"
        logs.mkdir(parents=True)
        terms = Terms(self.terms.typed, self.terms.say, pace={"port": port}, logs=logs.resolve())
        yield Place(self._place.name, None, self._supply.executable), terms, port

    @contextlib.contextmanager
    def _free_one(self) -> Iterator[tuple[Place, Terms, int]]:
        """Choose one of the servers that run already, which answers and which no other trial uses."""
        give_up = time.monotonic() + BACK_S
        while True:
            used = False
            for text in self._supply.addresses:
                place = Place.parse(text)
                assert place.address is not None and self._supply.locks is not None
                try:
                    right = SoleWriter(self._supply.locks / text.replace(":", "_"), folder=False)
                except InUse:
                    used = True
                    continue
                with right:
                    if asyncio.run(answers(*place.address, GLANCE_S)):
                        yield place, self.terms, place.address[1]
                        return
            if used:  # by trials that will end
                give_up = time.monotonic() + BACK_S
            elif time.monotonic() > give_up:
                raise TrainingError(f"no server answers at {' or '.join(self._supply.addresses)}")
            time.sleep(GLANCE_S)

    def _note(self, what: str, place: Place, terms: Terms, report: RunReport) -> None:
        note = MatchNote(
            what=what,
            server=str(place),
            profile=report.profile,
            speed=report.speed,
            seed=report.server_seed,
            episodes=len(report.episodes),
            cycles=report.cycles,
            missed=report.missed,
            unheard=report.unheard,
            wall_s=round(report.wall_s, 2),
            failure=report.failure,
            logs=terms.logs.name if terms.logs else None,
        )
        append(self._folder / MATCHES, msgspec.json.encode(note) + b"\n")


def venue(stage: str, task: Task, folder: Path, supply: Supply | None = None) -> Venue:
    """Return where a trial is played.

    Parameters
    ----------
    stage : str
        As `rcss_hat.stage.place.Place.parse` reads it.
    task : Task
    folder : Path
        Of the trial.
    supply : Supply, optional
    """
    supply = supply or Supply()
    place = Place.parse(stage)
    if place.address is not None:
        supply = Supply(supply.executable, (stage,), supply.locks or folder.parent)
    return Venue(task) if place.name == ARENA else ServerVenue(task, place, folder, supply)


def read_matches(folder: Path) -> list[MatchNote]:
    """Read what became of the servers of a trial; a line that a killed writer has cut off is left out.

    Raises
    ------
    TrainingError
        When the file is damaged.
    """
    path = folder / MATCHES
    if not path.exists():
        return []
    lines = read_text(path, "list of matches").split("\n")
    whole = lines[:-1]  # what follows the last end of line was cut off by a killed writer, or is nothing
    try:
        return [read(MatchNote, load_json(line), f"line {number}") for number, line in enumerate(whole, 1)]
    except FileFormatError as problem:
        raise TrainingError(f"{path} is not valid: {problem}") from problem


def running_match(experiment: Path, trial: str = "") -> tuple[str, Place]:
    """Find a trial of an experiment that is being played on a server.

    Parameters
    ----------
    experiment : Path
        Its folder.
    trial : str
        ``CONDITION/NN``, or ``CONDITION`` for any of its trials; by default any.

    Returns
    -------
    str, Place
        Which trial, and where: of several the one whose match began first.

    Raises
    ------
    NotRunning
        When there is none.
    """
    found = [e for e in running_matches(experiment) if not trial or e[0] == trial or e[0].startswith(f"{trial}/")]
    if not found:
        which = f"trial {trial} of {experiment}" if trial else f"trial of {experiment}"
        raise NotRunning(f"no {which} is being played on a server")
    name, match = found[0]
    return name, Place.at((match.host, match.port))


def running_matches(experiment: Path) -> list[tuple[str, Running]]:
    """List the trials of an experiment that are being played on servers, with their matches, oldest match first."""
    trials, found = experiment / "trials", []
    for path in trials.glob(f"*/*/{RUNNING}"):
        with contextlib.suppress(FileFormatError, OSError):  # it ended just now
            match = read(Running, load_json(read_text(path, "running match")), str(path))
            found.append((path.parent.relative_to(trials).as_posix(), match))
    return sorted(found, key=lambda entry: entry[1].since)
