"""Pictures of phase diagrams: each kind in the key, thresholds as lines."""

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import nrchain
from nrchain.diagrams.curves import Curve
from nrchain.diagrams.diagram import PhaseDiagram
from nrchain.diagrams.linear import Length
from nrchain.diagrams.mesh import Mesh
from nrchain.diagrams.plane import Axis, Plane
from nrchain.diagrams.regions import connected
from nrchain.diagrams.trials import PhasePoint, Trial
from nrchain.errors import SceneError
from nrchain.view.phase_plots import DARK, LOOKS, draw_phases, save_phases
from nrchain.view.style import INK, LEAST_CONTRAST, PAPER, contrast

KINDS = {(0, 0): ["straight"], (1, 0): ["buckled"], (0, 1): ["straight", "irregular"]}


def diagram():
    """Four points: three kinds, and one point with two of them."""
    scene = nrchain.load_scene("buckling", **{"chain.particles": 5, "title": "a $ sign"})
    plane = Plane(scene, Axis("slip.2s", 0.0, 1.0, 2), Axis("slip.3t", 0.0, 4.0, 2), 0)
    mesh, points = Mesh(plane), {}
    for site in mesh.sites():
        kinds = KINDS.get(site, ["straight"])
        trials = tuple(
            Trial(f"random:{n}", kind, 1.0, None, {}, 2.0, Length(2.0, 5), 7, 0.1, "")
            for n, kind in enumerate(kinds)
        )
        points[site] = PhasePoint(site, *plane.place(site), -0.1, 0.0, trials)
    line = np.array([0.2, 0.8])
    curves = [Curve(line, 4.0 * line, 0 * line, 0 * line, f * np.ones(2)) for f in (0.0, 0.3)]
    regions = tuple(connected(plane, mesh, points))
    ends = tuple(curves), tuple(mesh.cells), (), True
    return PhaseDiagram(
        scene, plane.x, plane.y, 0, ("random:0", "random:1"), tuple(points.values()), regions, *ends
    )


@pytest.fixture
def figure(tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    kept = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda f, *a, **k: (kept.append(f), save(f, *a, **k)))
    assert save_phases(diagram(), tmp_path / "d.png") == tmp_path / "d.png"
    return kept[0]


def test_the_key_names_each_kind_and_each_threshold(figure):
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [
        *("buckled", "straight", "irregular or straight"),
        *("straight chain buckles", "straight chain flutters"),
    ]


def test_quarters_fill_the_plane(figure):
    (axes,) = figure.axes
    fills = [one for one in axes.collections if isinstance(one, PolyCollection)]
    areas = [np.prod(np.ptp(path.vertices, axis=0)) for one in fills for path in one.get_paths()]
    assert areas == pytest.approx([0.5 * 2.0] * 4)


def test_thresholds_are_told_apart_without_colour(figure):
    (axes,) = figure.axes
    assert len(axes.lines) == 2
    assert len({line.get_linestyle() for line in axes.lines}) == 2


def test_kinds_are_told_apart_in_grey():
    assert len({marker for _, marker in LOOKS.values()}) == len(LOOKS)
    grey = [float(np.dot([0.299, 0.587, 0.114], to_rgb(colour))) for colour, _ in LOOKS.values()]
    assert min(np.diff(sorted(grey[:9]))) > 0.04


def test_other_endings_are_refused(tmp_path):
    with pytest.raises(SceneError, match="must end in one of"):
        save_phases(diagram(), tmp_path / "d.gif")


def test_a_diagram_is_drawn_on_axes_of_a_caller():
    before, axes = dict(matplotlib.rcParams), Figure().subplots()
    assert draw_phases(diagram(), axes) is axes
    assert len(axes.get_legend().get_texts()) == 5
    assert axes.get_xlabel() == "slip.2s"
    assert draw_phases(diagram(), key=False).get_legend() is None
    assert dict(matplotlib.rcParams) == before
    with pytest.raises(SceneError, match="must be axes of matplotlib"):
        draw_phases(diagram(), "d.png")


def test_markers_are_seen_on_the_colour_of_their_kind():
    for colour, _ in LOOKS.values():
        ink = PAPER if colour in DARK else INK
        ratio = contrast(colour) / contrast(ink)
        assert max(ratio, 1.0 / ratio) >= LEAST_CONTRAST
