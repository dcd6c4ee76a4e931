"""What rcssserver's Keepaway log (``.kwy``) looks like; `rcss_hat.keepaway.report.read_kwy` reads it."""

from __future__ import annotations


def log_head(keepers: int, takers: int, length: float, width: float) -> str:
    """Write what stands above the episodes."""
    return (
        f"# Keepers: {keepers}\n# Takers:  {takers}\n# Region:  {length:g} x {width:g}\n#\n# Description of Fields:\n"
        "# 1) Episode number\n# 2) Start time in simulator steps (100ms)\n# 3) End time in simulator steps (100ms)\n"
        "# 4) Duration in simulator steps (100ms)\n# 5) (o)ut of bounds / (t)aken away\n#\n"
    )


def log_line(number: int, start: int, end: int, reason: str) -> str:
    """Write an episode; ``reason`` is ``o`` or ``t``."""
    return f"{number}\t{start}\t{end}\t{end - start}\t{reason}\n"
