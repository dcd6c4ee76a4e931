"""Options that say where to play."""

from __future__ import annotations

import functools
from collections.abc import Callable, Set
from dataclasses import replace
from typing import Any, TypeVar, cast

import click

from rcss_hat.protocol.params import Value
from rcss_hat.stage.place import PLACES, Address, Place, parse_address

F = TypeVar("F", bound=Callable[..., Any])


class HostPort(click.ParamType):
    """A running server: ``HOST:PORT``."""

    name = "address"

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Show what can be given."""
        return "HOST:PORT"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Address:
        """Return (host, port)."""
        try:
            return value if isinstance(value, tuple) else parse_address(str(value))
        except ValueError as error:
            self.fail(str(error))


class Where(click.ParamType):
    """Where to play: ``arena``, ``fake``, ``real`` or ``HOST:PORT``."""

    name = "place"

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Show what can be given."""
        return "|".join((*PLACES, "HOST:PORT"))

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Place:
        """Return the place."""
        try:
            return value if isinstance(value, Place) else Place.parse(str(value))
        except ValueError as error:
            self.fail(str(error))


def place_options(default: str | None, told: str = "Where to play.") -> Callable[[F], F]:
    """Add ``--on --executable``; the command receives ``place``, None where there is no default."""

    def decorate(function: F) -> F:
        @click.option("--on", "place", type=Where(), default=default, show_default=True, help=told)
        @click.option("--executable", default=None, help="The rcssserver for --on real.  [default: the one on PATH]")
        @functools.wraps(function)
        def wrapper(*args: Any, place: Place | None, executable: str | None, **kwargs: Any) -> Any:
            return function(*args, place=place and replace(place, executable=executable), **kwargs)

        return cast(F, wrapper)

    return decorate


def server_pace(place: Place, speed: float) -> dict[str, Value]:
    """Return `Place.pace`; speeds that cannot be are wrong usage."""
    try:
        return place.pace(speed)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--speed") from error


def said_by_file(typed: Set[str]) -> frozenset[str]:
    """Return what a server must play when a file says what was played before it is: region, vision, what was typed."""
    return frozenset({"field", "vision", *typed})
