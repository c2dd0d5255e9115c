"""Pictures of branches: stable parts solid, unstable ones dashed, special points marked."""

from functools import cache

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.view.branch_plots import MARKERS, draw_branches, save_branches


@cache
def branches():
    changes = {"chain.particles": 6, "elasticity.ratio": 1e8, "elasticity.measure": "isotropic"}
    scene = nrchain.load_scene("buckling", **changes)
    return nrchain.continue_state(scene, {"slip.2s": (700.0, 900.0)}, branches=2)


def figure_of(monkeypatch, found, path):
    from matplotlib.figure import Figure

    kept = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda f, *a, **k: (kept.append(f), save(f, *a, **k)))
    assert save_branches(found, path) == path
    return kept[0]


def test_stability_and_special_points_are_drawn(tmp_path, monkeypatch):
    found = branches()
    figure = figure_of(monkeypatch, found, tmp_path / "branches.png")
    (panel,) = figure.axes  # nothing moves as a whole
    special = found.special[0]
    marks = [line for line in panel.lines if line.get_marker() == MARKERS["pitchfork"][0]]
    assert [mark.get_xdata()[0] for mark in marks] == [special.value]
    dashed = [line for line in panel.lines if line.get_linestyle() != "-" and line not in marks]
    assert len(dashed) == 1
    assert dashed[0].is_dashed()
    # the straight chain is unstable from the special point on
    assert dashed[0].get_xdata()[0] == special.value
    assert dashed[0].get_xdata()[-1] == 900.0
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(words) == ["pitchfork", "stable", "unstable"]
    heights = np.concatenate([line.get_ydata() for line in panel.lines])
    assert heights.max() == pytest.approx(found.branches[1].amplitude.max())


def test_another_ending_is_refused():
    with pytest.raises(SceneError, match="must end in one of"):
        save_branches(branches(), "branches.txt")


def test_one_quantity_is_drawn_on_axes_of_a_caller():
    from matplotlib.figure import Figure

    found, axes = branches(), Figure().subplots()
    assert draw_branches(found, axes) is axes
    heights = np.concatenate([line.get_ydata() for line in axes.lines])
    assert heights.max() == pytest.approx(found.branches[1].amplitude.max())
    assert axes.get_legend() is not None
    assert draw_branches(found, quantity="speed", key=False).get_legend() is None
    with pytest.raises(SceneError, match="must be one of amplitude, speed, spin"):
        draw_branches(found, quantity="mass")
