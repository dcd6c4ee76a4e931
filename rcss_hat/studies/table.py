"""One participant's game, in a worker process: his match, his pages, and what is kept of it."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo
from rcss_hat.hat.policy import python_policy
from rcss_hat.keepaway.decision import PERSON
from rcss_hat.keepaway.report import Episode
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import open_stage
from rcss_hat.studies.clock import since
from rcss_hat.studies.game_files import TABLES, GrowingTable, table_path
from rcss_hat.studies.plan import companion_policy
from rcss_hat.studies.spec import MATCH_OVER, GameSpec
from rcss_hat.system.files import NotWritten
from rcss_hat.system.locks import InUse
from rcss_hat.viewer import protocol
from rcss_hat.viewer.browser import Browser
from rcss_hat.viewer.controls import HELD, REFUSED, Fate, KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.frames import Frame
from rcss_hat.viewer.room import Manner, Room
from rcss_hat.viewer.stage_game import StageGame
from rcss_hat.viewer.turns import Companion

COUNTDOWN = 3
"""Seconds from the participant's coming to the first cycle."""
PATIENCE = 30.0
"""Seconds to wait for a worker of a server that was killed to give up a file."""
RETRY = 2.0
"""Seconds between two tries to write where the disk is full."""
LOOK = 0.1
"""Seconds between two looks whether the game stands still."""
TOLD = 20.0
"""Seconds between two remarks on how pictures come through."""
EARLY = 100
"""Messages of pages that are kept until the match is open."""
LATE_MS = 100
"""So much later than it should a picture is late."""

Emit = Callable[[dict[str, Any]], None]


class KeptGames(DemonstrationWriter):
    """Writes games; their keys are on the disk before.

    Parameters
    ----------
    before : callable
        Called before a game is written.
    after : callable
        Told the episode, and whether it was idle, when it is.
    """

    def __init__(
        self, path: Path, info: DemonstrationInfo, before: Callable[[], None], after: Callable[[Episode, bool], None]
    ) -> None:
        super().__init__(path, info, resume=True)
        self._before, self._after = before, after

    def end_episode(
        self, start: int, end: int, reason: str, idle: bool = False, final: Sequence[float] | None = None
    ) -> Episode:
        """Keep the running game; see `DemonstrationWriter.end_episode`."""
        self._before()
        episode = super().end_episode(start, end, reason, idle, final)
        self._after(episode, idle)
        return episode


class WatchedRoom(Room):
    """A room that takes down when pictures were made."""

    on_frame: Callable[[Frame], None] | None = None

    def frame(self, frame: Frame) -> None:
        """Show the newest picture."""
        if self.on_frame is not None:
            self.on_frame(frame)
        super().frame(frame)


class Table:
    """A participant's game.

    Parameters
    ----------
    spec : GameSpec
    emit : callable
        Told events of the journal, without ``utc``; at last `MATCH_OVER`.
    """

    def __init__(self, spec: GameSpec, emit: Emit) -> None:
        self.spec = spec
        self._emit_event = emit
        self._folder = Path(spec.folder)
        self._tables = {
            kind: GrowingTable(table_path(self._folder, spec.step, kind), list(columns))
            for kind, columns in (TABLES.items() if spec.kept else ())
        }
        self._writer: KeptGames | None = None
        self._games, self._played = spec.games, spec.played
        self._pressed: list[int] = []
        self._current = self._pending = _Moment(0, None)
        self._waiting: object = None
        self._cycle, self._held_since = 0, 0.0
        self._holder: str | None = None
        self._pictures = self._late = self._worst = 0
        self._stood_since_pace = True
        self._closed = False
        keys = KeyChannel(spec.actions)
        keys.on_fate = self._became
        # A pause would let people choose which games count; who looks away stops the game, and it counts.
        commands = ["start", "here"]
        for wanted, more in (
            (spec.may_end, ["stop"]),
            (spec.keepers != PERSON, ["take", "give"]),
            (spec.correct, ["seen"]),
        ):
            commands += more if wanted else []
        self._keys, self._commands = keys, tuple(commands)
        self._demonstrator: Demonstrator | None = None
        self._room: WatchedRoom | None = None
        self._entered: dict[int, Browser] = {}
        self._early: list[tuple[int, str]] = []

    # -- the game -----------------------------------------------------------------------------------------------------
    async def run(self) -> None:
        """Play until all games are played, or the table is closed."""
        await self._open_writer()
        self._demonstrator = demonstrator = Demonstrator(self._keys, self._writer, self._terms(), self._companion())
        if self._writer is None:
            demonstrator.on_kept = self._practised
        finished = self._played >= self._games
        try:
            if not finished:
                await self._play(demonstrator)
        finally:
            await self._put_away(demonstrator)
        # Who may end early has ended by his own command; else it counts how much was played.
        finished = self._played >= self._games or (self.spec.may_end and demonstrator.finished and not self._closed)
        self._emit(MATCH_OVER, finished=finished)

    def _terms(self) -> Terms:
        missing = self._games - (0 if self._writer is not None else self.spec.played)
        return Terms(
            missing, True, True, self.spec.speed * self.spec.hurry, correct=self.spec.correct, commands=self._commands
        )

    def _companion(self) -> Companion | None:
        policy = companion_policy(self.spec.keepers, self._task(), self.spec.seed)
        return None if policy is None else Companion(policy)

    async def _play(self, demonstrator: Demonstrator) -> None:
        spec, task = self.spec, self._task()
        policy = python_policy(demonstrator.answer, task.keepers, task.takers, "person")
        with open_stage(Place(ARENA), task, spec.seed, policy) as stage:
            game = StageGame(stage, demonstrator, spec.speed * spec.hurry, 0 if spec.hurry > 1 else COUNTDOWN)
            self._room = room = WatchedRoom(game, demonstrator, Manner(plain=True, language=spec.language))
            room.on_message, room.on_frame = self._said, self._framed
            for browser in self._entered.values():
                room.enter(browser)
            for page, text in self._early:
                self.hear(page, text)
            watch = asyncio.create_task(self._watch(demonstrator))
            try:
                await room.run()
            finally:
                watch.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await watch

    def _task(self) -> Task:
        return Task.parse(self.spec.size, self.spec.field, self.spec.vision, self.spec.profile)

    async def _open_writer(self) -> None:
        """Open the file, which a worker of a killed server may still hold; count what it has more than the journal."""
        if not self.spec.kept:
            return
        task, spec, deadline = self._task(), self.spec, time.monotonic() + PATIENCE
        info = DemonstrationInfo(
            spec.participant, ARENA, task, task.server_values(), spec.base_seed, spec.date, spec.note,
            spec.correct or spec.keepers != PERSON,
        )  # fmt: skip
        while True:
            try:
                self._writer = KeptGames(self._folder / f"{spec.step}.csv", info, self._flush_keys, self._recorded)
                break
            except InUse:
                if time.monotonic() > deadline:
                    raise
                await asyncio.sleep(0.2)
        for entry in self._writer.entries[spec.played :]:
            self._count(entry.episode, entry.idle, spec.match - 1, None)

    async def _put_away(self, demonstrator: Demonstrator) -> None:
        """Write what is still to be written, as soon as the disk lets us."""
        while True:
            try:
                demonstrator.close()
                break
            except NotWritten as problem:
                self._emit("failed", what=str(problem))
                if self._room is not None:
                    self._room.notice("Your game cannot be saved yet. Please wait.", "disk")
                await asyncio.sleep(RETRY)
        self._flush_all()
        self._tell_lag()
        for browser in list(self._entered.values()):  # the end of the last game comes before the next step
            with contextlib.suppress(ConnectionError):
                await browser.flush()
        if self._writer is not None:
            self._writer.__exit__(None, None, None)

    def close(self) -> None:
        """End the game; `run` then returns."""
        self._closed = True
        if self._demonstrator is not None:
            self._demonstrator.stop()

    def longer(self, games: int) -> None:
        """Let more games be played: so many in all."""
        self._games = games
        if self._demonstrator is not None:
            self._demonstrator.terms = self._terms()

    # -- pages --------------------------------------------------------------------------------------------------------
    def enter(self, page: int, browser: Browser) -> None:
        """Take a page that has connected; one at a time."""
        self._entered[page] = browser
        if self._room is not None:
            self._room.enter(browser)

    def hear(self, page: int, text: str) -> None:
        """Take what a page says; what comes before the match is open is heard then."""
        if self._room is None:
            if len(self._early) < EARLY:
                self._early.append((page, text))
        elif page in self._entered:
            self._room.hear(self._entered[page], text)
            if self._keys.pending is not self._waiting:
                self._waiting, self._pending = self._keys.pending, self._current

    def leave(self, page: int) -> None:
        """Let a page go."""
        browser = self._entered.pop(page, None)
        if self._room is not None and browser is not None:
            self._room.leave(browser)

    # -- what is taken down -------------------------------------------------------------------------------------------
    def _ms(self, steady: float | None = None) -> int:
        return since(self.spec.origin, time.monotonic() if steady is None else steady)

    def _emit(self, event: str, **fields: Any) -> None:
        self._emit_event({"ms": self._ms(), "event": event, "step": self.spec.step, **fields})

    def _framed(self, frame: Frame) -> None:
        self._cycle = frame["time"]
        holder = frame["holder"] if frame["holder"] in (frame["keepers"] or []) else None
        if holder != self._holder:
            self._holder, self._held_since = holder, time.monotonic()
        if self._tables:
            self._tables["frames"].add(self.spec.match, self._cycle, self._ms())

    def _said(self, browser: Browser, message: protocol.Message) -> None:
        """Take down what a page says, before it is done."""
        match message:
            case protocol.Press() | protocol.Mate() | protocol.Command():
                now = time.monotonic()
                held = None if self._holder is None else round((now - self._held_since) * 1000.0)
                self._current = _Moment(self._ms(now), held)
                if isinstance(message, protocol.Command):
                    self._emit("command", value=message.value)
            case protocol.Correct(cycle, action):
                self._emit("correction", match=self.spec.match, cycle=cycle, action=action)
            case protocol.Pace(intervals):
                self._paced(intervals)

    def _became(self, fate: Fate) -> None:
        """Take down a key, now that it is known what became of it."""
        press = fate.press
        moment = self._current if fate.fate in (REFUSED, HELD) else self._pending
        if fate.fate != REFUSED:
            self._pressed.append(press.cycle)
        if self._tables:
            at = None if press.at is None else round(press.at)
            self._tables["keys"].add(
                self.spec.match, press.cycle, moment.ms, at, press.action, press.mate, press.holder, moment.held_ms,
                fate.fate, fate.cycle,
            )  # fmt: skip

    def _paced(self, intervals: list[int]) -> None:
        standing, self._stood_since_pace = self._stood_since_pace, self._why() is not None
        for interval in intervals:
            if self._tables:
                self._tables["pace"].add(self.spec.match, self._cycle, self._ms(), interval, int(standing))
            if not standing:
                self._pictures += 1
                self._worst = max(self._worst, interval)
                self._late += interval > 100.0 / (self.spec.speed * self.spec.hurry) + LATE_MS

    def _tell_lag(self) -> None:
        if self._pictures:
            self._emit("lag", pictures=self._pictures, late=self._late, worst_ms=self._worst)
        self._pictures = self._late = self._worst = 0

    def _why(self) -> str | None:
        """Return why the game stands still; None: it goes on."""
        d = self._demonstrator
        if d is None or d.finished:
            return None
        reasons = (
            ("away", d.away),
            ("start", not d.started),
            ("asked", d.asking),
            ("hidden", not d.looking),
            ("replay", d.replaying),
        )
        return next((name for name, holds in reasons if holds), None)

    async def _watch(self, demonstrator: Demonstrator) -> None:
        """Take down when the game stands still, and now and then how pictures come through."""
        why, since_ms, cycle, told = self._why(), self._ms(), self._cycle, time.monotonic()

        def stood() -> None:
            if why is not None:
                self._emit("stood", match=self.spec.match, cycle=cycle, from_ms=since_ms, why=why)

        try:
            while True:
                await asyncio.sleep(LOOK)
                now = self._why()
                self._stood_since_pace |= now is not None
                if now != why:
                    stood()
                    why, since_ms, cycle = now, self._ms(), self._cycle
                if time.monotonic() - told > TOLD:
                    self._tell_lag()
                    told = time.monotonic()
        finally:
            stood()  # in the last game, until its end

    # -- games that are over ------------------------------------------------------------------------------------------
    def _flush_keys(self) -> None:
        self._tables["keys"].flush()

    def _flush_all(self) -> None:
        for table in self._tables.values():
            with contextlib.suppress(NotWritten):
                table.flush()

    def _recorded(self, episode: Episode, idle: bool) -> None:
        """Take a game that is on the disk."""
        keys = sum(episode.start <= cycle < episode.end for cycle in self._pressed)
        self._pressed = [cycle for cycle in self._pressed if cycle >= episode.end]
        self._count(episode, idle, self.spec.match, keys)
        for kind in ("frames", "pace"):
            with contextlib.suppress(NotWritten):
                self._tables[kind].flush()

    def _practised(self, episode: Episode) -> None:
        """Take a game of practice, of which nothing else is kept."""
        keys = sum(episode.start <= cycle < episode.end for cycle in self._pressed)
        self._pressed = [cycle for cycle in self._pressed if cycle >= episode.end]
        self._count(episode, not keys, self.spec.match, keys)

    def _count(self, episode: Episode, idle: bool, match: int, keys: int | None) -> None:
        self._played += 1
        self._emit(
            "game", game=self._played, match=match, start=episode.start, end=episode.end, reason=episode.reason,
            idle=idle, keys=keys,
        )  # fmt: skip


class _Moment(NamedTuple):
    """When a key was pressed, and for how long the ball had been where it was."""

    ms: int
    held_ms: int | None
