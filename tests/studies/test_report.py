"""From what is kept to tables, measures, an experiment and a report; with made-up participants."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rcss_hat.experiments.sets import package_demonstrations
from rcss_hat.experiments.study_file import parse_study
from rcss_hat.hat.demonstration import Demonstration
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.clock import utc_text
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.game_files import KEYS
from rcss_hat.studies.journal import Journal
from rcss_hat.studies.learning import Training, experiment_text
from rcss_hat.studies.parts import PeopleStudy
from rcss_hat.studies.plan import plan_of
from rcss_hat.studies.report import powers_of, write_people_report
from rcss_hat.studies.shown import consistency, shown_by
from rcss_hat.studies.tables import COLUMNS, tables_of

GAMES = 3
SETS = {"normal": "A", "fast": "B-fast", "limited": "B-limited"}


def demonstrated(place: int, condition: str) -> DemonstrationSet:
    return package_demonstrations(SETS[condition]).random(GAMES, place)


def played(folder: StudyFolder, place: int) -> None:
    """Write what is kept of a participant who has finished."""
    about = folder.admit(place)
    mine = folder.folder_of(place)
    journal = Journal(mine / "journal.jsonl")
    ms = 0

    def note(event: str, **fields: Any) -> None:
        nonlocal ms
        ms += 1000
        journal.append({"ms": ms, "utc": utc_text(ms / 1000.0), "event": event, **fields})

    condition = about["conditions"][0]
    shown = demonstrated(place, condition)
    for planned in plan_of(folder.study, place)[:-1]:
        note("begun", step=planned.name)
        note("look", step=planned.name, page=1, value=False)
        note("look", step=planned.name, page=1, value=True)
        if planned.kept:
            shown.save(mine / f"{planned.name}.csv")
            with (mine / f"{planned.name}.keys.csv").open("w", newline="") as file:
                rows = csv.writer(file, lineterminator="\n")
                rows.writerow(KEYS)
                for number, d in enumerate(shown, 1):
                    about_game = {"start": d.episode.start, "end": d.episode.end, "reason": d.episode.reason}
                    note("game", step=planned.name, game=number, match=1, idle=d.idle, keys=2, **about_game)
                    start = d.episode.start
                    rows.writerow([1, start, ms, "", 1, "", "l1", 100 * number, "played", start + 1])
                    rows.writerow([1, start, ms, "", 2, "", "l1", 50, "lapsed", start + 4])
                rows.writerow([2, 3, ms, "", 1, "", "", "", "lapsed", 9])
        if planned.name == "about":
            note(
                "answers",
                step="about",
                answers={"often": "never", "age": 30 + place, "which": ["a", "c"], "words": None},
            )
        note("done", step=planned.name, by="participant")


def test_who_decided_too_little_is_named_and_left_out(folder: StudyFolder, tmp_path: Path) -> None:
    mine = folder.folder_of(1)
    table = next(file for file in mine.glob("play-*.csv") if file.with_suffix(".json").exists())
    shown = DemonstrationSet.load(table)
    few = [
        Demonstration.of(d.episode, d.teacher, d.decisions[:k], 13, d.idle)
        for k, d in zip((1, 1, 0), shown, strict=True)
    ]
    DemonstrationSet(shown.info, tuple(few)).save(table)
    write_people_report(folder, tmp_path / "report")
    told = (tmp_path / "report" / "report.md").read_text()
    assert f"nothing to learn from: p001 in {table.stem}: 2 decisions of his own." in told
    assert "| p001 |" not in told.partition("## Demonstrations")[2].partition("##")[0]
    assert "| p002 |" in told


@pytest.fixture
def folder(tmp_path: Path, small: PeopleStudy) -> StudyFolder:
    folder = StudyFolder.begin(tmp_path / "study", small, rehearsal=True)
    for place in range(1, 7):
        played(folder, place)
    return folder


def test_tables_hold_everything_once_and_have_their_columns(folder: StudyFolder) -> None:
    tables = tables_of(folder.participants())
    assert {name: list(table.columns) for name, table in tables.items()} == {n: list(c) for n, c in COLUMNS.items()}
    assert len(tables["participants"]) == 6 and set(tables["participants"]["state"]) == {"finished"}
    assert len(tables["games"]) == 6 * GAMES and tables["games"]["seconds"].gt(0).all()
    assert len(tables["steps"]) == 6 * 6
    assert set(tables["steps"]["hidden_s"].iloc[:-1]) <= {0.0, 1.0}


def test_keys_belong_to_the_game_of_their_match_and_cycle(folder: StudyFolder) -> None:
    keys = tables_of(folder.participants())["keys"]
    mine = keys[keys["participant"] == "p001"]
    assert mine["game"].dropna().astype(int).tolist() == [1, 1, 2, 2, 3, 3]
    assert mine["game"].isna().sum() == 1  # of another match


def test_several_options_and_no_answer_are_told(folder: StudyFolder) -> None:
    answers = tables_of(folder.participants())["answers"].set_index(["participant", "question"])["answer"]
    assert answers["p002", "which"] == "a+c" and answers["p002", "words"] is None and answers["p002", "age"] == 32


def test_participants_are_measured(folder: StudyFolder) -> None:
    kept = folder.participants()[0]
    (shown,) = shown_by(kept)
    expected = demonstrated(1, shown.condition)
    assert shown.figures["mean_s"] == pytest.approx(expected.durations.mean())
    assert shown.figures["latency_ms"] == 200.0
    assert shown.figures["lapsed_share"] == pytest.approx(4 / 7)
    assert shown.figures["keys_per_s"] == pytest.approx(2 * GAMES / expected.durations.sum())


def test_consistency_tells_rules_from_dice() -> None:
    shown = package_demonstrations("A")
    consistent = consistency(shown)
    rng = np.random.default_rng(0)
    from dataclasses import replace

    dice = replace(shown, episodes=tuple(replace(d, actions=rng.permutation(d.actions)) for d in shown.episodes))
    by_chance = consistency(dice)
    assert consistent is not None and by_chance is not None
    assert consistent > 0.7 and abs(by_chance - 0.5) < 0.1


def test_the_experiment_has_a_condition_per_participant_group_and_all(folder: StudyFolder) -> None:
    shown = [s for kept in folder.participants() for s in shown_by(kept)]
    study = parse_study(experiment_text(folder, shown, Training(hours=1.0, trials=2)), folder.path)
    mine = [f"{s.participant}-{s.step}" for s in shown]
    groups = [f"group-{c}" for c in dict.fromkeys(s.condition for s in shown)]
    assert list(study.conditions) == ["no-prior", *mine, *groups, "best-of-all", "all-together"]
    assert study.conditions["no-prior"].trials == 10 and study.conditions[mine[0]].trials == 2
    assert study.task == shown[0].demonstration.info.task
    assert (
        DemonstrationSet.load(folder.path / str(study.sets[mine[2]].file)).n_decisions
        == shown[2].demonstration.n_decisions
    )


def test_without_a_demonstration_there_is_no_experiment(tmp_path: Path, small: PeopleStudy) -> None:
    empty = StudyFolder.begin(tmp_path / "study", small)
    with pytest.raises(FileFormatError, match="nobody has finished a game"):
        experiment_text(empty, [], Training())
    with pytest.raises(FileFormatError, match="is too small"):
        powers_of(empty, [4], None)
    assert "0 participants (nobody yet)" in write_people_report(empty, tmp_path / "report")[0].read_text()


def test_the_report_says_what_it_is_of(folder: StudyFolder, tmp_path: Path) -> None:
    pages = write_people_report(folder, tmp_path / "report")
    text = pages[0].read_text()
    assert "These are no people" in text and "6 participants (6 finished)" in text
    assert "| p004 |" in text and "### p001" in text and "else -> Action = 0" in text
    for name in COLUMNS:
        assert (tmp_path / "report" / "data" / f"{name}.csv").read_text().count("\n") > 1
    assert {p.participants for p in powers_of(folder, [5, 9], 10)} == {5, 9}
