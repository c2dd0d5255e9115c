"""Pictures do not depend on settings of matplotlib, and do not change them."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import product
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib import image, style
from support.selection import few_of

import nrchain
from nrchain.view.drawing import UNKNOWN, letters
from nrchain.view.effect_plots import save_effects
from nrchain.view.plots import save_chain

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

SEEN = ("text.usetex", "lines.linestyle", "lines.marker", "path.sketch")
"""Of these a little is seen, in letters or the ticks of axes in space: each is set alone."""


@pytest.fixture(scope="module")
def trajectory(tmp_path_factory):
    scene = nrchain.load_scene("passive", **SCENE)
    return nrchain.simulate(scene, output=tmp_path_factory.mktemp("runs") / "mine")


DRAWN = {
    "planes": lambda t, path: save_chain(t, path),
    "3d": lambda t, path: save_chain(t, path, view="3d"),
    "effects": lambda t, path: save_effects(t, path),
}


def differing(first: np.ndarray, second: np.ndarray) -> float:
    """The share of pixels that differ visibly; 1 for pictures of different sizes."""
    if first.shape != second.shape:
        return 1.0
    return float((np.abs(first - second).max(axis=2) > 0.1).mean())


def telling_sheets() -> dict[str, dict]:
    """Style sheets of matplotlib that together set every key that any of them sets.

    Those with the most settings come first.
    """
    sheets = {name: style.library[name] for name in style.available if "classic" not in name}
    chosen, seen = {}, set()
    for name in sorted(sheets, key=lambda name: -len(sheets[name])):
        if sheets[name].keys() - seen:
            chosen[name] = sheets[name]
            seen |= sheets[name].keys()
    return chosen


def hostile_settings() -> dict[str, dict]:
    """Those that are seen each alone, and all others together."""
    alone = {key: {key: HOSTILE[key]} for key in SEEN}
    others = {key: value for key, value in HOSTILE.items() if key not in SEEN}
    return alone | {"all others": others}


@pytest.mark.parametrize(
    ("view", "settings"),
    few_of(product(DRAWN, [hostile_settings, telling_sheets]), {("planes", hostile_settings)}),
)
def test_settings_of_a_user_neither_break_a_picture_nor_change_what_it_shows(
    view, settings, trajectory, tmp_path
):
    """Fonts aside: letters may look other than without, lines and places may not.

    Settings that are ignored are ignored together as well: one picture shows whether any is not.
    """
    path = tmp_path / "a.png"
    plain = image.imread(DRAWN[view](trajectory, path))
    blank = differing(plain, np.ones_like(plain))
    for name, given in settings().items():
        kept = {k: v for k, v in given.items() if not k.startswith(("font.fam", "font.sans"))}
        with matplotlib.rc_context(kept):
            before = dict(matplotlib.rcParams)
            drawn = image.imread(DRAWN[view](trajectory, path))
            assert dict(matplotlib.rcParams) == before
        assert differing(plain, drawn) < 0.3 * blank, name
        assert (drawn[:, 0] == 1.0).all(), f"{name}: no white edge"


@pytest.mark.parametrize("ending", few_of(["pdf", "svg"], {"pdf"}))
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


COMMANDS = {
    # matplotlib cannot be imported with this one
    "nonsense": ["run", "passive", "-o", ".", *(f"--set={k}={v}" for k, v in SCENE.items())],
    INLINE: ["--view", "3d", "-o", "chain.svg"],
    ABSENT: ["--effects", "-o", "chain.pdf"],
    "TkAgg": ["-o", "chain.png"],
}
"""What is drawn, all of it by one program, with each of the backends."""


@pytest.mark.parametrize("backend", few_of(COMMANDS, {"nonsense", INLINE}))
def test_the_program_draws_whatever_backend_a_notebook_names(backend, trajectory, tmp_path):
    command = COMMANDS[backend]
    plot = [] if command[0] == "run" else ["plot", str(trajectory.path)]
    ran = program("-m", "nrchain", *plot, *command, backend=backend, folder=tmp_path)
    assert ran.returncode == 0, ran.stderr
    (picture,) = tmp_path.glob("chain.*")
    assert picture.stat().st_size > 5_000


def test_the_program_keeps_quiet_about_caches_of_matplotlib(trajectory, tmp_path, monkeypatch):
    """Where no folder of a user can be written, a picture is drawn without a word."""
    monkeypatch.delenv("MPLCONFIGDIR", raising=False)
    for variable in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(variable, "/dev/null")
    command = ["-m", "nrchain", "plot", str(trajectory.path), "-o", "chain.png"]
    ran = program(*command, backend="agg", folder=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert "atplotlib" not in ran.stderr
    assert (tmp_path / "chain.png").exists()


LIBRARY = """
import sys
import nrchain
trajectory = nrchain.Trajectory.open(sys.argv[1])
try:
    print(nrchain.plots.save_chain(trajectory, "chain.png"))
except nrchain.SceneError as error:
    print(error)
"""


def drawn_by_a_library(trajectory, backend, folder):
    return program("-c", LIBRARY, str(trajectory.path), backend=backend, folder=folder)


def test_from_python_a_backend_that_is_none_is_named_with_what_helps(trajectory, tmp_path):
    printed = drawn_by_a_library(trajectory, "nonsense", tmp_path).stdout
    assert printed.startswith("MPLBACKEND = 'nonsense': is not a backend of matplotlib")
    assert not (tmp_path / "chain.png").exists()
    # what the message offers
    assert "MPLBACKEND=agg" in printed


@pytest.mark.parametrize("backend", few_of(["agg", "", ABSENT], {ABSENT}))
def test_from_python_any_other_backend_is_not_loaded(backend, trajectory, tmp_path):
    done = drawn_by_a_library(trajectory, backend, tmp_path)
    assert done.stdout == "chain.png\n", done.stderr


VALIDATION = """
import runpy
import sys
from types import ModuleType

from validation.report.studies import STUDIES, Study

def study(recorder):
    from matplotlib.figure import Figure

    recorder.check("holds", 1.0, 1.0, 1e-9, source="s")
    recorder.figure("A figure", Figure(figsize=(1, 1)), "Nothing.")

sys.modules["short"] = ModuleType("short")
sys.modules["short"].study = study
STUDIES.clear()
STUDIES["short"] = Study("short", "A short study")
sys.argv = ["validation", "--output", sys.argv[1]]
runpy.run_module("validation", run_name="__main__")
"""


def test_the_validation_draws_whatever_backend_a_notebook_names(tmp_path):
    root = Path(nrchain.__file__).parents[1]
    ran = program("-c", VALIDATION, str(tmp_path), backend="nonsense", folder=root)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert list(tmp_path.rglob("*.png"))
