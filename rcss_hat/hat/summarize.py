"""Policy summarisation, the second step of HAT: from a demonstration to a decision list, and how well it fits."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import clone
from sklearn.model_selection import GroupKFold, StratifiedKFold

from rcss_hat.hat.decision_list import DecisionList
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.hat.ripper import RipperClassifier
from rcss_hat.keepaway.decision import action_name

FOLDS = 10


@dataclass(frozen=True, slots=True, eq=False)
class Summary:
    """A decision list and its accuracy on decisions it was not learned from.

    Attributes
    ----------
    decision_list : DecisionList
        Learned from all decisions.
    printed : DecisionList
        The same for people: thresholds of as few decimals as decide every demonstrated state alike.
    teacher : str
    n_episodes, n_decisions : int
    seed : int
    training_accuracy : float
        Share of all decisions that the list reproduces.
    accuracy : float
        Stratified cross-validation over decisions, the paper's measure; nan where no action occurs twice.
    episode_accuracy : float
        Cross-validation that leaves out whole episodes; nan with fewer than two. Successive states of an episode are
        near duplicates, so this is the honest figure for play to come.
    majority_share : float
        Share of the most frequent action: the accuracy of always giving the same answer.
    confusion : ndarray of int, shape (n_actions, n_actions)
        Decisions by demonstrated (row) and predicted action (column) in the stratified cross-validation.
    """

    decision_list: DecisionList
    printed: DecisionList
    teacher: str
    n_episodes: int
    n_decisions: int
    seed: int
    training_accuracy: float
    accuracy: float
    episode_accuracy: float
    majority_share: float
    confusion: NDArray[np.int64]

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, None where there is none; the rules as text."""
        return {
            "teacher": self.teacher,
            "episodes": self.n_episodes,
            "decisions": self.n_decisions,
            "seed": self.seed,
            "rules": len(self.decision_list),
            "conditions": sum(len(rule.conditions) for rule in self.decision_list),
            "accuracy": _number(self.accuracy),
            "episode_accuracy": _number(self.episode_accuracy),
            "training_accuracy": _number(self.training_accuracy),
            "majority_share": _number(self.majority_share),
            "confusion": self.confusion.tolist(),
            "text": self.decision_list.format(comments=False),
        }

    def to_text(self) -> str:
        """Return rules and accuracies for people."""
        most = action_name(self.most_frequent)
        figures = [
            ("accuracy, stratified cross-validation", self.accuracy),
            ("accuracy, whole episodes left out", self.episode_accuracy),
            ("accuracy on the demonstration itself", self.training_accuracy),
            (f"share of the most frequent action ({most})", self.majority_share),
        ]
        width = max(len(text) for text, _ in figures)
        lines = [
            f"{len(self.decision_list)} rules from {self.n_decisions} decisions in {self.n_episodes} episodes of "
            f"{self.teacher}:",
            "",
            self.printed.format(),
            "",
            *(f"{text + ':':<{width + 1}} {_percent(value)}" for text, value in figures),
        ]
        return "\n".join(lines + self._confusion_lines())

    @property
    def most_frequent(self) -> int:
        """The most frequent action, the first of equals."""
        counts = np.sum([rule.counts for rule in self.decision_list if rule.counts is not None], axis=0)
        return int(np.argmax(counts))

    def _confusion_lines(self) -> list[str]:
        if not self.confusion.any():
            return []
        names = [action_name(k) for k in range(len(self.confusion))]
        wide = max(len("demonstrated"), *map(len, names))
        lines = ["", f"{'demonstrated':<{wide}}  predicted " + "".join(f"{name:>8}" for name in names)]
        for name, row in zip(names, self.confusion, strict=True):
            lines.append(f"{name:<{wide}}            " + "".join(f"{n:>8}" for n in row))
        return lines


def summarize(demonstrations: DemonstrationSet, seed: int, learner: RipperClassifier | None = None) -> Summary:
    """Learn a decision list from demonstrations and measure it.

    Parameters
    ----------
    demonstrations : DemonstrationSet
    seed : int
        Decides the learner's splits and the folds.
    learner : RipperClassifier, optional
        Parameters to use instead of the defaults; its ``random_state`` is replaced.

    Returns
    -------
    Summary

    Raises
    ------
    ValueError
        When there are too few decisions to learn from.

    Examples
    --------
    >>> import rcss_hat
    >>> summary = rcss_hat.summarize(rcss_hat.package_demonstrations("A"), seed=1)
    >>> len(summary.decision_list), bool(summary.training_accuracy > summary.majority_share)
    (4, True)
    """
    template = clone(learner) if learner is not None else RipperClassifier()
    template.set_params(random_state=seed)
    demonstrations = demonstrations.lessons
    X, y = demonstrations.X, demonstrations.y
    if len(y) < template.folds:
        raise ValueError(
            f"the demonstration of {demonstrations.info.teacher} holds {len(y)} decisions; at least {template.folds} "
            "are needed to learn rules"
        )
    task = demonstrations.info.task
    fitted = clone(template).fit(X, y)
    predicted = _predicted_stratified(template, X, y, seed)
    known = predicted >= 0
    rules = DecisionList.from_classifier(fitted, task.keepers, task.takers, demonstrations.info.teacher)
    return Summary(
        rules,
        rules.shortened(X),
        demonstrations.info.teacher,
        len(demonstrations),
        len(y),
        seed,
        float(np.mean(fitted.predict(X) == y)),
        float(np.mean(predicted[known] == y[known])) if known.any() else float("nan"),
        _episode_accuracy(template, demonstrations, seed),
        float(np.bincount(y).max() / len(y)),
        _confusion(y[known], predicted[known], task.keepers),
    )


def _predicted_stratified(
    template: RipperClassifier, X: NDArray[np.float64], y: NDArray[np.int64], seed: int
) -> NDArray[np.int64]:
    """Out-of-fold predictions; -1 where cross-validation is not possible."""
    predicted = np.full(len(y), -1, dtype=np.int64)
    folds = min(FOLDS, int(np.bincount(y).max()))
    if folds < 2 or len(y) - -(-len(y) // folds) < template.folds:
        return predicted
    splitter = StratifiedKFold(folds, shuffle=True, random_state=seed)
    with warnings.catch_warnings():
        # an action demonstrated fewer than ten times is missing from some folds, which is all right
        warnings.filterwarnings("ignore", message="The least populated class", category=UserWarning)
        splits = list(splitter.split(X, y))
    for train, test in splits:
        predicted[test] = clone(template).fit(X[train], y[train]).predict(X[test])
    return predicted


def _episode_accuracy(template: RipperClassifier, demonstrations: DemonstrationSet, seed: int) -> float:
    X, y, groups = demonstrations.X, demonstrations.y, demonstrations.groups
    folds = min(FOLDS, len(np.unique(groups)))
    if folds < 2:
        return float("nan")
    right, judged = 0, 0
    for train, test in GroupKFold(folds, shuffle=True, random_state=seed).split(X, y, groups):
        if len(train) >= template.folds:
            right += int((clone(template).fit(X[train], y[train]).predict(X[test]) == y[test]).sum())
            judged += len(test)
    return right / judged if judged else float("nan")


def _confusion(y: NDArray[np.int64], predicted: NDArray[np.int64], n_actions: int) -> NDArray[np.int64]:
    return np.bincount(n_actions * y + predicted, minlength=n_actions**2).reshape(n_actions, n_actions)


def _percent(value: float) -> str:
    return "not possible, too few" if np.isnan(value) else f"{100 * value:.1f} %"


def _number(value: float) -> float | None:
    return None if np.isnan(value) else round(value, 6)
