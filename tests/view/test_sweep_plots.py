"""Pictures of sweeps: what they draw, along which keys, and what they refuse."""

import numpy as np
import pytest

import nrchain
from nrchain import sweep_plots
from nrchain.errors import SceneError
from nrchain.sweeps.result import Sweep
from nrchain.view.sweep_units import label

SCENE = nrchain.load_scene("buckling", **{"chain.particles": 4})


def swept(points, names=("end.size", "measure.attractor")):
    """A sweep of results as its ledger has them: values of keys, then observables or None."""
    results = {}
    for place, (values, found) in enumerate(points):
        observed = {} if found is None else dict(zip(names, found, strict=False))
        ended = {"failed": "why"} if found is None else {"outcome": "completed"}
        results[f"{place:016x}"] = {"point": values, "observables": observed, **ended}
    return Sweep.of(SCENE, results, None)


def grid(xs=(0.0, 1.0, 3.0), ys=(0.0, 10.0)):
    return swept(
        [
            ({"slip.2s": x, "slip.3t": y}, (x + y, "straight" if x < 2.0 else "buckled"))
            for x in xs
            for y in ys
        ]
    )


def test_lines_have_the_values_of_each_second_key():
    axes = sweep_plots.draw_lines(grid(), "end.size", "slip.2s", by="slip.3t")
    assert [line.get_label() for line in axes.lines] == ["slip.3t = 0", "slip.3t = 10"]
    for line, y in zip(axes.lines, (0.0, 10.0), strict=True):
        assert line.get_xdata().tolist() == [0.0, 1.0, 3.0]
        assert line.get_ydata().tolist() == [y, 1.0 + y, 3.0 + y]
    unit = r"\mu/\gamma_T d^2"
    assert axes.get_xlabel() == rf"slip.2s  [$a\,{unit}$]"
    assert axes.get_ylabel() == "end.size  [$a$]"


def test_units_are_named_only_where_all_points_have_those_of_the_paper():
    assert label("end.size", SCENE, ("slip.2s",)) == "end.size  [$a$]"
    assert label("end.size", SCENE, ("chain.radius",)) == "end.size"
    other = nrchain.load_scene(SCENE, **{"elasticity.bend": 1.0})
    assert label("end.time", other, ("slip.2s",)) == "end.time"
    assert label("measure.straightness", SCENE, ("slip.2s",)) == "measure.straightness"


def test_small_numbers_stand_at_their_ticks_and_counts_of_spheres_are_whole():
    points = [({"chain.particles": n}, (n * 1e-7,)) for n in (4, 5)]
    axes = sweep_plots.draw_lines(swept(points), "end.size", "chain.particles")
    axes.figure.canvas.draw()
    assert axes.yaxis.get_offset_text().get_text() == ""
    assert "4.4e−07" in [text.get_text() for text in axes.get_yticklabels()]
    assert all(float(tick).is_integer() for tick in axes.get_xticks())


def test_a_map_has_the_value_of_each_point_around_it():
    axes = sweep_plots.draw_map(grid(), "end.size", "slip.2s", "slip.3t")
    (mesh,) = axes.collections
    assert mesh.get_array().tolist() == [[0.0, 1.0, 3.0], [10.0, 11.0, 13.0]]
    corners = mesh.get_coordinates()
    assert corners[0, :, 0].tolist() == [-0.5, 0.5, 2.0, 4.0]
    assert corners[:, 0, 1].tolist() == [-5.0, 5.0, 15.0]


def test_words_have_a_colour_and_a_marker_each():
    axes = sweep_plots.draw_map(grid(), "measure.attractor", "slip.2s", "slip.3t")
    drawn = {one.get_label(): one.get_offsets().tolist() for one in axes.collections}
    assert set(drawn) == {"straight", "buckled"}
    assert sorted(drawn["buckled"]) == [[3.0, 0.0], [3.0, 10.0]]
    colours = {tuple(one.get_facecolor()[0]) for one in axes.collections}
    assert len(colours) == 2
    lines = sweep_plots.draw_lines(grid(), "measure.attractor", "slip.2s")
    assert [text.get_text() for text in lines.get_yticklabels()] == ["straight", "buckled"]
    assert lines.lines[0].get_ydata().tolist() == [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]


def test_points_that_fill_no_grid_are_points_and_failures_are_crosses():
    points = [({"slip.2s": x, "slip.3t": x**2}, (x,)) for x in (1.0, 2.0, 3.0)]
    failed = ({"slip.2s": 4.0, "slip.3t": 2.0}, None)
    axes = sweep_plots.draw_map(swept([*points, failed]), "end.size", "slip.2s", "slip.3t")
    found, missing = axes.collections
    assert found.get_array().tolist() == [1.0, 2.0, 3.0]
    assert missing.get_offsets().tolist() == [[4.0, 2.0]]
    assert missing.get_label() == "no value"


def test_values_of_constant_ratio_have_a_logarithmic_axis():
    values = np.geomspace(1.0, 1000.0, 7).tolist()
    found = swept([({"elasticity.ratio": x}, (x,)) for x in values])
    axes = sweep_plots.draw_lines(found, "end.size", "elasticity.ratio")
    assert axes.get_xscale() == "log"
    assert sweep_plots.draw_lines(grid(), "end.size", "slip.2s").get_xscale() == "linear"


def test_given_axes_are_drawn_on_and_returned():
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    assert sweep_plots.draw_lines(grid(), "end.size", "slip.2s", axes=axes) is axes
    assert sweep_plots.draw_map(grid(), "end.size", "slip.2s", "slip.3t", axes=axes) is axes


def test_many_values_of_a_second_key_make_a_map_and_keys_not_drawn_are_told(tmp_path):
    from matplotlib.image import imread

    found = swept(
        [
            ({"slip.2s": x, "slip.3t": y, "chain.particles": n}, (x * y + n,))
            for x in (1.0, 2.0)
            for y in range(8)
            for n in (4, 5)
        ]
    )
    path, others = sweep_plots.save_sweep(found, tmp_path / "a.png")
    assert others == {"chain.particles": 4}
    assert imread(path).std() > 0.05
    _, others = sweep_plots.save_sweep(found, tmp_path / "b.png", at={"chain.particles": 5})
    assert others == {}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"x": "slip.4a"}, "must be a key of the sweep: slip.2s, slip.3t"),
        ({"x": "slip.2s", "y": "slip.2s"}, "must differ from x"),
        ({"at": {"slip.2s": 7.0}}, "not drawn"),
        ({"x": "slip.2s", "y": None, "at": {"slip.9a": 7.0}}, "not drawn"),
    ],
)
def test_other_keys_are_refused(given, words, tmp_path):
    with pytest.raises(SceneError, match=words):
        sweep_plots.save_sweep(grid(), tmp_path / "a.png", **given)
    assert not (tmp_path / "a.png").exists()
