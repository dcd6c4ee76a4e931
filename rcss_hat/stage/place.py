"""Where a match is played, as people name it: the arena, a server of our own, or one that runs somewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rcss_hat.schema import did_you_mean

if TYPE_CHECKING:
    from pathlib import Path

    from rcss_hat.keepaway.task import Task
    from rcss_hat.protocol.params import Value
    from rcss_hat.stage.servers import ServerProcess

ARENA, FAKE, REAL = "arena", "fake", "real"
PLACES = (ARENA, FAKE, REAL)
Address = tuple[str, int]
"""Host and port."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a match is played; `parse` makes it from text, and ``str`` gives the text back.

    Attributes
    ----------
    name : str
        ``arena``, ``fake``, ``real`` or ``HOST:PORT``.
    address : (str, int) or None
        Of a server that somebody else runs.
    executable : str or None
        The rcssserver of ``real``; None: the one on the PATH.

    Examples
    --------
    >>> from rcss_hat import Place
    >>> Place.parse("localhost:6000").address
    ('localhost', 6000)
    """

    name: str
    address: Address | None = None
    executable: str | None = None

    @classmethod
    def parse(cls, text: str, executable: str | None = None) -> Place:
        """Read a place.

        Raises
        ------
        ValueError
            Saying what there is.
        """
        return cls(text, None, executable) if text in PLACES else cls.at(parse_address(text, PLACES))

    @classmethod
    def at(cls, address: Address) -> Place:
        """Return the place of a server that somebody else runs."""
        return cls(f"{address[0]}:{address[1]}", address)

    def __str__(self) -> str:
        return self.name

    @property
    def title(self) -> str:
        """What people are told who plays the server."""
        return {REAL: "rcssserver", FAKE: "fake server"}.get(self.name, self.name)

    def pace(self, speed: float) -> dict[str, Value]:
        """Return the parameters of the server that is started here for people, who play and watch in real time.

        Parameters
        ----------
        speed : float
            Times real time.

        Raises
        ------
        ValueError
            When servers do not have this speed, or the one here is somebody else's.
        """
        from rcss_hat.stage.options import option, pace_options

        if self.name == ARENA:
            return {}
        pace = {"synch_mode": False, **pace_options(speed)}
        if self.address is None:
            return pace
        if len(pace) == 1:
            return {}
        needed = " ".join(option(name, value) for name, value in pace.items())
        raise ValueError(
            f"the server at {self.name} runs already, at its own speed; leave out --speed, and start it with {needed} "
            f"('rcss-hat server --real-time --speed {speed:g}' does)"
        )

    def server(self, task: Task, seed: int | None, logs: Path | None = None, **changes: Value) -> ServerProcess:
        """Return the server that is started for a match here, not started yet.

        Parameters
        ----------
        task : Task
        seed : int or None
            Of the fake server.
        logs : Path, optional
            Folder for what it writes; by default a temporary one.
        **changes : Value
            Further server parameters.

        Raises
        ------
        ServerFailed
            Where no rcssserver is found.
        """
        from rcss_hat.stage.servers import ServerFailed, ServerProcess, find_executable

        found = find_executable(self.executable) if self.name == REAL else None
        if self.name == REAL and found is None:
            raise ServerFailed(
                f"no executable {self.executable or 'rcssserver'!r} was found; give --executable PATH, or --on fake"
            )
        return ServerProcess(task, seed, found, logs, **changes)


def parse_address(text: str, words: tuple[str, ...] = ()) -> Address:
    """Read ``HOST:PORT``.

    Raises
    ------
    ValueError
        Saying what is expected: one of ``words``, too.
    """
    host, colon, port = text.rpartition(":")
    if colon and host and port.isascii() and port.isdigit() and 0 < int(port) < 65536:
        return host, int(port)
    listed = f"none of {', '.join(words)}, and not" if words else "not"
    near = did_you_mean(text, words)
    raise ValueError(f"{text!r} is {listed} HOST:PORT, for example localhost:6000{near}")
