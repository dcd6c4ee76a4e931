"""Matches on a server, step by step: a thread plays, and stands still while it waits for an answer.

While it stands still the server waits, too: in synch mode 1.25 s per cycle; after that, and in real time at once, it
goes on without us. Such cycles are counted (`Steps.missed`).
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import weakref
from collections.abc import Sequence
from queue import SimpleQueue
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcss_hat.envs.eye import Eye, truth_of
from rcss_hat.envs.stepping import DECISION, ENDED, GONE, HOLD, NO_CHOICE, REACHED, Setting, State, Steps
from rcss_hat.keepaway.agent import NO_DECISION, new_agent
from rcss_hat.keepaway.decision import Believer, Decide, EpisodeEnd
from rcss_hat.keepaway.report import OUT, TAKEN, Episode
from rcss_hat.keepaway.state import n_state_variables, state_variables
from rcss_hat.keepaway.taker_state import n_taker_variables, taker_state_variables
from rcss_hat.protocol.messages import Show
from rcss_hat.protocol.records import LEFT
from rcss_hat.stage.on_server import ServerStage
from rcss_hat.stage.stages import Part
from rcss_hat.stage.terms import Terms

DISCARD = -2
"""Answer of who wants no more of this episode."""
PARTING = 30.0
"""Seconds for a match to end that is not wanted any more."""


class _Event(NamedTuple):
    """Where the thread came to; see `Steps`."""

    what: int
    cycle: int = 0
    player: int = 0
    status: int = NO_DECISION
    number: int = 0
    start: int = 0
    last: int = 0
    missed: int = 0
    state: State | None = None
    views: Sequence[State | None] = ()
    episode: Episode | None = None
    failure: str = ""
    show: Show | None = None

    @property
    def waits(self) -> bool:
        """Whether the thread stands still until it is answered."""
        return self.what in (DECISION, REACHED)


class _Playing:
    """One match in a thread of its own; an `Onlooker` of its keepers."""

    def __init__(self, setting: Setting, seed: int) -> None:
        self.setting, self.seed = setting, seed
        self.events: SimpleQueue[_Event] = SimpleQueue()
        self.answers: SimpleQueue[int] = SimpleQueue()
        self._closing = self._discarding = False
        self._number, self._start, self._last = 1, -1, 0
        self._seen: dict[int, Believer] = {}
        self._acted = [-1] * setting.task.keepers
        self._decided_in = -1
        self._finals: dict[int, tuple[list[State | None], bool]] = {}
        self._views: list[list[tuple[int, State | None]]] = [[] for _ in range(setting.task.keepers)]
        self._eye = Eye() if setting.truth or setting.on_show is not None else None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._task: asyncio.Task[Any] | None = None
        self._stage: ServerStage | None = None
        self._thread = threading.Thread(target=self._play, name="keepaway", daemon=True)
        self._thread.start()

    # -- in the thread ------------------------------------------------------------------------------------------------
    def _play(self) -> None:
        failure = "the match was ended"
        try:
            failure = asyncio.run(self._match()) or failure
        except asyncio.CancelledError:  # before the match had begun
            pass
        except Exception as error:  # whatever it is, somebody waits for news
            failure = str(error) or type(error).__name__
        finally:
            if self._stage is not None:
                with contextlib.suppress(OSError):  # a folder that cannot be removed
                    self._stage.close()
            self.events.put(_Event(GONE, failure=failure, missed=self._missed, number=self._number))

    async def _match(self) -> str | None:
        self._loop, self._task = asyncio.get_running_loop(), asyncio.current_task()
        setting = self.setting
        policy = setting.policy(self._decide)
        policy.onlooker = self
        _warm_up(setting)
        orders = self._taker if setting.asks_takers else None
        self._stage = ServerStage(setting.place, setting.task, self.seed, policy, Terms(orders=orders))
        if self._closing:
            return self._stage.report.failure
        looking = None if self._eye is None else asyncio.create_task(self._eye.open(self._stage.address))
        try:
            await self._stage.run(Part(on_episodes=self._episodes))
        finally:
            if looking is not None and self._eye is not None:
                looking.cancel()
                await asyncio.gather(looking, return_exceptions=True)
                self._eye.close()
        return self._stage.report.failure

    @property
    def _missed(self) -> int:
        match = self._stage.match if self._stage is not None else None
        return 0 if match is None else match.missed

    def _decide(self, state: State, info: dict[str, Any]) -> int:
        """Answer for a keeper: this is its policy."""
        cycle, keeper = info["cycle"], info["keeper"] - 1
        for end in [end for end in self._finals if self._start < end <= cycle]:
            reason = TAKEN if self._finals[end][1] else OUT
            self._tell_end(Episode(self._number, self._start, end, reason))  # the first player has not heard of it yet
        if self._is_idle(cycle):
            return HOLD
        self._last, self._decided_in = keeper, cycle
        return self._ask(DECISION, cycle, keeper, info["status"], state)

    def _taker(self, number: int) -> tuple[Decide, EpisodeEnd | None]:
        """Return a taker's policy: the one that was given, or whoever steps."""
        setting = self.setting

        def decide(cycle: int, status: int, reward: float, state: State) -> int:
            if self._is_idle(cycle):
                return HOLD
            if setting.takers is not None:
                return setting.takers(state.copy(), {"episode": self._number, "cycle": cycle, "taker": number + 1})
            self._decided_in = cycle
            return self._ask(DECISION, cycle, setting.task.keepers + number, status, state.copy())

        return decide, None

    def _is_idle(self, cycle: int) -> bool:
        """Whether nobody wants to be asked: nobody is there, or it is not an episode that counts."""
        if self._start < 0:
            match = self._stage.match if self._stage is not None else None
            since = None if match is None else match.running_since
            self._start = -1 if since is None else since
        return self._closing or self._discarding or self._start < 0 or cycle >= self.setting.cap(self._start)

    def _ask(
        self, what: int, cycle: int, player: int, status: int, state: State | None, views: Sequence[State | None] = ()
    ) -> int:
        """Wait for an answer."""
        if not views and self.setting.every_view:
            views = [next((v for c, v in reversed(seen) if self._start < c < cycle), None) for seen in self._views]
        self._put(_Event(what, cycle, player, status, state=state, views=views))
        answer = self.answers.get()
        if answer == DISCARD:
            self._discarding = True
        return max(answer, HOLD)

    def _put(self, event: _Event) -> None:
        if self._eye is not None:
            event = event._replace(show=self._eye.at(event.cycle))
        self.events.put(event._replace(number=self._number, start=self._start, last=self._last, missed=self._missed))

    def ended(self, player: Believer, cycle: int, taken: bool) -> None:
        """See `Onlooker.ended`: when the first hears of an end, all still believe what was before."""
        self._seen[player.unum - 1] = player
        if cycle > self._start and cycle not in self._finals:
            self._finals[cycle] = self._look_around(), taken

    def acted(self, player: Believer) -> None:
        """See `Onlooker.acted`."""
        self._seen[player.unum - 1], self._acted[player.unum - 1] = player, player.cycle
        if self._eye is not None:
            self._eye.look()  # there is room for some hundred frames
        cycle = min(self._acted)
        if self.setting.every_view:
            seen = self._views[player.unum - 1]
            seen[:] = [*seen[-1:], (player.cycle, self._believed(player.unum - 1))]
        if self.setting.every_cycle and self._start < 0:
            self._is_idle(cycle)  # finds out whether the first episode has begun
        if self._closing or self._discarding or self._start < 0 or cycle <= self._start:
            return
        capped = cycle >= self.setting.cap(self._start)
        every = self.setting.every_cycle and cycle == player.cycle != self._decided_in
        if capped or every:
            views = self._look_around()
            self._ask(REACHED, cycle, self._last, NO_DECISION, self._best(views), views)
            self._discarding |= capped

    def _best(self, views: Sequence[State | None]) -> State | None:
        """Return the view of the keeper that decided last, or of one that knows where everybody is."""
        return next((views[k] for k in (self._last, *range(len(views))) if views and views[k] is not None), None)

    def _look_around(self) -> list[State | None]:
        return [self._believed(k) for k in range(self.setting.task.keepers)]

    def _believed(self, keeper: int) -> State | None:
        task = self.setting.task
        state = np.zeros(n_state_variables(task.keepers, task.takers))
        beliefs = self._seen[keeper].beliefs if keeper in self._seen else None
        return state if beliefs is not None and state_variables(beliefs.copy(), state) else None

    def _episodes(self, episodes: Sequence[Episode], cycles: int) -> bool:
        """Take the ends of episodes as the stage tells them."""
        for episode in episodes:
            if episode.end > self._start:
                self._start = episode.start  # of the first, if nobody has decided in it
                self._tell_end(episode)
        return self._closing

    def _tell_end(self, episode: Episode) -> None:
        views, _ = self._finals.get(episode.end, ([], False))
        self._put(_Event(ENDED, episode.end, state=self._best(views), views=views, episode=episode))
        self._finals = {cycle: state for cycle, state in self._finals.items() if cycle > episode.end}
        self._number, self._start, self._discarding = episode.number + 1, episode.end, False

    # -- outside ------------------------------------------------------------------------------------------------------
    def close(self) -> None:
        """End the match, and wait until it has."""
        self._closing = True
        self.answers.put(HOLD)
        if self._loop is not None and self._task is not None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join(PARTING)


def _warm_up(setting: Setting) -> None:
    """Compile what is looked at, before a server waits for an answer."""
    keepers, takers = setting.task.keepers, setting.task.takers
    agent = new_agent(LEFT, 1, keepers, takers, setting.task.params().record(), 0)
    state_variables(agent, np.zeros(n_state_variables(keepers, takers)))
    if setting.asks_takers:
        taker_state_variables(agent, np.zeros(n_taker_variables(keepers, takers)))


class ServerSteps(Steps):
    """See `Steps`."""

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        if setting.every_view and setting.asks_takers and setting.takers is None:
            raise ValueError(f"with takers that decide, a step on {setting.place} is one decision: use per='decision'")
        if setting.on_frame is not None:
            raise ValueError(f"in every cycle a match on {setting.place} is seen by monitors: rcss-hat watch")
        self._playing: _Playing | None = None
        self._waits = False
        self._show: Show | None = None
        self._end: Any = None

    def begin(self, seed: int) -> None:
        """See `Steps.begin`."""
        self.close()
        self.failure, self._waits = "", False
        self._playing = _Playing(self.setting, seed)
        self._end = weakref.finalize(self, self._playing.close)
        self.number, self.start = 1, 0

    def go_on(self, choice: int = NO_CHOICE) -> int:
        """See `Steps.go_on`."""
        playing = self._playing
        if playing is None:
            self.failure = self.failure or "no match has begun"
            return GONE
        if self._waits:
            playing.answers.put(choice)
        try:
            event = playing.events.get()
        except BaseException:  # Ctrl-C: what was answered is lost, and so is the match
            self.close()
            raise
        return self._take(event)

    def _take(self, event: _Event) -> int:
        self._waits = event.waits
        self.number, self.missed = event.number, event.missed
        if event.what == GONE:
            self.failure = event.failure
            self.close()
            return GONE
        self.cycle, self.player, self.status = event.cycle, event.player, event.status
        self.start, self.last = event.start, event.last
        self.perceived = event.state is not None
        if event.state is not None:
            self.state = event.state
        if event.views:
            self.views[: len(event.views)] = event.views
        if event.episode is not None:
            self.episode = event.episode
            self.number, self.start = event.episode.number + 1, event.episode.end  # the next one runs already
        if event.what == DECISION and event.player < self.setting.task.keepers:
            self.seen = self.setting.observations.of(self.state)
        if event.show is not None:
            self._show = event.show
            if self.setting.on_show is not None:
                self.setting.on_show(event.show, self.number, self.start)
        return event.what

    def truth(self) -> dict[str, NDArray[np.float64]]:
        """See `Steps.truth`."""
        assert self._show is not None, "the setting wants it"
        return truth_of(self._show, self.setting.task)

    def discard(self) -> int:
        """See `Steps.discard`."""
        what = self.go_on(DISCARD)
        while what not in (ENDED, GONE):
            what = self.go_on(DISCARD)
        return what

    def close(self) -> None:
        """See `Steps.close`."""
        if self._end is not None:
            self._end()
        self._playing, self._waits = None, False
