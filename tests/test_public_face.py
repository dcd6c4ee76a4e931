"""The public face: what it names exists, is documented with examples that run, and costs nothing until it is used."""

from __future__ import annotations

import ast
import doctest
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import rcss_hat

PACKAGES = [Path(rcss_hat.__file__).parent, Path(rcss_hat.__file__).parents[1] / "fake_server"]
NAMES = [name for name in rcss_hat.__all__ if name != "__version__"]


def _modules_with_examples() -> list[str]:
    files = (file for package in PACKAGES for file in package.rglob("*.py") if ">>> " in file.read_text())
    dotted = (".".join(file.relative_to(file.parents[_depth(file)]).with_suffix("").parts) for file in files)
    return sorted(name.removesuffix(".__init__") for name in dotted)


def _depth(file: Path) -> int:
    return next(k for k, folder in enumerate(file.parents) if folder in PACKAGES) + 1


@pytest.mark.compiled
@pytest.mark.parametrize("module", _modules_with_examples())
def test_the_examples_in_docstrings_run(module: str) -> None:
    """As ``python -m doctest`` would; nothing of a module is left out."""
    found = doctest.testmod(importlib.import_module(module), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert found.attempted > 0
    assert found.failed == 0


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_there_and_has_an_example(name: str) -> None:
    thing = getattr(rcss_hat, name)
    documented = thing if callable(thing) else rcss_hat.TransferMethod  # a table of methods is shown where they are
    assert documented.__doc__, name
    assert ">>>" in documented.__doc__, f"{name} needs a runnable example"


def test_type_checkers_are_told_the_same() -> None:
    stub = ast.parse((PACKAGES[0] / "__init__.pyi").read_text())
    told = {alias.asname: node.module for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert told == rcss_hat._HOME
    assert set(told) == set(NAMES)
    assert (PACKAGES[0] / "py.typed").exists()


def test_what_is_not_there_is_said_as_usual() -> None:
    with pytest.raises(AttributeError, match="module 'rcss_hat' has no attribute 'Tusk'"):
        _ = rcss_hat.Tusk
    assert set(NAMES) <= set(dir(rcss_hat))


def test_importing_the_package_imports_nothing_of_it() -> None:
    code = "import sys, rcss_hat; print([m for m in sys.modules if m.startswith(('rcss_hat.', 'numba', 'numpy'))])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
