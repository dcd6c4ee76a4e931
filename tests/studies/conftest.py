"""A small study for the tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from viewer.conftest import chromium as chromium

from rcss_hat.studies.parts import PeopleStudy
from rcss_hat.studies.people_file import load_people

SMALL = Path(__file__).with_name("small.toml")


@pytest.fixture
def small() -> PeopleStudy:
    return load_people(str(SMALL))
