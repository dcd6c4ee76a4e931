"""What the server tells a worker of a game, and what it hears: JSON, line by line."""

from __future__ import annotations

from msgspec import Struct


class GameSpec(Struct, frozen=True, kw_only=True):
    """A game to be played by a participant.

    Attributes
    ----------
    participant, step : str
    folder : str
        Of the participant.
    size, field : str
    vision : int
    profile : str
    speed : float
        Times real time.
    hurry : float
        How much faster still, in a rehearsal.
    actions : tuple of int
    keepers : str
        See `rcss_hat.studies.parts.GameOptions`.
    correct : bool
    games : int
        How many in all.
    played : int
        How many are in the journal.
    match : int
        Number of this match in the step.
    base_seed : int
        Of the step, from which those of its matches are drawn.
    seed : int
        Of this match.
    kept : bool
        Whether decisions are kept.
    practice : bool
        Whether it is practice.
    may_end : bool
        Whether the participant may end it early.
    origin : float
        What the steady clock showed when the participant began.
    language : str
    note : str
        For the header of the demonstration.
    date : str
    """

    participant: str
    step: str
    folder: str
    size: str
    field: str
    vision: int
    profile: str
    speed: float
    hurry: float
    actions: tuple[int, ...]
    keepers: str
    correct: bool
    games: int
    played: int
    match: int
    base_seed: int
    seed: int
    kept: bool
    practice: bool
    may_end: bool
    origin: float
    language: str
    note: str
    date: str


class Open(Struct, frozen=True, tag="open"):
    """Begin a game."""

    spec: GameSpec


class Enter(Struct, frozen=True, tag="enter"):
    """A page of a participant has connected."""

    participant: str
    page: int


class Leave(Struct, frozen=True, tag="leave"):
    """It has gone."""

    participant: str
    page: int


class Hear(Struct, frozen=True, tag="hear"):
    """It says something."""

    participant: str
    page: int
    text: str


class Longer(Struct, frozen=True, tag="longer"):
    """More games are wanted: so many in all."""

    participant: str
    games: int


class Close(Struct, frozen=True, tag="close"):
    """End a game; what was played is kept."""

    participant: str


Order = Open | Enter | Leave | Hear | Longer | Close
"""What a worker is told. It answers in lines: ``P<page> <message for it>``, ``E<participant> <event>``, and ``R`` when
it is ready."""

MATCH_OVER = "over"
"""Event that ends a game: ``finished`` tells whether all games were played."""
