"""The rule learner on any table: ``python examples/ripper_on_any_table.py [TABLE.csv --label COLUMN]``.

`RipperClassifier` is a classifier of scikit-learn: cross-validation, pipelines and searches take it. Without a table it
learns Fisher's irises.
"""

from __future__ import annotations

import argparse

import pandas as pd
from sklearn.datasets import load_iris
from sklearn.model_selection import cross_val_score

from rcss_hat import RipperClassifier


def irises() -> tuple[pd.DataFrame, pd.Series]:
    data = load_iris(as_frame=True)
    names = [name.removesuffix(" (cm)").replace(" ", "_") for name in data.feature_names]
    return data.data.set_axis(names, axis=1), data.target.map(dict(enumerate(map(str, data.target_names))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", nargs="?", help="a CSV file; its numeric columns are the variables")
    parser.add_argument("--label", help="the column to be predicted")
    parser.add_argument("--seed", type=int, default=0)
    o = parser.parse_args()
    if bool(o.table) != bool(o.label):
        parser.error("a table needs --label COLUMN, and the other way round")
    if o.table:
        table = pd.read_csv(o.table)
        if o.label not in table:
            parser.error(f"{o.table} has no column {o.label!r}; it has {', '.join(table)}")
        X, y = table.drop(columns=o.label).select_dtypes("number"), table[o.label]
    else:
        X, y = irises()
    learner = RipperClassifier(random_state=o.seed)
    scores = cross_val_score(learner, X, y, cv=10)
    print(learner.fit(X, y).to_text())
    print(f"accuracy in ten-fold cross-validation: {100 * scores.mean():.1f} % (always the same answer: "
          f"{100 * y.value_counts(normalize=True).max():.1f} %)")  # fmt: skip


if __name__ == "__main__":
    main()
