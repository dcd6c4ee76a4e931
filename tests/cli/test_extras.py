"""What only some installations have: said in one line where it is missing, before any work."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli

STUDY = "title = 'Short'\n[[condition]]\nname = 'one'\nhours = 0.01\nlearner = 'cmac'\n"


@pytest.fixture
def lacking(monkeypatch: pytest.MonkeyPatch) -> None:
    """An installation without extras."""
    for name in [n for n in sys.modules if n.startswith(("rcss_hat.viewer", "rcss_hat.experiments", "rcss_hat.cli."))]:
        monkeypatch.delitem(sys.modules, name)
    for package in ("aiohttp", "matplotlib", "jinja2"):
        for name in [n for n in sys.modules if n.split(".")[0] == package]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, package, None)


@pytest.mark.usefixtures("lacking")
@pytest.mark.parametrize(
    ("command", "extra"),
    [
        ("watch --on arena --no-open", "web"),
        ("demonstrate --browser --no-open --out {0}/d.csv", "web"),
        ("experiment {0}/study.toml --out {0}/results", "report,web"),
        ("report {0}", "report,web"),
    ],
)
def test_what_is_missing_is_said_with_what_installs_it(command: str, extra: str, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    result = CliRunner().invoke(cli, command.format(tmp_path).split())
    assert result.exit_code == 1 and f"pip install 'rcss-hat[{extra}]'" in result.stderr
    assert result.stderr.strip().count("\n") == 0 and len(result.stderr) < 200
    assert not (tmp_path / "results").exists() and not (tmp_path / "d.csv").exists()


@pytest.mark.usefixtures("lacking")
@pytest.mark.parametrize(
    "command",
    ["play --help", "train --method no-prior --hours 0.001 --seed 1 --quiet --out {0}/run",
     "experiment {0}/study.toml --trials 1 --no-report --jobs 1 --quiet --out {0}/results"],
)  # fmt: skip
def test_the_main_job_needs_none(command: str, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    result = CliRunner().invoke(cli, command.format(tmp_path).split())
    assert result.exit_code == 0, result.stderr
