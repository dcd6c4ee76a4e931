"""Demonstrations: rows and figures, choosing episodes, the files, and recording that can be stopped at any point."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hat_samples import hand_coded, made_up
from hypothesis import given, settings
from hypothesis import strategies as st

from rcss_hat.hat.demonstrations import (
    PICKS,
    Demonstration,
    DemonstrationInfo,
    DemonstrationSet,
    DemonstrationWriter,
    combine,
)
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.decision import Decision
from rcss_hat.keepaway.report import OUT, TAKEN, UNKNOWN, Episode
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.keepaway.task import Task

STATE = [float(k) for k in range(13)]
INFO = DemonstrationInfo("A", "arena", seed=7)

# --- rows -------------------------------------------------------------------------------------------------------


def test_rows_of_all_episodes() -> None:
    demonstrations = made_up()
    n = sum(len(d) for d in demonstrations)
    assert demonstrations.n_decisions == n
    assert demonstrations.X.shape == (n, 13)
    assert demonstrations.y.shape == demonstrations.groups.shape == (n,)
    for k, demonstration in enumerate(demonstrations):
        own = demonstrations.groups == k
        assert (demonstrations.X[own] == demonstration.states).all()
        assert (demonstrations.y[own] == demonstration.actions).all()


def test_recorded_decisions() -> None:
    demonstrations = hand_coded()
    assert demonstrations.n_decisions == 834
    assert len(demonstrations) == 20
    assert np.bincount(demonstrations.y).tolist() == [721, 35, 78]


def test_empty_set_has_empty_rows() -> None:
    demonstrations = DemonstrationSet(INFO, ())
    assert demonstrations.X.shape == (0, 13)
    assert demonstrations.y.shape == (0,)
    assert demonstrations.to_frame().shape == (0, 17)
    assert [len(part) for part in demonstrations.sequences()] == [0, 0, 0, 0]
    assert "no episode was finished" in demonstrations.describe().to_text()


def test_arrays_cannot_be_changed() -> None:
    demonstration = hand_coded().episodes[0]
    with pytest.raises(ValueError, match="read-only"):
        demonstration.actions[0] = 1


def test_frame_has_the_columns_of_the_file(tmp_path: Path) -> None:
    demonstrations = made_up()
    demonstrations.save(tmp_path / "demo.csv")
    read = pd.read_csv(tmp_path / "demo.csv")
    frame = demonstrations.to_frame()
    assert (
        list(frame.columns)
        == list(read.columns)
        == ["episode", "cycle", "keeper", *(f"s{k}" for k in range(13)), "action"]
    )
    assert np.allclose(frame.to_numpy(float), read.to_numpy(float))


def test_sequences_follow_each_keeper() -> None:
    states = np.arange(5.0)[:, np.newaxis] * np.ones(13)
    demonstration = Demonstration(
        Episode(1, 0, 50, OUT),
        "A",
        np.array([3, 4, 20, 21, 40]),
        np.array([1, 1, 2, 2, 1]),
        states,
        np.array([0, 1, 0, 2, 2]),
    )
    X, actions, rewards, last = DemonstrationSet(INFO, (demonstration, demonstration)).sequences()
    assert X[:, 0].tolist() == [0, 1, 4, 2, 3] * 2
    assert actions.tolist() == [0, 1, 2, 0, 2] * 2
    assert rewards.tolist() == [1, 36, 10, 1, 29] * 2
    assert last.tolist() == [False, False, True, False, True] * 2


@given(st.integers(0, 1000))
def test_rewards_of_a_keeper_add_up_to_the_end(seed: int) -> None:
    demonstrations = made_up(seed)
    _, _, rewards, last = demonstrations.sequences()
    total = 0.0
    for demonstration in demonstrations:
        for keeper in set(demonstration.keepers):
            total += demonstration.episode.end - demonstration.cycles[demonstration.keepers == keeper][0]
    assert rewards.sum() == total
    assert last.sum() == sum(len(set(d.keepers)) for d in demonstrations)


# --- choosing ---------------------------------------------------------------------------------------------------


@given(st.integers(0, 1000), st.integers(0, 6))
def test_best_and_worst_part_the_set(seed: int, n: int) -> None:
    demonstrations = made_up(seed)
    best, worst = demonstrations.best(n), demonstrations.worst(len(demonstrations) - n)
    assert len(best) == n
    if 0 < n < len(demonstrations):
        assert best.durations.min() > worst.durations.max()
    numbers = [d.episode.number for d in best]
    assert numbers == sorted(numbers)
    assert sorted(numbers + [d.episode.number for d in worst]) == [d.episode.number for d in demonstrations]


def test_random_choice_depends_on_the_seed_only() -> None:
    demonstrations = made_up(episodes=20)
    chosen = [tuple(d.episode.number for d in demonstrations.random(10, seed)) for seed in (1, 1, 2)]
    assert chosen[0] == chosen[1] != chosen[2]
    assert len(set(chosen[0])) == 10


@given(st.integers(0, 6), st.sampled_from(PICKS), st.integers(0, 9))
def test_split_parts_the_set(n: int, pick: str, seed: int) -> None:
    demonstrations = made_up()
    first, rest = demonstrations.split(n, pick, seed)
    assert len(first) == n
    for part in (first, rest):
        assert [d.episode.number for d in part] == sorted(d.episode.number for d in part)
    numbers = [d.episode.number for part in (first, rest) for d in part]
    assert sorted(numbers) == [d.episode.number for d in demonstrations]
    if pick == "first":
        assert numbers == sorted(numbers)
    if pick in ("best", "worst") and 0 < n < len(demonstrations):
        long, short = (first, rest) if pick == "best" else (rest, first)
        assert long.durations.min() >= short.durations.max()


def test_an_unknown_way_to_pick_is_refused() -> None:
    with pytest.raises(ValueError, match="picked by first, best, worst, random, not 'nicest'"):
        made_up().split(1, "nicest")


def test_too_many_episodes_are_an_error() -> None:
    for choose in (made_up().best, made_up().worst, made_up().split, lambda n: made_up().random(n, 0)):
        with pytest.raises(ValueError, match="has 6 episodes; cannot take 7 of them"):
            choose(7)


def test_combine_keeps_teachers_and_numbers_anew() -> None:
    a, c = made_up(1, teacher="A"), made_up(2, teacher="C")
    both = combine([a.best(2), c.best(3)])
    assert both.info.teacher == "A + C"
    assert [d.teacher for d in both] == ["A", "A", "C", "C", "C"]
    assert [d.episode.number for d in both] == [1, 2, 3, 4, 5]
    assert np.array_equal(both.X, np.concatenate([a.best(2).X, c.best(3).X]))
    assert (both.info.seed, both.info.stage, both.info.date) == (None, "arena", "2026-01-02")
    assert both.info.notes == "of A; of C"


def test_only_one_task_can_be_combined() -> None:
    with pytest.raises(ValueError, match="only demonstrations of one task can be combined"):
        combine([made_up(), made_up(task=Task(4, 3, 30.0, 30.0))])
    with pytest.raises(ValueError, match="give one or more"):
        combine([])


# --- figures ----------------------------------------------------------------------------------------------------


def test_description() -> None:
    described = hand_coded().describe()
    assert described.action_counts.tolist() == [721, 35, 78]
    assert described.action_shares == pytest.approx([721 / 834, 35 / 834, 78 / 834])
    assert (described.ranges[0] <= described.ranges[1]).all()
    assert (described.ranges[1] <= described.ranges[2]).all()
    assert np.isnan(described.share_out)
    text = described.to_text()
    assert "20 episodes" in text
    assert "834 decisions: Hold 721 (86.5 %), PASS1 35 (4.2 %), PASS2 78 (9.4 %)" in text
    assert made_up().describe().share_out == 0.5


def test_coverage_counts_tenths_of_the_range() -> None:
    diagonal = np.hypot(20.0, 20.0)
    states = np.zeros((4, 13))
    states[:, 0] = [0.0, 0.04 * diagonal, 0.051 * diagonal, 99.0]  # parts 0, 0, 1, last
    states[:, 1] = [0.0, 0.09 * diagonal, 0.11 * diagonal, 0.21 * diagonal]
    states[:, 12] = [0.0, 30.0, 100.0, 180.0]
    demonstration = Demonstration(Episode(1, 0, 9, OUT), "A", np.arange(4), np.ones(4), states, np.zeros(4))
    coverage = DemonstrationSet(INFO, (demonstration,)).describe().coverage
    assert coverage[[0, 1, 2, 12]] == pytest.approx([0.3, 0.3, 0.1, 0.4])


# --- files ------------------------------------------------------------------------------------------------------


@given(st.integers(0, 1000), st.sampled_from([Task(), Task(4, 3, 30.0, 30.0), Task(5, 4, 35.0, 35.0, 90, "11.1")]))
def test_files_read_back_to_the_last_bit(tmp_path_factory: pytest.TempPathFactory, seed: int, task: Task) -> None:
    path = tmp_path_factory.mktemp("demo") / "demo.csv"
    demonstrations = made_up(seed, task=task)
    demonstrations.save(path)
    assert DemonstrationSet.load(path) == demonstrations
    assert DemonstrationSet.load(path.with_suffix(".json")) == demonstrations


def test_header_is_open(tmp_path: Path) -> None:
    made_up().save(tmp_path / "demo.csv")
    header = json.loads((tmp_path / "demo.json").read_text())
    assert header["format"] == "rcss-hat demonstration"
    assert header["table"] == "demo.csv"
    assert header["task"] == {"keepers": 3, "takers": 2, "length": 20, "width": 20, "vision": 360, "profile": "19.0"}
    assert list(header["columns"]) == (tmp_path / "demo.csv").read_text().splitlines()[0].split(",")
    assert header["columns"]["action"] == "0 = Hold, 1 = PASS1, 2 = PASS2"
    first = header["episodes"][0]
    assert first["duration_s"] == (first["end"] - first["start"]) / 10
    assert first["end_reason"] == "taken"


def test_arff(tmp_path: Path) -> None:
    demonstrations = made_up(1)
    demonstrations.to_arff(tmp_path / "demo.arff")
    lines = (tmp_path / "demo.arff").read_text().splitlines()
    assert "@attribute state_12 numeric" in lines
    assert "@attribute action {0,1,2}" in lines
    rows = [line.split(",") for line in lines[lines.index("@data") + 1 :]]
    assert (np.array(rows)[:, :-1].astype(float) == demonstrations.X).all()
    assert (np.array(rows)[:, -1].astype(int) == demonstrations.y).all()


def broken(tmp_path: Path, line: int, old: str, new: str) -> Path:
    """A valid file with one change in one line of the table."""
    path = tmp_path / "demo.csv"
    made = Demonstration(
        Episode(1, 5, 60, TAKEN),
        "A",
        np.array([10, 20]),
        np.array([1, 2]),
        np.array([STATE, STATE]) + 0.5,
        np.array([0, 1]),
    )
    DemonstrationSet(INFO, (made,)).save(path)
    lines = path.read_text().splitlines(keepends=True)
    assert old in lines[line - 1]
    lines[line - 1] = lines[line - 1].replace(old, new, 1)
    path.write_text("".join(lines))
    return path


def test_byte_order_marks_are_ignored(tmp_path: Path) -> None:
    path = broken(tmp_path, 2, "3.5", "3.5")
    expected = DemonstrationSet.load(path)
    for file in (path, path.with_suffix(".json")):
        file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    assert DemonstrationSet.load(path) == expected


@pytest.mark.parametrize(
    ("line", "old", "new", "message"),
    [
        (1, "keeper", "player", "line 1: the columns of 3v2 are episode,cycle,keeper,s0,"),
        (2, "1,10,1,", "1,ten,1,", "line 2: cycle must be a whole number, not 'ten'"),
        (2, "1,10,1,", "1,10,4,", "line 2: keeper must be a uniform number 1 to 3 in 3v2, not 4"),
        (2, "1,10,1,", "1,1,", "line 2: expected 17 cells, found 16"),
        (2, "3.5", '"3.5', "line 2: unexpected end of data; is there a quote too many?"),
        (2, "3.5", '"3.5\n"', "line 2: a quote opens that does not close in this line"),
        (2, "3.5", "3" * 200_000, "line 2: field larger than field limit"),
        (2, "3.5", "1e300", "line 2: s3 must be metres or degrees, not 1e+300"),
        (2, "1,10,1,", f"1,{'9' * 5000},1,", "line 2: cycle must be a whole number, not '9999"),
        (2, "3.5", "", "line 2: s3 must be a number, not ''"),
        (2, "3.5", "nan", "line 2: s3 must be a finite number, not nan; states with unknown players are no decisions"),
        (3, "12.5,1", "12.5,3", "line 3: action must be one of 0 Hold, 1 PASS1, 2 PASS2 in 3v2, not 3"),
        (3, "1,20,2", "2,20,2", "line 3: expected a decision of episode 1, found episode 2"),
        (3, "1,20,2", "1,9,2", "within its cycles 5 to 60; found cycle 9 after 10"),
        (3, "1,20,2", "1,61,2", "within its cycles 5 to 60; found cycle 61 after 10"),
    ],
)
def test_errors_of_the_table_name_the_line(tmp_path: Path, line: int, old: str, new: str, message: str) -> None:
    path = broken(tmp_path, line, old, new)
    with pytest.raises(FileFormatError) as caught:
        DemonstrationSet.load(path)
    assert str(caught.value).startswith(str(path))
    assert message in str(caught.value)


def test_table_that_ends_early(tmp_path: Path) -> None:
    path = broken(tmp_path, 1, "episode", "episode")
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:2]))
    with pytest.raises(
        FileFormatError, match="ends within episode 1, before decision 2 of the 2 that its header lists"
    ):
        DemonstrationSet.load(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "x"}, "\"format\" must be 'rcss-hat demonstration', not 'x'"),
        ({"version": 9}, '"version" must be 1 to 1'),
        ({"task": {"keepers": 3}}, "task: 'takers' is missing"),
        (
            {"task": {"keepers": 2, "takers": 2, "length": 20, "width": 20, "vision": 360, "profile": "19.0"}},
            "task: Keepaway takes 3 to 11 keepers",
        ),
        ({"teacher": None}, "'teacher' must be str, not None"),
        ({"seed": "x"}, "'seed' must be int or null, not 'x'"),
        (
            {"episodes": [{"end_reason": "goal"}]},
            "episode entry 1: 'end_reason' must be out, taken, unknown, not 'goal'",
        ),
    ],
)
def test_errors_of_the_header_name_the_entry(tmp_path: Path, change: dict[str, object], message: str) -> None:
    made_up().save(tmp_path / "demo.csv")
    header = tmp_path / "demo.json"
    header.write_text(json.dumps(json.loads(header.read_text()) | change))
    with pytest.raises(FileFormatError) as caught:
        DemonstrationSet.load(tmp_path / "demo.csv")
    assert str(caught.value).startswith(f"{header}: ")
    assert message in str(caught.value)


def test_missing_files_and_other_names(tmp_path: Path) -> None:
    for name in ("demo.csv", "demo.json"):
        with pytest.raises(FileFormatError, match=rf"{name}: there is no such demonstration"):
            DemonstrationSet.load(tmp_path / name)
    made_up().save(tmp_path / "demo.csv")
    (tmp_path / "demo.json").rename(tmp_path / "other.json")
    with pytest.raises(FileFormatError, match=r"demo\.csv: its header demo\.json is not there"):
        DemonstrationSet.load(tmp_path / "demo.csv")
    with pytest.raises(FileFormatError, match=r"other\.json: its table other\.csv is not there"):
        DemonstrationSet.load(tmp_path / "other.json")
    with pytest.raises(FileFormatError, match=r"the name of a demonstration ends in \.csv"):
        DemonstrationSet.load(tmp_path / "demo.txt")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"actions": np.array([0, 3])}, "episode 1, decision 2: action must be one of 0 Hold, 1 PASS1, 2 PASS2"),
        ({"keepers": np.array([0, 1])}, "episode 1, decision 1: keeper must be a uniform number 1 to 3"),
        ({"states": np.zeros((2, 12))}, "episode 1, decision 1: a state of 3v2 has 13 variables, not 12"),
        (
            {"states": np.zeros((3, 13))},
            "episode 1: cycles, keepers, actions and the rows of states must be equally many",
        ),
        ({"cycles": np.array([20, 10])}, "must be in order and within its cycles 5 to 60; found cycle 10 after 20"),
        ({"episode": Episode(1, 5, 4, OUT)}, "episode 1 must end at cycle 5 or later, not at 4"),
        ({"episode": Episode(1, 5, 60, "x")}, "the end of an episode must be one of 'o', 't', '.', not 'x'"),
    ],
)
def test_impossible_episodes_are_errors(changes: dict[str, object], message: str) -> None:
    values: dict[str, object] = {
        "episode": Episode(1, 5, 60, OUT),
        "teacher": "A",
        "cycles": np.array([10, 20]),
        "keepers": np.array([1, 2]),
        "states": np.zeros((2, 13)),
        "actions": np.array([0, 1]),
    }
    with pytest.raises(ValueError, match=message):
        DemonstrationSet(INFO, (Demonstration(**(values | changes)),))  # type: ignore[arg-type]


# --- recording --------------------------------------------------------------------------------------------------


def record(writer: DemonstrationWriter, demonstrations: DemonstrationSet) -> None:
    for demonstration in demonstrations:
        for decision in demonstration.decisions:
            writer.add(decision.cycle, decision.keeper, decision.state, decision.action)
        episode = demonstration.episode
        writer.end_episode(episode.start, episode.end, episode.reason)


def test_recording_gives_the_same_file_as_saving(tmp_path: Path) -> None:
    demonstrations = made_up()
    demonstrations.save(tmp_path / "saved.csv")
    with DemonstrationWriter(tmp_path / "demo.csv", demonstrations.info) as writer:
        record(writer, demonstrations)
        assert writer.n_decisions == demonstrations.n_decisions
        assert writer.mean_duration == pytest.approx(demonstrations.durations.mean())
    assert (tmp_path / "demo.csv").read_text() == (tmp_path / "saved.csv").read_text()
    assert DemonstrationSet.load(tmp_path / "demo.csv") == demonstrations


def test_stopped_recording_keeps_finished_episodes(tmp_path: Path) -> None:
    demonstrations = made_up()
    with pytest.raises(KeyboardInterrupt), DemonstrationWriter(tmp_path / "demo.csv", demonstrations.info) as writer:
        record(writer, demonstrations.split(3)[0])
        writer.add(500, 1, STATE, 0)
        raise KeyboardInterrupt
    assert DemonstrationSet.load(tmp_path / "demo.csv") == demonstrations.split(3)[0]


def test_dropped_episode_is_not_kept(tmp_path: Path) -> None:
    with DemonstrationWriter(tmp_path / "demo.csv", INFO) as writer:
        writer.add(10, 1, STATE, 2)
        writer.drop_episode()
        writer.add(60, 2, STATE, 1)
        episode = writer.end_episode(50, 70, OUT)
    assert episode == Episode(1, 50, 70, OUT)
    loaded = DemonstrationSet.load(tmp_path / "demo.csv")
    assert loaded.y.tolist() == [1]


@settings(max_examples=15)
@given(st.integers(0, 6), st.integers(0, 400))
def test_resumed_recording_after_a_crash_anywhere(
    tmp_path_factory: pytest.TempPathFactory, finished: int, torn: int
) -> None:
    """Whatever was appended after the last listed episode, going on gives the file of an undisturbed recording."""
    path = tmp_path_factory.mktemp("demo") / "demo.csv"
    demonstrations = made_up()
    with DemonstrationWriter(path, demonstrations.info) as writer:
        record(writer, demonstrations.split(finished)[0])
    unfinished = "7,999,1," + ",".join("0.125" for _ in range(13)) + ",0\n"
    with path.open("a") as file:
        file.write((unfinished * 6)[:torn])
    assert DemonstrationSet.load(path) == demonstrations.split(finished)[0]
    with DemonstrationWriter(path, demonstrations.info, resume=True) as writer:
        assert len(writer.entries) == finished
        record(writer, demonstrations.split(finished)[1])
    assert DemonstrationSet.load(path) == demonstrations
    assert ",999," not in path.read_text()


def test_crash_between_table_and_header(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "demo.csv"
    demonstrations = made_up(per_episode=20)
    writer = DemonstrationWriter(path, demonstrations.info)
    record(writer, demonstrations.split(2)[0])

    def crash(source: object, target: object) -> None:
        raise OSError("power cut")

    monkeypatch.setattr(Path, "replace", crash)
    with pytest.raises(OSError, match="power cut"):
        record(writer, demonstrations.split(2)[1])
    monkeypatch.undo()
    assert DemonstrationSet.load(path) == demonstrations.split(2)[0]
    with DemonstrationWriter(path, demonstrations.info, resume=True) as writer:
        record(writer, demonstrations.split(2)[1])
    assert DemonstrationSet.load(path) == demonstrations


@pytest.mark.parametrize("resume", [False, True])
def test_a_recording_stopped_while_it_made_its_files_is_begun_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, resume: bool
) -> None:
    def stop(path: Path, text: str) -> None:
        raise KeyboardInterrupt

    for interrupted in ("header", "table"):
        made = [] if interrupted == "header" else ["demo.json"]
        with monkeypatch.context() as patch:
            if interrupted == "header":
                patch.setattr("rcss_hat.hat.demonstration_writer.write_text", stop)
            else:
                patch.setattr("rcss_hat.hat.demonstration_writer.table_head", lambda n: stop(tmp_path, ""))
            with pytest.raises(KeyboardInterrupt):
                DemonstrationWriter(tmp_path / "demo.csv", INFO)
        assert [path.name for path in tmp_path.iterdir() if path.suffix in (".csv", ".json")] == made
        with DemonstrationWriter(tmp_path / "demo.csv", INFO, resume) as writer:
            writer.remove_if_empty()


def test_a_table_without_header_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "demo.csv").write_text("somebody's\n")
    with pytest.raises(FileFormatError, match="exists already"):
        DemonstrationWriter(tmp_path / "demo.csv", INFO)
    assert (tmp_path / "demo.csv").read_text() == "somebody's\n"


def test_existing_file_is_not_overwritten(tmp_path: Path) -> None:
    made_up().save(tmp_path / "demo.csv")
    before = (tmp_path / "demo.csv").read_text()
    with pytest.raises(FileFormatError, match="exists already; go on with it"):
        DemonstrationWriter(tmp_path / "demo.csv", INFO)
    assert (tmp_path / "demo.csv").read_text() == before


@pytest.mark.parametrize(
    ("info", "message"),
    [
        (DemonstrationInfo("B", "arena"), "its teacher is 'A', not 'B'"),
        (DemonstrationInfo("A", "real"), "its stage is 'arena', not 'real'"),
        (DemonstrationInfo("A", "arena", Task(vision=90)), "its task is Task"),
        (
            DemonstrationInfo("A", "arena", notes="played 5 times as fast as real time"),
            "its notes is 'of A', not 'played 5",
        ),
    ],
)
def test_resuming_something_else_is_an_error(tmp_path: Path, info: DemonstrationInfo, message: str) -> None:
    made_up().save(tmp_path / "demo.csv")
    with pytest.raises(FileFormatError, match=message):
        DemonstrationWriter(tmp_path / "demo.csv", info, resume=True)


def test_impossible_decisions_are_refused_at_once(tmp_path: Path) -> None:
    writer = DemonstrationWriter(tmp_path / "demo.csv", INFO)
    writer.add(10, 1, STATE, 0)
    with pytest.raises(ValueError, match="cycle 9 comes before the last decision's, 10"):
        writer.add(9, 1, STATE, 0)
    with pytest.raises(ValueError, match="action must be one of"):
        writer.add(11, 1, STATE, 3)
    with pytest.raises(ValueError, match="has 13 variables, not 2"):
        writer.add(11, 1, [1.0, 2.0], 0)
    with pytest.raises(ValueError, match="within its cycles 0 to 9; found cycle 10"):
        writer.end_episode(0, 9, UNKNOWN)
    writer.end_episode(0, 20, UNKNOWN)
    assert DemonstrationSet.load(tmp_path / "demo.csv").n_decisions == 1


def test_mean_duration_of_nothing(tmp_path: Path) -> None:
    assert np.isnan(DemonstrationWriter(tmp_path / "demo.csv", INFO).mean_duration)


def test_number_of_variables_follows_the_task() -> None:
    task = Task(5, 4, 35.0, 35.0)
    assert DemonstrationInfo("A", "arena", task).n_variables == n_state_variables(5, 4) == 25


def turns() -> DemonstrationSet:
    """A person and a learner who took turns, and what was said of it afterwards."""
    info = replace(INFO, marked=True)
    state = tuple(float(k) for k in range(13))
    decisions = [
        Decision(0, 1, state, 0, "learner"), Decision(1, 1, state, 1, "learner", 2), Decision(5, 2, state, 0, "person"),
        Decision(6, 2, state, 0, "person", 1), Decision(7, 2, state, 2, "", 2),
    ]  # fmt: skip
    return DemonstrationSet(info, (Demonstration.of(Episode(1, 0, 20, OUT), "A", decisions, 13),))


def test_who_decided_and_what_was_right_is_kept(tmp_path: Path) -> None:
    made = turns()
    made.save(tmp_path / "x.csv")
    assert DemonstrationSet.load(tmp_path / "x.csv") == made
    head, *rows = (tmp_path / "x.csv").read_text().splitlines()
    assert head.endswith(",action,by,right")
    assert [row.split(",")[-3:] for row in rows] == [
        ["0", "learner", ""], ["1", "learner", "2"], ["0", "person", ""], ["0", "person", "1"], ["2", "", "2"],
    ]  # fmt: skip
    frame = made.to_frame()
    assert frame["by"].tolist()[:3] == ["learner", "learner", "person"] and frame["right"].isna().sum() == 2
    assert "2 of them taken by the learner, 3 corrected afterwards" in made.describe().to_text()
    writer = DemonstrationWriter(tmp_path / "y.csv", made.info)
    for d in made.episodes[0].decisions:
        writer.add(d.cycle, d.keeper, d.state, d.action, d.by, d.right)
    writer.end_episode(0, 20, OUT)
    assert DemonstrationSet.load(tmp_path / "y.csv").episodes[0].decisions == made.episodes[0].decisions


def test_lessons_are_what_the_person_decided_or_called_right() -> None:
    made = turns()
    taught = made.lessons
    assert (taught.y.tolist(), taught.episodes[0].cycles.tolist()) == ([2, 0, 1, 2], [1, 5, 6, 7])
    assert not taught.info.marked and taught.lessons is taught
    assert made.y.tolist() == [0, 1, 0, 0, 2], "what was played stays what was played"
    both = combine([made, replace(taught, info=INFO)])
    assert both.info.marked and len(both.lessons.y) == 8


@pytest.mark.parametrize(
    ("marks", "problem"),
    [(",robot,", "by must be person, learner or empty"), (",person,3", "right must be one of 0 Hold, 1 PASS1"),
     (",person,x", "right must be a whole number"), (",person", "expected 19 cells, found 18")],
)  # fmt: skip
def test_wrong_marks_are_named(tmp_path: Path, marks: str, problem: str) -> None:
    turns().save(tmp_path / "x.csv")
    text = (tmp_path / "x.csv").read_text()
    (tmp_path / "x.csv").write_text(text.replace(",learner,\n", marks + "\n", 1))
    with pytest.raises(FileFormatError, match=problem):
        DemonstrationSet.load(tmp_path / "x.csv")


def test_marks_need_columns(tmp_path: Path) -> None:
    writer = DemonstrationWriter(tmp_path / "x.csv", INFO)
    with pytest.raises(ValueError, match="no columns for who decided"):
        writer.add(0, 1, [0.0] * 13, 0, "learner")
