"""What every file that is read goes through: limits, decoding, unpacking, JSON, names that become paths."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from rcss_hat.inputs import FileFormatError, LineReader, check_name, excerpt, load_json, read_bytes, read_text


def text_of(data: bytes, tmp_path: Path) -> str:
    path = tmp_path / "file.txt"
    path.write_bytes(data)
    return read_text(path, "text")


def test_byte_order_mark_and_ends_of_lines(tmp_path: Path) -> None:
    assert text_of(b"\xef\xbb\xbfa\r\nb\rc\n", tmp_path) == "a\nb\nc\n"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\xff\xfea\0b\0", "is not UTF-8 text but UTF-16; save it as UTF-8"),
        (b"abc\0", r"holds a NUL byte \(at byte 3\), so it is no text"),
        (b"ab\xff", r"is not UTF-8 text, so not a text \(byte 2\)"),
    ],
)
def test_what_is_no_text(data: bytes, message: str, tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=message):
        text_of(data, tmp_path)


@pytest.mark.parametrize(
    ("name", "message"), [("missing", "there is no such log"), (".", "is a folder"), ("a\0b", "is no name of a file")]
)
def test_files_that_cannot_be_opened(name: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=message):
        read_bytes(tmp_path / name, "log")


def test_length_is_limited(tmp_path: Path) -> None:
    path = tmp_path / "long"
    path.write_bytes(b"x" * 11)
    assert read_bytes(path, "log", 11) == b"x" * 11
    with pytest.raises(FileFormatError, match="is longer than 10 bytes, the limit for a log"):
        read_bytes(path, "log", 10)
    with pytest.raises(FileFormatError, match="is longer than 10 bytes"):
        read_bytes(Path("/dev/zero"), "log", 10)


def lines_of(data: bytes, tmp_path: Path, **limits: int) -> tuple[list[bytes], str]:
    path = tmp_path / "log"
    path.write_bytes(data)
    reader = LineReader(path, "log", **limits)
    return list(reader), reader.cut


def test_lines_packed_or_not(tmp_path: Path) -> None:
    plain = b"\xef\xbb\xbfone\r\n\ntwo"
    expected = [b"one", b"", b"two"], ""
    assert lines_of(plain, tmp_path) == expected
    assert lines_of(gzip.compress(plain), tmp_path) == expected
    assert lines_of(gzip.compress(plain[:7]) + gzip.compress(plain[7:]) + b"\0\0", tmp_path) == expected


def test_what_is_cut_off_or_damaged_is_read_up_to_there(tmp_path: Path) -> None:
    rows = [f"row {k} {k * k % 997}".encode() for k in range(30_000)]
    packed = gzip.compress(b"\n".join(rows))
    found, why = lines_of(packed[: len(packed) // 2], tmp_path)
    assert why.endswith("it is cut off") and 10_000 < len(found) < 20_000 and found[:-1] == rows[: len(found) - 1]
    damaged = bytearray(packed)
    damaged[len(packed) // 2 : len(packed) // 2 + 40] = bytes(40)
    found, why = lines_of(bytes(damaged), tmp_path)
    assert why.endswith("it is damaged") and found[:5000] == rows[:5000]


def test_unpacked_bytes_and_lines_are_limited(tmp_path: Path) -> None:
    bomb = gzip.compress(b"0123456\n" * 1_000_000)
    with pytest.raises(FileFormatError, match="has more than 4 MiB unpacked, the limit for a log"):
        lines_of(bomb, tmp_path, limit=4 * 2**20)
    with pytest.raises(FileFormatError, match="has a line of more than 4 MiB, so it is no log"):
        lines_of(gzip.compress(bytes(50_000_000)), tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1,", "line 1, column 4: not JSON"),
        ('{"a": NaN}', "NaN is not a number of JSON"),
        ("[-Infinity]", "-Infinity is not a number of JSON"),
        ("[1e999]", "the number 1e999 is too great"),
        ("9" * 6000, "a whole number of 6000 digits; 40 are the limit"),
        ("[" * 33 + "]" * 33, "nested more than 32 levels deep"),
        ('{"a":' * 100_000, "nested more than 32 levels deep"),
        (r'"\ud800"', "holds half a character"),
    ],
)
def test_json_that_is_refused(text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        load_json(text)


def test_json_that_is_read() -> None:
    assert load_json('{"a": [1, 2.5e3, -7, true, null, "\\u00e9"]}') == {"a": [1, 2500.0, -7, True, None, "é"]}
    assert load_json("[" * 31 + "]" * 31)


@pytest.mark.parametrize("name", ["../../evil", "a/b", "", ".hidden", "a\n", "-x", "x" * 101, 7, None])
def test_names_that_are_no_paths(name: object) -> None:
    with pytest.raises(FileFormatError, match=r"a set must consist of letters, digits"):
        check_name(name, "a set")
    assert check_name("A-fast_2.1", "a set") == "A-fast_2.1"


def test_foreign_values_are_shown_short_and_escaped() -> None:
    assert excerpt("a\x1b[0m") == "'a\\x1b[0m'"
    assert len(excerpt(["long"] * 100)) == 60
    assert excerpt(10**5000) == "a whole number of more than 40 digits"
