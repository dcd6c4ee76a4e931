"""The parts of a study with people, as its TOML file has them: what may stand in each table, and within what limits."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from rcss_hat.schema import Name, Seed

MAX_PARTICIPANTS = 10_000
MAX_GAMES = 10_000
"""Of one step."""
MAX_STEPS = 200
"""Of one participant."""
MAX_POINTS = 21
"""Of a scale: as many as NASA-TLX has."""
MAX_OPTIONS = 50
MAX_ANSWER = 20_000
"""Characters of an answer in free text, at most."""
SLOWEST, FASTEST = 0.1, 20.0
"""Times real time."""

Short = Annotated[str, Meta(max_length=40)]
Games = Annotated[int, Meta(ge=1, le=MAX_GAMES, description=f"at least 1 and at most {MAX_GAMES:,}")]
Speed = Annotated[float, Meta(ge=SLOWEST, le=FASTEST, description=f"a number from {SLOWEST:g} to {FASTEST:g}")]
Language = Annotated[str, Meta(pattern=r"\A[a-z]{2,3}\Z", description="a code of two or three letters, such as 'en'")]
Participants = Annotated[
    int, Meta(ge=1, le=MAX_PARTICIPANTS, description=f"at least 1 and at most {MAX_PARTICIPANTS:,}")
]
Text = str | dict[str, str]
"""For people: in the study's first language, or in several, by their codes."""


class Part(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of the file."""


class GameOptions(Part, frozen=True, kw_only=True):
    """What is played; None: as the tables above it say.

    Attributes
    ----------
    size, field : str
        As ``3v2`` and ``20x20``.
    vision : int
    profile : str
    speed : float
        Times real time.
    actions : tuple of str
        What people may do: ``hold``, ``pass1`` and so on.
    episodes : int
        Games that are played.
    seeds : {"own", "same"}
        Whether everybody plays matches of his own, or all play the same.
    keepers : str
        Who plays while the participant does not: ``person``, nobody; ``hold``, ``random``, ``hand``; or a decision
        list, by its file in the study's file, by its content once that is read. A key of the participant's takes over.
    correct : bool
        Whether participants look at every game again, and say what would have been right.
    """

    size: Short | None = None
    field: Short | None = None
    vision: int | None = None
    profile: Short | None = None
    speed: Speed | None = None
    actions: tuple[Short, ...] | None = None
    episodes: Games | None = None
    seeds: Literal["own", "same"] | None = None
    keepers: str | None = None
    correct: bool | None = None


class Condition(GameOptions, frozen=True, kw_only=True):
    """A condition that participants are assigned to: what it changes of the game."""

    name: Name
    label: str = ""

    @property
    def title(self) -> str:
        """What people call it."""
        return self.label or self.name


class Question(Part, frozen=True, kw_only=True):
    """A question.

    Attributes
    ----------
    name : str
        Of its column.
    kind : {"choice", "scale", "number", "text"}
    text : str or dict
    hint : str or dict
        Below the text.
    required : bool
        Whether one cannot go on without an answer.
    options : tuple
        Of a choice. What is kept is the option in the study's first language.
    several : bool
        Whether a choice may be of several options, or of none.
    min, max, step : float
        Of a scale, or of a number.
    low, high : str or dict
        What the ends of a scale mean.
    longest : int
        Characters of free text.
    """

    name: Name
    kind: Literal["choice", "scale", "number", "text"]
    text: Text
    hint: Text = ""
    required: bool = True
    options: tuple[Text, ...] = ()
    several: bool = False
    min: float | None = None
    max: float | None = None
    step: Annotated[float, Meta(gt=0)] = 1.0
    low: Text = ""
    high: Text = ""
    longest: Annotated[int, Meta(ge=1, le=MAX_ANSWER)] = 2_000

    def __post_init__(self) -> None:
        """Check what belongs together."""
        if self.kind == "choice" and not 2 <= len(self.options) <= MAX_OPTIONS:
            raise ValueError(f"a choice needs 2 to {MAX_OPTIONS} options, not {len(self.options)}")
        if self.kind != "choice" and (self.options or self.several):
            raise ValueError(f"options are for a choice, not for a {self.kind}")
        if self.min is not None and self.max is not None and not self.min < self.max:
            raise ValueError(f"min must be less than max, not {self.min:g} and {self.max:g}")
        if self.kind == "scale":
            if self.min is None or self.max is None:
                raise ValueError("a scale needs min and max")
            if not 2 <= len(self.points) <= MAX_POINTS:
                raise ValueError(f"a scale has 2 to {MAX_POINTS} points, not {(self.max - self.min) / self.step + 1:g}")

    @property
    def points(self) -> list[float]:
        """What can be chosen on a scale."""
        if self.min is None or self.max is None:
            return []
        n = min(int((self.max - self.min) / self.step + 1e-9), MAX_POINTS) + 1
        return [self.min + k * self.step for k in range(n)]


class Step(Part, frozen=True, kw_only=True, tag_field="kind"):
    """A step of a participant's way.

    Attributes
    ----------
    name : str
        Of its files and columns.
    title : str or dict
    per_condition : bool
        Steps one after the other that say so are gone through once for every condition that a participant is assigned
        to, in his order; with ``design = "between"`` that is one.
    """

    name: Name
    title: Text = ""
    per_condition: bool = False


class TextStep(Step, frozen=True, kw_only=True, tag="text"):
    """Something to read, in Markdown; ``agree``: what must be ticked before one can go on, such as a consent."""

    text: Text
    agree: Text = ""


class GameStep(GameOptions, frozen=True, kw_only=True, tag_field="kind"):
    """Games that are played, see `Step`; what it says of them holds before what conditions and ``[game]`` say."""

    name: Name
    title: Text = ""
    per_condition: bool = False


class PracticeStep(GameStep, frozen=True, kw_only=True, tag="practice"):
    """Games to practise.

    Attributes
    ----------
    keep : bool
        Keep them, apart from demonstrations.
    may_end : bool
        Whether the participant may go on before all games are played.
    """

    keep: bool = False
    may_end: bool = False


class DemonstrationStep(GameStep, frozen=True, kw_only=True, tag="demonstration"):
    """Games that are kept as demonstrations."""


class QuestionsStep(Step, frozen=True, kw_only=True, tag="questions"):
    """Questions; ``use``: those of a questionnaire of the package, such as ``nasa-tlx``, before its own."""

    text: Text = ""
    use: str = ""
    question: tuple[Question, ...] = ()


class EndStep(Step, frozen=True, kw_only=True, tag="end"):
    """Thanks; ``code``: shows each participant a code that proves that he came to the end."""

    text: Text
    code: bool = False


AnyStep = TextStep | PracticeStep | DemonstrationStep | QuestionsStep | EndStep
STEPS: dict[str, type[Any]] = {
    "text": TextStep,
    "practice": PracticeStep,
    "demonstration": DemonstrationStep,
    "questions": QuestionsStep,
    "end": EndStep,
}


class PeopleFile(Part, frozen=True, kw_only=True):
    """The whole file; what its tables hold is read one by one, so that messages name them."""

    title: Text
    description: str = ""
    seed: Seed = 0
    participants: Participants
    design: Literal["between", "within"] = "between"
    languages: tuple[Language, ...] = ("en",)
    game: dict[str, Any] = {}
    condition: tuple[Any, ...] = ()
    step: tuple[Any, ...] = ()


class PeopleStudy(Part, frozen=True, kw_only=True):
    """A study with people, read and checked; complete: all its texts are in it.

    Attributes
    ----------
    title : str or dict
    description : str
    seed : int
        Of the order in which conditions are assigned, and of the matches.
    participants : int
        Places.
    design : {"between", "within"}
        Whether a participant meets one condition, or all.
    languages : tuple of str
        Of its texts; the first is the one that participants see first.
    game : GameOptions
        What holds where conditions and steps say nothing else.
    conditions : tuple of Condition
    steps : tuple of steps
    """

    title: Text
    description: str
    seed: int
    participants: int
    design: Literal["between", "within"]
    languages: tuple[str, ...]
    game: GameOptions
    conditions: tuple[Condition, ...]
    steps: tuple[AnyStep, ...]

    @property
    def language(self) -> str:
        """The first language."""
        return self.languages[0]


def said(text: Text, language: str, first: str) -> str:
    """Return a text in a language; in the study's first where it has none in that."""
    if isinstance(text, str):
        return text
    return text.get(language) or text.get(first, "")
