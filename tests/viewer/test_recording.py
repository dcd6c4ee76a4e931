from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from rcss_hat.keepaway.report import read_kwy
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.recording import Recording, read_recording

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


def test_json_logs_are_read_as_their_sisters_in_text() -> None:
    recording = read_recording(DATA / "sample-json.rcg.gz")
    assert (len(recording.scenes), recording.skipped, recording.cut) == (80, 0, "")
    assert recording.setup.keepaway and (recording.setup.length, recording.setup.width) == (20.0, 20.0)
    assert recording.setup.teams == ("keepers", "takers")
    assert {len(scene.snapshot.players) for scene in recording.scenes} == {5}
    assert [scene.snapshot.time for scene in recording.scenes[:3]] == [1, 2, 3]
    assert recording.episodes and recording.episodes[0].start == 0


def text_log(path: Path, *lines: str) -> Recording:
    head = "ULG5\n(server_param (keepaway 0)(half_time 300)(simulator_step 100))\n(playmode 1 play_on)\n"
    path.write_text(head + "".join(f"{line}\n" for line in lines))
    return read_recording(path)


def frame(time: int) -> str:
    player = "((l 1) 0 0x1 -5 1 0 0 0 0 (v h 90) (s 8000 1 1 130600) (c 0 0 0 0 0 0 0 0 0 0 0))"
    return f"(show {time} ((b) 0.3 0 0 0) {player})"


def test_names_and_scores_may_come_after_the_first_frame(tmp_path: Path) -> None:
    recording = text_log(
        tmp_path / "a.rcg", frame(1), "(team 2 Red null 0 0)", frame(2), "(team 3 Red Green 0 1)", frame(3),
        "(team 4 Red null 1 1)", frame(4),
    )  # fmt: skip
    assert recording.setup.teams == ("Red", "Green")
    assert [scene.snapshot.score for scene in recording.scenes] == [None, (0, 0), (0, 1), (1, 1)]
    assert Playback(recording).frame(3)["score"] == [1, 1]


def test_absent_teams_of_ordinary_soccer_are_no_keepers(tmp_path: Path) -> None:
    assert text_log(tmp_path / "a.rcg", "(team 1 Red null 0 0)", frame(1)).setup.teams == ("Red", "right")
    assert text_log(tmp_path / "b.rcg", frame(1)).setup.teams == ("left", "right")


def test_a_json_log_of_soccer_has_names_and_score(tmp_path: Path) -> None:
    show = (
        '{"show":{"time":%d,"ball":{"x":0.3,"y":0,"vx":0,"vy":0},"players":[{"side":"l","unum":1,"type":0,"state":1,'
        '"x":-5,"y":1,"vx":0,"vy":0,"body":0,"neck":0,"vq":"h","vw":90,"stamina":8000,"effort":1,"recovery":1,'
        '"capacity":130600,"count":{}},{"side":"r","unum":1,"type":0,"state":0,"x":1,"y":1,"count":{}}]}},'
    )
    path = tmp_path / "game.rcg"
    lines = [
        "[", '{"version":"19.0.0"},', '{"server_param":{"half_time":300,"keepaway":false}},',
        '{"playmode":{"time":1,"mode":"play_on"}},', show % 1,
        '{"team":{"time":2,"l":{"name":"Red","score":2},"r":{"name":null,"score":0}}},', show % 2, show[:60],
    ]  # fmt: skip
    path.write_text("\n".join(lines))
    recording = read_recording(path)
    assert (len(recording.scenes), recording.skipped) == (2, 1)
    assert recording.setup.teams == ("Red", "right") and not recording.setup.keepaway
    assert recording.scenes[1].snapshot.score == (2, 0)
    assert [player.id for player in recording.scenes[0].snapshot.players] == ["l1"]


def test_a_compressed_log_is_played_up_to_where_it_was_cut(tmp_path: Path) -> None:
    packed = (DATA / "sample-v5.rcg.gz").read_bytes()
    path = tmp_path / "cut.rcg.gz"
    path.write_bytes(packed[: len(packed) * 6 // 10])
    recording = read_recording(path)
    assert 80 < len(recording.scenes) < 160 and recording.cut == "it cannot be decompressed to its end: it is cut off"


@pytest.mark.parametrize("value", ["1e300", "0", "-5"])
def test_a_match_that_cannot_be_is_refused(value: str, tmp_path: Path) -> None:
    path = tmp_path / "a.rcg"
    path.write_text(f"ULG5\n(server_param (keepaway 1)(keepaway_length {value}))\n{frame(1)}\n")
    with pytest.raises(WatchError, match="server_param"):
        read_recording(path)


def test_what_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.rcg.gz"
    path.write_bytes(gzip.compress(b"ULG5\n" + bytes(30_000_000)))
    with pytest.raises(WatchError, match="has a line of more than 4 MiB, so it is no game log"):
        read_recording(path)
