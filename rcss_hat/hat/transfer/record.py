"""The record of a transfer method that kernels read."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

KIND_NO_PRIOR, KIND_VALUE_BONUS, KIND_EXTRA_ACTION, KIND_PPR, KIND_CHAT, KIND_REPLAY = range(6)
"""Kinds of methods, by which compiled code tells them apart."""

NO_ADVICE = -1
"""Advice when the rules say nothing about a state."""

METHOD = np.dtype(
    [
        ("kind", "i4"),
        ("forced", "i8"),  # episodes in which the advice is followed without a choice
        ("bonus", "f8"),  # cycles
        ("in_targets", "u1"),  # the bonus also counts in the values that learning aims at
        ("decay", "f8"),  # of the probability of reuse
        ("schedule", "u1"),  # what it decays with, see rcss_hat.hat.transfer.reuse
        ("threshold", "f8"),  # confidence below which advice is not followed
    ]
)
"""A transfer method: what it is and its settings. It never changes in play; what changes is in the LEARNER record."""


class TransferMethod(ABC):
    """Base of the transfer methods: frozen dataclasses whose fields are their hyper-parameters."""

    __slots__ = ()

    name: ClassVar[str]
    """As it is written on the command line and in results."""
    n_extra_actions: ClassVar[int] = 0
    """Pseudo-actions that need weights of their own."""
    needs_advice: ClassVar[bool] = True
    """Whether it uses D, the summary of demonstrations."""

    @property
    def replay_passes(self) -> int:
        """How often the demonstrations themselves are replayed before learning."""
        return 0

    @abstractmethod
    def describe(self) -> str:
        """Return one line for people."""

    @abstractmethod
    def to_record(self) -> NDArray[np.void]:
        """Return the METHOD record, shape (1,)."""


def method_record(kind: int, **values: float) -> NDArray[np.void]:
    """Make a METHOD record; fields that are not named are 0."""
    record = np.zeros(1, dtype=METHOD)
    record["kind"][0] = kind
    for field, value in values.items():
        record[field][0] = value
    return record


def check_count(name: str, value: int) -> None:
    """Raise ValueError unless a setting is a whole number of at least 0."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"{name} must be a whole number of at least 0, not {value!r}")


def check_number(name: str, value: float, low: float, high: float) -> None:
    """Raise ValueError unless a setting is a number from ``low`` to ``high``."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"{name} must be a number from {low:g} to {high:g}, not {value!r}")
    if not math.isfinite(value):
        raise ValueError(f"{name} must be finite, not {value!r}")
