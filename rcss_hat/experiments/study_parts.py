"""The parts of a study as its TOML file has them: what may stand in each table, and within what limits."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from rcss_hat.keepaway.task import Task
from rcss_hat.schema import Name, Seed
from rcss_hat.stage.place import ARENA, Place

MAX_HOURS = 10_000
MAX_TRIALS = 10_000
"""Of all conditions together."""
MAX_CONDITIONS = 1_000
"""With those that are sampled."""
MAX_EPISODES = 10_000
"""Of one set of demonstrations."""
MAX_EVALUATION = 1_000_000
"""Episodes before and after learning."""

Hours = Annotated[float, Meta(ge=0, le=MAX_HOURS, description=f"a number of hours from 0 to {MAX_HOURS:,}")]
Trials = Annotated[int, Meta(ge=1, le=MAX_TRIALS, description=f"at least 1 and at most {MAX_TRIALS:,}")]
Evaluation = Annotated[int, Meta(ge=0, le=MAX_EVALUATION, description=f"at least 0 and at most {MAX_EVALUATION:,}")]
Episodes = Annotated[int, Meta(ge=1, le=MAX_EPISODES, description=f"at least 1 and at most {MAX_EPISODES:,}")]
Sets = Annotated[int, Meta(ge=1, le=MAX_CONDITIONS, description=f"at least 1 and at most {MAX_CONDITIONS:,}")]
Short = Annotated[str, Meta(max_length=40)]
Metric = Literal["jumpstart", "final", "total", "greedy", "early", "hours"]
"""``jumpstart`` is the duration of the initial policy, ``hours`` the time to the threshold."""


class Part(Struct, frozen=True, forbid_unknown_fields=True):
    """A table of the file."""


class SetSpec(Part, frozen=True, kw_only=True):
    """Where a demonstration set comes from: exactly one of ``package``, ``file``, ``teacher``, ``of`` or ``rules``.

    Attributes
    ----------
    name, label : str
    package : str or None
        A set that ships with the package.
    file : str or None
        A demonstration file, relative to the study's file.
    teacher : str or None
        A scripted teacher, who demonstrates in the arena; with ``episodes``, ``seed`` and, if it is another than the
        study's, a task.
    of : tuple of str
        Other sets, joined; each contributes what ``pick`` and ``episodes`` say.
    rules : str or None
        No demonstrations but a decision list: a file, or ``paper`` for the one printed in the HAT paper.
    pick : {"all", "first", "best", "worst", "random"}
        Which episodes of each set in ``of``; best: the longest.
    episodes : int or None
        How many.
    seed : int
        Of the teacher, or of random picks.
    size, field : str or None
        The teacher's task.
    map_to : str or None
        Summarised rules are translated to this size, such as ``4v3``.
    """

    name: Name
    label: str = ""
    package: str | None = None
    file: str | None = None
    teacher: str | None = None
    of: tuple[str, ...] = ()
    rules: str | None = None
    pick: Literal["all", "first", "best", "worst", "random"] = "all"
    episodes: Episodes | None = None
    seed: Seed = 0
    size: Short | None = None
    field: Short | None = None
    map_to: Short | None = None

    @property
    def title(self) -> str:
        """What people call it: its label, or its name."""
        return self.label or self.name

    def __post_init__(self) -> None:
        """Check what does not need the other sets."""
        if self.name.endswith((".rules", ".figures")):
            raise ValueError("a name must not end in .rules or .figures: files that belong to a set do")
        sources = [k for k in ("package", "file", "teacher", "of", "rules") if getattr(self, k) not in (None, ())]
        if len(sources) != 1:
            raise ValueError(f"needs exactly one of package, file, teacher, of and rules, not {sources or 'none'}")
        if self.pick != "all" and (not self.of or self.episodes is None):
            raise ValueError(f"pick = {self.pick!r} needs 'of' and 'episodes'")
        if self.teacher is not None and self.episodes is None:
            raise ValueError("a teacher needs a number of episodes")
        Task.parse(self.size or "3v2", self.field)
        Task.parse(self.map_to or "3v2")


class Round(Part, frozen=True, kw_only=True):
    """A later round of demonstrations: from ``hour`` on, D is another one and reuse begins anew.

    Attributes
    ----------
    hour : float
        Simulated hours of learning before it.
    demonstrations : str or None
        The set whose summary is D from now on.
    watch : str or None
        Instead: a teacher who watches the learner play ``episodes`` episodes and says for every decision what he
        would have done; these decisions are added to all demonstrations before.
    episodes : int or None
    """

    hour: Annotated[float, Meta(gt=0, le=MAX_HOURS, description=f"more than 0 and at most {MAX_HOURS:,}")]
    demonstrations: str | None = None
    watch: str | None = None
    episodes: Episodes | None = None

    def __post_init__(self) -> None:
        """Check the round."""
        if (self.demonstrations is None) == (self.watch is None):
            raise ValueError("a round needs either demonstrations or watch")
        if self.watch is not None and self.episodes is None:
            raise ValueError("a round with watch needs a number of episodes")


class Published(Part, frozen=True, kw_only=True):
    """What a paper reports of a condition; None: nothing. ``hours``: simulated hours to the threshold."""

    jumpstart: float | None = None
    final: float | None = None
    total: float | None = None
    hours: float | None = None
    significant: tuple[str, ...] = ()


class Defaults(Part, frozen=True, kw_only=True):
    """What holds for conditions that do not say otherwise."""

    size: Short = "3v2"
    field: Short | None = None
    vision: int = 360
    profile: str = "19.0"
    learner: str = "paper"
    learner_settings: dict[str, Any] = {}
    hours: Hours = 30.0
    trials: Trials = 10
    evaluation_episodes: Evaluation = 1000
    stage: Annotated[str, Meta(max_length=300)] = ARENA

    def __post_init__(self) -> None:
        """Check what types do not say."""
        Place.parse(self.stage)

    @property
    def task(self) -> Task:
        """The task; raises ValueError when there is none such."""
        return Task.parse(self.size, self.field, self.vision, self.profile)


class ConditionEntry(Defaults, frozen=True, kw_only=True):
    """A ``[[condition]]``: what it changes of the defaults, and what is its own, see `rcss_hat.experiments.study`."""

    name: Name
    label: str | None = None
    method: str = "no-prior"
    settings: dict[str, Any] = {}
    demonstrations: str | None = None
    rounds: tuple[Round, ...] = ()
    baseline: str | None = None
    published: Published = Published()

    def __post_init__(self) -> None:
        """Check that rounds come one after the other, where they can be had."""
        super().__post_init__()
        if self.stage != ARENA and any(r.watch is not None for r in self.rounds):
            raise ValueError("rounds with watch need what only the arena shows: stage must be 'arena'")
        hours = [r.hour for r in self.rounds]
        if hours != sorted(hours) or (hours and hours[-1] >= self.hours):
            raise ValueError(f"rounds must follow each other before the end of the {self.hours:g} hours")


class Table(Part, frozen=True, kw_only=True):
    """A table of the report: some conditions, in this order."""

    name: Name
    title: str
    conditions: tuple[str, ...]


class Figure(Part, frozen=True, kw_only=True):
    """A figure of the report: learning curves, and mean durations of demonstration sets as lines."""

    name: Name
    title: str
    conditions: tuple[str, ...]
    teachers: tuple[str, ...] = ()


class ClaimTest(Part, frozen=True, kw_only=True):
    """One comparison: each of ``conditions`` against each of ``than`` or of ``teachers``.

    Attributes
    ----------
    test : str
    metric : str
    conditions : tuple of str
    than : tuple of str
        Conditions.
    than_metric : str or None
        Another metric of those than of ``conditions``.
    teachers : tuple of str
        Instead of ``than``: demonstration sets, whose mean duration is compared with.
    """

    test: Literal["higher", "lower", "similar", "not lower", "not higher"]
    metric: Metric
    conditions: tuple[str, ...]
    than: tuple[str, ...] = ()
    than_metric: Metric | None = None
    teachers: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that it compares with something."""
        if bool(self.than) == bool(self.teachers):
            raise ValueError("a test needs either than or teachers")


class StageComparison(Part, frozen=True, kw_only=True):
    """Conditions that are the same but for where they were played, side by side, tested for being equivalent.

    Attributes
    ----------
    name, title : str
    pairs : tuple of (str, str)
        Conditions; the first of a pair minus the second is what is estimated.
    margins : mapping of str to float
        By measure (``initial``, ``jumpstart``, ``final``, ``total``): how far two means may lie apart and still count
        as the same, seconds. Chosen before anything is run.
    """

    name: Name
    title: str
    pairs: tuple[tuple[str, str], ...]
    margins: dict[
        Literal["initial", "jumpstart", "final", "total"],
        Annotated[float, Meta(gt=0, description="more than 0")],
    ]


class Claim(Part, frozen=True, kw_only=True):
    """A qualitative claim, and the comparisons that decide whether it is reproduced."""

    text: str = ""
    tests: tuple[ClaimTest, ...] = ()


class Sampling(Part, frozen=True, kw_only=True):
    """Draw demonstration sets from pools, and make a condition of each.

    Attributes
    ----------
    pools : tuple of str
        Demonstration sets to draw from, one pool per set.
    episodes : tuple of int
        Sizes to draw.
    sets : int
        How many sets; pools and sizes alternate.
    method : str
    hours : float
        0: only the initial policy is evaluated.
    """

    pools: tuple[str, ...]
    episodes: tuple[Episodes, ...]
    sets: Sets
    method: str = "ppr"
    hours: Hours = 0.0

    def __post_init__(self) -> None:
        """Check that there is something to draw."""
        if not self.pools or not self.episodes:
            raise ValueError("sampling needs pools and episodes")


class StudyFile(Part, frozen=True, kw_only=True):
    """The whole file; what its tables hold is read one by one, so that messages name them."""

    title: str = "Experiment"
    description: str = ""
    seed: Seed = 0
    baseline: str | None = None
    defaults: dict[str, Any] = {}
    demonstrations: dict[str, Any] = {}
    condition: tuple[Any, ...] = ()
    table: tuple[Any, ...] = ()
    figure: tuple[Any, ...] = ()
    claim: tuple[Any, ...] = ()
    comparison: tuple[Any, ...] = ()
    missed_at_most: Annotated[float, Meta(ge=0, le=1, description="a share from 0 to 1")] = 0.01
    sampling: Sampling | None = None
