"""Scripted teachers at play: they last as long as the paper's people."""

from __future__ import annotations

import numpy as np
import pytest

from rcss_hat.experiments.demonstrating import demonstrate
from rcss_hat.keepaway.task import Task

SESSIONS = 8


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("teacher", "paper"), [("A", 10.4), ("B", 10.5), ("C", 11.3), ("B-fast", 4.3), ("B-limited", 5.2)]
)
def test_teachers_last_as_long_as_the_papers(teacher: str, paper: float) -> None:
    """Within 15 %, on the physics of the paper's server; `scripts/bench/teachers.py` measures it with more sessions."""
    sessions = [demonstrate(Task(profile="11.1"), teacher, 20, seed) for seed in range(1, SESSIONS + 1)]
    assert np.mean([session.durations for session in sessions]) == pytest.approx(paper, rel=0.15)
