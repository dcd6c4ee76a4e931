"""A server as a stage: a fake or real one that is started for the match, or one that runs already."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Mapping
from dataclasses import replace

from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.keepaway.decision import KeeperPolicy, OnDecision, onlooker_of, overheard
from rcss_hat.keepaway.final_states import FinalStates
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.session import KeepawayPlayer
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.aside import aside
from rcss_hat.numeric.compiling import compiling
from rcss_hat.protocol.params import Value
from rcss_hat.stage.crew import Crew, never
from rcss_hat.stage.match import Match, play_match
from rcss_hat.stage.options import REFEREED_BY_TRAINER
from rcss_hat.stage.place import Address, Place
from rcss_hat.stage.processes import ProcessCrew
from rcss_hat.stage.servers import ServerFailed
from rcss_hat.stage.stages import Part, Stage
from rcss_hat.stage.survey import KEEPERS
from rcss_hat.stage.terms import Terms
from rcss_hat.stage.trainer import TrainerClient

SYNCH_PATIENCE_S = 1.25
"""Seconds that a server in synch mode waits for an answer."""
ENDLESS = 10**9
"""Episodes of a match that something else ends."""


class ServerStage(Stage):
    """A match on a server over UDP.

    Attributes
    ----------
    server : ServerProcess or None
        Started for the match; None where the server runs already.
    match : Match or None
        What is being played.
    """

    def __init__(self, place: Place, task: Task, seed: int, policy: TeamPolicy | None, terms: Terms) -> None:
        if policy is not None and policy.on_frame is not None:
            raise ValueError(f"{policy.spec} sees the whole field, as only the arena shows it: use --on arena")
        super().__init__(place, task, seed, policy, terms)
        changes = REFEREED_BY_TRAINER if terms.trainer is not None else {}
        self.server = None if place.address else place.server(task, seed, terms.logs, **changes, **terms.pace)
        self.match: Match | None = None
        self._address = place.address or (self.server.host, self.server.port)  # type: ignore[union-attr]

    @property
    def address(self) -> Address:
        """Where players and monitors find the server."""
        return self._address

    def close(self) -> None:
        """Remove what the server left behind."""
        if self.server is not None:
            self.server.clean()

    def play(self, part: Part) -> RunReport:
        """Play; see `Stage.play`."""
        try:
            return asyncio.run(self.run(part))
        except KeyboardInterrupt:
            self.report.end_early(INTERRUPTED)
            return self.report

    async def run(self, part: Part) -> RunReport:
        """Play in an event loop that runs already; see `Stage.run`."""
        if part.on_frame is not None:
            raise ValueError("who wants to see a match on a server connects to it as a monitor")
        finals = None if part.on_decision is None else FinalStates(self.task)
        try:
            async with self.server or contextlib.nullcontext():  # started first: it may have to compile, too
                with compiling(self.terms.say, "the players", "rcss_hat.keepaway.agent"):
                    await aside(self._warm_up)
                    if finals is not None:
                        await aside(finals.warm_up)
                await self._play(part, finals)
        except ServerFailed as error:
            self.report.end_early(error)
        return self.report

    async def _play(self, part: Part, finals: FinalStates | None) -> None:
        endless = part.episodes is None and part.cycles is not None
        match = self.match = self._match(ENDLESS if endless else part.episodes, part.on_decision, finals)
        playing, enough = asyncio.current_task(), False
        assert playing is not None

        def ended(episode: Episode) -> None:
            nonlocal enough
            if enough:
                return
            if finals is not None:
                episode = replace(episode, final=finals.take(episode.end))
            over = part.on_episodes is not None and part.on_episodes([episode], match.cycles)
            if over or (part.cycles is not None and match.cycles >= part.cycles):
                enough = playing.cancel()

        await play_match(self.report, match, self.server, self._trainer(), self.terms.kick_off, ended)
        if self.policy is not None:
            self.report.decided(self.policy.times, _patience_s(match.gathering.told))
        if enough:
            playing.uncancel()
            self.report.stopped_on_purpose()

    def _warm_up(self) -> None:
        """Compile here what players need: processes of theirs would race for it, and servers wait for answers."""
        if self.policy is not None:
            self.policy.warm_up()
        KeepawayPlayer(KEEPERS, self.task.keepers, self.task.takers, self.seed, never).prepare()

    def _match(self, episodes: int | None, on_decision: OnDecision | None, finals: FinalStates | None) -> Match:
        keepers: KeeperPolicy | None = self.policy
        crew: Crew | None = None
        if self.terms.processes:
            if self.policy is None or on_decision is not None or self.terms.orders is not None:
                raise ValueError("players in processes of their own are both teams, and tell nobody what they decide")
            crew = ProcessCrew(self.task, *self.address, self.seed, self.policy)
        elif keepers is not None and on_decision is not None:
            keepers = overheard(keepers, on_decision)
            if finals is not None and onlooker_of(keepers) is None:
                keepers = overheard(keepers, finals.decided)
                keepers.onlooker = finals  # type: ignore[attr-defined]
        return Match(self.task, self.address, self.seed, keepers, self.terms.takers, episodes, self.terms, crew)

    def _trainer(self) -> TrainerClient | None:
        """Return the trainer that referees instead of the server, not connected yet."""
        if self.terms.trainer is None:
            return None
        host, port = self.address
        return TrainerClient(self.task, host, self.terms.trainer or port + 1, self.seed)


def _patience_s(told: Mapping[str, Value]) -> float:
    """Seconds that a server gives for an answer: to the end of the cycle, or in synch mode until it waits no more."""
    return SYNCH_PATIENCE_S if told.get("synch_mode") else float(told.get("simulator_step", 100)) / 1000.0
