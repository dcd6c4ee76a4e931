from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from rcss_hat.hat.transfer.learners import Learners
from rcss_hat.hat.transfer.making import make_method
from rcss_hat.learning.bounds import learner_bounds
from rcss_hat.learning.checkpoint import CheckpointError, load_checkpoint, save_checkpoint
from rcss_hat.learning.config import LearnerConfig
from rcss_hat.learning.sarsa import LEARNER


def test_arrays_and_header_come_back(tmp_path: Path) -> None:
    records = np.zeros(3, dtype=LEARNER)
    records["last_value"] = [1.5, -2.5, np.pi]
    path = tmp_path / "a.npz"
    save_checkpoint(path, {"hour": 1.5, "name": "Ä"}, {"records": records, "weights": np.arange(6.0).reshape(2, 3)})
    checkpoint = load_checkpoint(path)
    assert (checkpoint.header["hour"], checkpoint.header["name"]) == (1.5, "Ä")
    assert (checkpoint.array("records", LEARNER, (3,)) == records).all()
    assert checkpoint.array("weights", np.dtype("f8"), (2, 3)).tolist() == [[0, 1, 2], [3, 4, 5]]


def test_an_array_of_another_kind_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    save_checkpoint(path, {}, {"weights": np.zeros((2, 3))})
    checkpoint = load_checkpoint(path)
    with pytest.raises(CheckpointError, match=r"a.npz: weights has shape \(2, 3\), this learner needs \(3, 3\)"):
        checkpoint.array("weights", np.dtype("f8"), (3, 3))
    with pytest.raises(CheckpointError, match="weights was written by another version"):
        checkpoint.array("weights", np.dtype("f4"), (2, 3))
    with pytest.raises(CheckpointError, match="no array 'records'; there are weights"):
        checkpoint.array("records", LEARNER, (3,))


def test_objects_and_reserved_names_are_not_saved(tmp_path: Path) -> None:
    for arrays in ({"a": np.array([object()])}, {"header": np.zeros(1)}):
        with pytest.raises(ValueError, match="cannot save"):
            save_checkpoint(tmp_path / "a.npz", {}, arrays)
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.npz"
    save_checkpoint(path, {"hour": 1}, {"weights": np.zeros(2)})

    def fail(file: io.BufferedWriter, **_: object) -> None:
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(OSError, match="disk full"):
        save_checkpoint(path, {"hour": 2}, {"weights": np.zeros(2)})
    assert load_checkpoint(path).header["hour"] == 1
    assert [file.name for file in tmp_path.iterdir()] == ["a.npz"]


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    path.write_bytes(b"something else")
    with pytest.raises(CheckpointError, match=r"a\.npz is not a checkpoint of rcss-hat, or is damaged"):
        load_checkpoint(path)
    np.savez(path, weights=np.zeros(3))
    with pytest.raises(CheckpointError, match="not a checkpoint"):
        load_checkpoint(path)
    np.save(tmp_path / "b.npy", np.zeros(3))
    with pytest.raises(CheckpointError, match="not a checkpoint"):
        load_checkpoint(tmp_path / "b.npy")
    save_checkpoint(path, {"version": 99}, {})
    with pytest.raises(CheckpointError, match="checkpoint version 99; this program reads 1"):
        load_checkpoint(path)
    save_checkpoint(path, {"format": "another"}, {})
    with pytest.raises(CheckpointError, match="not a checkpoint"):
        load_checkpoint(path)


def test_a_damaged_checkpoint_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    save_checkpoint(path, {}, {"weights": np.random.default_rng(0).normal(size=2000)})
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(CheckpointError, match="damaged"):
        load_checkpoint(path)
    broken = bytearray(whole)
    broken[len(whole) // 2] ^= 0xFF
    path.write_bytes(broken)
    with pytest.raises(CheckpointError, match="damaged"):
        load_checkpoint(path)


def test_pickles_inside_are_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    save_checkpoint(path, {}, {"weights": np.zeros(2)})
    buffer = io.BytesIO()
    np.save(buffer, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("extra.npy", buffer.getvalue())
    with pytest.raises(CheckpointError):
        load_checkpoint(path)


def test_what_unpacks_to_too_much_is_refused_before_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.npz"
    save_checkpoint(path, {}, {"weights": np.zeros(400_000)})
    assert path.stat().st_size < 10_000
    monkeypatch.setattr("rcss_hat.learning.checkpoint.MAX_UNPACKED", 2**20)
    with pytest.raises(CheckpointError, match="unpacks to 3 MiB in 2 arrays; the limits are 1 MiB and 64"):
        load_checkpoint(path)


def test_an_array_that_claims_to_be_longer_than_it_is_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    save_checkpoint(path, {}, {"weights": np.zeros(3)})
    with zipfile.ZipFile(path) as file:
        members = {name: file.read(name) for name in file.namelist()}
    members["weights.npy"] = members["weights.npy"].replace(b"(3,)", b"(999999999999,)").replace(b" " * 11, b"", 1)
    with zipfile.ZipFile(path, "w") as file:
        for name, data in members.items():
            file.writestr(name, data)
    with pytest.raises(CheckpointError, match="damaged"):
        load_checkpoint(path)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("last_action", 3, "'last_action' is 3; it must be -1 to 2"),
        ("last_start", 10**6, "'last_start' points out of the features of its variable"),
        ("trace_high", -1, "'trace_high' is -1"),
        ("trace_low", 5, "'trace_low' points out of the features of its variable"),
        ("n_actions", 12, "'n_actions' is not that of these settings"),
        ("step", np.inf, "'step' is inf"),
    ],
)
def test_learners_with_wrong_numbers_are_refused(tmp_path: Path, field: str, value: float, message: str) -> None:
    path = tmp_path / "learners.npz"
    team = Learners.create(LearnerConfig(lambda_=0.9), make_method("no-prior"))
    team.save(path)
    assert Learners.load(path).n_keepers == 3
    team.records[field] = value
    team.save(path)
    with pytest.raises(CheckpointError, match=re.escape(message)):
        Learners.load(path)


def test_every_field_of_a_learner_has_bounds() -> None:
    team = Learners.create(LearnerConfig(), make_method("no-prior"))
    assert set(learner_bounds(team.records, 3)) == set(LEARNER.names)


@pytest.mark.parametrize(
    "change", [{"n_keepers": 10**9}, {"n_takers": None}, {"seed": -1}, {"method": []}, {"config": 7}]
)
def test_settings_that_cannot_be_are_refused(tmp_path: Path, change: dict) -> None:
    path = tmp_path / "learners.npz"
    Learners.create(LearnerConfig(), make_method("no-prior")).save(path)
    saved = load_checkpoint(path)
    save_checkpoint(path, {**saved.header, **change}, saved.arrays)
    with pytest.raises(CheckpointError, match="the settings in the file are not valid"):
        Learners.load(path)
