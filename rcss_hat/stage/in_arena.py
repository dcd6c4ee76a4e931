"""The arena as a stage."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from heapq import merge
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.batch import play_batch
from rcss_hat.arena.match import SPEED, ArenaMatch, prepare
from rcss_hat.hat.policy import TeamPolicy
from rcss_hat.hat.taker_policy import TakerPolicy
from rcss_hat.keepaway.decision import Decision, PolicyFailed
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.compiling import compiling
from rcss_hat.stage.place import Place
from rcss_hat.stage.stages import Part, Stage
from rcss_hat.stage.terms import Terms
from rcss_hat.system.interrupts import interrupt_flag


class ArenaStage(Stage):
    """A match in the compiled loop."""

    waits = True

    def __init__(self, place: Place, task: Task, seed: int, policy: TeamPolicy | None, terms: Terms) -> None:
        if terms.trainer is not None:
            raise ValueError("a trainer referees on a server, not in the arena")
        if policy is None or not terms.takers:
            raise ValueError("in the arena both teams are ours")
        super().__init__(place, task, seed, policy, terms)
        asked = self._asked if policy.function is not None else None
        self.match = ArenaMatch(task, seed, policy, external=asked, orders=self._orders(terms))
        self._policy, self._part = policy, Part()

    @staticmethod
    def _orders(terms: Terms) -> TakerPolicy | None:
        if terms.orders is not None and not isinstance(terms.orders, TakerPolicy):
            raise ValueError("in the arena takers are told what to do by a TakerPolicy")
        return terms.orders

    @property
    def cycle(self) -> int:
        """Cycles of this match that were played before."""
        return self.match.cycle

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything of the match that changes; see `ArenaMatch.arrays`."""
        return self.match.arrays()

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Go back to what `arrays` returned."""
        self.match.restore(dict(arrays))

    def play(self, part: Part) -> RunReport:
        """Play; see `Stage.play`."""
        self._begin()
        self._part = part
        self.match.log(part.on_decision is not None, self._is_seen)
        begun, before, played = time.monotonic(), self.match.cycle, list[Episode]()
        try:
            with interrupt_flag() as interrupted:
                for ended in self.match.advance(part.cycles, part.episodes):
                    played += ended
                    self._tell()
                    if part.on_episodes is not None and part.on_episodes(ended, self.match.cycle):
                        break
                    if interrupted():
                        raise KeyboardInterrupt
        except KeyboardInterrupt:
            self.report.end_early(INTERRUPTED)
        except PolicyFailed as error:
            self.report.end_early(error)
        finally:
            self._part = Part()  # whoever was told is not held any longer
        self._played(played, self.match.cycle - before, time.monotonic() - begun)
        return self.report

    def play_matches(self, matches: int, jobs: int, episodes: int, told: Callable[[int], object]) -> RunReport:
        """Play a batch of matches; see `Stage.play_matches`."""
        if self.terms.orders is not None:
            raise ValueError("many matches are played by hand-coded takers")
        self._begin()
        begun, results = time.monotonic(), []
        try:
            for result in play_batch(self.task, self._policy.spec, self.seed, matches, episodes, jobs):
                results.append(result)
                told(len(results))
        except KeyboardInterrupt:
            self.report.end_early(INTERRUPTED)
        except PolicyFailed as error:
            self.report.end_early(error)
        results.sort(key=lambda result: result.number)
        cycles = sum(result.cycles for result in results)
        self._played([e for result in results for e in result.episodes], cycles, time.monotonic() - begun)
        return self.report

    @property
    def _is_seen(self) -> bool:
        return self._part.on_frame is not None or self._policy.on_frame is not None

    def _begin(self) -> None:
        with compiling(self.terms.say, "the players and the simulation", "rcss_hat.arena.loop"):
            prepare()
        self.report.told(self.task, self.task.profile, SPEED)
        self.report.ends_judged_by = "referee"

    def _played(self, episodes: list[Episode], cycles: int, wall_s: float) -> None:
        """Add what was played to the report: a match may be played part by part."""
        so_far = self.report
        so_far.played([*so_far.episodes, *episodes], so_far.cycles + cycles, so_far.wall_s + wall_s)

    def _asked(self, state: NDArray[np.float64], info: dict[str, Any]) -> int:
        """Answer for a policy in Python; whoever sees the match has seen it up to here."""
        assert self._policy.function is not None
        if self._is_seen:
            self._tell()
        return self._policy.function(state, info)

    def _tell(self) -> None:
        """Tell what was seen and decided since the last time, cycle by cycle: first what was seen."""
        frames = ((int(frame["time"]), 0, frame) for frame in self.match.take_frames())
        decisions = ((int(d["cycle"]), 1, d) for d in self.match.take_decisions())
        for cycle, kind, row in merge(frames, decisions, key=lambda entry: entry[:2]):
            if kind == 0:
                for told in (self._policy.on_frame, self._part.on_frame):
                    if told is not None:
                        told(row)
            elif self._part.on_decision is not None:
                decision = Decision(cycle, int(row["keeper"]), tuple(row["state"].tolist()), int(row["action"]))
                self._part.on_decision(decision)
