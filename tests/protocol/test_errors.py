from __future__ import annotations

import pickle

import pytest

from rcss_hat.protocol.errors import LocalProtocolError, ProtocolError, RemoteProtocolError


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
