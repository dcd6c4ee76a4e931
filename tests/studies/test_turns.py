"""Studies in which others play along, and games are looked at again."""

from __future__ import annotations

import asyncio
from pathlib import Path

import aiohttp
import msgspec
import numpy as np
import pytest

from rcss_hat.experiments.study_file import parse_study
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.hat.mapping import map_rules
from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.address import Address
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.learning import Training, write_experiment
from rcss_hat.studies.parts import PeopleStudy
from rcss_hat.studies.people_file import PeopleError, load_people
from rcss_hat.studies.plan import assigned, plan_of
from rcss_hat.studies.report import write_people_report
from rcss_hat.studies.scripted import ScriptedParticipant
from rcss_hat.studies.server import StudyServer

from .serving import people_of, whole

pytestmark = pytest.mark.compiled
TURNS = Path(__file__).with_name("turns.toml")


@pytest.fixture
def study(tmp_path: Path) -> PeopleStudy:
    PAPER_RULES.save(tmp_path / "rules.json")
    (tmp_path / "turns.toml").write_text(TURNS.read_text())
    return load_people(str(tmp_path / "turns.toml"))


def test_a_study_keeps_the_decision_list_that_plays_along(study: PeopleStudy, tmp_path: Path) -> None:
    (tmp_path / "rules.json").unlink()
    games = {p.condition: p.game for k in (1, 2, 3) for p in plan_of(study, k) if p.name.startswith("play")}
    described = {name: game.described for name, game in games.items() if game is not None}
    assert described.pop("rules") == ", turns with a decision list"
    assert described == {"alone": "", "turns": ", turns with hand, looked at again"}
    folder = StudyFolder.begin(tmp_path / "folder", study, rehearsal=True)
    assert StudyFolder(folder.path).study == study


@pytest.mark.parametrize(
    ("keepers", "why"),
    [
        ("hnad", r"condition 'rules': keepers must be one of person, hold, random, hand or the file of a decision "
         r"list, not 'hnad'; did you mean 'hand'\?"),
        ("4v3.json", r"step '\w+' in condition 'rules': keepers: the decision list is for 4v3, the game is 3v2"),
        ("broken.json", r"condition 'rules': keepers must be one of .*broken.json"),
        ("{}", r"step '\w+' in condition 'rules': "),
    ],
)  # fmt: skip
def test_who_cannot_play_along_is_refused(tmp_path: Path, keepers: str, why: str) -> None:
    map_rules(PAPER_RULES, 4, 3).save(tmp_path / "4v3.json")
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "turns.toml").write_text(TURNS.read_text().replace("rules.json", keepers))
    with pytest.raises(PeopleError, match=why):
        load_people(str(tmp_path / "turns.toml"))


def test_a_study_that_is_under_way_keeps_its_partners(study: PeopleStudy, tmp_path: Path) -> None:
    folder = StudyFolder.begin(tmp_path / "folder", study, rehearsal=True)
    folder.admit(1)
    other = msgspec.structs.replace(study, game=msgspec.structs.replace(study.game, keepers="hold"))
    with pytest.raises(FileFormatError, match="was begun with another study: game differ"):
        StudyFolder.begin(tmp_path / "folder", other, rehearsal=True)


@pytest.mark.asyncio
async def test_participants_play_in_turns_correct_and_are_reported(study: PeopleStudy, tmp_path: Path) -> None:
    folder = StudyFolder.begin(tmp_path / "folder", study, rehearsal=True)
    async with StudyServer(folder, Address(), 1, lambda text: None, hurry=20.0) as server:
        people = [ScriptedParticipant(server.link(place), "B", place, 20.0) for place in (1, 2, 3)]
        async with aiohttp.ClientSession() as session, asyncio.timeout(120):
            await asyncio.gather(*(one.run(session) for one in people))
    kept = people_of(folder.path)
    for mine in kept.values():
        whole(mine)
        condition = mine.about["conditions"][0]
        shown = DemonstrationSet.load(mine.folder / f"play-{condition}.csv")
        deciders = {d.by for episode in shown.episodes for d in episode.decisions}
        events = [e for e in mine.events if e["event"] == "correction"]
        assert shown.info.marked == (condition != "alone")
        assert deciders == {"alone": {""}, "turns": {"person", "learner"}, "rules": {"person", "learner"}}[condition]
        corrected = {d.cycle for episode in shown.episodes for d in episode.decisions if d.right is not None}
        played = [e for e in events if e["step"].startswith("play")]
        assert len(shown) == 3 and corrected == {e["cycle"] for e in played}
        assert bool(events) == (condition == "turns")
        if condition == "turns":
            assert len(played) == 3 and {e["step"] for e in events} == {"practice-turns", "play-turns"}
            assert any(e["event"] == "stood" and e["why"] == "replay" for e in mine.events)
    assert {assigned(study, place)[0] for place in (1, 2, 3)} == {"alone", "turns", "rules"}
    write_people_report(folder, tmp_path / "report")
    told = (tmp_path / "report" / "report.md").read_text()
    assert "Decisions by the participant" in told and "Decisions corrected" in told
    in_turns = DemonstrationSet.load(next(folder.path.glob("participants/*/play-turns.csv")))
    own = float(np.mean([d.by != "learner" for game in in_turns for d in game.decisions]))
    assert 0.0 < own < 1.0 and f"{own:.3f}" in told
    taught = parse_study(write_experiment(folder, Training()).read_text(), folder.path)
    assert taught.conditions
