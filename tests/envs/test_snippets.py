"""Every piece of Python in the page on environments runs."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "environments.md").read_text()
SNIPPETS = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("k", range(len(SNIPPETS)))
def test_snippet(k: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    import rcss_hat.envs  # noqa: F401 (registers, as its entry point does where the package is installed)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(compile(SNIPPETS[k], f"docs/reference/environments.md, snippet {k + 1}", "exec"), {"__name__": "snippet"})


def test_the_page_has_its_snippets() -> None:
    assert len(SNIPPETS) >= 7
    for name in ("KeepawayEnv", "keepaway_v0", "KeepawayVectorEnv", "RecordDemonstrations", "testing"):
        assert any(name in snippet for snippet in SNIPPETS)
