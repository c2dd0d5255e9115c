"""Pictures of plane waves: one panel on axes of a caller, lines that are told apart."""

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import nrchain
from nrchain.errors import SceneError
from nrchain.theory.lattice import Branch
from nrchain.view.dispersion_plots import NAMES, draw_dispersion, save_dispersion


@pytest.fixture(scope="module")
def found():
    return nrchain.dispersion(nrchain.load_scene("buckling"))


def test_one_panel_is_drawn_on_axes_of_a_caller(found):
    before, axes = dict(matplotlib.rcParams), Figure().subplots()
    assert draw_dispersion(found, axes) is axes
    assert axes.get_xlabel() == "$qd$"
    assert r"[$\mu/\gamma_T d^2$]" in axes.get_ylabel()
    lattice = axes.lines[0]
    assert np.allclose(lattice.get_ydata(), found.lattice[:, Branch.BEND_PLUS].real)
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert set(words) == set(NAMES.values())
    looks = {(line.get_linestyle(), line.get_linewidth()) for line in axes.lines}
    assert len(looks) == len(axes.lines)  # theories and branches differ without colour
    other = draw_dispersion(found, kind="stretch and twist", part="frequency", key=False)
    assert other.get_legend() is None
    assert other.get_ylabel().startswith("frequency")
    assert dict(matplotlib.rcParams) == before


def test_panels_that_are_not_known_are_refused(found, tmp_path):
    with pytest.raises(SceneError, match="must be one of bending, stretch and twist, shear"):
        draw_dispersion(found, kind="sound")
    with pytest.raises(SceneError, match="must be one of growth, frequency"):
        draw_dispersion(found, part="size")
    with pytest.raises(SceneError, match="must be axes of matplotlib"):
        draw_dispersion(found, "waves.png")
    with pytest.raises(SceneError, match="must end in one of"):
        save_dispersion(found, tmp_path / "waves.gif")
