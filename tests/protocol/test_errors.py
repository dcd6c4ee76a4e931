from __future__ import annotations

import pickle

import pytest

from rcss_hat.protocol.errors import LINE, LocalProtocolError, ProtocolError, RemoteProtocolError, one_line


def test_the_common_kind_is_abstract() -> None:
    with pytest.raises(TypeError, match="abstract"):
        ProtocolError("x")
    assert issubclass(LocalProtocolError, ProtocolError)


def test_remote_errors_quote_the_place() -> None:
    error = RemoteProtocolError("expected a number", b"(see x ((b) 1 2))", 5)
    assert str(error) == "expected a number at byte 5 of 17: (see >>>x ((b) 1 2))"
    assert (error.reason, error.position) == ("expected a number", 5)


def test_excerpts_are_short_and_printable() -> None:
    text = str(RemoteProtocolError("bad", b"\xff" * 5000, 2500))
    assert text.isprintable()
    assert len(text) < 300


def test_remote_errors_survive_pickling() -> None:
    error = pickle.loads(pickle.dumps(RemoteProtocolError("bad", b"(x)", 1)))
    assert (error.reason, error.data, error.position) == ("bad", b"(x)", 1)


def test_remote_errors_need_no_message() -> None:
    assert str(RemoteProtocolError("the server refuses")) == "the server refuses"


@pytest.mark.parametrize(
    ("sent", "shown"),
    [
        ("\x1b]0;title\x07", "\\x1b]0;title\\x07"),
        ("two\r\nlines", "two\\r\\nlines"),
        ("\x9b31m", "\\x9b31m"),
        ("left \u202e right", "left \\u202e right"),
        ("\ud800", "\\ud800"),
        ("größer 東京 ± 1", "größer 東京 ± 1"),
    ],
)
def test_what_others_sent_is_shown_escaped(sent: str, shown: str) -> None:
    assert one_line(sent) == shown
    assert str(RemoteProtocolError(sent)) == shown


def test_a_line_has_a_limit() -> None:
    assert one_line("x" * LINE) == "x" * LINE
    for text in ("x" * 5000, "\x1b" * 5000, "ä" * (LINE + 1)):
        assert len(one_line(text)) == LINE and one_line(text).endswith("...")
    assert len(str(RemoteProtocolError("y" * 4000, b"\xff" * 5000, 2500))) == LINE
