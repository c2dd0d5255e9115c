"""What `import nrchain` offers: every public name, whatever was imported before, and no more."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from support.markup import assert_plain_table
from support.selection import few_of
from support.specimens import SPECIMENS

import nrchain
from nrchain import rod
from nrchain.effects.registry import find_effect
from nrchain.errors import SceneError, UnknownNameError

ROOT = Path(nrchain.__file__).parents[1]
MODULES = [name for name in nrchain.__all__ if isinstance(getattr(nrchain, name), ModuleType)]


def fresh(program: str) -> str:
    """What a program prints that nothing was imported for before."""
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return run.stdout


@pytest.mark.parametrize("name", nrchain.__all__)
def test_every_public_name_is_found_after_import_nrchain(name):
    assert getattr(nrchain, name) is not None
    assert name in dir(nrchain)


@pytest.mark.parametrize(
    "name", few_of(["cost", "measure", "rod", "plan", "plots", "rules"], {"cost", "rules"})
)
def test_modules_that_the_docs_name_are_public_in_a_fresh_process(name):
    assert name in MODULES
    printed = fresh(f"import nrchain; print(nrchain.{name}.__name__, {name!r} in dir(nrchain))")
    assert re.fullmatch(rf"nrchain\.[a-z.]*\b{name} True\n", printed)


def test_every_name_of_the_docs_is_found():
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    written = re.findall(r"(?<![\w./-])nrchain((?:\.[A-Za-z_]\w*)+)", text)
    assert len(written) > 20
    for dotted in written:
        thing = nrchain
        for part in dotted.strip(".").split("."):
            thing = getattr(thing, part)


def test_no_name_is_both_a_module_and_something_else():
    """Importing a module sets its name on the package: a public name that is the same is lost."""
    modules = {path.stem for path in Path(nrchain.__file__).parent.iterdir()}
    others = {name for name in nrchain.__all__ if nrchain._MODULES.get(name) != f"nrchain.{name}"}
    assert not modules & others


def test_dir_is_the_same_whatever_was_imported():
    shown = "print(sorted(dir(nrchain)) == sorted([*nrchain.__all__, '__version__']))"
    assert fresh(f"import nrchain; {shown}") == "True\n"
    assert fresh(f"import nrchain, nrchain.cli.app, nrchain.geometry.lie; {shown}") == "True\n"


def test_import_nrchain_loads_nothing_else():
    printed = fresh(
        "import sys, typing, importlib, collections.abc; before = set(sys.modules)\n"
        "import nrchain; dir(nrchain)\n"
        "print(*sorted(set(sys.modules) - before))"
    )
    allowed = {"nrchain", "nrchain.version", "nrchain.scene", "nrchain.scene.extensions"}
    allowed |= {"__future__"}
    assert set(printed.split()) <= allowed


def test_a_name_that_is_none_is_an_attribute_error_that_helps():
    with pytest.raises(AttributeError, match=r"'nrchain' has no attribute 'measur'") as error:
        nrchain.measur  # noqa: B018
    assert (error.value.name, error.value.obj) == ("measur", nrchain)
    with pytest.raises(AttributeError, match=r"a scene has no 'sterc'; did you mean 'steric'\?"):
        nrchain.load_scene("passive").sterc  # noqa: B018


def test_every_file_that_is_no_code_is_shipped_with_the_package():
    settings = configparser.ConfigParser()
    settings.read(ROOT / "setup.cfg")
    package = ROOT / "nrchain"
    shipped = {
        path
        for name, patterns in settings["options.package_data"].items()
        for pattern in patterns.split()
        for path in (ROOT / name.replace(".", "/")).glob(pattern)
    }
    files = {path for path in package.rglob("*") if path.is_file() and path.suffix != ".py"}
    assert {path for path in files if "__pycache__" not in path.parts} == shipped
    assert package / "py.typed" in shipped


def test_a_wheel_holds_the_mark_of_types_and_the_scenes(tmp_path):
    pytest.importorskip("setuptools.build_meta")
    source = tmp_path / "source"
    skip = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "nrchain", source / "nrchain", ignore=skip)
    for name in ("setup.cfg", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    build = f"from setuptools import build_meta; build_meta.build_wheel({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=source, capture_output=True, check=True)
    (wheel,) = tmp_path.glob("*.whl")
    held = zipfile.ZipFile(wheel).namelist()
    assert "nrchain/py.typed" in held
    assert "nrchain/scene/scenes/buckling.toml" in held


@pytest.mark.parametrize("name", SPECIMENS)
def test_what_is_shown_of_a_result_does_not_fill_a_screen(name):
    specimen = SPECIMENS[name]()
    for one in specimen if isinstance(specimen, list) else [specimen]:
        shown = repr(one)
        assert len(shown) <= 320, shown
        assert shown.count("\n") <= 1, shown
        if hasattr(one, "_repr_html_"):
            assert_plain_table(one._repr_html_())


def test_a_scene_and_a_rate_show_what_matters():
    changes = {"chain.radius": 1.5, "field.force": [0, 0, 1], "run.end": 20.0}
    scene = nrchain.load_scene("buckling", title="Mine", **changes)
    assert repr(scene) == (
        "<Scene 'Mine': 20 spheres, d = 10, a = 1.5, clamped ends, 2s +100, field, to t = 20>"
    )
    assert repr(nrchain.load_scene(scene, title="")).startswith("<Scene: 20 spheres, ")
    growth, frequency = nrchain.measure.Estimate(-0.5, 0.001), nrchain.measure.Estimate(2.0, 0.03)
    rate = nrchain.measure.Rate(growth, frequency, 0.314, 1.0, 0.02, 7.0)
    assert repr(rate) == (
        "<Rate Λ = (-0.5 ± 0.001) + i (2 ± 0.03) at q = 0.314, t = 1 to 7, misfit 0.02>"
    )


def contributions():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 4})
    frames = np.broadcast_to(np.eye(3), (4, 3, 3))
    return nrchain.contributions(scene, np.outer(np.arange(4.0), [10.0, 0.0, 0.0]), frames)


@pytest.mark.parametrize(
    ("table", "wrong", "right"),
    [
        (contributions, "slip 2a", "slip 2s"),
        (lambda: SPECIMENS["nrchain.Trajectory"]().counters, "step", "steps"),
        (lambda: nrchain.contribution_sizes(SPECIMENS["nrchain.Trajectory"]()), "bent", "bend"),
        (
            lambda: rod.moduli(nrchain.Rod.of(nrchain.load_scene("wave"))),
            "C_par_M_ta",
            "C_par_M_tau",
        ),
        (lambda: nrchain.load_scene("buckling").slip.modes, "2a", "2s"),
        (
            lambda: nrchain.load_scene("passive", field={"force": [0, 0, 1]}).further,
            "fild",
            "field",
        ),
    ],
)
def test_an_unknown_name_is_reported_with_the_known_ones(table, wrong, right):
    found = table()
    assert found[right] is not None
    with pytest.raises(UnknownNameError, match=f"did you mean '{right}'") as error:
        found[wrong]
    assert isinstance(error.value, KeyError)
    assert str(error.value).startswith(f"{wrong!r} is not known; there are ")
    assert all(name in str(error.value) for name in found)
    assert found.get(wrong) is None
    assert wrong not in found


def test_effects_are_found_by_name():
    with pytest.raises(SceneError, match=r"there are .*stretch.*did you mean 'stretch'\?"):
        find_effect("strech")
