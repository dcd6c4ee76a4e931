"""A participant as the server knows him: his place, his journal, his pages, and the game he plays in a worker."""

from __future__ import annotations

import asyncio
import contextlib
import time
from concurrent.futures import Executor
from typing import Any, Protocol

from rcss_hat.experiments.run_folder import versions
from rcss_hat.numeric.seeds import derived_seed
from rcss_hat.studies.clock import Clock, utc_seconds
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.journal import FILE, Event, Journal
from rcss_hat.studies.parts import PracticeStep
from rcss_hat.studies.plan import Planned, plan_of
from rcss_hat.studies.pool import Pool
from rcss_hat.studies.progress import Progress
from rcss_hat.studies.spec import MATCH_OVER, GameSpec
from rcss_hat.system.files import NotWritten

RETRY = 2.0
"""Seconds between two tries to write an event where the disk is full."""
MAX_LOOKS = 10_000
"""Remarks of pages of text since the server was started; what comes on top is not kept."""
REOPEN, LONGEST = 1.0, 60.0
"""Seconds before a game is begun again whose worker has ended: at first, and where that goes on, at most."""


class Page(Protocol):
    """A page of the game that is connected."""

    number: int

    def go_on(self) -> None:
        """Let it load the participant's next step."""

    def replaced(self) -> None:
        """Tell it that another page was opened, and close it."""


class Participant:
    """One participant.

    Parameters
    ----------
    folder : StudyFolder
    place : int
    writing : Executor
        One thread in which journals are written, so that nobody waits for the disk whose event it is not.
    hurry : float
        How much faster games are played than they should, in a rehearsal.

    Attributes
    ----------
    name : str
    about : dict
        What is kept of him in ``participant.json``.
    progress : Progress
    trouble : str
        What keeps something of his from being saved, or his game from being played; empty: nothing.
    seen : float
        When he was heard of last, by the steady clock; 0: not since the server was started.
    lag : (int, int, int)
        Pictures since the server was started, those that came late, and the longest wait in milliseconds.

    Raises
    ------
    FileFormatError
        When what is kept of him is damaged.
    NotWritten
    """

    def __init__(self, folder: StudyFolder, place: int, writing: Executor, hurry: float = 1.0) -> None:
        self._folder, self._writing, self._hurry = folder, writing, hurry
        fresh = not (folder.folder_of(place) / FILE).exists()
        self.about = folder.admit(place)
        self.place, self.name = place, str(self.about["participant"])
        self._path = folder.folder_of(place)
        self._journal = Journal(self._path / FILE)
        events = self._journal.events
        self.progress = Progress(plan_of(folder.study, place), events)
        self._clock = Clock(utc_seconds(self.about["begun"]), events[-1]["ms"] if events else 0)
        self.trouble, self.seen = "", 0.0
        self.lag = (0, 0, 0)
        self._looks = self._failures = 0
        self._pages: dict[int, Page] = {}
        self._pool: Pool | None = None
        self._playing: str | None = None
        self._opening = asyncio.Lock()
        self._inbox: asyncio.Queue[tuple[Event, asyncio.Future[None] | None]] = asyncio.Queue()
        self._secretary: asyncio.Task[None] | None = None
        self._later: set[asyncio.Task[None]] = set()
        if fresh or not events:
            self._append(
                self._event(
                    "arrived", conditions=self.about["conditions"], study=folder.study_file, software=versions()
                )
            )
        else:
            self._append(self._event("resumed", study=folder.study_file, software=versions()))

    def serve(self, pool: Pool) -> None:
        """Begin to take events; games are played in this pool."""
        self._pool = pool
        self._secretary = asyncio.create_task(self._write())

    async def close(self) -> None:
        """Write what is still to be written; games have ended before."""
        if self._secretary is not None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(3 * RETRY):
                    await self._inbox.join()
            for task in (self._secretary, *self._later):
                task.cancel()
            await asyncio.gather(self._secretary, *self._later, return_exceptions=True)

    # -- the journal --------------------------------------------------------------------------------------------------
    def _event(self, event: str, **fields: Any) -> Event:
        return self._event_at(self._clock.ms(), event, fields)

    def _event_at(self, ms: int, event: str, fields: dict[str, Any]) -> Event:
        return {"ms": ms, "utc": self._clock.utc(ms), "event": event, **fields}

    def _append(self, event: Event) -> None:
        self._journal.append(event)
        self.progress.take(event)

    async def note(self, event: str, **fields: Any) -> None:
        """Take an event down; it is on the disk afterwards, and so is everything before it.

        Raises
        ------
        NotWritten
            When it is not; then it did not happen.
        """
        done: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._inbox.put_nowait((self._event(event, **fields), done))
        await done

    def note_later(self, event: str, **fields: Any) -> None:
        """Take an event down as soon as the disk lets us."""
        self._inbox.put_nowait((self._event(event, **fields), None))

    async def _write(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            event, done = await self._inbox.get()
            while True:
                try:
                    await loop.run_in_executor(self._writing, self._journal.append, event)
                except NotWritten as problem:
                    self.trouble = str(problem)
                    if done is None:
                        await asyncio.sleep(RETRY)
                        continue
                    if not done.done():
                        done.set_exception(problem)
                else:
                    self.trouble = event["what"] if event["event"] == "failed" else ""
                    self.progress.take(event)
                    if done is not None and not done.done():
                        done.set_result(None)
                break
            self._inbox.task_done()

    # -- his way ------------------------------------------------------------------------------------------------------
    @property
    def online(self) -> bool:
        """Whether a page of a game is connected, or he was heard of in the last minute."""
        return bool(self._pages) or (self.seen > 0 and time.monotonic() - self.seen < 60.0)

    def heard(self) -> None:
        """Take note that he is there."""
        self.seen = time.monotonic()

    async def begin_step(self) -> None:
        """Take down that he sees his step, the first time he does."""
        if not self.progress.begun:
            await self.note("begun", step=self.progress.current.name)

    async def finish_step(self, name: str, *events: tuple[str, dict[str, Any]]) -> None:
        """Take down what he did in a step, and that it is behind him; nothing when it was already.

        Raises
        ------
        NotWritten
        """
        async with self._opening:
            if self.progress.current.name != name or self.progress.finished:
                return
            await self.begin_step()
            for event, fields in events:
                await self.note(event, step=name, **fields)
            await self.note("done", step=name, by="participant")

    def look(self, value: bool) -> None:
        """Take down whether a page of text is in sight."""
        if self._looks < MAX_LOOKS:
            self._looks += 1
            self.note_later("look", step=self.progress.current.name, page=0, value=value)

    async def stop(self) -> None:
        """End his way early; what he did is kept."""
        if not self.progress.finished:
            await self.note("stopped", by="experimenter")
            self._end_game()
            self._send_on()

    async def extend(self, games: int) -> bool:
        """Let him play more games in the step he is at; False: it is no game."""
        current = self.progress.current
        if current.game is None:
            return False
        await self.note("extended", step=current.name, games=games)
        if self._pool is not None and self._playing == current.name:
            self._pool.longer(self.name, self.progress.wanted(current.name))
        return True

    # -- pages of games -----------------------------------------------------------------------------------------------
    async def enter(self, page: Page) -> None:
        """Take a page of the game; one that is open already gives way."""
        for old in list(self._pages.values()):
            self.leave(old, "replaced")
            old.replaced()
        self._pages[page.number] = page
        self.heard()
        self.note_later("page", state="opened", step=self.progress.current.name, page=page.number)
        await self._play()
        if page.number in self._pages and self._playing is not None and self._pool is not None:
            self._pool.enter(self.name, page.number)

    def hear(self, page: Page, text: str) -> None:
        """Pass on what a page says."""
        self.heard()
        if page.number in self._pages and self._pool is not None:
            self._pool.hear(self.name, page.number, text)

    def leave(self, page: Page, state: str = "closed") -> None:
        """Let a page go."""
        if self._pages.pop(page.number, None) is None:
            return
        self.heard()
        self.note_later("page", state=state, step=self.progress.current.name, page=page.number)
        if self._pool is not None:
            self._pool.leave(self.name, page.number)

    async def put_away(self, patience: float = 20.0) -> None:
        """Wait until no game of his is played in a worker."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(patience):
                while self._playing is not None:
                    await asyncio.sleep(0.05)

    def _send_on(self) -> None:
        for page in list(self._pages.values()):
            page.go_on()

    # -- games --------------------------------------------------------------------------------------------------------
    async def _play(self) -> None:
        """Begin the game of his step, if it is one and is not begun yet."""
        async with self._opening:
            current = self.progress.current
            if self._playing is not None or self._pool is None:
                return
            if current.game is None:
                self._send_on()
                return
            await self.begin_step()
            spec = self._spec(current)
            speed = current.game.speed * self._hurry
            recorded = len(self.progress.played[current.name].games)
            await self.note(
                "match", step=current.name, match=spec.match, seed=spec.seed, recorded=recorded, speed=speed
            )
            self._playing = current.name
            await self._pool.open(self, spec)

    def _spec(self, current: Planned) -> GameSpec:
        game = current.game
        assert game is not None
        played = self.progress.played[current.name]
        match = played.matches + 1
        kind = "rehearsal" if self._folder.rehearsal else "study"
        study = self._folder.study
        chosen = self.progress.language
        return GameSpec(
            participant=self.name,
            step=current.name,
            folder=str(self._path),
            size=game.task.size,
            field=game.task.field,
            vision=game.task.vision,
            profile=game.task.profile,
            speed=game.speed,
            hurry=self._hurry,
            actions=game.actions,
            keepers=game.keepers,
            correct=game.correct,
            games=self.progress.wanted(current.name),
            played=len(played.games),
            match=match,
            base_seed=game.seed,
            seed=derived_seed(game.seed, match),
            kept=current.kept,
            practice=isinstance(current.step, PracticeStep),
            may_end=isinstance(current.step, PracticeStep) and current.step.may_end,
            origin=self._clock.origin,
            language=chosen if chosen in study.languages else study.language,
            note=f"{kind}, {current.name}: {game.speed:g} times real time{game.described}",
            date=str(self.about["begun"])[:10],
        )

    def happened(self, event: Event) -> None:
        """Take an event of the game; see `rcss_hat.studies.pool.Player`."""
        if event["event"] == MATCH_OVER:
            self._playing = None
            self._soon(self._over(event["step"], event["finished"]))
            return
        if event["event"] == "game":
            self._failures = 0
        if event["event"] == "lag":
            pictures, late, worst = self.lag
            self.lag = pictures + event["pictures"], late + event["late"], max(worst, event["worst_ms"])
        fields = {name: value for name, value in event.items() if name not in ("event", "ms")}
        self._inbox.put_nowait((self._event_at(event["ms"], event["event"], fields), None))

    def lost(self) -> None:
        """Take note that the game is gone; whoever is there begins it again."""
        self._playing = None
        if not self.progress.finished:
            self.note_later("failed", step=self.progress.current.name, what="the process of the game ended")
            self._soon(self._reopen())

    async def _reopen(self) -> None:
        await asyncio.sleep(min(REOPEN * 2.0**self._failures, LONGEST))
        self._failures += 1
        if self._pages and self._playing is None:
            await self._play()
            self._enter_all()

    async def _over(self, step: str, finished: bool) -> None:
        """Go on after a game: to the next step, or, when more games were asked for meanwhile, to another match."""
        await self._inbox.join()
        if self.progress.stopped or self.progress.current.name != step:
            self._send_on()
        elif (
            finished
            and len(self.progress.played[step].games) < self.progress.wanted(step)
            and not self._ended_early(step)
        ):
            await self._reopen()
        elif finished:
            async with self._opening:
                await self._note_surely("done", step=step, by="participant")
            self._send_on()

    def _ended_early(self, step: str) -> bool:
        current = self.progress.current
        return isinstance(current.step, PracticeStep) and current.step.may_end

    async def _note_surely(self, event: str, **fields: Any) -> None:
        self.note_later(event, **fields)
        await self._inbox.join()

    def _enter_all(self) -> None:
        if self._pool is not None and self._playing is not None:
            for number in self._pages:
                self._pool.enter(self.name, number)

    def _end_game(self) -> None:
        if self._pool is not None and self._playing is not None:
            self._pool.end(self.name)

    def _soon(self, work: Any) -> None:
        task: asyncio.Task[None] = asyncio.create_task(work)
        self._later.add(task)
        task.add_done_callback(self._later.discard)
