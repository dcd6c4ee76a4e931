from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from rcss_hat.keepaway.report import read_kwy
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.recording import read_recording

from .audience import DATA


@pytest.mark.parametrize(("version", "scenes"), [(4, 80), (5, 200), (6, 80)])
def test_all_text_versions_are_read(version: int, scenes: int) -> None:
    recording = read_recording(DATA / f"sample-v{version}.rcg.gz")
    assert len(recording.scenes) == scenes and recording.skipped == 0
    assert recording.setup.keepaway and (recording.setup.length, recording.setup.width) == (20.0, 20.0)
    assert recording.setup.teams == ("keepers", "takers")
    assert {len(scene.snapshot.players) for scene in recording.scenes} == {5}
    assert {scene.snapshot.mode for scene in recording.scenes} == {"play_on"}


def test_episodes_of_a_log_are_those_the_server_counted() -> None:
    recording = read_recording(DATA / "sample-v5.rcg.gz")
    logged = [e for e in read_kwy(DATA / "monitor-v5.kwy") if e.end <= 200]
    assert recording.episodes == logged
    for scene in recording.scenes:
        assert scene.start == max(e.end for e in logged if e.end <= scene.snapshot.time) if scene.episode > 1 else True
    assert [s.episode for s in recording.scenes[:35]] == [1] * 31 + [2] * 4


def test_a_spliced_last_line_is_left_out(tmp_path: Path) -> None:
    """A server stopped while it writes puts the result into an unfinished frame."""
    text = gzip.decompress((DATA / "sample-v5.rcg.gz").read_bytes())
    shows = [line for line in text.splitlines() if line.startswith(b"(show ")]
    spliced = shows[-1][:300] + b'(msg 200 1 "(result 202511221436 keepers_0-vs-takers_0)")'
    path = tmp_path / "cut.rcg"
    path.write_bytes(text.replace(shows[-1], spliced))
    recording = read_recording(path)
    assert (len(recording.scenes), recording.skipped) == (199, 1)
    path.write_bytes(text[: text.index(shows[-1]) + 250])
    assert len(read_recording(path).scenes) == 199


def test_what_is_no_log_is_named(tmp_path: Path) -> None:
    path = tmp_path / "x.rcg"
    for content, message in (
        (b"", "no game log"),
        (b"ULG\x03rest", "game_log_version=5"),
        (b"[\n{}", "no game log"),
        (b"ULG5\n(server_param (keepaway 1))\n", "no frame"),
    ):
        path.write_bytes(content)
        with pytest.raises(WatchError, match=message):
            read_recording(path)
    path.write_bytes(gzip.compress(b"ULG5\n")[:-6])
    with pytest.raises(WatchError, match="decompressed"):
        read_recording(path)
