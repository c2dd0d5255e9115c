"""The figures of the paper: what they show, and what they look like."""

from functools import cache

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.text import Text
from support.grey_figures import COARSE, TOLERANCE, difference, grey, stored

from nrchain.errors import SceneError
from nrchain.figures import evolution, figure_1, figure_3, figure_4, figure_7, response, squirmer
from nrchain.figures.catalogue import NUMBERS, draw_figure
from nrchain.view.style import LEAST_CONTRAST, WIDTHS, contrast

WHITE = (1.0, 1.0, 1.0)


@cache
def sheet(number):
    return draw_figure(number, detail=COARSE)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_figure_looks_as_the_stored_picture(number):
    """Letters of another font, or lines half a dot away, stay within the tolerance."""
    assert difference(grey(sheet(number).figure), stored(f"figure-{number}")) < TOLERANCE


def test_the_comparison_notices_a_panel_that_is_left_out_and_passes_another_font():
    whole = stored("figure-4")
    rest = whole.copy()
    height, width = whole.shape
    rest[: height // 2, 2 * width // 3 :] = 1.0
    assert difference(whole, rest) > 1.3 * TOLERANCE
    assert difference(whole, np.roll(whole, 6, axis=1)) > 1.3 * TOLERANCE
    with matplotlib.rc_context({"font.family": "serif"}):
        assert difference(grey(draw_figure("3").figure), stored("figure-3")) < TOLERANCE


@pytest.mark.parametrize("number", NUMBERS)
def test_each_line_is_seen_on_white_and_letters_are_small(number):
    figure = sheet(number).figure
    assert figure.get_size_inches()[0] == WIDTHS["two"]
    for axes in figure.axes:
        for line in axes.lines:
            if line.get_linestyle() not in ("None", "") and to_rgb(line.get_color()) != WHITE:
                assert contrast(line.get_color()) >= LEAST_CONTRAST
            if line.get_marker() not in ("None", ""):
                assert contrast(line.get_markeredgecolor()) >= LEAST_CONTRAST
    sizes = {text.get_size() for text in figure.findobj(Text) if text.get_text().strip()}
    assert min(sizes) >= 6.0
    assert max(sizes) <= 8.0
    assert figure.get_suptitle() == ""


@pytest.mark.parametrize("number", ["4", "5", "6", "7"])
def test_waves_have_a_key_of_each_kind_of_line(number):
    axes = sheet(number).figure.axes[1]
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words[-3:] == ["law", "lattice", "runs"]
    assert len(words) == 2 + 3
    looks = {line.get_linestyle() for line in axes.lines}
    assert len(looks) == 3


def evolutions(number):
    """The panels (d) and (e) of a figure: axes with chains at four times."""
    return [one for one in sheet(number).figure.axes[4:] if len(one.lines) == 4]


@pytest.mark.parametrize("number", ["4", "5", "6"])
def test_times_differ_in_marks_and_chains_fill_their_panels(number):
    panels = evolutions(number)
    assert len(panels) == {"6": 1}.get(number, 4)
    for axes in panels:
        assert len({line.get_marker() for line in axes.lines}) == 4
        x = np.concatenate([line.get_xdata() for line in axes.lines])
        left, right = axes.get_xlim()
        assert left < x.min()
        assert x.max() < right
        assert np.ptp(x) > 0.9 * (right - left)
    # y and z have one scale: the larger of both extents fills a third of the height or more
    parts = [np.concatenate([one.get_ydata() for one in axes.lines]) for axes in panels[:2]]
    extents = [np.ptp(y) / np.ptp(axes.get_ylim()) for y, axes in zip(parts, panels, strict=False)]
    assert 0.3 < max(extents) < 0.9


@pytest.mark.parametrize("number", ["4", "5"])
def test_a_panel_says_how_far_it_is_stretched(number):
    figure = sheet(number).figure
    figure.canvas.draw()
    for axes in evolutions(number)[::2]:
        wide, tall = axes.get_window_extent().size
        scales = wide / np.ptp(axes.get_xlim()), tall / np.ptp(axes.get_ylim())
        words = axes.get_title(loc="right")
        stated = float(words.split()[-2]) if words else 1.0
        assert scales[1] / scales[0] == pytest.approx(stated, rel=0.03)


def test_frames_are_in_the_panels_and_in_the_key():
    panels = evolutions("7")[:2]
    for vector, size in enumerate(evolution.LENGTHS):
        parts = []
        for axes in panels:
            width = evolution.THICKNESSES[vector]
            drawn = [one for one in axes.collections if one.get_linewidths()[0] == width]
            assert len(drawn) == 4
            parts.append(
                np.concatenate([72.0 * np.array(one.get_segments())[:, 1] for one in drawn])
            )
        # both views together show the whole vector: x, y and x, z
        (x, y), (_, z) = (part.T for part in parts)
        assert np.sqrt(x**2 + y**2 + z**2) == pytest.approx(np.full(len(x), size))
    axes = panels[1]
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words[-2:] == ["$e_1$", "$e_2$"]


def test_one_column_has_panels_that_are_read():
    figure = draw_figure("4", width="one", detail=COARSE).figure
    wide, high = figure.get_size_inches()
    assert (wide, high <= 9.3) == (WIDTHS["one"], True)
    for axes in figure.axes:
        box = axes.get_window_extent()
        if axes.get_xlabel():
            assert box.height / figure.dpi > 0.4
            assert box.width / figure.dpi > 1.0
    chain = figure.axes[1]
    assert chain.get_xlim()[1] - chain.get_xlim()[0] < 160.0


def test_settings_of_matplotlib_neither_change_nor_count():
    before = dict(matplotlib.rcParams)
    plain = grey(draw_figure("3").figure)
    assert dict(matplotlib.rcParams) == before
    given = {"axes.facecolor": "red", "lines.linewidth": 9, "legend.frameon": True}
    with matplotlib.rc_context(given):
        assert difference(grey(draw_figure("3").figure), plain) < TOLERANCE


@pytest.mark.parametrize("width", WIDTHS)
def test_a_figure_fits_its_columns(width):
    figure = draw_figure("3", width=width, title=True).figure
    assert figure.get_size_inches()[0] == WIDTHS[width]
    assert "Constitutive" in figure.get_suptitle()
    figure.canvas.draw()
    box = figure.get_tightbbox()
    assert box.x0 > -0.1
    assert box.x1 < WIDTHS[width] + 0.1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"number": "2"}, "figure = '2': must be one of 1, 3, 4, 5, 6, 7"),
        ({"number": 1, "width": "three"}, "width = 'three': must be one of one, two"),
    ],
)
def test_other_figures_are_refused(given, message):
    with pytest.raises(SceneError, match=message):
        draw_figure(**given)


# What panels show, against laws written here.


def test_forces_of_two_pushers_are_those_of_the_law():
    """F = 6π (7/6r²)(3c² − 1) n and T = 8π (7/2r³) c (e × n), before and after the motion."""
    for moved in (False, True):
        positions, frames = figure_1.poses(moved)
        force, torque = figure_1.forces(moved)
        for i, j in ((0, 1), (1, 0)):
            away = positions[i] - positions[j]
            r = np.linalg.norm(away)
            n, e = away / r, frames[j, 0]
            c = n @ e
            assert force[i] == pytest.approx(6 * np.pi * 7 / (6 * r**2) * (3 * c**2 - 1) * n)
            expected = 8 * np.pi * 7 / (2 * r**3) * c * np.cross(e, n)
            assert torque[i] == pytest.approx(expected)


def test_the_second_frame_of_reference_differs_by_a_rigid_motion():
    here, there = figure_1.poses(False), figure_1.poses(True)
    turn = figure_1.rotation(figure_1.TURN)
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1.0)
    assert there[0] == pytest.approx(here[0] @ turn.T + figure_1.SHIFT)
    assert np.linalg.norm(figure_1.forces(False)[0].sum(axis=0)) > 1.0
    remark = sheet("1").remarks[0]
    assert float(remark.split(" to ")[1].split()[0]) < 1e-12


def test_tracers_of_a_source_dipole_feel_its_law():
    points = squirmer.tracers("3t")
    found = squirmer.flow_of("3t", points)
    r = np.linalg.norm(points, axis=1, keepdims=True)
    n, e = points / r, np.array([1.0, 0.0, 0.0])
    law = -(e - 3.0 * (n @ e)[:, None] * n) / (5.0 * r**3)
    assert np.allclose(found.velocity, law, rtol=1e-12)
    assert np.allclose(found.vorticity, 0.0, atol=1e-15)


@pytest.mark.parametrize("label", ["2s", "3a", "3t", "4a"])
def test_flow_is_that_of_pystokes(label):
    assert squirmer.misfit_of_pystokes(label) < 1e-12


def test_what_forces_a_displaced_chain_feels():
    """2s pushes along the displacement, 3a and 4a across the plane, 3t along the chain."""
    positions, push = response.forces("2s", 1.0)
    assert push[:, 1] @ positions[:, 1] > 0.0
    assert np.allclose(response.forces("2s", -1.0)[1], -push)
    for label in ("3a", "4a"):
        _, force = response.forces(label, 1.0)
        assert np.allclose(force[:, :2], 0.0, atol=1e-12 * np.abs(force).max())
    _, along = response.forces("3t", 1.0)
    assert np.all(along[:, 0] > np.abs(along[:, 1]))
    # 3a acts as the third derivative of the displacement and 4a as the second, a quarter wave apart
    third, second = (response.forces(label, 1.0)[1][:, 2] for label in ("3a", "4a"))
    sine = positions[:, 1]
    cosine = np.roll(sine, -response.PARTICLES // 4)
    assert abs(second @ sine) > 5.0 * abs(second @ cosine)
    assert abs(third @ cosine) > 5.0 * abs(third @ sine)


def test_measured_waves_follow_the_lattice():
    waves = figure_4.MODE.waves
    q, rate = waves.measured(100.0, 16)
    law = 7.0 / 3.0 * 100.0 / 1e3 * (10.0 * q) ** 2 - (10.0 * q) ** 4
    assert q == pytest.approx(2.0 * np.pi / 160.0)
    assert rate.real == pytest.approx(law, rel=0.05)
    assert rate == pytest.approx(waves.lattice(100.0, np.array([q]))[0], rel=1e-3)
    spinning = figure_7.MODE.waves
    q, rate = spinning.measured(1e4, 28)
    law = 363.0 / 10.0 / 1e5 * 1e4 * (10.0 * q) ** 2
    assert spinning.shown(q, rate) == pytest.approx(-law / q, rel=0.05)


def test_constitutive_relations_of_pushers():
    """C_par_Fε = 14/3, C_perp_Fε = −7/3 a²/d² γ_T V: half the size and of other sign."""
    table, largest = figure_3.responses("2s")
    assert largest == pytest.approx(14.0 / 3.0 / 100.0)
    assert [name for name, _, _ in figure_3.entries(table, 0)] == ["F₁"]
    shear = {name: value for name, value, _ in figure_3.entries(table, 1)}
    assert shear["F₂"] == pytest.approx(-0.5)
    assert set(shear) == {"F₂", "m₃"}
    assert figure_3.entries(table, 3) == []


def test_the_shade_covers_the_fluid_alone():
    axes = sheet("4").figure.axes[0]
    (mesh,) = (one for one in axes.collections if isinstance(one, QuadMesh))
    values = np.ma.filled(mesh.get_array(), np.nan).reshape(31, 31)
    assert np.isnan(values[15, 15])
    assert np.isfinite(values[0]).all()
    assert isinstance(axes.lines[0], Line2D)
