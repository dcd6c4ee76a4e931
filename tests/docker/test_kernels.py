"""The players' image holds compiled kernels for whoever runs it: all of them are read where nothing can be written."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from rcss_hat.arena.match import prepare
from rcss_hat.numeric import jit
from rcss_hat.numeric.cache_folders import cache_root

pytestmark = pytest.mark.compiled

# Whoever runs the tests may write into the folder of kernels; a user of the image may not, nor anywhere else.
PLAY = """
from contextlib import suppress
from numba.core import event
from rcss_hat.numeric import cache_folders as folders

folders._takes_files = lambda folder: False
with event.install_recorder("numba:compile") as compiled, suppress(SystemExit):
    from rcss_hat.cli.main import cli
    cli("play --on arena --keepers hand --episodes 1 --seed 1".split())
print(folders.cache_root(), folders.shared_roots()[0], len(compiled.buffer))
"""


def test_the_arena_plays_on_kernels_that_can_only_be_read() -> None:
    root = cache_root()
    if jit.config.DISABLE_JIT or jit.config.CACHE_DIR or root is None:  # type: ignore[attr-defined]
        pytest.skip("nothing is compiled, or not where the image has it")
    prepare()
    found = subprocess.run(
        [sys.executable, "-c", PLAY],
        env={**os.environ, "RCSS_HAT_CACHE": str(root)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "1 episodes" in found.stdout
    assert found.stdout.splitlines()[-1] == f"None {root} 0"
    assert "Compiling" not in found.stderr
