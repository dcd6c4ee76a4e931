"""What can go wrong between a client and a server: the peer's fault, or ours."""

from __future__ import annotations

EXCERPT = 24
"""Bytes of the message quoted on either side of an error."""
LINE = 200
"""Most characters of a message to people that quotes what others sent."""


def one_line(text: str, limit: int = LINE) -> str:
    r"""Make a text that holds what others sent fit for a terminal: one line, printable, not too long.

    Control characters (a terminal's escape sequences, line breaks) and whatever else has no glyph of its own, such as
    marks that turn the direction of writing, become ``\x1b`` or the like. Letters of any script stay.

    Parameters
    ----------
    text : str
    limit : int
        Most characters; what is cut off is replaced by three dots.
    """
    line = text if text.isprintable() else "".join(c if c.isprintable() else _escape(c) for c in text[: limit + 1])
    return line if len(line) <= limit else line[: limit - 3] + "..."


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


class ProtocolError(Exception):
    """Something the protocol does not allow; only its two kinds can be raised."""

    def __init__(self, message: str) -> None:
        if type(self) is ProtocolError:
            raise TypeError("ProtocolError is abstract; raise LocalProtocolError or RemoteProtocolError")
        super().__init__(one_line(message))


class LocalProtocolError(ProtocolError):
    """We were about to send something illegal; nothing was sent."""


class RemoteProtocolError(ProtocolError):
    """The peer sent something malformed.

    Parameters
    ----------
    reason : str
        What was expected.
    data : bytes, optional
        The whole message.
    position : int, optional
        Index of the first byte that does not fit; needs `data`.

    Attributes
    ----------
    reason, data, position
        As given.
    """

    def __init__(self, reason: str, data: bytes | None = None, position: int = 0) -> None:
        self.reason = reason
        self.data = data
        self.position = position
        where = "" if data is None else f" at byte {position} of {len(data)}: {excerpt(data, position)}"
        super().__init__(reason + where)

    def __reduce__(self) -> tuple[type, tuple[str, bytes | None, int]]:
        """Copy and pickle by the three arguments (worker processes report errors this way)."""
        return type(self), (self.reason, self.data, self.position)


def excerpt(data: bytes, position: int) -> str:
    """Quote the bytes around a position, printable, with ``>>>`` in front of the position."""
    start, end = max(0, position - EXCERPT), position + EXCERPT
    before = repr(bytes(data[start:position]))[2:-1]
    after = repr(bytes(data[position:end]))[2:-1]
    return f"{'...' if start else ''}{before}>>>{after}{'...' if end < len(data) else ''}"
