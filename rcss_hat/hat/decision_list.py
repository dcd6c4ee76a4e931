"""Decision lists: the policy summaries that HAT hands from a demonstration to a learner.

A list is immutable. It prints as in the HAT paper (section 5), is kept as JSON with thresholds to the last bit, and
becomes one array for kernels (``to_arrays``; ``rule_rows`` reads it).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcss_hat.hat._rule_shortening import shorten
from rcss_hat.hat._rule_text import MAX_WEIGHT, ParsedRule, parse_rules, rule_text
from rcss_hat.hat.conditions import AT_LEAST
from rcss_hat.hat.rule import Rule, counts_from, rule_from
from rcss_hat.hat.rule_rows import RULE_ROW, RuleArrays
from rcss_hat.inputs import FileFormatError, excerpt, item, parse_json, read_text
from rcss_hat.keepaway.decision import action_name
from rcss_hat.keepaway.state import n_state_variables, state_names
from rcss_hat.system.files import write_text

FORMAT = "rcss-hat decision list"
VERSION = 1
MAX_TEAM = 11


@dataclass(frozen=True, slots=True)
class DecisionList:
    """An ordered list of rules, the first one that covers a state deciding, and a default action.

    Attributes
    ----------
    rules : tuple of Rule
        Each with one condition or more.
    default_action : int
        0 = Hold, 1 = PASS1 and so on.
    keepers, takers : int
        The task; they decide number and meaning of the state variables.
    default_counts : tuple of float or None
        Weight, per action, of the training rows left to the default.
    names : tuple of str
        Meaning of each state variable, by default ``rcss_hat.keepaway.state.state_names``.
    title : str
        What the list was made from, for people.

    Raises
    ------
    ValueError
        When a variable, an action or the counts do not fit the task.

    Examples
    --------
    >>> from rcss_hat import DecisionList
    >>> rules = DecisionList.parse('''
    ... if (state_3 <= 4.5 and state_11 >= 60) -> Action = 1
    ... else -> Action = 0
    ... ''')
    >>> print(rules)
    if (state_3 <= 4.5 and state_11 >= 60) -> Action = 1  # PASS1; state_3 = dist(K1,T1); state_11 = min_ang(K2,K1,T)
    else -> Action = 0                                    # Hold
    >>> rules([8.0] * 3 + [4.0] * 8 + [75.0] * 2)
    1
    """

    rules: tuple[Rule, ...]
    default_action: int = 0
    keepers: int = 3
    takers: int = 2
    default_counts: tuple[float, ...] | None = None
    names: tuple[str, ...] = field(default=())
    title: str = ""

    def __post_init__(self) -> None:
        if not (1 <= self.keepers <= MAX_TEAM and 1 <= self.takers <= MAX_TEAM):
            size = f"{excerpt(self.keepers)}v{excerpt(self.takers)}"
            raise ValueError(f"a team has 1 to {MAX_TEAM} players; there is no Keepaway of {size}")
        n_variables = n_state_variables(self.keepers, self.takers)
        if not self.names:
            object.__setattr__(self, "names", tuple(state_names(self.keepers, self.takers)))
        if len(self.names) != n_variables:
            raise ValueError(f"{self._task} has {n_variables} state variables, but {len(self.names)} names were given")
        for number, rule in enumerate(self.all_rules, start=1):
            where = f"rule {number}" if number <= len(self.rules) else "the default rule"
            self._check_rule(rule, where, n_variables)
            if not rule.conditions and number <= len(self.rules):
                raise ValueError(f"{where} has no condition, so the rules after it could never decide")

    def _check_rule(self, rule: Rule, where: str, n_variables: int) -> None:
        if not 0 <= rule.action < self.keepers:
            raise ValueError(
                f"{where}: {self._task} has the actions 0 to {self.keepers - 1}, not {excerpt(rule.action)}"
            )
        for condition in rule.conditions:
            if condition.feature >= n_variables:
                raise ValueError(
                    f"{where}: {self._task} has state_0 to state_{n_variables - 1}, "
                    f"not state_{excerpt(condition.feature)}"
                )
        if rule.counts is not None and (
            len(rule.counts) != self.keepers or not all(0.0 <= c <= MAX_WEIGHT for c in rule.counts)
        ):
            raise ValueError(f"{where}: counts must be {self.keepers} numbers, one per action, 0 to {MAX_WEIGHT:g}")

    @property
    def _task(self) -> str:
        return f"{self.keepers}v{self.takers}"

    @property
    def default(self) -> Rule:
        """The rule without conditions that comes last."""
        return Rule((), self.default_action, self.default_counts)

    @property
    def all_rules(self) -> tuple[Rule, ...]:
        """The rules and the default."""
        return (*self.rules, self.default)

    def __len__(self) -> int:
        """Number of rules, the default included (the paper's way of counting)."""
        return len(self.rules) + 1

    def __iter__(self) -> Iterator[Rule]:
        return iter(self.all_rules)

    def match(self, state: Sequence[float] | NDArray[np.float64]) -> Rule:
        """Return the rule that decides a state."""
        if len(state) != len(self.names):
            raise ValueError(f"{self._task} has {len(self.names)} state variables, not {len(state)}")
        return next(rule for rule in self.all_rules if rule.covers(state))

    def __call__(self, state: Sequence[float] | NDArray[np.float64]) -> int:
        """Return the action advised in a state of ``n_state_variables(keepers, takers)`` numbers."""
        return self.match(state).action

    def predict(self, states: ArrayLike) -> NDArray[np.int64]:
        """Return the actions advised in many states, shape (n_rows, n_variables)."""
        rows = np.asarray(states, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != len(self.names):
            raise ValueError(f"states must be of shape (n, {len(self.names)}) for {self._task}, not {rows.shape}")
        actions = np.full(len(rows), self.default_action, dtype=np.int64)
        for rule in reversed(self.rules):
            covered = np.logical_and.reduce([condition.covers(rows) for condition in rule.conditions])
            actions[covered] = rule.action
        return actions

    @classmethod
    def from_classifier(cls, classifier: Any, keepers: int = 3, takers: int = 2, title: str = "") -> DecisionList:
        """Take over the rules of a fitted ``RipperClassifier`` whose classes are actions.

        Rules after one without conditions are left out: they decide nothing.

        Raises
        ------
        ValueError
            When the classes are not actions of the task, or the variables not its state variables.
        """
        actions = [_as_action(label, keepers) for label in classifier.classes_]
        rules = []
        for learned in classifier.rules_:
            counts = np.zeros(keepers)
            counts[actions] = learned.counts
            rules.append(Rule(learned.conditions, actions[learned.prediction], tuple(map(float, counts))))
            if not learned.conditions:
                break
        n_variables = n_state_variables(keepers, takers)
        if classifier.n_features_in_ != n_variables:
            raise ValueError(
                f"{keepers}v{takers} has {n_variables} state variables, but the classifier was fitted to "
                f"{classifier.n_features_in_}"
            )
        *conditional, default = rules
        return cls(tuple(conditional), default.action, keepers, takers, default.counts, title=title)

    def shortened(self, states: ArrayLike) -> DecisionList:
        """Return the list with thresholds of as few decimals as decide all of some states as this one does.

        Parameters
        ----------
        states : array-like, shape (n_rows, n_variables)
            Such as those that it was learned from. States between them may be decided otherwise.
        """
        rows = np.asarray(states, dtype=np.float64).reshape(-1, len(self.names))
        decided = self.predict(rows)
        rules = shorten(self.rules, lambda rules: np.array_equal(replace(self, rules=rules).predict(rows), decided))
        return replace(self, rules=rules)

    # --- text ---------------------------------------------------------------------------------------------------

    def format(self, comments: bool = True, digits: int | None = None) -> str:
        """Print the rules as the HAT paper does (section 5), each bound of a rule once.

        Parameters
        ----------
        comments : bool, default=True
            Name beside each rule its action and the variables it tests.
        digits : int, optional
            Decimals of the thresholds; by default as many as needed to read the same numbers again. Rounded
            thresholds may decide states on the border differently.
        """
        lines = []
        for number, rule in enumerate(self.rules):
            word = "elseif" if number else "if"
            lines.append((f"{word} ({rule_text(rule.conditions, digits)}) -> Action = {rule.action}", rule))
        lines.append((f"else -> Action = {self.default_action}", self.default))
        if not comments:
            return "\n".join(text for text, _ in lines)
        width = max(len(text) for text, _ in lines)
        return "\n".join(f"{text:<{width}}  # {self._comment(rule)}" for text, rule in lines)

    def _comment(self, rule: Rule) -> str:
        tested = dict.fromkeys(condition.feature for condition in rule.conditions)
        meanings = [f"state_{feature} = {self.names[feature]}" for feature in tested]
        return "; ".join([action_name(rule.action), *meanings])

    __str__ = format

    @classmethod
    def parse(cls, text: str, keepers: int = 3, takers: int = 2, title: str = "") -> DecisionList:
        """Read rules printed as in the HAT paper, or by Weka's JRip.

        Parameters
        ----------
        text : str
            ``if (state_11 >= 74.84 and state_3 <= 5.99) -> Action = 1``, then ``elseif (...) -> Action = 2``, at the
            end ``else -> Action = 0``. Comments run from ``#`` to the end of the line; line breaks do not matter; the
            signs ≤, ≥ and → and names of actions (Hold, PASS1) are understood. Or what Weka prints for JRip:
            ``(state_11 >= 74.84) and (state_3 <= 5.99) => Action=1 (30.0/2.0)``, at the end `` => Action=0 (9.0/1.0)``.
            JRip counts the wrong rows of a rule together; they are shared out evenly among the other actions, so that
            `Rule.precision` and `Rule.confidence` are right.
        keepers, takers : int
        title : str

        Raises
        ------
        FileFormatError
            Naming the line, what was found and what was expected.
        """
        *conditional, default = parse_rules(text)
        try:
            return cls(
                tuple(Rule(rule.conditions, rule.action, _spread(rule, keepers)) for rule in conditional),
                default.action,
                keepers,
                takers,
                _spread(default, keepers),
                title=title,
            )
        except ValueError as error:
            raise FileFormatError(str(error)) from error

    # --- files --------------------------------------------------------------------------------------------------

    def to_json(self) -> str:
        """Write the list as JSON, thresholds exact to the last bit."""
        rules = [
            {
                "if": [
                    {"variable": c.feature, "operator": c.operator, "threshold": c.threshold} for c in rule.conditions
                ],
                "action": rule.action,
                "counts": rule.counts,
            }
            for rule in self.rules
        ]
        content = {
            "format": FORMAT,
            "version": VERSION,
            "title": self.title,
            "keepers": self.keepers,
            "takers": self.takers,
            "variables": self.names,
            "actions": [action_name(action) for action in range(self.keepers)],
            "rules": rules,
            "default": {"action": self.default_action, "counts": self.default_counts},
        }
        return json.dumps(content, indent=1, ensure_ascii=False) + "\n"

    @classmethod
    def from_json(cls, text: str) -> DecisionList:
        """Read what ``to_json`` wrote.

        Raises
        ------
        FileFormatError
            Naming the entry and what it should be.
        """
        content = parse_json(text, FORMAT, VERSION)
        rules = [rule_from(entry, f"rule {k}") for k, entry in enumerate(item(content, "rules", list), start=1)]
        default = item(content, "default", dict)
        names = item(content, "variables", list) if "variables" in content else []
        if not all(isinstance(name, str) for name in names):
            raise FileFormatError(f"'variables' must be a list of names, not {excerpt(names)}")
        try:
            return cls(
                tuple(rules),
                item(default, "action", int, "default"),
                item(content, "keepers", int),
                item(content, "takers", int),
                counts_from(default, "default"),
                tuple(names),
                item(content, "title", str) if "title" in content else "",
            )
        except FileFormatError:
            raise
        except ValueError as error:
            raise FileFormatError(str(error)) from error

    def save(self, path: str | Path) -> None:
        """Write the list: as text if the name ends in ``.txt``, else as JSON."""
        path = Path(path)
        write_text(path, self.format() + "\n" if path.suffix == ".txt" else self.to_json())

    @classmethod
    def load(cls, path: str | Path, keepers: int = 3, takers: int = 2) -> DecisionList:
        """Read a list, JSON or text.

        Parameters
        ----------
        path : str or Path
        keepers, takers : int
            The task of a list kept as text; JSON says it itself.

        Raises
        ------
        FileFormatError
            Naming the file, the place and what would be right.
        """
        path = Path(path)
        text = read_text(path, "decision list")
        try:
            if text.lstrip().startswith("{"):
                return cls.from_json(text)
            return cls.parse(text, keepers, takers, title=path.stem)
        except FileFormatError as error:
            raise FileFormatError(f"{path}: {error}") from error

    # --- kernels ------------------------------------------------------------------------------------------------

    def to_arrays(self) -> RuleArrays:
        """Lay the list out for kernels.

        Returns
        -------
        ndarray of RULE_ROW, shape (number of conditions + number of rules with the default,)
        """
        rows: list[tuple[int, int, int, float, float, float]] = []
        for rule in self.all_rules:
            answer = len(rows) + len(rule.conditions)
            for condition in rule.conditions:
                sign = -1.0 if condition.operator == AT_LEAST else 1.0
                rows.append((condition.feature, answer + 1, -1, sign, condition.threshold, 0.0))
            rows.append((-1, -1, rule.action, 0.0, 0.0, rule.confidence))
        return np.array(rows, dtype=RULE_ROW)


def _as_action(label: Any, keepers: int) -> int:
    try:
        action = int(label)
    except (TypeError, ValueError):
        action = -1
    if not 0 <= action < keepers or action != label:
        raise ValueError(f"the classes must be actions, whole numbers 0 to {keepers - 1}, not {label!r}")
    return action


def _spread(rule: ParsedRule, keepers: int) -> tuple[float, ...] | None:
    """Counts by action of a rule of which only the sums of right and wrong rows are known."""
    if rule.covered is None or rule.wrong is None or keepers < 2:
        return None
    counts = [rule.wrong / (keepers - 1)] * keepers
    if rule.action < keepers:  # else the list is refused
        counts[rule.action] = rule.covered - rule.wrong
    return tuple(counts)


PAPER_RULES = DecisionList.parse(
    """
    if (state_11 >= 74.84 and state_3 <= 5.99 and state_11 <= 76.26) -> Action = 1
    elseif (state_11 >= 53.97 and state_4 <= 5.91 and state_0 >= 8.45 and state_8 <= 7.06) -> Action = 1
    elseif (state_3 <= 4.84 and state_0 >= 7.33 and state_12 >= 43.66 and state_8 <= 5.57) -> Action = 2
    else -> Action = 0
    """,
    title="Taylor, Suay and Chernova 2011, Subject A",
)
"""The four rules printed in the HAT paper (section 5), learned from 20 episodes of Subject A."""
