"""Where a study is served: its own address, and the one that people open."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import urlsplit


@dataclass(frozen=True)
class Address:
    """Where a study is served.

    Attributes
    ----------
    bind : str
        Interface.
    port : int
        0: any that is free.
    public : str
        Address that people open, with the path that a reverse proxy gives it; empty: the server's own.
    """

    bind: str = "127.0.0.1"
    port: int = 0
    public: str = ""

    def __post_init__(self) -> None:
        """Check the public address.

        Raises
        ------
        ValueError
        """
        parts = urlsplit(self.public)
        if self.public and (
            parts.scheme not in ("http", "https") or not parts.hostname or parts.query or parts.fragment
        ):
            raise ValueError(f"a public address is http(s)://HOST/PATH/, not {self.public!r}")

    @property
    def prefix(self) -> str:
        """Path before all others, without a slash at its end."""
        return urlsplit(self.public).path.rstrip("/")
