"""Confidence-based HAT: follow D where it is sure, with a probability that fades (Wang and Taylor, IJCAI 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.transfer.ppr import select_ppr
from rcss_hat.hat.transfer.record import KIND_CHAT, NO_ADVICE, TransferMethod, check_number, method_record
from rcss_hat.hat.transfer.reuse import SCHEDULES, check_schedule
from rcss_hat.numeric.jit import kernel


@kernel
def select_chat(
    method: NDArray[np.void], learner: NDArray[np.void], rng: NDArray[np.uint64], advice: int, confidence: float
) -> int:
    """Select as `select_ppr` does, taking advice below the threshold of confidence for none."""
    trusted = advice if confidence >= method["threshold"][0] else NO_ADVICE
    return select_ppr(method, learner, rng, trusted)


@dataclass(frozen=True, slots=True)
class CHAT(TransferMethod):
    """Follow the advice with probability psi where the summary's confidence reaches a threshold.

    The published factor for Keepaway is 0.999. It decays there with every time step; the default here is PPR's decay by
    episodes, so that the two methods differ by the threshold alone. The threshold is this package's choice.
    """

    threshold: float = 0.6
    """Confidence, 0 to 1, from which on advice may be followed."""
    decay: float = 0.999
    """psi after k episodes is ``decay ** k``."""
    schedule: str = "episode"
    """What psi decays with: ``episode``, ``decision`` or ``within-episode``."""

    name: ClassVar[str] = "chat"

    def __post_init__(self) -> None:
        """Check the settings."""
        check_number("threshold", self.threshold, 0.0, 1.0)
        check_number("decay", self.decay, 0.0, 1.0)
        check_schedule(self.schedule)

    def describe(self) -> str:
        """Return one line for people."""
        return f"CHAT: D where its confidence is at least {self.threshold:g}, psi = {self.decay:g} ** {self.schedule}s"

    def to_record(self) -> NDArray[np.void]:
        """Return the METHOD record, shape (1,)."""
        schedule = SCHEDULES.index(self.schedule)
        return method_record(KIND_CHAT, threshold=self.threshold, decay=self.decay, schedule=schedule)
