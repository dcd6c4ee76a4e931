"""Transfer methods by name and settings, as the command line and studies give them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from rcss_hat.hat.registry import METHODS
from rcss_hat.hat.transfer.method import TransferMethod


def make_method(name: str, settings: Mapping[str, Any] | None = None) -> TransferMethod:
    """Make a method by name.

    Parameters
    ----------
    name : str
        One of `rcss_hat.hat.registry.METHODS`.
    settings : mapping, optional
        Hyper-parameters that differ from the defaults.

    Raises
    ------
    ValueError
        For an unknown name or setting, or a value that is not allowed.
    """
    method = METHODS[name]
    if not (isinstance(method, type) and issubclass(method, TransferMethod) and method.name == name):
        raise ValueError(f"the transfer method {name!r} is no TransferMethod of that name")
    described: Any = method
    known = {field.name for field in fields(described)}
    unknown = sorted(set(settings or ()) - known)
    if unknown:
        has = ", ".join(sorted(known)) if known else "none"
        raise ValueError(f"transfer method {name} has no setting {unknown[0]!r}; it has {has}")
    return method(**(settings or {}))


def parameters(method: TransferMethod) -> dict[str, Any]:
    """Return the hyper-parameters of a method as JSON data; `make_method` takes them back."""
    described: Any = method
    return {field.name: getattr(method, field.name) for field in fields(described)}
