"""``rcss-hat demonstrate``: record (state, action) pairs of a teacher."""

from __future__ import annotations

import datetime
import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rcss_hat.cli.common import (
    POLICIES,
    Target,
    deliver,
    drawn,
    fail,
    named_policy,
    packed,
    plain_errors,
    progress_bar,
    say,
    task_options,
    typed_settings,
)
from rcss_hat.cli.person import Screen, parse_actions, play_by_hand
from rcss_hat.cli.places import place_options, said_by_file, server_pace
from rcss_hat.keepaway.report import INTERRUPTED, Episode, RunReport
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, FAKE, Place
from rcss_hat.stage.terms import Terms
from rcss_hat.system.files import NotWritten

if TYPE_CHECKING:
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter
    from rcss_hat.hat.demonstrations import DemonstrationInfo
    from rcss_hat.hat.policy import TeamPolicy
    from rcss_hat.stage.stages import Stage


@dataclass(frozen=True)
class Options:
    """What ``demonstrate`` is told, beside the task and the place."""

    teacher: str
    browser: bool
    terminal: bool
    actions: str | None
    speed: float
    port: int
    open_browser: bool
    keepers: str | None
    correct: bool
    plain: bool
    language: str | None
    public_url: str | None
    episodes: int
    seed: int | None
    out: Path
    resume: bool
    as_json: bool

    @property
    def person(self) -> bool:
        """Whether a person demonstrates."""
        return self.browser or self.terminal


@click.command()
@place_options(None, "Where to play.  [default: fake; people: arena]")
@click.option(
    "--teacher",
    default="hand",
    show_default=True,
    help=f"A scripted person: A, B, C, B-fast, B-limited; or {POLICIES}",
)
@click.option("--browser", is_flag=True, help="You demonstrate, in a browser.")
@click.option("--terminal", is_flag=True, help="You demonstrate, in this terminal.")
@click.option("--actions", default=None, help="You: what you may do, e.g. hold,pass1.  [default: everything]")
@click.option(
    "--speed",
    type=click.FloatRange(0.1, 20),
    default=1.0,
    show_default=True,
    help="You: times real time; servers at most 5.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Of the page; 0: any.")
@click.option("--open/--no-open", "open_browser", default=True, help="Open the page by itself.")
@click.option("--keepers", default=None, help=f"Browser: who plays until you take over: {POLICIES}")
@click.option("--correct", is_flag=True, help="Browser, arena: look at each episode again, and say what was right.")
@click.option("--plain", is_flag=True, help="The page shows no state variables and values; for studies.")
@click.option("--language", default=None, help="Of the page: en, de.  [default: the browser's]")
@click.option("--public-url", default=None, help="Under which a reverse proxy shows the page.")
@click.option("--episodes", type=click.IntRange(1), default=20, show_default=True, help="How many in all.")
@click.option("--seed", type=click.IntRange(0), default=None, help="Same seed, same demonstration (fake and arena).")
@click.option("--out", type=Target(), required=True, help="The table, x.csv (and x.json).")
@click.option("--resume", is_flag=True, help="Go on with an existing file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@task_options
@packed(Options)
def demonstrate(task: Task, place: Place | None, options: Options) -> None:
    """Record a teacher that controls the keeper with the ball: a policy, a scripted person, or you.

    Every finished episode is on the disk before the next one ends; Ctrl-C keeps them all. A demonstration that is
    resumed goes on with other matches, also with the same seed.

    \b
    Example:
      rcss-hat demonstrate --on fake --teacher hand --episodes 20 --seed 1 --out demo.csv
      rcss-hat demonstrate --browser --episodes 20 --out mine.csv
      rcss-hat demonstrate --browser --keepers runs/ppr --correct --out taught.csv
      rcss-hat demonstrate --browser --on fake --speed 5 --out fast.csv
      rcss-hat demonstrate --browser --on localhost:6000 --actions hold,pass1 --out mine.csv
      rcss-hat summarize demo.csv --out rules.json
    """
    from rcss_hat.experiments.run_folder import session_seed
    from rcss_hat.hat.demonstration_writer import DemonstrationWriter

    place = place or Place(ARENA if options.person else FAKE)
    lesson = _lesson(task, place, options)
    wanted, hidden = options.episodes, options.as_json or options.person
    with (
        plain_errors(ValueError, RuntimeError),
        DemonstrationWriter(options.out, lesson.info, options.resume) as writer,
    ):
        seed, teacher = session_seed(lesson.info.seed or 0, len(writer.entries)), lesson.info.teacher
        report = RunReport.of(str(place), teacher, task, seed)
        with progress_bar(f"{teacher} demonstrates", wanted, hide=hidden) as update:
            if len(writer.entries) >= wanted:
                say(f"{options.out} already has {len(writer.entries)} episodes")
            else:
                try:
                    report = lesson.record(seed, writer, update)
                finally:
                    writer.remove_if_empty()
                if not writer.entries:
                    report.end_early("ended before the first episode was over")
        text = _json(report, writer) if options.as_json else _described(options.out, writer)
    deliver(text)
    if report.missed and not options.as_json:
        cycles = report.cycles * (task.keepers + task.takers)
        share = 100.0 * report.missed / max(cycles, 1)
        click.echo(f"In {share:.1f} % of all cycles a player's command came too late for the server.", err=True)
    if report.failure:
        kept = f"{len(writer.entries)} of {wanted} episodes are in {options.out}; --resume goes on"
        fail(f"{report.failure} ({kept if writer.entries else 'no episode was recorded'})")
    sys.exit(report.exit_code)


def _lesson(task: Task, place: Place, options: Options) -> Lesson:
    """Check what was asked for."""
    from rcss_hat.hat.demonstrations import DemonstrationInfo
    from rcss_hat.hat.teachers import STYLES

    if options.speed != 1.0 and not options.person:
        raise click.UsageError("--speed is for people: give it with --browser or --terminal")
    _check_page(options, place)
    scripted = next((style for style in STYLES if style.lower() == options.teacher.lower()), None)
    try:
        allowed = parse_actions(options.actions, task.keepers)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--actions") from error
    seed = drawn(options.seed)
    if not (options.person or scripted):
        _policy(options.teacher, task, seed)
    pace = server_pace(place, options.speed) if options.person else {}
    terms = Terms(said_by_file(typed_settings()), say, pace=pace)
    in_force = {} if place.address else {**task.server_values(), **pace}
    remarks = [f"played {options.speed:g} times as fast as real time"] if options.speed != 1.0 else []
    if options.keepers is not None:
        named_policy(options.keepers, task, seed, "--keepers")
        remarks.append(f"taking turns with {options.keepers}")
    if options.correct:
        remarks.append("corrected after each episode")
    name, today = "person" if options.person else options.teacher, datetime.date.today().isoformat()
    marked = options.keepers is not None or options.correct
    info = DemonstrationInfo(name, str(place), task, in_force, seed, today, "; ".join(remarks), marked)
    return Lesson(task, place, options, info, terms, allowed, None if options.person else scripted)


def _check_page(options: Options, place: Place) -> None:
    """Check what is asked of the page."""
    from rcss_hat.viewer.pagefiles import languages, public_origin

    if (options.keepers or options.correct) and not options.browser:
        raise click.UsageError("--keepers and --correct are for the page: give them with --browser")
    if options.correct and place.name != ARENA:
        raise click.UsageError("--correct needs a game that stands still meanwhile: --on arena")
    if options.language is not None and options.language not in languages():
        raise click.BadParameter(f"there are {', '.join(languages())}", param_hint="--language")
    if options.public_url is not None:
        try:
            public_origin(options.public_url)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--public-url") from error


def _policy(teacher: str, task: Task, seed: int) -> TeamPolicy:
    from rcss_hat.hat.teachers import STYLES

    return named_policy(teacher, task, seed, "--teacher", f"; scripted persons are {', '.join(STYLES)}")


@dataclass(frozen=True)
class Lesson:
    """Who teaches what, where; checked."""

    task: Task
    place: Place
    options: Options
    info: DemonstrationInfo
    terms: Terms
    allowed: tuple[int, ...]
    scripted: str | None

    def record(self, seed: int, writer: DemonstrationWriter, update: Callable[..., None]) -> RunReport:
        """Record what is missing; ``seed``: of this session's match."""
        return self._by_hand(seed, writer) if self.options.person else self._by_policy(seed, writer, update)

    def _by_hand(self, seed: int, writer: DemonstrationWriter) -> RunReport:
        from rcss_hat.hat.policy import python_policy
        from rcss_hat.viewer.controls import KeyChannel
        from rcss_hat.viewer.demonstrator import Demonstrator
        from rcss_hat.viewer.demonstrator import Terms as PersonTerms
        from rcss_hat.viewer.room import Manner
        from rcss_hat.viewer.turns import Companion

        o = self.options
        terms = PersonTerms(o.episodes, start=True, speed=o.speed, correct=o.correct)
        learner = None if o.keepers is None else Companion(named_policy(o.keepers, self.task, seed, "--keepers"))
        demonstrator = Demonstrator(KeyChannel(self.allowed), writer, terms, learner)
        policy = python_policy(demonstrator.answer, self.task.keepers, self.task.takers, "person")
        with self._stage(seed, policy) as stage, _early_end(stage.report):
            manner = Manner(o.plain, o.language)
            screen = Screen(o.speed, o.terminal, o.port, o.open_browser, manner, o.public_url)
            play_by_hand(stage, demonstrator, screen)
        return stage.report

    def _by_policy(self, seed: int, writer: DemonstrationWriter, update: Callable[..., None]) -> RunReport:
        from rcss_hat.hat.recorder import Recorder
        from rcss_hat.hat.teachers import teacher_policy
        from rcss_hat.stage.stages import Part

        recorder, missing = Recorder(writer), self.options.episodes - len(writer.entries)

        def keep(episodes: Sequence[Episode], cycle: int) -> None:
            for episode in episodes:
                recorder.keep(episode)
                update(len(writer.entries))

        if self.scripted:
            policy = teacher_policy(self.scripted, self.task.keepers, self.task.takers, seed)
        else:
            policy = _policy(self.options.teacher, self.task, seed)
        with self._stage(seed, policy) as stage, _early_end(stage.report):
            stage.play(Part(missing, None, keep, recorder.decided))
        return stage.report

    def _stage(self, seed: int, policy: TeamPolicy) -> Stage:
        from rcss_hat.stage.stages import open_stage

        try:
            return open_stage(self.place, self.task, seed, policy, self.terms)
        except ValueError as error:
            raise click.UsageError(str(error)) from error


@contextmanager
def _early_end(report: RunReport) -> Iterator[None]:
    """Take what ends a recording early as the report's failure."""
    try:
        yield
    except KeyboardInterrupt:
        report.end_early(INTERRUPTED)
    except NotWritten as problem:
        report.end_early(problem)


def _json(report: RunReport, writer: DemonstrationWriter) -> str:
    mean = None if math.isnan(writer.mean_duration) else round(writer.mean_duration, 4)
    summary = {**report.summary(), "out_file": str(writer.table), "episodes": len(writer.entries)}
    return json.dumps({**summary, "decisions": writer.n_decisions, "mean_s": mean})


def _described(out: Path, writer: DemonstrationWriter) -> str:
    from rcss_hat.hat.demonstrations import DemonstrationSet

    return DemonstrationSet.load(out).describe().to_text() if writer.entries else "no episode was recorded"
