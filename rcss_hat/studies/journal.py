"""What happened to a participant, event by event: one line of JSON each, on the disk before anything follows from it.

The journal is all that is known of a participant's way: where he is follows from it (`rcss_hat.studies.progress`),
after a crash as well. A line that was cut off by one is not an event.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rcss_hat.inputs import FileFormatError, LineReader, load_json
from rcss_hat.studies.game_files import remove_unended_line
from rcss_hat.system.files import append

FILE = "journal.jsonl"
Event = dict[str, Any]

COMMON = {
    "ms": "Milliseconds since the participant began (`arrived` is at 0).",
    "utc": "Time of day (UTC) by the server's clock, which may have been set in between; `ms` was not.",
    "event": "What happened: one of the headings below.",
}
EVENTS: dict[str, dict[str, str]] = {
    "arrived": {
        "conditions": "Conditions that the participant is assigned to, in his order.",
        "study": "File of the study that was in force.",
        "software": "Versions of this software and what it stands on.",
    },
    "resumed": {
        "study": "File of the study that is in force, when the server was started again.",
        "software": "Versions of this software and what it stands on.",
    },
    "begun": {"step": "Step that the participant sees from now on."},
    "done": {"step": "Step that is behind him.", "by": "`participant`, or `experimenter`: who ended it."},
    "answers": {"step": "Step of the questions.", "answers": "By the questions' names; null: not answered."},
    "agreed": {"step": "Step whose text was agreed to.", "text": "What was ticked, in the words that were shown."},
    "match": {
        "step": "Step of the games.",
        "match": "Number of the match in this step, from 1; there is more than one when the server was started again.",
        "seed": "Of the match: the same seed and the same decisions play the same match.",
        "recorded": "Games of this step that were over before this match.",
        "speed": "Times real time.",
    },
    "game": {
        "step": "Step of the game.",
        "game": "Number of the game in this step; in the demonstration's file the number of its episode.",
        "match": "Match it was played in.",
        "start": "Cycle of the match in which it began.",
        "end": "Cycle in which it ended.",
        "reason": "`o`: the ball left the region, `t`: it was taken.",
        "idle": "Whether no key was pressed in it.",
        "keys": "Keys pressed in it.",
    },
    "stood": {
        "step": "Step of the games.",
        "match": "Match that stood still.",
        "cycle": "Cycle in which it did.",
        "from_ms": "When it stopped.",
        "why": "`start`: not begun, `away`: no page open, `hidden`: page not in sight or behind a dialog, "
        "`asked`: whether anybody is there, `replay`: the game was looked at again.",
    },
    "correction": {
        "step": "Step of the games.",
        "match": "Match of the game that was looked at again.",
        "cycle": "Cycle of the decision.",
        "action": "What the participant called right; null: what was played, after all.",
    },
    "page": {
        "state": "`opened`, `closed` (also when the network broke), or `replaced` by a newer one.",
        "step": "Step that it showed.",
        "page": "Number of the page since the server was started.",
    },
    "look": {
        "step": "Step that the page showed.",
        "page": "Number of the page.",
        "value": "Whether it is in sight: visible, its window in front, no dialog before it.",
    },
    "command": {
        "step": "Step of the games.",
        "value": "What was pressed beside passes: `start`, `here`, `stop` where practice may be ended, `take` and "
        "`give` of turns, `seen` when a game was looked at again.",
    },
    "lag": {
        "step": "Step of the games.",
        "pictures": "Pictures since the last such event.",
        "late": "Of these, those that came to the page more than 100 ms too late.",
        "worst_ms": "Longest time between two pictures.",
    },
    "language": {"value": "Language the participant chose."},
    "extended": {"step": "Step that was made longer.", "games": "By so many games."},
    "stopped": {"by": "Who ended the participant's way early."},
    "failed": {"step": "Step that could not go on.", "what": "Why."},
}
"""Every event and its fields; `rcss_hat.studies.codebook` makes the codebook of it."""


class Journal:
    """One participant's journal, open for writing.

    Parameters
    ----------
    path : Path
        Begun when it is missing; a last line that was cut off is removed.

    Attributes
    ----------
    events : list of dict
        All so far.

    Raises
    ------
    FileFormatError
        When another line is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.events = read_journal(path) if path.exists() else []
        if path.exists():
            remove_unended_line(path)

    def append(self, event: Event) -> None:
        """Add an event; it is on the disk afterwards.

        Raises
        ------
        NotWritten
            When it cannot be; then it did not happen.
        """
        check_event(event)
        append(self.path, (json.dumps(event, ensure_ascii=False) + "\n").encode())
        self.events.append(event)


def check_event(event: Event) -> None:
    """Check that an event is one of `EVENTS`, with all its fields.

    Raises
    ------
    ValueError
    """
    kind = event.get("event")
    if not isinstance(kind, str) or kind not in EVENTS:
        raise ValueError(f"there is no event {kind!r}")
    if event.keys() != COMMON.keys() | EVENTS[kind].keys():
        raise ValueError(f"an event {kind!r} has {', '.join([*COMMON, *EVENTS[kind]])}, not {', '.join(event)}")


def read_journal(path: Path) -> list[Event]:
    """Read all events of a journal.

    Raises
    ------
    FileFormatError
        Naming the line and what would be right.
    """
    reader = LineReader(path, "journal")
    events = []
    for number, line in enumerate(reader, 1):
        if reader.unended:
            break  # cut off: its event never happened
        try:
            event = load_json(line.decode())
            check_event(event)
        except (FileFormatError, ValueError, AttributeError) as problem:
            raise FileFormatError(f"{path}: line {number}: {problem}") from problem
        events.append(event)
    return events
