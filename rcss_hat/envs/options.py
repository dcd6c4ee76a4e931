"""What an environment is asked to be, checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rcss_hat.envs.rewards import CYCLES
from rcss_hat.envs.spaces import Observations
from rcss_hat.envs.stepping import Setting
from rcss_hat.hat.taker_policy import HAND, load_taker_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place

PER_DECISION, PER_CYCLE = "decision", "cycle"


@dataclass(frozen=True, slots=True)
class Options:
    """What `rcss_hat.envs.keepaway_env.KeepawayEnv` is asked to be; see there.

    Raises
    ------
    ValueError
        Naming what would be right.
    """

    size: str = "3v2"
    field: str | None = None
    vision: int = 360
    profile: str = "19.0"
    stage: str = ARENA
    takers: str | Callable[..., int] = HAND
    hold_cycles: int = 1
    max_cycles: int | None = None
    normalize: bool = False
    reward: str = CYCLES
    discount: float | None = None
    per: str = PER_DECISION
    truth: bool = False

    def __post_init__(self) -> None:
        self.task  # noqa: B018 (says what is wrong with it)
        Place.parse(self.stage)
        if self.hold_cycles < 1:
            raise ValueError(f"hold_cycles must be 1 or more, not {self.hold_cycles}")
        if self.max_cycles is not None and self.max_cycles < 1:
            raise ValueError(f"max_cycles must be 1 or more, or None, not {self.max_cycles}")
        if self.per not in (PER_DECISION, PER_CYCLE):
            raise ValueError(f"per is {PER_DECISION!r} or {PER_CYCLE!r}, not {self.per!r}")
        if not isinstance(self.takers, str) and not callable(self.takers):
            raise ValueError(f"takers are {HAND!r}, a function of (state, info) or its name, not {self.takers!r}")

    @property
    def task(self) -> Task:
        """What is played."""
        return Task.parse(self.size, self.field, self.vision, self.profile)

    def _taker_policy(self) -> Callable[..., int] | None:
        """Return who decides for the takers, found by its name where that is given; None: nobody."""
        if not isinstance(self.takers, str):
            return self.takers
        named = load_taker_policy(self.takers, self.task, 0)
        return None if named is None else named.function

    def setting(self, observations: Observations, **changes: Any) -> Setting:
        """Return what `rcss_hat.envs.stepping.open_steps` plays."""
        takers = self._taker_policy()
        asked: dict[str, Any] = {
            "hold_cycles": self.hold_cycles,
            "max_cycles": self.max_cycles,
            "every_cycle": self.per == PER_CYCLE,
            "takers": takers,
            "truth": self.truth,
            "taker_cycles": None if takers is None else 1,
        }
        return Setting(Place.parse(self.stage), observations.task, observations, **asked | changes)
