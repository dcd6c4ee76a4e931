"""The documentation holds what it says: snippets run, the tutorial's commands too, links lead somewhere."""

from __future__ import annotations

import re
import runpy
import shlex
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

import rcss_hat
from rcss_hat.cli.main import cli

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
SHORTER = [
    ("--hours 5", "--hours 0.1"), ("hours=5", "hours=0.1"), ("hours=0.5", "hours=0.1"),
    ("--episodes 500", "--episodes 5"), ("--episodes 100", "--episodes 5"), ("--episodes 20", "--episodes 5"),
    ("episodes=100", "episodes=5"), ("episodes=20", "episodes=3"),
    ("hours = 5\ntrials = 3", "hours = 1\ntrials = 1\nevaluation_episodes = 20"),
]  # fmt: skip
"""What pages write, and how little of it is enough to see that it works."""


def blocks(page: Path, kind: str) -> list[str]:
    """Code of a page, indented or not."""
    found = re.findall(rf"^( *)```{kind}\n(.*?)^ *```$", page.read_text(), re.MULTILINE | re.DOTALL)
    return [re.sub(rf"^{indent}", "", text, flags=re.MULTILINE) for indent, text in found]


def smaller(text: str) -> str:
    for long, short in SHORTER:
        text = text.replace(long, short)
    return text


@pytest.mark.compiled
@pytest.mark.parametrize("page", ["README.md", "docs/index.md", "docs/how-to/policy.md", "docs/how-to/method.md"])
def test_the_snippets_of_a_page_run_one_after_the_other(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    snippets = blocks(ROOT / page, "python")
    assert snippets
    module = ModuleType("snippet")  # dataclasses look their module up
    monkeypatch.setitem(sys.modules, "snippet", module)
    for number, snippet in enumerate(snippets, 1):
        exec(compile(smaller(snippet), f"{page}, snippet {number}", "exec"), vars(module))


@pytest.mark.compiled
@pytest.mark.slow
def test_the_tutorial_leads_to_a_learning_curve(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = DOCS / "tutorial.md"
    Path("mine.toml").write_text(smaller(blocks(page, "toml")[0]))
    commands = [line for text in blocks(page, "bash") for line in text.splitlines() if line.startswith("rcss-hat ")]
    played = [smaller(line) for line in commands if "--browser" not in line]
    assert len(played) >= 7
    for line in played:
        done = CliRunner().invoke(cli, shlex.split(line)[1:])
        assert done.exit_code == 0, f"{line}: {done.output}"
    assert Path("results/mine/report/figures/learning-curves.png").is_file()
    assert Path("results/mine/report/report.html").is_file()


def test_the_reference_has_every_public_name_once() -> None:
    shown = re.findall(r"^::: rcss_hat\.(\w+)$", (DOCS / "reference" / "python.md").read_text(), re.MULTILINE)
    assert Counter(shown) == Counter(name for name in rcss_hat.__all__ if name != "__version__")


def test_pages_ask_only_for_what_can_be_made() -> None:
    made = runpy.run_path(str(ROOT / "scripts" / "site_pages.py"))["MADE"]
    asked = {
        mark for page in DOCS.rglob("*.md") for mark in re.findall(r"^<!-- made: ([\w-]+) -->$", page.read_text(), re.M)
    }
    assert asked == set(made)
    for make in made.values():
        assert make().count("\n") > 2


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "examples/README.md"])
def test_links_of_pages_beside_the_site_lead_somewhere(page: str) -> None:
    links = re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", (ROOT / page).read_text())
    missing = [link for link in links if "://" not in link and not ((ROOT / page).parent / link).exists()]
    assert not missing


def test_every_page_is_in_the_navigation() -> None:
    """MkDocs does not complain of pages that nobody finds."""
    listed = (ROOT / "mkdocs.yml").read_text()
    pages = [str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md") if page.name != "report.md"]
    assert [page for page in pages if page not in listed] == []


def test_pictures_are_shown_somewhere() -> None:
    text = "".join(page.read_text() for page in [ROOT / "README.md", *DOCS.rglob("*.md")])
    assert [p.name for p in (DOCS / "images").iterdir() if p.name not in text] == []
