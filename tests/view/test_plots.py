"""Pictures show every chain to scale, and leave the process unchanged."""

import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import proj3d
from support.selection import few_of

from nrchain.errors import SceneError, TrajectoryError
from nrchain.scene.derived import modes_text
from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.one_chain import DISCERNIBLE
from nrchain.view.panels import SLENDER
from nrchain.view.plots import draw_chain, save_chain


def trajectory_of(positions, status="completed", **changes):
    snapshots, particles, _ = positions.shape
    scene = load_scene({"chain.particles": particles, "run.end": 10.0}, **changes)
    frames = np.broadcast_to(np.eye(3), (snapshots, particles, 3, 3))
    return Trajectory(
        np.linspace(0.0, 10.0, snapshots), positions, frames, scene, status=status, reason="contact"
    )


def bent(particles=20, snapshots=11, width=0.3):
    """Chains along x that grow an arc in y and a wave in z, ``width`` of their length wide."""
    u = np.linspace(0.0, 1.0, particles)
    length = 10.0 * (particles - 1)
    grown = np.linspace(0.0, width * length, snapshots)[:, None]
    return np.stack(
        np.broadcast_arrays(
            length * u, grown * np.sin(np.pi * u), 0.3 * grown * np.sin(2 * np.pi * u)
        ),
        axis=-1,
    )


@pytest.fixture
def figures(monkeypatch):
    """Every figure that is saved."""
    saved = []
    save = Figure.savefig

    def keeping_save(figure, *args, **kwargs):
        saved.append(figure)
        save(figure, *args, **kwargs)

    monkeypatch.setattr(Figure, "savefig", keeping_save)
    return saved


@pytest.mark.parametrize("view", ["planes", "3d"])
def test_a_title_in_a_script_the_font_lacks_does_not_warn(tmp_path, view):
    """Warnings are errors in tests."""
    trajectory = trajectory_of(bent(), title="鎖の座屈 चेन")
    assert save_chain(trajectory, tmp_path / "chain.png", view=view).stat().st_size > 0


def planes(figure):
    """The panels xy, xz and yz with the directions they show."""
    return dict(zip(((0, 1), (0, 2), (1, 2)), figure.axes, strict=False))


def inches_per_unit(axes):
    """The scales of a panel, horizontal and vertical."""
    width, height = axes.figure.get_size_inches()
    box = axes.get_position()
    return (
        box.width * width / np.diff(axes.get_xlim())[0],
        box.height * height / np.diff(axes.get_ylim())[0],
    )


def words(figure):
    return "\n".join(text.get_text() for text in figure.texts)


EXAMPLES = {
    "bent": bent(),
    "slender": bent(width=1e-3),
    "one snapshot": bent()[:1],
    "two spheres": bent(particles=2),
    "straight": bent(width=0.0),
    "across x": bent()[..., [1, 0, 2]],
    "a point": np.zeros((3, 2, 3)),
    "long": bent(particles=10_000, snapshots=2),
    "large": 1e9 * bent(),
}


@pytest.mark.parametrize("view", ["planes", "3d"])
@pytest.mark.parametrize(
    "example", few_of(EXAMPLES, {"bent", "two spheres", "a point", "long", "large"})
)
def test_any_chain_gives_a_picture(tmp_path, example, view):
    path = tmp_path / "chain.png"
    assert save_chain(trajectory_of(EXAMPLES[example]), path, view=view) == path
    image = matplotlib.image.imread(path)
    height, width = image.shape[:2]
    assert 300 < height < 2000
    assert 600 < width < 2400
    ink = np.any(image[..., :3] < 0.9, axis=-1)
    assert 0.002 < ink.mean() < 0.5


@settings(max_examples=10, deadline=None)
@given(
    seed=st.integers(0, 1000),
    exponents=st.tuples(*3 * [st.floats(-3, 5)]),
    shift=st.floats(-1e4, 1e4),
)
def test_every_sphere_is_inside_the_panels(tmp_path_factory, seed, exponents, shift):
    points = np.random.default_rng(seed).normal(size=(3, 5, 3)) * 10.0 ** np.array(exponents)
    points += shift
    saved = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", lambda figure, *args, **kwargs: saved.append(figure))
        save_chain(trajectory_of(points), tmp_path_factory.getbasetemp() / "unsaved.png")
    for plane, axes in planes(saved[0]).items():
        for direction, (low, high) in zip(plane, (axes.get_xlim(), axes.get_ylim()), strict=True):
            assert low < points[..., direction].min()
            assert points[..., direction].max() < high
        across, up = inches_per_unit(axes)
        assert plane != (1, 2) or np.isclose(across, up)


@pytest.mark.parametrize("width", [2 * SLENDER, 0.5 * SLENDER, 0.0])
def test_only_a_slender_chain_is_stretched_and_the_picture_says_so(tmp_path, figures, width):
    points = bent(width=width)
    points[..., 2] += 1e-12 * np.random.default_rng(0).normal(size=points.shape[:2])
    save_chain(trajectory_of(points), tmp_path / "chain.png")
    upper, lower = (planes(figures[0])[plane] for plane in ((0, 1), (0, 2)))
    assert inches_per_unit(upper) == pytest.approx(inches_per_unit(lower))
    along, across = inches_per_unit(upper)
    assert not upper.xaxis.get_tick_params()["labelbottom"]
    if width == 0.5 * SLENDER:
        assert 1.0 < np.ptp(upper.get_ylim()) / np.ptp(points[..., 1]) < 1.5
        assert f"stretched {float(f'{across / along:.2g}'):g} times" in words(figures[0])
    else:
        assert across == pytest.approx(along)
        assert "stretched" not in words(figures[0])


def test_spheres_are_to_scale_and_lengths_in_radii(tmp_path, figures):
    save_chain(trajectory_of(2.0 * bent(), **{"chain.radius": 2.0}), tmp_path / "chain.png")
    upper = planes(figures[0])[0, 1]
    assert len(upper.collections) == 6
    assert np.allclose(upper.collections[-1].get_offsets(), bent()[-1, :, :2])
    assert np.all(upper.collections[-1].get_widths() == 2.0)
    for line, spheres in zip(upper.lines, upper.collections, strict=True):
        assert tuple(spheres.get_facecolor()[0]) == tuple(line.get_color())
    assert upper.get_ylabel() == "y/a"


def test_a_long_chain_is_a_line(tmp_path, figures):
    save_chain(trajectory_of(bent(particles=DISCERNIBLE + 1)), tmp_path / "chain.png")
    upper = planes(figures[0])[0, 1]
    assert not upper.collections
    assert len(upper.lines) == 6


@pytest.mark.parametrize(("times", "drawn"), [(1, 1), (4, 4), (6, 6), (11, 11), (50, 11)])
def test_each_time_has_its_colour_in_the_bar(tmp_path, figures, times, drawn):
    points = bent(particles=DISCERNIBLE + 1)
    save_chain(trajectory_of(points), tmp_path / "chain.png", times=times)
    lines = planes(figures[0])[0, 1].lines
    colours = [tuple(line.get_color()) for line in lines]
    assert len(set(colours)) == len(lines) == drawn
    assert np.allclose(lines[0].get_ydata(), points[0, :, 1])
    if drawn > 1:
        assert np.allclose(lines[-1].get_ydata(), points[-1, :, 1])
        bar = figures[0].axes[-1]
        assert [tuple(colour) for colour in bar.images[0].get_array()[:, 0]] == colours
        labels = [label.get_text() for label in bar.get_yticklabels()]
        assert (labels[0], labels[-1]) == ("0", "10")
        low, high = bar.images[0].get_extent()[2:]
        fields = (bar.get_yticks() - low) / (high - low) * drawn
        middles = np.arange(drawn) + 0.5
        assert np.abs(fields[:, None] - middles).min(axis=1) == pytest.approx(0.0, abs=1e-9)
        assert fields[[0, -1]] == pytest.approx(middles[[0, -1]])


def test_the_title_of_a_picture_describes_the_run(tmp_path, figures):
    changes = {"title": "Costs $5, $x^", "slip.2s": 100, "chain.ends": "clamped"}
    save_chain(trajectory_of(bent(), status="stopped", **changes), tmp_path / "chain.svg")
    text = words(figures[0])
    for part in (r"Costs \$5, \$x^", "2s +100", "clamped ends", "N = 20", "stopped at t = 10"):
        assert part in text


@pytest.mark.parametrize(
    ("slip", "text"),
    [
        ({}, "passive"),
        ({"2s": 100, "3a": -5000}, "2s +100, 3a −5000"),
        ({"4a": [1.5, -2, 0]}, "4a −2 to +1.5"),
        ({"3t": [7, 7, 7]}, "3t +7"),
    ],
)
def test_modes_text(slip, text):
    assert modes_text(load_scene({"chain.particles": 3, "run.end": 1, "slip": slip}).slip) == text


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("chain.png", {"view": "top"}, "view = 'top': must be one of planes, 3d"),
        ("chain.png", {"times": 0}, "times = 0: must be at least 1"),
        ("chain.bmp", {}, "must end in one of .png, .pdf, .svg"),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path, name, options, message):
    with pytest.raises(SceneError, match=message):
        save_chain(trajectory_of(bent()), tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_a_trajectory_without_snapshots_is_refused(tmp_path):
    with pytest.raises(TrajectoryError, match="no finished snapshot"):
        save_chain(trajectory_of(np.zeros((0, 3, 3))), tmp_path / "chain.png")


def test_settings_of_matplotlib_stay_as_they_are(tmp_path):
    before = dict(matplotlib.rcParams)
    save_chain(trajectory_of(bent()), tmp_path / "chain.png")
    assert dict(matplotlib.rcParams) == before


def test_no_global_figure_machinery_is_loaded():
    program = """
import sys, tempfile, numpy as np
from nrchain.view.plots import save_chain
assert "matplotlib" not in sys.modules
from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.scene.derived import modes_text
scene = load_scene({"chain.particles": 3, "run.end": 1.0})
trajectory = Trajectory(np.zeros(1), np.zeros((1, 3, 3)), np.zeros((1, 3, 3, 3)), scene)
with tempfile.TemporaryDirectory() as directory:
    for view in "planes", "3d":
        save_chain(trajectory, directory + "/chain.png", view=view)
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def coloured(figure):
    return {tuple(np.round(line.get_color(), 6)) for line in figure.lines}


def test_one_panel_takes_and_returns_axes():
    trajectory = trajectory_of(bent())
    given = Figure().subplots()
    before = dict(matplotlib.rcParams)
    axes = draw_chain(trajectory, given, plane="xz", times=3)
    assert axes is given
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x/a", "z/a")
    assert len(axes.lines) == len(coloured(axes)) == 3
    assert np.allclose(axes.lines[-1].get_ydata(), bent()[-1, :, 2])
    assert axes.get_aspect() == 1.0
    assert draw_chain(trajectory).figure.get_size_inches()[0] == pytest.approx(3.375)
    assert draw_chain(trajectory, plane="3d").name == "3d"
    assert dict(matplotlib.rcParams) == before


def test_logarithmic_times_show_early_and_late_states(tmp_path):
    trajectory = trajectory_of(bent(snapshots=101))
    axes = draw_chain(trajectory, times=4, spacing="logarithmic")
    heights = [line.get_ydata().max() for line in axes.lines]
    every = bent(snapshots=101)[..., 1].max(axis=1)
    assert heights == pytest.approx(every[[0, 1, 10, 100]])
    assert save_chain(trajectory, tmp_path / "a.png", spacing="logarithmic").exists()


@pytest.mark.parametrize("plane", ["xy", "3d"])
def test_frames_are_drawn_where_they_point(plane):
    trajectory = trajectory_of(bent(snapshots=1))
    turned = trajectory.frames[..., [1, 2, 0], :]  # e1 along y, e2 along z
    trajectory = Trajectory(trajectory.time, trajectory.positions, turned, trajectory.scene)
    axes = draw_chain(trajectory, plane=plane, times=1, frames=True)
    _, e1, e2, heads = axes.lines
    thick, thin = (np.array(line.get_data_3d() if plane == "3d" else line.get_data()).T
                     for line in (e1, e2))  # fmt: skip
    for points, direction in ((thick, 1), (thin, 2)):
        begin, end = points[0::3], points[1::3]
        assert np.allclose(end - begin, 4.0 * np.eye(3)[direction][: points.shape[1]])
        assert len(begin) == 10
    assert e1.get_linewidth() > 2.0 * axes.lines[0].get_linewidth()
    key = axes.get_legend()
    assert [text.get_text() for text in key.get_texts()] == ["e₁", "e₂"]
    # the key shows what is drawn
    for shown, drawn in zip(key.get_lines(), (e1, e2), strict=True):
        assert shown.get_linewidth() == drawn.get_linewidth()
    shown = key.get_lines()[1]
    for name in ("marker", "markersize", "markerfacecolor", "markeredgewidth"):
        assert getattr(shown, f"get_{name}")() == getattr(heads, f"get_{name}")()


def test_spheres_are_to_scale_on_demand(tmp_path, figures):
    slender = trajectory_of(bent(width=1e-3))
    save_chain(slender, tmp_path / "chain.png", spheres="scale")
    upper = planes(figures[0])[0, 1]
    along, across = inches_per_unit(upper)
    assert along == pytest.approx(across)
    assert [np.all(one.get_widths() == 2.0) for one in upper.collections] == [True] * 6
    assert not draw_chain(trajectory_of(bent()), spheres="dots").collections
    many = trajectory_of(bent(particles=DISCERNIBLE + 1))
    assert len(draw_chain(many, spheres="scale", times=2).collections) == 2


def test_spheres_to_scale_in_perspective_cover_their_size():
    """Beside a helix whose radius is 30 of its spheres, a sphere is seen as 1/30 of it."""
    angle = np.linspace(0.0, 4.0 * np.pi, 20)
    helix = np.stack([angle, 30.0 * np.cos(angle), 30.0 * np.sin(angle)], axis=-1)
    axes = draw_chain(trajectory_of(helix[None]), plane="3d", times=1, spheres="scale")
    axes.figure.canvas.draw()
    (discs,) = axes.collections
    seen = [np.ptp(path.vertices, axis=0) for path in discs.get_paths()]
    # the height of the helix is foreshortened by the cosine of the elevation, that of a disc is not
    chain = proj3d.proj_transform(*helix.T, axes.get_proj())
    ratio = np.mean(seen, axis=0)[1] / np.ptp(chain[1]) * np.cos(np.radians(axes.elev))
    assert ratio == pytest.approx(1.0 / 30.0, rel=0.25)
    # each disc is round
    pixels = np.array(seen) * np.abs(
        axes.transData.transform([1, 1]) - axes.transData.transform([0, 0])
    )
    assert pixels[:, 0] == pytest.approx(pixels[:, 1], rel=0.05)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axes": "chain.png"}, "axes = 'chain.png': must be axes of matplotlib; a function save_"),
        ({"plane": "zx"}, "plane = 'zx': must be one of xy, xz, yz, 3d"),
        ({"spacing": "random"}, "spacing = 'random': must be one of linear, logarithmic"),
        ({"spheres": "big"}, "spheres = 'big': must be one of auto, scale, dots"),
    ],
)
def test_options_that_are_not_known_are_refused(options, message):
    with pytest.raises(SceneError, match=message):
        draw_chain(trajectory_of(bent()), **options)
