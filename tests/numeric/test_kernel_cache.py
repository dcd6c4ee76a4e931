"""Kernels that somebody else compiled, in a folder that can only be read."""

from __future__ import annotations

import importlib.util
import itertools
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from numba import types
from numba.core.registry import cpu_target

from rcss_hat.numeric import cache_folders as cf
from rcss_hat.numeric import jit, sources
from rcss_hat.numeric.targets import Target, generic_environment, own_target

pytestmark = pytest.mark.compiled
SOURCE = "def twice(x):\n    return x + x\n"
_names = itertools.count()


class Machine:
    """Folders of which some can be written to, and the kernel of a module that is read anew each time."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self.shared, self.home, self._patch = folder / "shared", folder / "home" / "rcss-hat", patch
        self.module = f"tiny_{os.getpid()}_{next(_names)}"
        self.file = folder / f"{self.module}.py"
        self.file.write_text(SOURCE)
        patch.setenv("RCSS_HAT_CACHE", str(self.shared))
        patch.setenv("XDG_CACHE_HOME", str(self.home.parent))
        patch.setattr(cf, "SHIPPED", folder / "shipped")

    def writable(self, *roots: Path) -> None:
        """Let only these take files, whoever runs the tests (root may write everywhere)."""
        self._patch.setattr(cf, "_takes_files", lambda folder: folder in roots)
        for root in roots:
            root.mkdir(parents=True, exist_ok=True)
        self.forget()

    @staticmethod
    def forget() -> None:
        """Ask again for everything that a process asks for once."""
        for found in (cf.cache_root, cf.shared_roots, cf.fingerprint, cf.source_digest, sources._source):
            found.cache_clear()

    def function(self) -> Any:
        spec = importlib.util.spec_from_file_location(self.module, self.file)
        assert spec is not None and spec.loader is not None
        module = sys.modules[self.module] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.twice

    def kernel(self) -> Any:
        return jit.njit(self.function())


def files(folder: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Machine]:
    if jit.config.DISABLE_JIT:  # type: ignore[attr-defined]
        pytest.skip("nothing is compiled")
    found = Machine(tmp_path, monkeypatch)
    yield found
    sys.modules.pop(found.module, None)
    monkeypatch.undo()
    for function in (cf.cache_root, cf.shared_roots):
        function.cache_clear()


def compiled_by_somebody(machine: Machine) -> dict[Path, int]:
    machine.writable(machine.shared)
    assert machine.kernel()(2) == 4
    made = files(machine.shared)
    assert made
    return made


def test_what_somebody_compiled_is_used_and_not_touched(machine: Machine) -> None:
    made = compiled_by_somebody(machine)
    machine.writable(machine.home)
    kernel = machine.kernel()
    assert cf.is_cached(machine.module)
    assert kernel(2) == 4
    assert kernel.stats.cache_hits and not kernel.stats.cache_misses
    assert files(machine.shared) == made and not files(machine.home)


def test_a_miss_is_compiled_into_the_users_own_cache(machine: Machine) -> None:
    made = compiled_by_somebody(machine)
    machine.writable(machine.home)
    kernel = machine.kernel()
    assert kernel(2.5) == 5.0
    assert kernel.stats.cache_misses and files(machine.home)
    again = machine.kernel()
    assert again(2.5) == 5.0 and again(2) == 4
    assert len(again.stats.cache_hits) == 2 and not again.stats.cache_misses
    assert files(machine.shared) == made


def test_without_a_folder_of_ones_own_a_miss_lives_in_memory(machine: Machine) -> None:
    made = compiled_by_somebody(machine)
    machine.writable()
    assert cf.cache_root() is None
    kernel = machine.kernel()
    assert kernel(2) == 4 and kernel.stats.cache_hits
    assert kernel(2.5) == 5.0
    assert files(machine.shared) == made


def test_other_sources_are_not_taken_from_it(machine: Machine) -> None:
    compiled_by_somebody(machine)
    machine.file.write_text(SOURCE.replace("x + x", "x * 3"))
    machine.writable(machine.home)
    assert machine.kernel()(2) == 6


def test_what_was_compiled_for_another_processor_is_none(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba itself looks at the processor; what we say of the cache has to agree."""
    made = compiled_by_somebody(machine)
    assert own_target() == cpu_target.target_context.codegen().magic_tuple()
    another = Target("x86_64-unknown-linux-gnu", "another", "+sse2")
    monkeypatch.setattr(cf, "own_target", lambda: another)
    monkeypatch.setattr(cf, "readable_targets", lambda: (another,))
    machine.writable(machine.home)
    kernel = machine.kernel()
    assert not cf.is_cached(machine.module)
    assert kernel(2) == 4
    assert kernel.stats.cache_misses and not kernel.stats.cache_hits
    assert cf.is_cached(machine.module)
    assert files(machine.shared) == made


def test_several_modules_are_compiled_when_all_are(machine: Machine) -> None:
    compiled_by_somebody(machine)
    assert cf.is_cached(machine.module)
    assert not cf.is_cached(machine.module, "rcss_hat.numeric.wire")


def test_a_kernel_with_a_fixed_signature_is_read_too(machine: Machine) -> None:
    signature = types.float64(types.float64)
    machine.writable(machine.shared)
    jit.pointed(machine.function(), signature)
    machine.writable()
    kernel = jit.pointed(machine.function(), signature)
    assert kernel.stats.cache_hits and kernel(2.5) == 5.0
    assert len(kernel.signatures) == 1 and not kernel._can_compile


def test_nothing_is_needed_of_the_shared_folder(machine: Machine) -> None:
    machine.writable(machine.home)
    assert not cf.shared_roots()
    assert machine.kernel()(2) == 4 and files(machine.home)


# --- for any processor ------------------------------------------------------------------------------------------------
def test_what_was_compiled_for_any_processor_of_the_kind_is_used_here(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in an image: nobody knows which processor will run it."""
    here = own_target()
    generic = Target(here.system, generic_environment()["NUMBA_CPU_NAME"], "")
    monkeypatch.setattr(cf, "own_target", lambda: generic)
    made = compiled_by_somebody(machine)
    monkeypatch.setattr(cf, "own_target", lambda: here)
    monkeypatch.setattr(cf, "readable_targets", lambda: (here, generic))
    machine.writable(machine.home)
    kernel = machine.kernel()
    assert cf.is_cached(machine.module)
    assert kernel(2) == 4 and kernel.stats.cache_hits and not kernel.stats.cache_misses
    monkeypatch.setattr(cf, "readable_targets", lambda: (here,))  # an older processor
    assert not cf.is_cached(machine.module)
    kernel = machine.kernel()
    assert kernel(2) == 4 and kernel.stats.cache_misses
    assert {path: time for path, time in files(machine.shared).items() if path in made} == made


# --- versions that are gone -------------------------------------------------------------------------------------------
def test_kernels_of_versions_that_are_gone_are_removed(machine: Machine) -> None:
    machine.writable(machine.home)
    folder = machine.home / machine.module
    for version in range(6):
        machine.file.write_text(SOURCE.replace("x + x", f"x * {version}"))
        machine.forget()
        cf.clear_gone.cache_clear()
        cf.used.cache_clear()
        assert machine.kernel()(2) == 2 * version
        for path in folder.iterdir():
            os.utime(path, (path.stat().st_mtime - 60.0,) * 2)
    assert len(list(folder.iterdir())) == cf.KEPT


def test_kernels_that_were_used_lately_stay(machine: Machine, tmp_path: Path) -> None:
    machine.writable(machine.home)
    assert machine.kernel()(2) == 4
    folder = next((machine.home / machine.module).iterdir())
    os.utime(folder, (1e9, 1e9))
    cf.used.cache_clear()
    assert machine.kernel()(2) == 4  # read from it, which counts as use
    cf.clear_gone.cache_clear()
    cf.clear_gone(machine.home)
    assert folder.is_dir()
    os.utime(folder, (1e9, 1e9))
    cf.clear_gone.cache_clear()
    cf.clear_gone(machine.home)
    assert not folder.exists()


def test_only_kernels_are_removed(tmp_path: Path) -> None:
    """Somebody may name any folder as the cache."""
    theirs = [tmp_path / "photos" / "2019" / "sea.jpg", tmp_path / "rcss_hat.x-0123456789abcdef" / "letter.txt",
              tmp_path / "diary" / "0123456789abcdef" / "today.txt"]  # fmt: skip
    ours = [tmp_path / "rcss_hat.x" / "0123456789abcdef" / "parts" / "x.f-1.py311.nbi",
            tmp_path / "rcss_hat.x-0123456789abcdef" / "x.f-1.py311.1.nbc"]  # fmt: skip
    for path in (*theirs, *ours):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        for folder in [path, *path.parents][: len(path.relative_to(tmp_path).parts)]:
            os.utime(folder, (1e9, 1e9))
    cf.clear_gone.cache_clear()
    cf.clear_gone(tmp_path)
    assert all(path.exists() for path in theirs) and not any(path.exists() for path in ours)


def test_a_module_that_was_never_compiled_is_not_cached(machine: Machine) -> None:
    machine.writable(machine.home)
    assert not cf.is_cached("rcss_hat.numeric.wire")
    folder = cf.own_folder("rcss_hat.numeric.wire")
    assert folder is not None
    folder.path.mkdir(parents=True)
    assert not cf.is_cached("rcss_hat.numeric.wire")
    (folder.path / "x.nbi").touch()
    assert cf.is_cached("rcss_hat.numeric.wire")
