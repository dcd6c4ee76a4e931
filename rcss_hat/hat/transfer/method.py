"""What a transfer method is: settings for people, a record and a kernel for compiled code, all in one file.

A method of another package is a module like those beside this one, named by an entry point of the group
``rcss_hat.methods``:

.. code-block:: toml

    [project.entry-points."rcss_hat.methods"]
    my-method = "my_package.my_method:MyMethod"
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from rcss_hat.learning.sarsa import LEARNER
from rcss_hat.numeric.pointers import Slot

if TYPE_CHECKING:
    from rcss_hat.hat.transfer.learners import Learners
    from rcss_hat.hat.transfer.replay import Decisions

NO_ADVICE = -1
"""Advice when the rules say nothing about a state."""
N_SETTINGS = 8

METHOD = np.dtype(
    [
        ("select", "i8"),  # address of the kernel that selects
        ("bonus", "f8"),  # cycles added to Q of the advised action in the values that learning aims at
        ("settings", "f8", (N_SETTINGS,)),  # the method's own, in an order of its own
    ]
)
"""A transfer method as compiled code reads it. It never changes in play; what changes is in the LEARNER record."""

SELECT = Slot(
    types.int64,
    *(numba.typeof(np.zeros(1, dtype=record)) for record in (METHOD, LEARNER)),
    numba.typeof(np.zeros(4, dtype=np.uint64)),
    types.int64,
    types.float64,
)
"""Where the loop calls a method's kernel: (METHOD, LEARNER, random stream, advice, confidence) -> row of the weights
that gets the credit. A row below ``n_actions`` is that action, a row above executes the advice. The advice is D(s) as
an action number, or `NO_ADVICE`; its confidence lies between 0 and 1."""


class TransferMethod(ABC):
    """Base of the transfer methods: frozen dataclasses whose fields are their hyper-parameters.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> from rcss_hat import METHODS, TransferMethod
    >>> PPR = METHODS["ppr"]
    >>> issubclass(PPR, TransferMethod), PPR(decay=0.99).describe()
    (True, 'Probabilistic Policy Reuse: psi = 0.99 ** episodes')
    """

    __slots__ = ()

    name: ClassVar[str]
    """As it is written on the command line and in results."""
    n_extra_actions: ClassVar[int] = 0
    """Pseudo-actions that need weights of their own."""
    needs_advice: ClassVar[bool] = True
    """Whether it uses D, the summary of demonstrations."""
    needs_decisions: ClassVar[bool] = False
    """Whether it uses the demonstrated decisions themselves."""
    select: ClassVar[staticmethod[[NDArray[np.void], NDArray[np.void], NDArray[np.uint64], int, float], int]]
    """The kernel, as a static method in plain Python; compiled when a learner with this method is made."""

    @abstractmethod
    def describe(self) -> str:
        """Return one line for people."""

    def settings(self) -> tuple[float, ...]:
        """Return the numbers that the kernel gets, at most 8."""
        return ()

    @property
    def target_bonus(self) -> float:
        """Cycles added to Q of the advised action in the values that learning aims at."""
        return 0.0

    def psi(self, learner: NDArray[np.void]) -> float:
        """Return the probability with which a learner's next decision reuses the advice; nan where there is none."""
        return math.nan

    def psi_after(self, episodes: int) -> float | None:
        """Return psi after so many episodes, for the log; None where there is none or it does not follow from them."""
        return None

    def prepare(self, learners: Learners, decisions: Decisions) -> None:  # noqa: B027 (most methods have nothing to do)
        """Teach learners that have not learned yet; called once, when the method `needs_decisions`."""

    def to_record(self) -> NDArray[np.void]:
        """Return the METHOD record, shape (1,); its address holds in this process."""
        record = np.zeros(1, dtype=METHOD)
        record["select"][0] = SELECT.address(type(self).select)
        record["bonus"][0] = self.target_bonus
        numbers = self.settings()
        record["settings"][0, : len(numbers)] = numbers
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


def check_choice(name: str, value: Any, choices: tuple[str, ...]) -> None:
    """Raise ValueError unless a setting is one of the choices."""
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(choices)}, not {value!r}")
