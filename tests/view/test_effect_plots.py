"""Pictures of effects, also of chains on which no effect acts."""

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain import effect_plots
from nrchain.errors import SceneError, TrajectoryError
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.effect_plots import draw_effects, save_effects


def run(**changes):
    base = {"chain.particles": 5, "run": {"end": 1.0, "snapshots": 4}, "start.shape": "random"}
    return nrchain.simulate(nrchain.load_scene(base, **changes))


def figure_of(monkeypatch, trajectory, path):
    from matplotlib.figure import Figure

    kept = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda f, *a, **k: (kept.append(f), save(f, *a, **k)))
    assert save_effects(trajectory, path) == path
    assert path.stat().st_size > 10_000
    return kept[0]


def test_every_effect_is_a_line_along_the_chain_and_over_time(tmp_path, monkeypatch):
    trajectory = run(**{"slip.2s": 100.0, "field.force": [0, 0, 1.0], "title": "100 $ [red]"})
    figure = figure_of(monkeypatch, trajectory, tmp_path / "effects.png")
    along, turning, over_time = figure.axes
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        *("stretch", "shear", "twist", "bend", "slip 2s", "field", "total")
    ]
    assert len(along.lines) == 5  # twist and bend give no velocity
    assert len(turning.lines) == 6  # nor does the field an angular velocity
    assert len(over_time.lines) == 7
    sizes = nrchain.contribution_sizes(trajectory)
    drawn = {line.get_ydata()[-1] for line in over_time.lines}
    assert drawn == {values[-1] for values in sizes.values()}
    found = nrchain.contributions(trajectory.scene, trajectory.positions[-1], trajectory.frames[-1])
    expected = np.linalg.norm(found["field"].twist[:, :3], axis=1)
    assert any(np.array_equal(line.get_ydata(), expected) for line in along.lines)


@pytest.mark.parametrize("ending", few_of(["pdf", "svg"], {"svg"}))
def test_other_formats(tmp_path, ending):
    assert save_effects(run(), tmp_path / f"a.{ending}").exists()


def test_a_chain_at_rest(tmp_path):
    assert save_effects(run(**{"start.shape": "straight"}), tmp_path / "a.png").exists()


def test_what_cannot_be_drawn_is_refused(tmp_path):
    trajectory = run()
    with pytest.raises(SceneError, match="must end in"):
        save_effects(trajectory, tmp_path / "a.doc")
    empty = Trajectory(np.empty(0), np.empty((0, 5, 3)), np.empty((0, 5, 3, 3)), trajectory.scene)
    with pytest.raises(TrajectoryError, match="no finished snapshot"):
        save_effects(empty, tmp_path / "a.png")


def test_long_runs_are_thinned(tmp_path, monkeypatch):
    monkeypatch.setattr(effect_plots, "MOST_TIMES", 2)
    figure = figure_of(monkeypatch, run(), tmp_path / "a.png")
    assert len(figure.axes[2].lines[0].get_xdata()) == 2


def test_one_panel_is_drawn_on_axes_of_a_caller():
    from matplotlib.figure import Figure

    trajectory, axes = run(**{"slip.2s": 100.0}), Figure().subplots()
    assert draw_effects(trajectory, axes) is axes
    assert axes.get_xlabel() == "$t$  [$\\gamma_T d^2/\\mu$]"
    sizes = nrchain.contribution_sizes(trajectory)
    drawn = {line.get_ydata()[-1] for line in axes.lines}
    assert drawn == {values[-1] for values in sizes.values()}
    other = draw_effects(trajectory, panel="velocity", key=False)
    assert other.get_xlabel() == "sphere"
    assert other.get_legend() is None
    with pytest.raises(SceneError, match="must be one of velocity, angular velocity, over time"):
        draw_effects(trajectory, panel="energy")
