"""The codebook of a study's folder: every file, column and event, made of the tables that the code writes by."""

from __future__ import annotations

from collections.abc import Mapping

from rcss_hat.studies.answers import options
from rcss_hat.studies.game_files import TABLES
from rcss_hat.studies.journal import COMMON, EVENTS
from rcss_hat.studies.parts import PeopleStudy, Question, QuestionsStep, said

FILE = "codebook.md"
ABOUT = {
    "format": "What kind of file this is.",
    "version": "Of the format.",
    "participant": "Name of the participant: that of his place, and nothing else about him.",
    "place": "Number of the place, from 1; it decides, with the study's seed, the conditions and the matches.",
    "conditions": "Conditions the place is assigned to, in order.",
    "study": "File of the study that was in force when he began.",
    "software": "Versions of this software and what it stands on, when he began.",
    "begun": "Time of day (UTC) of his beginning, at which `ms` is 0.",
    "code": "Code that he is shown at the end, where the study shows one.",
    "rehearsal": "true: no person, but a scripted participant of a rehearsal.",
}
"""Entries of ``participant.json``."""
DECISIONS = {
    "episode": "Number of the game in this step.",
    "cycle": "Cycle of the match (100 ms of the game) of the decision.",
    "keeper": "Uniform number of the keeper with the ball.",
    "s0 ...": "The state variables as this keeper perceives them, metres and degrees; the header names them.",
    "action": "What was decided: 0 Hold, 1 PASS1 (to the team mate he takes for the nearest), 2 PASS2, and so on.",
    "by": "Who decided: `person`, or `learner`, who plays while the participant does not. Only in games with `keepers` "
    "or `correct`.",
    "right": "What the participant called right when he looked at the game again; empty where he said nothing. Only "
    "there.",
}
_TITLES = {"keys": "every key", "frames": "when pictures were made", "pace": "how pictures came to the page"}


def codebook(study: PeopleStudy) -> str:
    """Write the codebook of a study, in Markdown."""
    parts = [
        f"# Codebook: {said(study.title, study.language, study.language)}",
        "Every participant has a folder, `participants/p001` and so on. No names, addresses or traits of "
        "browsers are kept "
        "anywhere. Lines and rows are on the disk at once; a last line without an end, after a crash, is to "
        "be ignored.",
        "## `participant.json`",
        _table("entry", ABOUT),
        "## `journal.jsonl`: what happened",
        "One JSON object per line, in the order in which it was written (`ms` of neighbours may be in "
        "another order by some "
        "milliseconds: games are played in other processes). Every event has",
        _table("field", COMMON),
    ]
    for event, fields in EVENTS.items():
        parts += [f"### `{event}`", _table("field", fields)]
    parts += [
        "## `STEP.csv` and `STEP.json`: decisions",
        "Demonstrations as `rcss-hat demonstrate` writes them; of practice, too, where the study keeps it. "
        "`STEP.json` lists "
        "the games with their cycles, how they ended, and whether a key was pressed in them (`idle`).",
        _table("column", DECISIONS),
    ]
    for kind, columns in TABLES.items():
        parts += [
            f"## `STEP.{kind}.csv`: {_TITLES[kind]}",
            "A row belongs to game g of the step when its `match` is that of g (event `game`) and its "
            "`cycle` is at least the "
            "game's `start` and less than its `end`.",
            _table("column", columns),
        ]
    for step in study.steps:
        if isinstance(step, QuestionsStep):
            asked = {q.name: _asked(study, q) for q in step.question}
            parts += [f"## Answers of step `{step.name}`", _table("question", asked)]
    return "\n\n".join(parts) + "\n"


def _asked(study: PeopleStudy, question: Question) -> str:
    text = said(question.text, study.language, study.language)
    if question.kind == "choice":
        several = " (several)" if question.several else ""
        return f"{text} One of{several}: {', '.join(options(question, study.language))}."
    if question.kind == "scale":
        low, high = (said(end, study.language, study.language) for end in (question.low, question.high))
        return f"{text} {question.min:g} ({low}) to {question.max:g} ({high}), in steps of {question.step:g}."
    return f"{text} ({'a number' if question.kind == 'number' else 'free text'})"


def _table(name: str, rows: Mapping[str, str]) -> str:
    def safe(text: str) -> str:
        return " ".join(text.replace("|", "\\|").split())

    lines = [f"| {name} | meaning |", "|---|---|", *(f"| `{key}` | {safe(text)} |" for key, text in rows.items())]
    return "\n".join(lines)
