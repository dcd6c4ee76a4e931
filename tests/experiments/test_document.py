"""Documents: Markdown and HTML of the same blocks."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rcss_hat.experiments.document import Code, Document, FigureBlock, Heading, Paragraph, TableBlock
from rcss_hat.experiments.figures import learning_curve_figure
from rcss_hat.experiments.metrics import Curves
from rcss_hat.experiments.predictors import FIGURES, predict, predictor_figure


def test_blocks_become_markdown_html_and_files(tmp_path: Path) -> None:
    curves = {"a": Curves(np.array([1.0, 2.0]), np.array([[5.0, 6.0], [5.5, 6.5]]))}
    document = Document("A & B")
    document.add(
        Heading("Part", 2),
        Paragraph("**Bold** and `code` < 1"),
        TableBlock(pd.DataFrame({"Name": ["a|b", "**c**"], "Value": ["1", "2"]}), name="numbers"),
        FigureBlock(learning_curve_figure(curves), "one", "A figure"),
        FigureBlock(learning_curve_figure(curves), "two", "The same"),
        Code("if x <= 1"),
    )
    markdown, page = document.save(tmp_path)
    text, html = markdown.read_text(), page.read_text()
    assert "## Part" in text and r"| a\|b | 1 |" in text and "| --- | ---: |" in text and "(figures/one.png)" in text
    assert "<h1>A &amp; B</h1>" in html and "<strong>Bold</strong> and <code>code</code> &lt; 1" in html
    assert "<pre><code>if x &lt;= 1</code></pre>" in html and html.count("<svg") == 2
    ids = [part.split('"')[0] for part in html.split('id="')[1:]]
    assert len(ids) == len(set(ids)) > 10
    assert (tmp_path / "tables" / "numbers.csv").read_text() == "Name,Value\na|b,1\nc,2\n"
    assert {p.name for p in (tmp_path / "figures").iterdir()} == {"one.png", "one.svg", "two.png", "two.svg"}


def test_texts_of_a_study_are_texts_in_the_page(tmp_path: Path) -> None:
    hostile = "<script>alert('$x^$')</script> & \"**<b>**\" `<i>`"
    curves = {hostile: Curves(np.array([1.0, 2.0]), np.array([[5.0, 6.0], [5.5, 6.5]]))}
    document = Document(hostile)
    document.add(
        Heading(hostile, 3),
        Paragraph(hostile),
        TableBlock(pd.DataFrame({hostile: [hostile]}), prose=True),
        FigureBlock(learning_curve_figure(curves, {hostile: 5.0}, hostile), "one", hostile),
        Code(hostile),
    )
    _, page = document.save(tmp_path)
    html = page.read_text()
    assert not {"<script", "<b>", "<i>"} & set(re.findall(r"<\w+>?", html))
    assert html.count("&lt;script&gt;") >= 8 and html.count("<strong>&lt;b&gt;</strong>") == 6
    ET.fromstring(html.replace("<!doctype html>", "").replace('<meta charset="utf-8">', "").replace('1">', '1"/>', 1))


def sets(n: int) -> pd.DataFrame:
    rng = np.random.default_rng(1)
    frame = pd.DataFrame({name: rng.normal(size=n) for name in FIGURES})
    frame["rules"] = 3.0  # says nothing
    frame["jumpstart"] = 2.0 * frame["mean_s"] + 0.2 * rng.normal(size=n)
    return frame.assign(set=[f"s{k}" for k in range(n)], pool=["A", "B"] * (n // 2))


def test_the_figure_that_decides_is_found() -> None:
    prediction = predict(sets(60), "jumpstart", seed=0)
    best = prediction.correlations.iloc[0]
    assert prediction.correlations.index[0] == "mean_s" and 0.9 < best["low"] < best["rho"] < best["high"] <= 1.0
    assert "rules" not in prediction.correlations.index
    assert prediction.r2_linear > 0.95 and 0.3 < prediction.r2_forest < prediction.r2_linear
    other = prediction.correlations.loc["coverage"]
    assert other["low"] < 0.0 < other["high"]
    assert len(predictor_figure(prediction).axes) == 3


def test_a_few_sets_predict_nothing() -> None:
    with pytest.raises(ValueError, match="from 8 sets"):
        predict(sets(8), "jumpstart", seed=0)
