"""Which version of the sources a kernel is of: a digest over its module and all that this imports of its project."""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
from collections.abc import Collection
from functools import cache
from pathlib import Path

PACKAGES = ("rcss_hat", "fake_server")
_IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+import\s+(\([^)]*\)|[^\n#]*)|import\s+([\w.]+))", re.MULTILINE)


@cache
def _source(module: str) -> str | None:
    loaded = sys.modules.get(module)
    path = getattr(loaded, "__file__", None)
    if path is None:
        try:
            spec = importlib.util.find_spec(module)
        except (ImportError, ValueError):
            return None
        path = spec.origin if spec else None
    return Path(path).read_text(encoding="utf-8") if path and path.endswith(".py") else None


def _imports(source: str, module: str = "", roots: Collection[str] = PACKAGES) -> set[str]:
    """Modules under the roots that a source imports, with names that may be modules, too."""
    found = set()
    for match in _IMPORT.finditer(source):
        package, names, plain = match.groups()
        package = package or plain
        if package.startswith("."):  # within the module's own package
            above = len(package) - len(package.lstrip("."))
            package = ".".join([*module.split(".")[:-above], *filter(None, package.split("."))])
        if package.split(".")[0] in roots:
            found.add(package)
            found.update(f"{package}.{name}" for name in re.findall(r"\w+", names or ""))
    return found


@cache
def source_digest(module: str) -> str:
    """Hash of the sources of a module and of the modules of this project, or of its own, that it imports.

    Parameters
    ----------
    module : str
        Dotted module name, for example ``"rcss_hat.simulation.motion"``.

    Returns
    -------
    str
        Hexadecimal digest.
    """
    seen: dict[str, str] = {}
    queue, roots = [module], {*PACKAGES, module.split(".")[0]}
    while queue:
        name = queue.pop()
        if name in seen:
            continue
        source = _source(name)
        if source is None:
            continue
        seen[name] = source
        queue.extend(_imports(source, name, roots))
    digest = hashlib.sha256()
    for name in sorted(seen):
        digest.update(name.encode())
        digest.update(seen[name].encode())
    return digest.hexdigest()
