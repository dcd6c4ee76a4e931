"""Playing a recorded transcript to real clients, as if the server that it was recorded from were there again.

A transcript has one JSON object per line: ``client`` (a name), ``dir`` (``recv``: server to client, ``send``: client to
server) and ``text``, or ``base64`` for binary frames; ``.gz`` files are unpacked. Every real client takes the part of a
recorded one with the same first datagram and gets that client's messages in order. In a recording of synch mode, what
followed the n-th ``(done)`` is sent when the real client has said ``(done)`` n times; in other recordings, what
followed the n-th datagram is sent after the real client's n-th.
"""

from __future__ import annotations

import base64
import binascii
import logging
import selectors
import socket
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from fake_server.connection import Address, Connection
from rcss_hat.inputs import FileFormatError, LineReader, excerpt, item, load_json
from rcss_hat.protocol.commands import MAX_DATAGRAM

REFUSAL = "(error no_more_player_or_goalie_or_illegal_client_version)"
"""Reply to clients for whom the recording has no part left."""
_DONE = b"(done)"
_LOG = logging.getLogger(__name__)


class TranscriptError(Exception):
    """A transcript cannot be read; the message names file, line and reason."""


@dataclass
class Part:
    """What one recorded client got and sent.

    Attributes
    ----------
    name : str
    first : bytes
        Its first datagram, without NUL.
    turns : list of list of bytes
        Entry 0: what it got after its first datagram; entry n: after its n-th answer.
    by_done : bool
        Whether answers are ``(done)`` commands; otherwise every datagram is one.
    """

    name: str
    first: bytes = b""
    turns: list[list[bytes]] = field(default_factory=lambda: [[]])
    by_done: bool = False


def read_transcript(path: Path) -> list[Part]:
    """Read a transcript.

    Parameters
    ----------
    path : Path
        A ``.jsonl`` or ``.jsonl.gz`` file.

    Returns
    -------
    list of Part
        In the order in which the clients first sent something.

    Raises
    ------
    TranscriptError
        When it cannot be read or holds no client. One that is cut off is read up to there, and that is said.
    """
    entries: dict[str, list[tuple[bool, bytes]]] = {}
    reader = LineReader(path, "transcript")
    try:
        for number, line in enumerate(reader, 1):
            try:
                client, sent, data = _entry(line, f"{path}:{number}")
            except TranscriptError:
                if not reader.unended or not entries:
                    raise
                reader.cut = reader.cut or "its last line is cut off"
                break
            entries.setdefault(client, []).append((sent, data))
    except FileFormatError as error:
        raise TranscriptError(f"cannot read {error}") from None
    parts = [_part(name, events) for name, events in entries.items() if any(sent for sent, _ in events)]
    if not parts:
        raise TranscriptError(
            f"{path}: no client sends anything" + (f"; cannot read on: {reader.cut}" * bool(reader.cut))
        )
    if reader.cut:
        _LOG.warning("%s: %s; it is replayed up to there", path, reader.cut)
    return parts


def _entry(line: bytes, where: str) -> tuple[str, bool, bytes]:
    try:
        record = load_json(line.decode("utf-8"))
        client, direction = item(record, "client", str), item(record, "dir", str)
        if direction not in ("send", "recv"):
            raise TranscriptError(f"{where}: dir is send or recv, not {excerpt(direction)}")
        if "base64" in record:
            return client, direction == "send", base64.b64decode(item(record, "base64", str))
        end = b"" if direction == "send" else b"\0"
        return client, direction == "send", item(record, "text", str).encode("latin-1", "replace") + end
    except (FileFormatError, UnicodeDecodeError, binascii.Error, ValueError) as error:
        raise TranscriptError(f"cannot read {where}: not a line of a transcript ({error})") from None


def _part(name: str, events: list[tuple[bool, bytes]]) -> Part:
    part = Part(name, by_done=any(sent and _DONE in data for sent, data in events))
    for sent, data in events:
        if not sent:
            if part.first:
                part.turns[-1].append(data)
        elif not part.first:
            part.first = data
        elif not part.by_done or _DONE in data:
            part.turns.append([])
    return part


class _Actor:
    """A real client that plays a recorded part."""

    def __init__(self, part: Part, connection: Connection) -> None:
        self.part = part
        self.connection = connection
        self._turn = 0
        self._send_turn()

    @property
    def finished(self) -> bool:
        """Whether the client has got everything, or has gone."""
        return self._turn >= len(self.part.turns) or not self.connection.connected

    def read(self) -> None:
        """Take what has arrived, and send what follows it."""
        for data in self.connection.receive():
            for _ in range(data.count(_DONE) if self.part.by_done else 1):
                self._send_turn()

    def _send_turn(self) -> None:
        if self.finished:
            return
        for data in self.part.turns[self._turn]:
            self.connection.send_bytes(data)
        self._turn += 1


class Replay:
    """A server that plays a transcript.

    Parameters
    ----------
    parts : list of Part
        As from `read_transcript`.
    port : int
        0 is any free one; trainers connect to the next port.
    bind : str
        Address to listen on.

    Attributes
    ----------
    port, coach_port : int
    """

    def __init__(self, parts: Iterable[Part], port: int = 6000, bind: str = "127.0.0.1") -> None:
        self._left = list(parts)
        self._bind = bind
        self._actors: dict[Address, _Actor] = {}
        self._selector = selectors.DefaultSelector()
        self._stopped = False
        sockets = [self._listen(port), self._listen(port + 1 if port else 0)]
        self.port, self.coach_port = (s.getsockname()[1] for s in sockets)

    def _listen(self, port: int) -> socket.socket:
        listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            listener.bind((self._bind, port))
        except (OSError, OverflowError) as error:
            listener.close()
            self.close()
            raise OSError(f"cannot listen on {self._bind} port {port}: {error}") from None
        listener.setblocking(False)
        self._selector.register(listener, selectors.EVENT_READ)
        return listener

    def run(self, wait: float = 0.2) -> None:
        """Serve until every client that came has got its part, or until `stop`.

        Parameters
        ----------
        wait : float
            Seconds after which `stop` is noticed.
        """
        while not self._stopped and not (self._actors and all(actor.finished for actor in self._actors.values())):
            for key, _ in self._selector.select(wait):
                actor = key.data
                if actor is None:
                    self._welcome(key.fileobj)
                    continue
                actor.read()
                if not actor.connection.connected:
                    self._selector.unregister(key.fileobj)
                    actor.connection.dispose()

    def stop(self) -> None:
        """End `run` soon; may be called from another thread."""
        self._stopped = True

    def close(self) -> None:
        """Close all sockets."""
        for key in list(self._selector.get_map().values()):
            if isinstance(key.fileobj, socket.socket):
                key.fileobj.close()
        self._selector.close()

    def _welcome(self, listener: object) -> None:
        """Give a new client the first part that begins like it, else the first part of its kind."""
        if not isinstance(listener, socket.socket):
            return
        try:
            data, address = listener.recvfrom(MAX_DATAGRAM)
        except BlockingIOError:
            return
        if address in self._actors:
            return
        text = data.rstrip(b"\0\n")
        same = [part for part in self._left if part.first.rstrip(b"\0\n") == text]
        alike = [part for part in self._left if _kind(part.first) == _kind(text)]
        part = next(iter(same or alike), None)
        if part is None:
            listener.sendto(REFUSAL.encode("ascii") + b"\0", address)
            return
        self._left.remove(part)
        actor = _Actor(part, Connection(self._bind, address))
        self._actors[address] = actor
        if actor.connection.connected:
            self._selector.register(actor.connection.socket, selectors.EVENT_READ, actor)


def _kind(first: bytes) -> bytes:
    """What a client is: a monitor, a trainer, or a player of a team."""
    words = first.replace(b"(", b" ( ").replace(b")", b" ) ").split()
    if words[1:2] == [b"dispinit"]:
        return b"monitor"
    if words[1:3] == [b"init", b"("]:
        return b"trainer"
    return b"player " + b"".join(words[2:3])
