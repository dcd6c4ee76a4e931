"""Many matches that are played together, over threads, each to its next decision."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rcss_hat.arena.match import NEVER, prepare
from rcss_hat.arena.vector_handle import VectorHandle
from rcss_hat.arena.vector_records import BEGINNING, CUT_OFF, DISCARDING, NOT_ENDED, Batch, Part, new_batch
from rcss_hat.hat.brains import EXTERNAL, fixed_brains
from rcss_hat.keepaway.task import Task
from rcss_hat.numeric.cache_folders import is_cached
from rcss_hat.simulation.keepaway import kick_off
from rcss_hat.simulation.referee import award_drop_ball
from rcss_hat.simulation.world import World

KERNELS = "rcss_hat.arena.vector_handle"
"""Module of the kernel that is compiled for this."""


class VectorMatch:
    """Many matches of one task that are played together, each decided from outside.

    Parameters
    ----------
    task : Task
    matches : int
    threads : int
        How many of them share the matches.
    hold_cycles : int
        Cycles from a Hold to the next decision.
    max_cycles : int
        Cycles after which an episode is cut off; 0: never.
    goes_on : bool
        Whether a step in which an episode ends goes on to the first decision of the next.
    normalize : bool
        Scale observations, see `rcss_hat.keepaway.observation.observation_scale`.

    Attributes
    ----------
    batch : Batch
        ``observations``, ``final_observations`` and ``lanes`` are what comes of a step.
    table : ndarray of int32, shape (matches, fields of LANE)
        The lanes, for who copies them often.
    """

    def __init__(
        self,
        task: Task,
        matches: int,
        threads: int = 1,
        hold_cycles: int = 1,
        max_cycles: int = 0,
        goes_on: bool = True,
        normalize: bool = False,
    ) -> None:
        if matches < 1 or threads < 1:
            raise ValueError(f"there must be a match and a thread, not {matches} and {threads}")
        self.task, self.matches, self.hold_cycles, self.normalize = task, matches, hold_cycles, normalize
        self.goes_on, self.threads = goes_on, min(threads, matches)
        self._brains = fixed_brains(EXTERNAL, task.keepers, task.takers, 0)
        self._handle: VectorHandle
        self._pool = ThreadPoolExecutor(self.threads - 1, "matches") if self.threads > 1 else None
        edges = np.linspace(0, matches, self.threads + 1).astype(int).tolist()
        self._parts = [Part(a, b, max_cycles, goes_on) for a, b in pairwise(edges)]
        self._all = np.arange(matches)
        self._rows = self._all.copy()
        self.batch: Batch
        self.table: NDArray[np.int32]

    def begin(self, seeds: Sequence[int]) -> None:
        """Begin new matches and play each to its first decision.

        Parameters
        ----------
        seeds : sequence of int
            As many as matches; each decides everything about its match, see `ArenaMatch`.
        """
        if not is_cached(KERNELS):
            prepare()  # what this kernel is linked from is compiled in two processes there
        self.batch = new_batch(self.task, seeds, self.hold_cycles, self.normalize)
        for i in range(self.matches):
            kick_off(self._world(i))
        self._handle = VectorHandle(self.batch, self._brains, self._rows)
        self.table = self.batch.lanes.view(np.int32).reshape(self.matches, -1)
        self.batch.lanes["doing"], self.batch.lanes["keepers"] = BEGINNING, self.task.keepers
        if self._parts[0].max_cycles:
            self.batch.control["stop_cycle"] = self._parts[0].max_cycles
        self._play()

    def step(self, actions: NDArray[np.integer]) -> None:
        """Take the decisions at hand and play on to the next.

        Where an episode ended in the last step and matches do not go on, the action counts for nothing: that match is
        played to the first decision of its next episode.

        Parameters
        ----------
        actions : ndarray of int, shape (matches,)
            Legal ones.
        """
        self.batch.choices[:] = actions
        self._play()

    def discard(self) -> None:
        """Leave the episodes at hand, which are played to their ends by Hold, and go to the first decisions after."""
        lanes = self.batch.lanes
        between = (lanes["ended"] != NOT_ENDED) & (lanes["ended"] != CUT_OFF) & (not self.goes_on)
        lanes["doing"] = np.where(between, BEGINNING, DISCARDING)
        lanes["dt"], lanes["ended"] = 0, NOT_ENDED
        self.batch.control["stop_cycle"][~between] = NEVER
        self._play()

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _world(self, i: int) -> World:
        batch = self.batch
        return World(batch.match[i : i + 1], batch.params, batch.types, batch.streams[i])

    def _play(self) -> None:
        """Let every match do what it is doing until it waits."""
        self._rows[:] = self._all
        waiting = [] if self._pool is None else [self._pool.submit(self._handle.play, part) for part in self._parts[1:]]
        stuck = [self._handle.play(self._parts[0]), *(each.result() for each in waiting)]
        for part, n in zip(self._parts, stuck, strict=True):
            self._finish(part, n)

    def _finish(self, part: Part, stuck: int) -> None:
        """Drop balls that are stuck, which is rare, and let those matches go on."""
        while stuck:
            for i in self._rows[part.first : part.first + stuck].tolist():
                award_drop_ball(self._world(i))
            stuck = self._handle.play(part._replace(last=part.first + stuck))
