"""The folder of a study with people: what is where, who may come in, and who was removed.

``study-1.json``
    The study as it was read, with all its texts; ``study-2.json`` after its texts were changed, and so on.
``codebook.md``
    What every file and column means.
``keys/secrets.json``
    The links' tokens. Whoever has them can take part in somebody's place, or see the experimenter's page.
``participants/p001/``
    ``participant.json``, ``journal.jsonl``, and the files of what was played, see `rcss_hat.studies.game_files`.
``removed.json``
    Places whose participants' data were removed, and when.
"""

from __future__ import annotations

import json
import secrets
import shutil
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from rcss_hat.experiments.run_folder import versions
from rcss_hat.inputs import FileFormatError, check_name, item, load_json, parse_json, read_text
from rcss_hat.schema import read
from rcss_hat.studies.clock import utc_text
from rcss_hat.studies.codebook import FILE as CODEBOOK
from rcss_hat.studies.codebook import codebook
from rcss_hat.studies.journal import FILE as JOURNAL
from rcss_hat.studies.journal import Event, read_journal
from rcss_hat.studies.parts import PeopleStudy
from rcss_hat.studies.plan import Planned, assigned, participant_name, plan_of
from rcss_hat.studies.progress import Progress
from rcss_hat.system.files import write_text

STUDY, PARTICIPANT, SECRETS, REMOVED = (
    "rcss-hat study with people", "rcss-hat participant", "rcss-hat study links", "rcss-hat removed participants"
)  # fmt: skip
"""Formats of the files."""
VERSION = 1
PARTICIPANTS, REPORT, EXPERIMENT = "participants", "report", "experiment"
_TEXTS = {"title", "description", "participants", "languages", "text", "agree", "hint", "low", "high", "label"}
"""What may be changed in a study that is under way."""
_CODE = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"


@dataclass(frozen=True, slots=True)
class Links:
    """Tokens of the links: the experimenter's, the open one, and one per place."""

    lab: str
    open: str
    places: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Kept:
    """What is kept of one participant.

    Attributes
    ----------
    name : str
    folder : Path
    about : dict
        ``participant.json``.
    events : list of dict
        The journal.
    progress : Progress
    """

    name: str
    folder: Path
    about: dict[str, Any]
    events: list[Event]
    progress: Progress

    @property
    def plan(self) -> tuple[Planned, ...]:
        """His steps."""
        return self.progress.plan


class StudyFolder:
    """The folder of a study that was begun.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    study : PeopleStudy
        As it is in force.
    study_file : str
        Name of its file.
    rehearsal : bool
        Whether scripted participants play in it.

    Raises
    ------
    FileFormatError
        When it is none.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        found = sorted(path.glob("study-*.json"), key=_number)
        if not found:
            raise FileFormatError(f"{path} is not the folder of a study with people: it has no study-1.json")
        self.study_file = found[-1].name
        self.study, self.rehearsal = _read_study(found[-1])

    # -- beginning ----------------------------------------------------------------------------------------------------
    @classmethod
    def begin(cls, path: Path, study: PeopleStudy, rehearsal: bool = False) -> StudyFolder:
        """Make the folder of a study, or go on with one of the same study.

        Raises
        ------
        FileFormatError
            When it is another study's; texts, languages and the number of places may differ.
        NotWritten
        """
        if not any(path.glob("study-*.json")):
            _write_study(path / "study-1.json", study, rehearsal)
            return cls(path)
        folder = cls(path)
        if folder.rehearsal != rehearsal:
            what = "a rehearsal" if folder.rehearsal else "people"
            raise FileFormatError(f"{path} holds data of {what}; keep rehearsals and people apart")
        if folder.study == study:
            return folder
        before, now = _structure(folder.study), _structure(study)
        if before != now:
            changed = ", ".join(sorted(k for k in before.keys() | now.keys() if before.get(k) != now.get(k)))
            raise FileFormatError(
                f"{path} was begun with another study: {changed} differ. Texts, languages and the number of "
                "participants may be changed; for anything else use a new folder"
            )
        used = [kept.name for kept in folder.participants()]
        if used and used[-1] > participant_name(study.participants):
            raise FileFormatError(f"{path} has data of {used[-1]} already: participants cannot be less than that")
        _write_study(path / f"study-{_number(path / folder.study_file) + 1}.json", study, rehearsal)
        return cls(path)

    def links(self) -> Links:
        """Return the tokens of the links; those that are missing are drawn.

        Raises
        ------
        FileFormatError, NotWritten
        """
        place = self.path / "keys" / "secrets.json"
        lab, everybody, places = secrets.token_urlsafe(24), secrets.token_urlsafe(12), list[str]()
        if place.exists():
            found = parse_json(read_text(place, "file of links"), SECRETS, VERSION)
            lab, everybody = item(found, "lab", str), item(found, "open", str)
            places = [str(token) for token in item(found, "places", list)]
            if len(places) >= self.study.participants:
                return Links(lab, everybody, tuple(places))
        places += [secrets.token_urlsafe(12) for _ in range(self.study.participants - len(places))]
        told = {"format": SECRETS, "version": VERSION, "lab": lab, "open": everybody, "places": places}
        place.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_text(place, json.dumps(told, indent=1) + "\n")
        return Links(lab, everybody, tuple(places))

    # -- participants -------------------------------------------------------------------------------------------------
    def folder_of(self, place: int) -> Path:
        """Folder of the participant of a place."""
        return self.path / PARTICIPANTS / participant_name(place)

    def admit(self, place: int) -> dict[str, Any]:
        """Make the folder of a participant who comes for the first time, or return what is known of him.

        Raises
        ------
        FileFormatError, NotWritten
        """
        file = self.folder_of(place) / "participant.json"
        if file.exists():
            return _read_about(file)
        about = {
            "format": PARTICIPANT,
            "version": VERSION,
            "participant": participant_name(place),
            "place": place,
            "conditions": list(assigned(self.study, place)),
            "study": self.study_file,
            "software": versions(),
            "begun": utc_text(time.time()),
            "code": "".join(secrets.choice(_CODE) for _ in range(8)),
            "rehearsal": self.rehearsal,
        }
        write_text(file, json.dumps(about, indent=1) + "\n")
        return about

    def participants(self) -> list[Kept]:
        """Return everybody of whom something is kept, in the order of their places.

        Raises
        ------
        FileFormatError
            When something of it is damaged.
        """
        found = []
        for file in sorted((self.path / PARTICIPANTS).glob("*/participant.json")):
            about = _read_about(file)
            journal = file.parent / JOURNAL
            events = read_journal(journal) if journal.exists() else []
            plan = plan_of(self.study, about["place"])
            found.append(Kept(about["participant"], file.parent, about, events, Progress(plan, events)))
        return found

    # -- removing -----------------------------------------------------------------------------------------------------
    def removed(self) -> dict[str, str]:
        """Names of the participants whose data were removed, and when."""
        file = self.path / "removed.json"
        if not file.exists():
            return {}
        found = item(parse_json(read_text(file, "list of removed participants"), REMOVED, VERSION), "removed", dict)
        return {str(name): str(when) for name, when in found.items()}

    def remove(self, name: str) -> list[Path]:
        """Remove everything that is kept of a participant; his place is given to nobody else.

        Returns
        -------
        list of Path
            What else was removed: reports and experiments, which hold his data, too.

        Raises
        ------
        FileFormatError
            When there is no such participant.
        OSError
        """
        check_name(name, "the name of a participant")
        folder = self.path / PARTICIPANTS / name
        if not folder.is_dir():
            there = ", ".join(kept.name for kept in self.participants()) or "none"
            raise FileFormatError(f"{self.path} has no participant {name}; there are {there}")
        told = {"format": REMOVED, "version": VERSION, "removed": {**self.removed(), name: utc_text(time.time())}}
        write_text(self.path / "removed.json", json.dumps(told, indent=1) + "\n")
        made = [place for place in (self.path / REPORT, self.path / EXPERIMENT) if place.exists()]
        for place in (folder, *made):
            shutil.rmtree(place)
        return made


def is_study_folder(path: Path) -> bool:
    """Whether a folder is that of a study with people."""
    return path.is_dir() and (path / "study-1.json").is_file()


def _number(path: Path) -> int:
    text = path.stem.removeprefix("study-")
    return int(text) if text.isdecimal() and len(text) < 9 else 0


def _write_study(path: Path, study: PeopleStudy, rehearsal: bool) -> None:
    write_text(path.parent / CODEBOOK, codebook(study))
    told = {"format": STUDY, "version": VERSION, "rehearsal": rehearsal, "since": utc_text(time.time())}
    write_text(path, json.dumps({**told, "study": msgspec.to_builtins(study)}, indent=1, ensure_ascii=False) + "\n")


def _read_study(path: Path) -> tuple[PeopleStudy, bool]:
    try:
        found = parse_json(read_text(path, "study"), STUDY, VERSION)
        return read(PeopleStudy, item(found, "study", dict), "the study"), item(found, "rehearsal", bool)
    except FileFormatError as problem:
        raise FileFormatError(f"{path}: {problem}") from problem


def _read_about(path: Path) -> dict[str, Any]:
    try:
        about = parse_json(read_text(path, "participant"), PARTICIPANT, VERSION)
        place = item(about, "place", int)
        if not 1 <= place < 10**6 or item(about, "participant", str) != path.parent.name:
            raise FileFormatError(f"it is not that of {path.parent.name}")
        for key, kind in (("conditions", list), ("begun", str), ("code", str), ("rehearsal", bool), ("software", dict)):
            item(about, key, kind)
    except FileFormatError as problem:
        raise FileFormatError(f"{path}: {problem}") from problem
    return about


def _structure(study: PeopleStudy) -> dict[str, Any]:
    """Return what must not change while a study is under way: everything but words."""

    def bare(value: Any) -> Any:
        if isinstance(value, dict):
            return {
                name: len(part) if name == "options" else bare(part)
                for name, part in value.items()
                if name not in _TEXTS
            }
        return [bare(part) for part in value] if isinstance(value, list) else value

    found: dict[str, Any] = bare(load_json(msgspec.json.encode(study).decode()))
    return found
