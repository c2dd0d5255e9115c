"""Pictures come out whatever matplotlib is told by others, and tell it nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib import image, style

import nrchain
from nrchain.view.drawing import UNKNOWN, letters
from nrchain.view.effect_plots import draw_effects
from nrchain.view.plots import draw_chain

INLINE = "module://matplotlib_inline.backend_inline"
ABSENT = "module://nowhere_to_be_found.backend"
SCENE = {"chain.particles": 5, "run.end": 4.0, "run.snapshots": 5, "slip.2s": 40.0}

HOSTILE = {
    "text.usetex": True,
    "text.parse_math": False,
    "savefig.format": "pdf",
    "savefig.bbox": "tight",
    "savefig.dpi": 33,
    "savefig.transparent": True,
    "savefig.facecolor": "red",
    "figure.facecolor": "red",
    "figure.frameon": False,
    "figure.autolayout": True,
    "figure.constrained_layout.use": True,
    "figure.dpi": 20,
    "font.size": 30,
    "axes.grid": False,
    "axes.facecolor": "red",
    "axes.prop_cycle": matplotlib.cycler(marker=["o"], linestyle=[":"]),
    "axes.formatter.use_mathtext": True,
    "axes.titley": 0.5,
    "axes.titlepad": 60.0,
    "axes.labelcolor": "red",
    "axes.labelpad": 60.0,
    "axes.spines.left": False,
    "axes.xmargin": 0.4,
    "xtick.minor.visible": True,
    "xtick.labelsize": 40,
    "ytick.left": False,
    "ytick.major.size": 30,
    "lines.linewidth": 20,
    "lines.linestyle": ":",
    "lines.marker": "x",
    "lines.markersize": 30,
    "legend.fontsize": 30,
    "legend.frameon": True,
    "path.sketch": (1, 100, 2),
    "image.origin": "lower",
    "grid.color": "red",
}


@pytest.fixture(scope="module")
def trajectory():
    return nrchain.simulate(nrchain.load_scene("passive", **SCENE))


DRAWN = {
    "planes": lambda t, path: draw_chain(t, path),
    "3d": lambda t, path: draw_chain(t, path, view="3d"),
    "effects": lambda t, path: draw_effects(t, path),
}


def differing(first: np.ndarray, second: np.ndarray) -> float:
    """The share of pixels that are seen to differ; 1 for pictures of different sizes."""
    if first.shape != second.shape:
        return 1.0
    return float((np.abs(first - second).max(axis=2) > 0.1).mean())


@pytest.mark.parametrize("view", DRAWN)
def test_settings_of_a_user_neither_break_a_picture_nor_change_what_it_shows(
    view, trajectory, tmp_path
):
    """Fonts aside: letters may look other than without, lines and places may not."""
    path = tmp_path / "a.png"
    plain = image.imread(DRAWN[view](trajectory, path))
    blank = differing(plain, np.ones_like(plain))
    sheets = {name: style.library[name] for name in style.available if "classic" not in name}
    one_by_one = {key: {key: value} for key, value in HOSTILE.items()}
    for name, settings in (sheets | one_by_one).items():
        kept = {k: v for k, v in settings.items() if not k.startswith(("font.fam", "font.sans"))}
        with matplotlib.rc_context(kept):
            before = dict(matplotlib.rcParams)
            drawn = image.imread(DRAWN[view](trajectory, path))
            assert dict(matplotlib.rcParams) == before
        assert differing(plain, drawn) < 0.3 * blank, name
        assert (drawn[:, 0] == 1.0).all(), f"{name}: no white edge"


@pytest.mark.parametrize("ending", ["pdf", "svg"])
def test_files_of_vectors_need_no_tex_either(ending, trajectory, tmp_path):
    with matplotlib.rc_context({"text.usetex": True, "savefig.format": "png"}):
        for draw in DRAWN.values():
            start = draw(trajectory, tmp_path / f"a.{ending}").read_bytes()[:5]
            assert start == (b"%PDF-" if ending == "pdf" else b"<?xml")


def test_a_letter_that_no_font_has_is_a_box_and_a_dollar_is_no_mathematics():
    assert letters("2s, λ∥ = $5") == r"2s, λ∥ = \$5"
    assert letters("a \U0001f9ec b") == f"a {UNKNOWN} b"


def program(*arguments, backend, folder):
    environment = os.environ | {"MPLBACKEND": backend}
    return subprocess.run(
        [sys.executable, *arguments],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("backend", [INLINE, ABSENT, "nonsense", "TkAgg"])
def test_the_program_draws_whatever_backend_a_notebook_names(backend, tmp_path):
    changes = [part for key, value in SCENE.items() for part in ("--set", f"{key}={value}")]
    ran = program(
        *("-m", "nrchain", "run", "passive", "-o", "mine", *changes),
        backend=backend,
        folder=tmp_path,
    )
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "mine" / "chain.png").stat().st_size > 10_000
    for options in (["--view", "3d", "-o", "space.svg"], ["--effects", "-o", "effects.pdf"]):
        drawn = program(
            *("-m", "nrchain", "plot", "mine", *options), backend=backend, folder=tmp_path
        )
        assert drawn.returncode == 0, drawn.stderr
        assert (tmp_path / options[-1]).stat().st_size > 5_000


LIBRARY = f"""
import nrchain
trajectory = nrchain.simulate(nrchain.load_scene("passive", **{SCENE}))
try:
    print(nrchain.plots.draw_chain(trajectory, "chain.png"))
except nrchain.SceneError as error:
    print(error)
"""


def test_from_python_a_backend_that_is_none_is_named_with_what_helps(tmp_path):
    told = program("-c", LIBRARY, backend="nonsense", folder=tmp_path).stdout
    assert told.startswith("MPLBACKEND = 'nonsense': is not a backend of matplotlib")
    assert not (tmp_path / "chain.png").exists()
    # what the message offers
    assert "MPLBACKEND=agg" in told
    for backend in ("agg", "", ABSENT):
        drawn = program("-c", LIBRARY, backend=backend, folder=tmp_path)
        assert drawn.stdout == "chain.png\n", drawn.stderr


def test_the_validation_draws_whatever_backend_a_notebook_names(tmp_path):
    root = Path(nrchain.__file__).parents[1]
    arguments = ("-m", "validation", "rest", "--quick", "--output", str(tmp_path))
    ran = program(*arguments, backend="nonsense", folder=root)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert list(tmp_path.rglob("*.png"))
