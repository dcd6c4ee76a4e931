"""What machine code is made for: this processor, or any of its kind that is not too old."""

from __future__ import annotations

import platform
from functools import cache
from typing import Any, NamedTuple

from llvmlite import binding as llvm
from numba.core.registry import cpu_target

_X86_64_V3 = (
    "avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sahf", "sse3", "sse4.1",
    "sse4.2", "ssse3", "xsave",
)  # fmt: skip
"""Features of the level that Intel's processors have had since 2013 and AMD's since 2015, in LLVM's words."""
_GENERIC = {"x86_64": ("x86-64-v3", _X86_64_V3), "AMD64": ("x86-64-v3", _X86_64_V3), "aarch64": ("generic", ()),
            "arm64": ("generic", ())}  # fmt: skip


class Target(NamedTuple):
    """What numba compiles for.

    Attributes
    ----------
    system : str
        LLVM's triple.
    processor : str
    features : str
        Beyond those that the processor's name stands for.
    """

    system: str
    processor: str
    features: str


@cache
def own_target() -> Target:
    """Return what numba compiles for in this process: this processor, unless ``NUMBA_CPU_NAME`` says otherwise."""
    return Target(*cpu_target.target_context.codegen().magic_tuple())


@cache
def readable_targets() -> tuple[Target, ...]:
    """Return what kernels may have been compiled for that run here, the best first."""
    processor, needed = _GENERIC.get(platform.machine(), ("", ()))
    features: Any = llvm.get_host_cpu_features()
    generic = Target(own_target().system, processor, "")
    fits = processor and all(features.get(name, False) for name in needed)
    return tuple(dict.fromkeys([own_target(), generic] if fits else [own_target()]))


def generic_environment() -> dict[str, str]:
    """Return the variables by which numba compiles for every processor of this kind that is not too old.

    Raises
    ------
    ValueError
        When there is no such choice for this kind.
    """
    if platform.machine() not in _GENERIC:
        raise ValueError(f"no processor stands for all of the kind {platform.machine()!r}; x86_64 and aarch64 have one")
    return {"NUMBA_CPU_NAME": _GENERIC[platform.machine()][0], "NUMBA_CPU_FEATURES": ""}
