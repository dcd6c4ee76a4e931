"""The table of transfer methods.

A new method is one file with its dataclass and its selection kernel, a row here, and a branch in
`rcss_hat.hat.transfer.kernels.select`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from rcss_hat.hat.transfer.chat import CHAT
from rcss_hat.hat.transfer.extra_action import ExtraAction
from rcss_hat.hat.transfer.no_prior import NoPrior
from rcss_hat.hat.transfer.ppr import PPR
from rcss_hat.hat.transfer.record import TransferMethod
from rcss_hat.hat.transfer.replay import Replay
from rcss_hat.hat.transfer.value_bonus import ValueBonus

METHODS: dict[str, type[TransferMethod]] = {
    method.name: method for method in (NoPrior, ValueBonus, ExtraAction, PPR, CHAT, Replay)
}
"""All methods by name."""


def make_method(name: str, settings: Mapping[str, Any] | None = None) -> TransferMethod:
    """Make a method by name.

    Parameters
    ----------
    name : str
        A key of `METHODS`.
    settings : mapping, optional
        Hyper-parameters that differ from the defaults.

    Raises
    ------
    ValueError
        For an unknown name or setting, or a value that is not allowed.
    """
    if name not in METHODS:
        raise ValueError(f"no transfer method {name!r}; there are {', '.join(METHODS)}")
    known = set(parameters(METHODS[name]()))
    unknown = sorted(set(settings or ()) - known)
    if unknown:
        has = ", ".join(sorted(known)) if known else "none"
        raise ValueError(f"transfer method {name} has no setting {unknown[0]!r}; it has {has}")
    return METHODS[name](**(settings or {}))


def parameters(method: TransferMethod) -> dict[str, Any]:
    """Return the hyper-parameters of a method as JSON data; `make_method` takes them back."""
    described: Any = method
    return {field.name: getattr(method, field.name) for field in fields(described)}
