"""The files of the pages, the headers that keep everything foreign away, and addresses by which they are reached."""

from __future__ import annotations

from importlib import resources
from urllib.parse import urlsplit

_TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".json": "application/json",
    ".svg": "image/svg+xml",
}
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


def static_files() -> dict[str, tuple[bytes, str]]:
    """Read the pages' files: name to (content, content type).

    ``index.html`` is for those who watch, ``play.html`` for who plays; both ask for the other files, and for
    ``socket``, beside themselves, under whatever address that is. ``play.html`` knows which languages there are.
    """
    folder = resources.files("rcss_hat.viewer") / "static"
    found = {}
    for file in folder.iterdir():
        suffix = "." + file.name.rpartition(".")[2]
        if suffix in _TYPES:
            found[file.name] = file.read_bytes(), _TYPES[suffix]
    content, content_type = found["play.html"]
    found["play.html"] = content.replace(b'"LANGUAGES"', f'"{" ".join(languages())}"'.encode()), content_type
    return found


def languages() -> list[str]:
    """Languages of the texts, by their codes; English first, which stands for all others."""
    folder = resources.files("rcss_hat.viewer") / "static"
    names = [file.name.split(".")[1] for file in folder.iterdir() if file.name.startswith("text.")]
    return sorted(names, key=lambda name: (name != "en", name))


def public_origin(url: str) -> tuple[str, str]:
    """Split a public address into scheme and host, with the port where it names one.

    Raises
    ------
    ValueError
        When it is none.
    """
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname or parts.query or parts.fragment:
        raise ValueError(f"a public address is such as https://study.example.org/keepaway/, not {url!r}")
    return parts.scheme, parts.netloc
