"""Every snippet of docs/how-to/learners.md does what the page says."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli

pytestmark = [pytest.mark.compiled, pytest.mark.slow]
PAGE = (Path(__file__).parents[2] / "docs" / "how-to" / "learners.md").read_text()
NEEDS = {"stable_baselines3": "stable_baselines3", "model.zip": "stable_baselines3", "minari": "minari"}


def test_the_snippets_run_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python first: it makes the models that the commands play."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    (tmp_path / "mine.py").write_text("def policy(state, info):\n    return int(state[3] < 4.0)\n")
    snippets = re.findall(r"```(python|bash)\n(.*?)```", PAGE, re.DOTALL)
    lines = [line for kind, text in snippets if kind == "bash" for line in text.splitlines()]
    assert len(snippets) >= 6 and len(lines) >= 5
    missing = {word for word, module in NEEDS.items() if not _is_there(module)}
    for kind, text in snippets:
        if kind == "python" and not any(word in text for word in missing):
            exec(compile(text, "docs/how-to/learners.md", "exec"), {})
    for line in lines:
        if not any(word in line for word in missing):
            done = CliRunner().invoke(cli, line.split()[1:])
            assert done.exit_code == 0, f"{line}: {done.output}"


def _is_there(module: str) -> bool:
    try:
        __import__(module)
    except ImportError:
        return False
    return True
