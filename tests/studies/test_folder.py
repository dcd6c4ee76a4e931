"""The folder of a study: begun once, gone on with, and what is removed is gone."""

from __future__ import annotations

import json
import stat
from pathlib import Path

import msgspec
import pytest

from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.folder import StudyFolder, is_study_folder
from rcss_hat.studies.journal import COMMON, EVENTS, Journal
from rcss_hat.studies.parts import PeopleStudy


@pytest.fixture
def folder(tmp_path: Path, small: PeopleStudy) -> StudyFolder:
    return StudyFolder.begin(tmp_path / "study", small)


def test_a_study_is_read_as_it_was_begun(folder: StudyFolder, small: PeopleStudy) -> None:
    assert StudyFolder(folder.path).study == small
    assert is_study_folder(folder.path) and not is_study_folder(folder.path.parent)


def test_texts_may_change_and_the_rest_may_not(folder: StudyFolder, small: PeopleStudy) -> None:
    better = msgspec.structs.replace(small, title="Better", participants=24)
    again = StudyFolder.begin(folder.path, better)
    assert again.study == better and again.study_file == "study-2.json"
    assert StudyFolder.begin(folder.path, better).study_file == "study-2.json"
    with pytest.raises(FileFormatError, match="begun with another study: seed differ"):
        StudyFolder.begin(folder.path, msgspec.structs.replace(better, seed=6))
    shorter = msgspec.structs.replace(better, steps=better.steps[1:])
    with pytest.raises(FileFormatError, match="steps differ"):
        StudyFolder.begin(folder.path, shorter)


def test_places_that_were_used_stay(folder: StudyFolder, small: PeopleStudy) -> None:
    folder.admit(7)
    with pytest.raises(FileFormatError, match="has data of p007 already"):
        StudyFolder.begin(folder.path, msgspec.structs.replace(small, participants=6))


def test_people_and_rehearsals_are_kept_apart(folder: StudyFolder, small: PeopleStudy) -> None:
    with pytest.raises(FileFormatError, match="holds data of people; keep rehearsals and people apart"):
        StudyFolder.begin(folder.path, small, rehearsal=True)


def test_links_stay_the_same_and_more_can_be_had(folder: StudyFolder, small: PeopleStudy) -> None:
    links = folder.links()
    assert len({*links.places, links.lab, links.open}) == 14
    assert folder.links() == links
    more = StudyFolder.begin(folder.path, msgspec.structs.replace(small, participants=15)).links()
    assert more.places[:12] == links.places and len(set(more.places)) == 15
    assert stat.S_IMODE((folder.path / "keys").stat().st_mode) == 0o700


def test_a_participant_is_admitted_once(folder: StudyFolder) -> None:
    about = folder.admit(3)
    assert folder.admit(3) == about
    assert about["participant"] == "p003" and len(about["code"]) == 8
    assert [kept.name for kept in folder.participants()] == ["p003"]


def test_everything_of_a_participant_is_removed(folder: StudyFolder) -> None:
    for place in (1, 2):
        folder.admit(place)
        Journal(folder.folder_of(place) / "journal.jsonl")
    for made in ("report", "experiment"):
        (folder.path / made).mkdir()
        (folder.path / made / "of-all.csv").write_text("x")
    assert folder.remove("p001") == [folder.path / "report", folder.path / "experiment"]
    left = [str(path.relative_to(folder.path)) for path in folder.path.rglob("*")]
    assert not any("p001" in path or "of-all" in path for path in left)
    assert [kept.name for kept in folder.participants()] == ["p002"]
    assert list(folder.removed()) == ["p001"]
    with pytest.raises(FileFormatError, match="has no participant p001; there are p002"):
        folder.remove("p001")


@pytest.mark.parametrize("name", ["../study", "", "p002/..", "p9"])
def test_nothing_else_is_removed(folder: StudyFolder, name: str) -> None:
    folder.admit(2)
    with pytest.raises(FileFormatError):
        folder.remove(name)
    assert folder.folder_of(2).is_dir()


def test_damage_is_named(folder: StudyFolder) -> None:
    folder.admit(1)
    file = folder.folder_of(1) / "participant.json"
    about = json.loads(file.read_text())
    file.write_text(json.dumps({**about, "participant": "p002"}))
    with pytest.raises(FileFormatError, match="it is not that of p001"):
        folder.participants()


def test_the_codebook_describes_everything_that_is_written(folder: StudyFolder) -> None:
    folder.admit(1)
    text = (folder.path / "codebook.md").read_text()
    about = json.loads((folder.folder_of(1) / "participant.json").read_text())
    assert all(f"| `{entry}` |" in text for entry in about)
    assert all(f"| `{field}` |" in text for fields in (COMMON, *EVENTS.values()) for field in fields)
    assert all(f"### `{event}`" in text for event in EVENTS)
    assert "| `tlx-effort` |" in text and "One of: never, often." in text
