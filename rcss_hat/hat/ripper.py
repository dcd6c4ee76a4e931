"""RIPPER, the rule learner with which HAT summarises demonstrations, as a scikit-learn classifier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils import check_random_state
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_array, check_is_fitted, check_scalar, validate_data

from rcss_hat.hat._ripper_learn import Settings, learn_rules
from rcss_hat.hat._ripper_ruleset import ClassTask
from rcss_hat.hat._ripper_table import Mask, Table, make_table
from rcss_hat.hat.conditions import Condition, covered_by_all


@dataclass(frozen=True, slots=True)
class RipperRule:
    """One rule of a fitted ``RipperClassifier``.

    Attributes
    ----------
    conditions : tuple of Condition
        In the order they were added; empty for the default rule.
    label : int
        Index into ``classes_`` of the class the rule was learned for.
    counts : tuple of float
        Weight per class of the training rows that reach the rule and fulfil it.
    """

    conditions: tuple[Condition, ...]
    label: int
    counts: tuple[float, ...]

    @property
    def distribution(self) -> tuple[float, ...]:
        """Share of each class among the training rows covered; all on ``label`` when there are none."""
        total = sum(self.counts)
        if total <= 0.0:
            return tuple(float(k == self.label) for k in range(len(self.counts)))
        return tuple(count / total for count in self.counts)

    @property
    def prediction(self) -> int:
        """Index of the class predicted: the most frequent one among the rows covered, the first of equals."""
        return int(np.argmax(self.distribution))


class RipperClassifier(ClassifierMixin, BaseEstimator):
    """Ordered rule list learned by RIPPER, with the behaviour of Weka's JRip.

    Classes are learned from the rarest to the most frequent, each against all rows that no rule covers yet. A rule
    grows by the condition of largest information gain on two thirds of those rows and is pruned on the last third;
    rule sets are then optimised by revising, replacing, adding and deleting rules so as to shorten their description.
    The most frequent class is the default. The first rule that covers a row decides.

    Thresholds are values of the data, and both operators, ``<=`` and ``>=``, include them. A missing value (NaN)
    fulfils no condition.

    Parameters
    ----------
    folds : int, default=3
        One of so many parts of the rows prunes, the others grow.
    min_weight : float, default=2.0
        A rule stops growing at a condition that leaves less weight of its class than this.
    optimizations : int, default=2
        Number of optimisation runs.
    check_error : bool, default=True
        Reject rules that err on half or more of the rows they cover.
    prune : bool, default=True
        Without pruning, rules grow on all rows and there is neither optimisation nor deletion.
    random_state : int, RandomState instance or None, default=None
        Decides the splits into grow and prune rows, and the order of equally frequent classes. With an int, the
        rules depend on nothing but the set of weighted rows: neither on their order nor on repeating rows in place of
        weighting them.

    Attributes
    ----------
    rules_ : tuple of RipperRule
        In order of application; the last one is the default rule, without conditions.
    classes_ : ndarray, shape (n_classes,)
    n_features_in_ : int
    feature_names_in_ : ndarray of str, shape (n_features_in_,)
        Only when the training data had names of features.

    References
    ----------
    .. [1] W. W. Cohen, "Fast Effective Rule Induction", ICML 1995, pp. 115-123.
    .. [2] J. R. Quinlan, "MDL and Categorical Theories (Continued)", ICML 1995, pp. 464-470.
    .. [3] M. E. Taylor, H. B. Suay, S. Chernova, "Integrating Reinforcement Learning with Human Demonstrations of
       Varying Ability", AAMAS 2011, pp. 617-624.

    Examples
    --------
    >>> from sklearn.datasets import load_iris
    >>> from rcss_hat.hat.ripper import RipperClassifier
    >>> iris = load_iris()
    >>> learner = RipperClassifier(random_state=0).fit(iris.data, iris.target)
    >>> print(learner.to_text(["sepal_length", "sepal_width", "petal_length", "petal_width"]))
    (petal_width >= 1.7) => class=2 (48.0/2.0)
    (petal_length >= 5) => class=2 (5.0/1.0)
    (petal_length >= 3) => class=1 (47.0/0.0)
     => class=0 (50.0/0.0)
    """

    def __init__(
        self,
        folds: int = 3,
        min_weight: float = 2.0,
        optimizations: int = 2,
        check_error: bool = True,
        prune: bool = True,
        random_state: int | np.random.RandomState | None = None,
    ) -> None:
        self.folds = folds
        self.min_weight = min_weight
        self.optimizations = optimizations
        self.check_error = check_error
        self.prune = prune
        self.random_state = random_state

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = True
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Learn the rules.

        Parameters
        ----------
        X : array-like, shape (n_samples, n_features)
            Numbers; NaN where missing.
        y : array-like, shape (n_samples,)
            Class of each row.
        sample_weight : array-like, shape (n_samples,), optional
            Not negative; 1 by default.

        Returns
        -------
        self

        Raises
        ------
        ValueError
            For data or parameters out of range, or fewer rows than ``folds``.
        """
        self._check_parameters()
        values, targets = validate_data(self, X, y, dtype=np.float64, ensure_all_finite="allow-nan")
        if np.isinf(values).any():
            raise ValueError(
                "Input X contains infinity; RipperClassifier takes finite numbers, and NaN for missing ones"
            )
        check_classification_targets(targets)
        weights = _checked_weights(sample_weight, len(targets))
        n_samples = int((weights > 0.0).sum())
        if not n_samples:
            raise ValueError("sample_weight is zero for all rows; at least one weight must be above zero")
        if n_samples < self.folds:
            raise ValueError(
                f"n_samples = {n_samples} rows of positive weight are too few: RIPPER needs at least folds = "
                f"{self.folds} of them to split them into grow and prune rows"
            )
        self.classes_, labels = np.unique(targets, return_inverse=True)
        table = make_table(values, labels, weights, self.folds)
        self.rules_ = self._learn(table, len(self.classes_), check_random_state(self.random_state))
        return self

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Predict the class of each row: the most frequent one among the training rows its rule covers.

        Parameters
        ----------
        X : array-like, shape (n_samples, n_features)

        Returns
        -------
        ndarray, shape (n_samples,)
        """
        which = self.apply(X)
        return self.classes_[np.array([rule.prediction for rule in self.rules_])][which]

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:
        """Shares of the classes among the training rows that the rule of each row covers; not smoothed.

        Parameters
        ----------
        X : array-like, shape (n_samples, n_features)

        Returns
        -------
        ndarray, shape (n_samples, n_classes)
            In the order of ``classes_``.
        """
        which = self.apply(X)
        return np.array([rule.distribution for rule in self.rules_])[which]

    def apply(self, X: ArrayLike) -> NDArray[np.intp]:
        """Find the rule that decides each row.

        Parameters
        ----------
        X : array-like, shape (n_samples, n_features)

        Returns
        -------
        ndarray of int, shape (n_samples,)
            Index into ``rules_``.
        """
        check_is_fitted(self)
        rows = validate_data(self, X, dtype=np.float64, reset=False, ensure_all_finite="allow-nan")
        return first_match([rule.conditions for rule in self.rules_], rows)

    def to_text(self, feature_names: Sequence[str] | None = None) -> str:
        """Print the rules as JRip prints them: conditions, class, weight of covered rows / of errors among them.

        Parameters
        ----------
        feature_names : sequence of str, optional
            By default those of the training data, or ``state_0``, ``state_1`` and so on.
        """
        check_is_fitted(self)
        if feature_names is None:
            feature_names = getattr(self, "feature_names_in_", [f"state_{k}" for k in range(self.n_features_in_)])
        if len(feature_names) != self.n_features_in_:
            raise ValueError(f"{self.n_features_in_} names of features are needed, not {len(feature_names)}")
        return "\n".join(format_rule(rule, feature_names, self.classes_) for rule in self.rules_)

    def _check_parameters(self) -> None:
        check_scalar(self.folds, "folds", Integral, min_val=2)
        check_scalar(self.min_weight, "min_weight", Real, min_val=0.0)
        check_scalar(self.optimizations, "optimizations", Integral, min_val=0)
        check_scalar(self.check_error, "check_error", (bool, np.bool_))
        check_scalar(self.prune, "prune", (bool, np.bool_))

    def _learn(self, table: Table, n_classes: int, rng: np.random.RandomState) -> tuple[RipperRule, ...]:
        settings = Settings(self.folds, float(self.min_weight), self.optimizations, bool(self.prune))
        class_weights = np.bincount(table.labels, table.weights, minlength=n_classes)
        shuffled = rng.permutation(n_classes)
        ordered = shuffled[np.argsort(class_weights[shuffled], kind="stable")]
        left = np.ones(len(table.labels), dtype=np.bool_)
        rules: list[RipperRule] = []
        for position, label in enumerate(ordered[:-1]):
            positive = np.where(table.labels == label, table.weights, 0.0)
            if not positive[left].any():
                continue
            share = class_weights[label] / class_weights[ordered[position:]].sum()
            task = ClassTask(table, left, positive, float(share), bool(self.check_error))
            for candidate in learn_rules(task, settings, rng):
                taken = candidate.covers & left
                rules.append(RipperRule(candidate.conditions, int(label), _counts(table, taken, n_classes)))
                left = left & ~candidate.covers
        return (*rules, RipperRule((), int(ordered[-1]), _counts(table, left, n_classes)))


def first_match(rules: Sequence[tuple[Condition, ...]], rows: NDArray[np.float64]) -> NDArray[np.intp]:
    """Find the first rule that covers each row; the last one for rows that none covers.

    Parameters
    ----------
    rules : sequence of tuple of Condition
    rows : ndarray, shape (n_rows, n_features)

    Returns
    -------
    ndarray of int, shape (n_rows,)
    """
    which = np.full(len(rows), len(rules) - 1, dtype=np.intp)
    for index in range(len(rules) - 2, -1, -1):
        which[covered_by_all(rules[index], rows)] = index
    return which


def format_rule(rule: RipperRule, feature_names: Sequence[str], classes: Sequence[Any] | NDArray[Any]) -> str:
    """Print one rule in JRip's form; thresholds with at most 6 decimals."""
    conditions = " and ".join(
        f"({feature_names[c.feature]} {c.operator} {_six_decimals(c.threshold)})" for c in rule.conditions
    )
    covered = sum(rule.counts)
    return f"{conditions} => class={classes[rule.label]} ({covered:.1f}/{covered - rule.counts[rule.label]:.1f})"


def _six_decimals(value: float) -> str:
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _counts(table: Table, rows: Mask, n_classes: int) -> tuple[float, ...]:
    counts = np.bincount(table.labels[rows], table.weights[rows], minlength=n_classes)
    return tuple(float(count) for count in counts)


def _checked_weights(sample_weight: ArrayLike | None, n_rows: int) -> NDArray[np.float64]:
    if sample_weight is None:
        return np.ones(n_rows)
    weights = check_array(sample_weight, ensure_2d=False, dtype=np.float64, input_name="sample_weight")
    if weights.ndim != 1 or len(weights) != n_rows:
        raise ValueError(f"sample_weight must be of shape ({n_rows},), one weight per row, not {weights.shape}")
    if (weights < 0.0).any():
        raise ValueError("Negative values in sample_weight; weights must be 0 or more")
    return weights
