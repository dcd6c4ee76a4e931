"""The rehearsal that lies in examples/people: complete, as the codebook says, and without what is nobody's business."""

from __future__ import annotations

import json
from pathlib import Path

from rcss_hat.studies.codebook import codebook
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.game_files import TABLES
from rcss_hat.studies.people_file import load_people

from .serving import people_of, whole

EXAMPLE = Path(__file__).parents[2] / "examples" / "people"
FOLDER = EXAMPLE / "rehearsal"


def test_twelve_scripted_participants_went_through_the_study_beside_it() -> None:
    kept = people_of(FOLDER)
    assert len(kept) == 12 and all(mine.about["rehearsal"] for mine in kept.values())
    for mine in kept.values():
        whole(mine)
    assert StudyFolder(FOLDER).study == load_people(str(EXAMPLE / "study.toml"))


def test_the_codebook_is_that_of_what_is_written_now() -> None:
    text = (FOLDER / "codebook.md").read_text()
    assert text == codebook(StudyFolder(FOLDER).study)
    for kind, columns in TABLES.items():
        files = list(FOLDER.glob(f"participants/*/*.{kind}.csv"))
        assert len(files) == 12
        assert all(file.read_text().partition("\n")[0].split(",") == list(columns) for file in files)


def test_no_links_and_no_addresses_lie_there() -> None:
    assert not (FOLDER / "keys").exists()
    texts = [file.read_text() for file in FOLDER.rglob("*.json*")]
    assert texts and not any("127.0.0.1" in text or "User-Agent" in text for text in texts)
    states = [
        json.loads(line)["event"] for line in (FOLDER / "participants/p001/journal.jsonl").read_text().splitlines()
    ]
    assert states[0] == "arrived" and states.count("done") == 7


def test_its_report_is_beside_it() -> None:
    text = (FOLDER / "report" / "report.md").read_text()
    assert "These are no people" in text and "How many participants?" in text
    assert "Does a person's teaching help?" in text and "| all of normal | 1 |" in text and "### p012" in text
