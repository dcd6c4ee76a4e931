"""Reading TOML into records: limits, and messages that name the place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import pytest
from msgspec import Meta, Struct

from rcss_hat.inputs import FileFormatError
from rcss_hat.schema import Name, check, did_you_mean, parse_toml, read

Few = Annotated[int, Meta(ge=1, le=5)]


class Inner(Struct, frozen=True, forbid_unknown_fields=True):
    kind: Literal["a", "b"]
    sizes: tuple[Few, ...] = ()


class Outer(Struct, frozen=True, forbid_unknown_fields=True):
    name: Name = "x"
    parts: tuple[Inner, ...] = ()
    share: Annotated[float, Meta(ge=0, le=1, description="0 to 1")] | None = None
    texts: Annotated[tuple[str, ...], Meta(max_length=2)] = ()

    def __post_init__(self) -> None:
        if self.name == "y":
            raise ValueError("y is taken")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (3, "the file has a value of the wrong kind: 3; it must be a table"),
        ({"nme": 3}, "the file has no entry 'nme'; known are name, parts, share, texts; did you mean 'name'?"),
        ({"name": "../x"}, "the file: name must be a name of letters, digits, '.', '_' and '-', not '../x'"),
        ({"name": "x\n"}, r"the file: name must be a name of letters, digits, '.', '_' and '-', not 'x\n'"),
        ({"name": "y"}, "the file: y is taken"),
        ({"parts": [{"kind": "a"}, {}]}, "the file: parts 2 needs 'kind'"),
        ({"parts": [{"kind": "c"}]}, "the file: parts 1: kind must be one of a, b, not 'c'"),
        ({"parts": [{"kind": "a", "sizes": [1, 9]}]}, "the file: parts 1: sizes 2 must be at most 5, not 9"),
        ({"parts": [{"kind": "a", "sizes": [True]}]}, "the file: parts 1: sizes 1 has a value of the wrong kind: True"),
        ({"share": float("nan")}, "the file: share must be 0 to 1, not nan"),
        ({"share": 10**400}, "the file: share must be 0 to 1, not a whole number of more than 40 digits"),
        ({"share": "x"}, "the file: share has a value of the wrong kind: 'x'; it must be 0 to 1"),
        ({"texts": ["a", "b", "c"]}, "the file: texts must be at most 2 long"),
    ],
)
def test_messages_name_the_place_the_value_and_what_is_right(data: object, message: str) -> None:
    with pytest.raises(FileFormatError) as raised:
        read(Outer, data, "the file")
    assert str(raised.value).startswith(message)


def test_what_fits_becomes_a_record() -> None:
    data = {"name": "a.b-c_d", "parts": [{"kind": "b", "sizes": [5]}], "share": 1}
    assert read(Outer, data, "the file") == Outer("a.b-c_d", (Inner("b", (5,)),), 1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = ", "Invalid value"),
        ("a = " + "9" * 6000, "an integer of more than 64 bits"),
        ("a = 0x" + "F" * 6000, "an integer of more than 64 bits: a whole number of more than 40 digits"),
        ("a = " + "[" * 5000 + "]" * 5000, "nested more than 32 levels deep"),
        ("a = " + "[" * 40 + "]" * 40, "nested more than 32 levels deep"),
        ("a." * 200 + "a = 1", "nested more than 32 levels deep"),
    ],
)
def test_toml_that_is_not_right_is_refused(text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        parse_toml(text)


def test_dataclasses_are_checked_and_keep_their_values() -> None:
    @dataclass(frozen=True)
    class Settings:
        share_: Annotated[float, Meta(ge=0, le=1, description="0 to 1")] = 0.5

        def __post_init__(self) -> None:
            check(self)

    assert type(Settings(1).share_) is int, "a whole number stays one, in files too"
    with pytest.raises(ValueError, match=r"^share must be 0 to 1, not 2$"):
        Settings(2)


def test_suggestions() -> None:
    assert did_you_mean("eplison", ["alpha", "epsilon"]) == "; did you mean 'epsilon'?"
    assert did_you_mean("x" * 10**6, ["alpha"]) == ""
