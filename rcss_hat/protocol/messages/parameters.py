"""Parameters, by name: of the server, of the limits of player types, of each type."""

from __future__ import annotations

from collections.abc import Mapping

from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.messages.event import Event, reads, record
from rcss_hat.protocol.messages.groups import Group, Quoted
from rcss_hat.protocol.params import BY_NAME, ServerParams, Value

__all__ = ["PlayerParam", "PlayerType", "ServerParam"]

NAMELESS_IN_7 = (b"server_param", b"player_param", b"player_type")
"""Messages that version 7 gets without names; they are not read."""


@record
class ServerParam(Event):
    """The parameters of the server, by name; booleans come as 0 and 1."""

    values: Mapping[str, Value]

    def to_text(self) -> str:
        """Return ``(server_param (NAME VALUE)...)``."""
        return _text("server_param", self.values)

    def to_params(self, profile: str = "19.0") -> ServerParams:
        """Return them as server parameters; what the message lacks has the profile's default.

        Raises
        ------
        RemoteProtocolError
            When a value is of the wrong kind.
        """
        params = ServerParams(profile)
        for name, value in self.values.items():
            if name in BY_NAME:
                try:
                    params.set(name, value)
                except TypeError as error:
                    raise RemoteProtocolError(f"bad server_param message: {error}") from None
        return params


@record
class PlayerParam(Event):
    """The limits of heterogeneous players, by name."""

    values: Mapping[str, Value]

    def to_text(self) -> str:
        """Return ``(player_param (NAME VALUE)...)``."""
        return _text("player_param", self.values)


@record
class PlayerType(Event):
    """One type of player: its number and its parameters by name (``id`` among them)."""

    id: int
    values: Mapping[str, Value]

    def to_text(self) -> str:
        """Return ``(player_type (NAME VALUE)...)``."""
        return _text("player_type", self.values)


@reads("server_param")
def _server_param(group: Group) -> Event:
    return ServerParam(values=_values(group))


@reads("player_param")
def _player_param(group: Group) -> Event:
    return PlayerParam(values=_values(group))


@reads("player_type")
def _player_type(group: Group) -> Event:
    values = _values(group)
    identity = values.get("id")
    if not isinstance(identity, int) or identity < 0:
        group.fail("expected (id N) among the values")
    return PlayerType(id=identity, values=values)


def _values(group: Group) -> dict[str, Value]:
    values: dict[str, Value] = {}
    while group.more:
        pair = group.group()
        name = pair.word()
        values[name] = _value(pair)
        pair.finish()
    return values


def _value(pair: Group) -> Value:
    item = pair.peek()
    if isinstance(item, Quoted):
        return pair.text()
    value = pair.number()
    return int(value) if isinstance(item, str) and item.lstrip("-").isdigit() else value


# --- writing ----------------------------------------------------------------------------------------------------------
def wire_text(text: str) -> str:
    """Return a text of the command line as messages hold it: every byte of its UTF-8 form one character."""
    return text.encode("utf-8", "surrogateescape").decode("latin-1")


def _spell(value: Value) -> str:
    if isinstance(value, str):
        return f'"{wire_text(value)}"'
    return f"{value:g}" if isinstance(value, float) else f"{int(value)}"


def _text(name: str, values: Mapping[str, Value]) -> str:
    return f"({name} {''.join(f'({key} {_spell(value)})' for key, value in values.items())})"
