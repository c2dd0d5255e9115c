"""Pictures of cycles: stable parts solid, unstable ones dashed, special points marked."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import nrchain
from nrchain.errors import SceneError
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.varied import Line
from nrchain.view.branch_plots import MARKERS
from nrchain.view.cycle_plots import draw_cycles, save_cycles


def diagram():
    """A branch that loses stability at a period doubling between its second and third cycle."""
    scene = nrchain.load_scene("buckling", **{"chain.particles": 4})
    line = Line(scene, {"slip.3t": (0.0, 4.0)})
    still = np.zeros((1, 3, 4, 3)), np.zeros((1, 3, 4, 3, 3))
    orbit = Orbit(5.0, np.zeros(7), np.ones(1), *still)
    special = nrchain.SpecialCycle("period doubling", 2.5, 1e-6, np.pi, 1, 1, orbit)
    values = np.arange(1.0, 5.0)
    branch = nrchain.CycleBranch(
        line=line,
        values=values,
        periods=10.0 - values,
        amplitudes=np.sqrt(values),
        multipliers=np.zeros((4, 2), complex),
        unstable=np.array([0, 0, 1, 1]),
        errors=np.zeros(4),
        special=(special,),
        reasons=("", ""),
        origin=np.zeros(3),
        orbits=(orbit,) * 4,
    )
    return nrchain.CycleDiagram(line, (branch,))


def test_amplitude_and_period_are_drawn_with_special_points(tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    kept, save = [], Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda f, *a, **k: (kept.append(f), save(f, *a, **k)))
    assert save_cycles(diagram(), tmp_path / "cycles.png") == tmp_path / "cycles.png"
    _, periods = kept[0].axes
    solid, dashed, mark = periods.lines
    assert solid.get_xdata() == pytest.approx([1.0, 2.0, 2.5])
    assert solid.get_ydata() == pytest.approx([9.0, 8.0, 7.5])
    assert dashed.is_dashed()
    assert dashed.get_xdata() == pytest.approx([2.5, 3.0, 4.0])
    assert mark.get_marker() == MARKERS["period doubling"][0]
    assert mark.get_xdata() == pytest.approx([2.5])


def test_other_formats_are_refused(tmp_path):
    with pytest.raises(SceneError):
        save_cycles(diagram(), tmp_path / "cycles.txt")


def test_one_quantity_is_drawn_on_axes_of_a_caller():
    axes = Figure().subplots()
    assert draw_cycles(diagram(), axes, quantity="periods") is axes
    assert axes.get_ylabel() == "period T  [$\\gamma_T d^2/\\mu$]"
    assert axes.lines[0].get_ydata() == pytest.approx([9.0, 8.0, 7.5])
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert sorted(words) == ["period doubling", "stable", "unstable"]
    assert draw_cycles(diagram()).get_ylabel() == "largest excursion  [$a$]"
    with pytest.raises(SceneError, match="must be one of amplitudes, periods"):
        draw_cycles(diagram(), quantity="length")
