"""Hatch's build hook for a wheel that carries compiled kernels; without it a wheel is pure Python.

    HATCH_BUILD_HOOK_ENABLE_CUSTOM=true pip wheel --no-deps .

It is for this platform and this version of Python, and for every processor of its kind that is not too old. The kernels
stay beside the sources, too (``rcss_hat/kernels``): pip asks for a wheel twice, and they need not be compiled again.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class KernelsHook(BuildHookInterface):
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        path = os.pathsep.join(filter(None, [self.root, os.environ.get("PYTHONPATH")]))
        command = [sys.executable, "-m", "rcss_hat.compile", "--for-all"]
        done = subprocess.run(
            command, check=False, cwd=self.root, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL
        )
        if done.returncode:
            raise RuntimeError("the kernels could not be compiled")
        build_data["force_include"][str(Path(self.root) / "rcss_hat" / "kernels")] = "rcss_hat/kernels"
        build_data["pure_python"], build_data["infer_tag"] = False, True
