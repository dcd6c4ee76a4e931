"""Versions and names that stand in several files of the project are the same."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import yaml

import rcss_hat

ROOT = Path(__file__).parents[1]


def test_the_version_is_in_one_place() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert project["project"]["dynamic"] == ["version"]
    assert project["tool"]["hatch"]["version"]["path"] == "rcss_hat/__init__.py"
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == rcss_hat.__version__  # the file's form wants it written down
    assert rcss_hat.__version__ in (ROOT / "CHANGELOG.md").read_text()


def test_the_hook_formats_as_the_tests_do() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())
    ruff = next(repo["rev"] for repo in hooks["repos"] if "ruff" in repo["repo"])
    assert re.search(rf"^ruff=={ruff.removeprefix('v')}$", (ROOT / "constraints.txt").read_text(), re.MULTILINE)


def test_issue_templates_are_forms() -> None:
    for template in (ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"):
        form = yaml.safe_load(template.read_text())
        if template.name != "config.yml":
            assert {"name", "description", "body"} <= form.keys(), template.name
            assert all(field["type"] in ("textarea", "input", "markdown") for field in form["body"])


def test_everything_that_the_extra_all_promises_is_an_extra() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for name, wants in extras.items():
        for inner in re.findall(r"rcss-hat\[([\w,]+)\]", " ".join(wants)):
            assert set(inner.split(",")) <= extras.keys(), name
