"""What people call by name: ours, and what other packages name by entry points. Listing the names imports nothing."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from importlib.metadata import entry_points
from typing import Any

from rcss_hat.schema import did_you_mean


class RegistryError(ValueError, KeyError):
    """A name that nobody has, or another package's thing that cannot be used."""

    __str__ = ValueError.__str__


class Registry(Mapping[str, Any]):
    """What can be had by name; looking a name up imports the thing.

    Parameters
    ----------
    what : str
        For messages, such as ``"transfer method"``.
    group : str
        Group of the entry points by which other packages add to it.
    ours : mapping
        Name to ``"module:object"``; these names are ours.
    """

    def __init__(self, what: str, group: str, ours: Mapping[str, str]) -> None:
        self.what, self.group, self.ours = what, group, ours

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self.ours, *(entry.name for entry in entry_points(group=self.group))]))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __contains__(self, name: object) -> bool:
        return name in list(iter(self))

    def __getitem__(self, name: str) -> Any:
        if name in self.ours:
            module, _, attribute = self.ours[name].partition(":")
            return getattr(importlib.import_module(module), attribute)
        found = list(entry_points(group=self.group, name=name))
        if not found:
            raise RegistryError(f"no {self.what} {name!r}; there are {', '.join(self)}{did_you_mean(name, self)}")
        if len(found) > 1:
            raise RegistryError(f"the {self.what} {name!r} is in several packages: {', '.join(e.value for e in found)}")
        try:
            return found[0].load()
        except Exception as error:  # whatever a stranger's module does when it is imported
            raise RegistryError(f"the {self.what} {name!r} ({found[0].value}) cannot be imported: {error!r}") from error


_TRANSFER = "rcss_hat.hat.transfer"
METHODS = Registry(
    "transfer method",
    "rcss_hat.methods",
    {
        "no-prior": f"{_TRANSFER}.no_prior:NoPrior",
        "value-bonus": f"{_TRANSFER}.value_bonus:ValueBonus",
        "extra-action": f"{_TRANSFER}.extra_action:ExtraAction",
        "ppr": f"{_TRANSFER}.ppr:PPR",
        "chat": f"{_TRANSFER}.chat:CHAT",
        "replay": f"{_TRANSFER}.replay:Replay",
    },
)
"""Transfer methods: classes derived from `rcss_hat.hat.transfer.TransferMethod`."""
