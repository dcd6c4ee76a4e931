"""Replaying transcripts to real clients."""

from __future__ import annotations

import base64
import gzip
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from server_clients import Client

from fake_server.replay import REFUSAL, Replay, TranscriptError, read_transcript

TRANSCRIPT = Path(__file__).parent.parent / "data" / "fake_server" / "transcript.jsonl.gz"


def lines(*entries: tuple[str, str, str]) -> str:
    return "\n".join(json.dumps({"client": c, "dir": d, "text": t}) for c, d, t in entries)


@contextmanager
def replaying(path: Path) -> Iterator[Replay]:
    replay = Replay(read_transcript(path), port=0)
    thread = threading.Thread(target=replay.run, args=(0.05,))
    thread.start()
    try:
        yield replay
    finally:
        replay.stop()
        thread.join(20.0)
        replay.close()
        assert not thread.is_alive()


def recorded_for(client: str) -> list[str]:
    with gzip.open(TRANSCRIPT, "rt") as transcript:
        entries = [json.loads(line) for line in transcript]
    return [entry["text"] for entry in entries if entry["client"] == client and entry["dir"] == "recv"]


def test_every_client_gets_its_recorded_messages_in_order() -> None:
    with replaying(TRANSCRIPT) as replay:
        clients = {"t1": Client(replay.port), "k1": Client(replay.port)}
        inits = {"k1": "(init keepers (version 11))", "t1": "(init takers (version 11))"}
        for name, client in clients.items():
            client.send(inits[name])
        for name, client in clients.items():
            wanted = recorded_for(name)
            while len(client.got) < len(wanted):
                try:
                    message = client.receive(0.5)
                except TimeoutError:
                    message = "(think)"  # the recording may want more than one answer to a think
                if message == "(think)":
                    client.send("(turn 10)")  # only (done) counts
                    client.send("(dash 50)(done)")
            assert client.got == wanted
            client.close()


def test_messages_wait_for_the_answer(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    path.write_text(
        lines(
            ("a", "send", "(init x (version 11))"), ("a", "recv", "(init l 1 before_kick_off)"),
            ("a", "recv", "(think)"), ("a", "send", "(turn 5)"), ("a", "send", "(done)"),
            ("a", "recv", "(sense_body 1)"),
        )
    )  # fmt: skip
    with replaying(path) as replay:
        client = Client(replay.port)
        client.send("(init x (version 11))")
        assert [client.receive(), client.receive()] == ["(init l 1 before_kick_off)", "(think)"]
        client.send("(turn 5)")
        assert client.quiet_for(0.2)
        client.send("(done)")
        assert client.receive() == "(sense_body 1)"
        client.close()


def test_without_synch_mode_every_datagram_counts_and_binary_frames_are_sent(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    frame = {"client": "m", "dir": "recv", "base64": base64.b64encode(bytes(range(9))).decode()}
    first = lines(("m", "send", "(dispinit)"))
    last = lines(("m", "send", "(dispstart)"), ("m", "recv", '(msg 0 1 "x")'))
    path.write_text("\n".join([first, json.dumps(frame), last]))
    with replaying(path) as replay:
        client = Client(replay.port)
        client.send("(dispinit)")
        assert client.receive_bytes() == bytes(range(9))
        client.send("(dispstart)")
        assert client.receive() == '(msg 0 1 "x")'
        client.close()


def test_clients_without_a_part_are_refused_and_others_get_parts_of_their_kind(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    path.write_text(
        lines(
            ("a", "send", "(init x (version 11))"), ("a", "recv", "first"), ("a", "send", "(x)"), ("a", "recv", "z"),
            ("b", "send", "(init x (version 12))"), ("b", "recv", "second"), ("b", "send", "(x)"), ("b", "recv", "z"),
        )
    )  # fmt: skip
    with replaying(path) as replay:
        answers = []
        for first in ("(init x (version 12))", "(init x (version 99))", "(init x (version 11))", "(dispinit)"):
            client = Client(replay.port)
            client.send(first)
            answers.append(client.receive())
            client.close()
        assert answers == ["second", "first", REFUSAL, REFUSAL]


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("", "no client sends anything"),
        ('{"client": "a", "dir": "recv", "text": "x"}', "no client sends anything"),
        ("not json", r":1: not a line of a transcript"),
        ('{"client": "a", "dir": "sent", "text": "x"}', r":1: dir is send or recv, not 'sent'"),
        ('{"client": "a", "dir": "send"}', r":1: not a line"),
        ('{"client": "a", "dir": "send", "text": 5}', r":1: not a line"),
        ("[1]", r":1: not a line"),
    ],
)
def test_bad_transcripts_are_named(tmp_path: Path, content: str, complaint: str) -> None:
    path = tmp_path / "t.jsonl"
    path.write_text(content)
    with pytest.raises(TranscriptError, match=complaint):
        read_transcript(path)


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(TranscriptError, match=r"cannot read .*missing"):
        read_transcript(tmp_path / "missing.jsonl")
    (tmp_path / "t.jsonl.gz").write_bytes(b"not packed")
    with pytest.raises(TranscriptError, match="cannot read"):
        read_transcript(tmp_path / "t.jsonl.gz")
