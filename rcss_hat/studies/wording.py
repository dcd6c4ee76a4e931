"""The words of the study's own pages, one file per language in ``texts``; what a language lacks is in English."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from rcss_hat.schema import parse_toml

ENGLISH = "en"


@cache
def wording(language: str) -> dict[str, str]:
    """Return all words in a language."""
    return {**_file(ENGLISH), **(_file(language) if language in languages() else {})}


@cache
def languages() -> tuple[str, ...]:
    """Return the languages there are."""
    folder = files("rcss_hat.studies") / "texts"
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")))


def _file(language: str) -> dict[str, Any]:
    return parse_toml((files("rcss_hat.studies") / "texts" / f"{language}.toml").read_text(encoding="utf-8"))
