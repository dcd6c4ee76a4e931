from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rcss_hat.experiments.figures import learning_curve_figure, save_figure
from rcss_hat.experiments.metrics import Curves


def curves(n_trials: int = 5) -> dict[str, Curves]:
    random, hours = np.random.default_rng(0), np.arange(0.5, 30.1, 0.5)
    means = {"No Prior": (6.0, 14.3, 9.0), "PPR": (6.5, 15.2, 5.0), "Extra Action": (5.5, 16.0, 6.0)}
    return {
        label: Curves(
            hours, end - (end - first) * np.exp(-hours / pace) + random.normal(0, 0.3, (n_trials, len(hours)))
        )
        for label, (first, end, pace) in means.items()
    }


def test_a_figure_shows_every_curve_and_line() -> None:
    figure = learning_curve_figure(curves(), {"Teacher A": 10.4, "Threshold": 14.0}, "Figure 3")
    (axes,) = figure.axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == [
        "No Prior (5 trials)",
        "PPR (5 trials)",
        "Extra Action (5 trials)",
        "Teacher A (10.4 s)",
        "Threshold (14.0 s)",
    ]
    assert axes.get_title() == "Figure 3"
    assert "hours" in axes.get_xlabel() and "(s)" in axes.get_ylabel()
    drawn = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert len({line.get_color() for line in drawn}) == 3
    for line, curve in zip(drawn, curves().values(), strict=True):
        assert np.allclose(line.get_ydata(), curve.mean)


def test_error_bars_are_standard_errors() -> None:
    known = curves()
    figure = learning_curve_figure(known)
    container = figure.axes[0].containers[0]
    (bars,) = container.lines[2]
    segments = bars.get_segments()
    error = known["No Prior"].standard_error
    assert len(segments) >= 10
    assert (segments[0][1, 1] - segments[0][0, 1]) / 2 == pytest.approx(error[0])


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_figures_are_written(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"figure.{ending}"
    save_figure(learning_curve_figure(curves(n_trials=1)), path)
    assert path.read_bytes()[:5] in (b"\x89PNG\r", b"<?xml", b"%PDF-")


def test_a_figure_without_curves_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one curve"):
        learning_curve_figure({})
