"""One client's socket: datagrams ending in NUL, compressed when the client asked for it.

As rcssserver does, every client gets a socket of its own, connected to the client's address; an ICMP "port unreachable"
for it means that the client has gone.
"""

from __future__ import annotations

import socket
import zlib

from rcss_hat.protocol.commands import MAX_DATAGRAM
from rcss_hat.protocol.digits import Buffer

Address = tuple[str, int]


class Connection:
    """A client's dedicated socket.

    Parameters
    ----------
    bind : str
        Local address; the port is any free one.
    address : tuple of str and int
        The client.

    Attributes
    ----------
    address : tuple of str and int
    socket : socket.socket
        Does not block.
    connected : bool
        False once the client has gone: nothing is sent or received any more, and the socket waits to be disposed of.
    """

    def __init__(self, bind: str, address: Address) -> None:
        self.address = address
        self.connected = True
        self._level = -1
        self._held: list[bytes] | None = None
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setblocking(False)
        self.socket.bind((bind, 0))
        self.socket.connect(address)

    def compress(self, level: int) -> None:
        """Compress from now on, both ways, with a zlib level of 0 to 9; not any more when negative."""
        self._level = level

    def send(self, message: str) -> None:
        """Send a text message."""
        self.send_bytes(message.encode("latin-1") + b"\0")

    def send_buffer(self, buffer: Buffer, size: int) -> None:
        """Send the first ``size`` bytes of a buffer, which has room for one more."""
        buffer[size] = 0
        self.send_bytes(buffer[: size + 1].data)

    def hold(self) -> None:
        """Keep what is sent until `release`; a burst wakes the client once, not with every datagram."""
        if self._held is None:
            self._held = []

    def release(self) -> None:
        """Send what was kept, and everything else at once again."""
        held, self._held = self._held, None
        if held and self.connected and self._level < 0:
            send = self.socket.send
            try:
                for data in held:
                    send(data)
            except OSError:
                self.close()
            return
        for data in held or ():
            self.send_bytes(data)

    def send_bytes(self, data: bytes | memoryview) -> None:
        """Send a datagram as it is."""
        if not self.connected:
            return
        if self._held is not None:
            self._held.append(bytes(data))
            return
        if self._level >= 0:
            stream = zlib.compressobj(self._level)
            data = stream.compress(data) + stream.flush(zlib.Z_SYNC_FLUSH)
        try:
            self.socket.send(data)
        except OSError:
            self.close()

    def receive(self) -> list[bytes]:
        """Return all datagrams that have arrived, decompressed; those that cannot be are left out.

        All before any is answered: what a client sends because of an answer belongs to the next look.
        """
        messages: list[bytes] = []
        receive = self.socket.recv
        while self.connected:
            try:
                data = receive(MAX_DATAGRAM)
            except BlockingIOError:
                break
            except OSError:
                self.close()
                break
            if self._level >= 0:
                data = _decompressed(data)
            if data:
                messages.append(data)
        return messages

    def close(self) -> None:
        """Have nothing more to do with the client."""
        self.connected = False

    def dispose(self) -> None:
        """Close the socket too."""
        self.connected = False
        self.socket.close()


class Nobody(Connection):
    """The connection of who has none: what is sent is lost."""

    def __init__(self) -> None:
        self.address, self.connected = ("", 0), False


def _decompressed(data: bytes) -> bytes:
    """Return the content of a compressed datagram, as far as it fits into one; empty when it is none."""
    try:
        return zlib.decompressobj().decompress(data, MAX_DATAGRAM)
    except zlib.error:
        return b""
