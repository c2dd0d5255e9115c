"""Reduced units: a scene in other units has the same motion; SI values by hand."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import nrchain
from nrchain.errors import MissingLibraryError, SceneError
from nrchain.units import UNITS, Units, of

LENGTH, TIME, FORCE = 3.0, 0.25, 7.0

SCENE = {
    "chain.particles": 5,
    "friction.kind": "pairwise",
    "elasticity.ratio": None,
    "elasticity.stretch": 30.0,
    "elasticity.shear": 20.0,
    "elasticity.twist": 900.0,
    "elasticity.bend": 1500.0,
    "slip.4a": 500.0,
    "steric.kind": "harmonic",
    "steric.strength": 400.0,
    "steric.range": 10.0,
    "field.force": [0.0, 3.0, -1.0],
    "field.torque": [0.0, 0.0, 20.0],
    "field.body_force": [1.0, 0.0, 0.0],
    "field.body_torque": [5.0, 0.0, 0.0],
    "flow.gradient": [[0.0, 0.02, 0.0], [0.0, 0.0, 0.0], [0.01, 0.0, 0.0]],
    "start.amplitude": 0.7,
    "run.end": 5.0,
    "run.snapshots": 3,
}


def scaled(scene):
    """Changes that state the scene with lengths, times and forces as multiples of other units."""
    factors = {"L": LENGTH, "T": TIME, "F": FORCE, "F L": FORCE * LENGTH, "F/L": FORCE / LENGTH}
    factors |= {"1/T": 1 / TIME, "F T/L²": FORCE * TIME / LENGTH**2}
    values = {key: SCENE.get(key) for key in UNITS} | {
        "chain.spacing": scene.chain.spacing,
        "chain.radius": scene.chain.radius,
        "chain.viscosity": scene.chain.viscosity,
    }
    given = {key: value for key, value in values.items() if value is not None}
    changes = {key: (np.array(given[key]) * factors[UNITS[key]]).tolist() for key in given}
    return changes | {
        f"slip.{m}": scene.slip.modes[m].strength * LENGTH / TIME for m in ("2s", "4a")
    }


def test_a_scene_in_other_units_has_the_same_motion():
    """Positions scale as L, times as T, frames not at all: each key has the unit of the table."""
    scene = nrchain.load_scene("buckling", **SCENE, **{"run.rtol": 1e-10, "run.atol": 1e-10})
    other = nrchain.load_scene(scene, **scaled(scene))
    assert other.chain.radius != 1.0
    assert other.chain.viscosity != 1.0
    one, two = nrchain.simulate(scene), nrchain.simulate(other)
    assert two.time == pytest.approx(one.time * TIME)
    moved = np.abs(one.positions[-1] - one.positions[0]).max()
    assert moved > 0.5
    assert two.positions == pytest.approx(one.positions * LENGTH, abs=1e-6 * LENGTH)
    assert two.frames == pytest.approx(one.frames, abs=1e-6)


@pytest.mark.parametrize("third", ["slip.2s", "run.end", "elasticity.bend"])
def test_three_values_in_si_give_the_units(third):
    """a = 2 um, η = 1 mPa s: F = η L²/T, so that any further value gives T."""
    scene = nrchain.load_scene("buckling")
    length, viscosity, time = 2e-6, 1e-3, 5.0
    force = viscosity * length**2 / time
    values = {
        "slip.2s": f"{100.0 * length / time} m/s",
        "run.end": f"{scene.run.end * time} s",
        "elasticity.bend": f"{scene.moduli.bend * force * length} N m",
    }
    known = {"chain.radius": "2 um", "chain.viscosity": "1 mPa s", third: values[third]}
    found = of(scene, **known)
    assert (found.length, found.time, found.force) == pytest.approx((length, time, force))


def test_drag_of_a_sphere_of_a_micrometre_in_water():
    """γ_T = 6πηa = 1.885e-8 N s/m: a force of 1 pN moves it at 53 um/s."""
    scene = nrchain.load_scene("passive")
    known = {"chain.radius": "1 um", "chain.viscosity": "1 mPa s", "run.end": "400 s"}
    found = of(scene, **known)
    force = found.to_reduced("1 pN")
    speed = found.to_si(force / scene.drag.translation, "L/T")
    assert speed.to("um/s").magnitude == pytest.approx(53.05, rel=1e-3)


def test_what_goes_there_comes_back():
    found = Units(length=2e-6, time=0.3, force=4e-13)
    rows = np.arange(6.0).reshape(2, 3)
    for unit in ("L", "T", "F", "F L", "F/L", "L/T", "1/T", "F T/L²", "slip.2s", "elasticity.bend"):
        assert found.to_reduced(found.to_si(rows, unit)) == pytest.approx(rows)
    changes = {key: SCENE[key] for key in SCENE if key.startswith("elasticity")}
    scene = nrchain.load_scene("buckling", **changes)
    shown = found.describe(scene)
    again = found.scene(scene, **shown)
    assert again.moduli.shear == pytest.approx(scene.moduli.shear)
    assert again.slip.modes["2s"].strength == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("known", "message"),
    [
        ({"chain.radius": "1 um"}, "must be three keys"),
        ({"chain.radius": "1 um", "chain.spacing": "10 um", "run.end": "1 s"}, "must fix length"),
        ({"chain.radius": "1 um", "run.end": "1 s", "slip.2s": "1 um"}, "must have the unit L/T"),
        ({"chain.radius": "1 um", "run.end": "1 s", "slip.2s": "1 fast"}, "must be a value with"),
        ({"chain.radius": "1 um", "run.end": "1 s", "slip.2s": "-1 um/s"}, "the sign"),
        ({"chain.radius": "1 um", "run.end": "1 s", "slip.4a": "1 um/s"}, "other than zero"),
        (
            {"chain.radius": "1e-300 m", "chain.viscosity": "1 Pa s", "run.end": "1 s"},
            "between 1/1e\\+60 and 1e\\+60",
        ),
        ({"chain.radius": "1 um", "run.end": "1 s", "chain.particles": "1 K"}, "must have a unit"),
    ],
)
def test_values_that_fix_no_units_are_refused(known, message):
    with pytest.raises(SceneError, match=message):
        of(nrchain.load_scene("buckling"), **known)


def test_units_of_keys_are_those_of_the_page_of_scenes():
    text = (Path(nrchain.__file__).parents[1] / "docs/scenes.md").read_text(encoding="utf-8")
    listed = {}
    for section, table in re.findall(r"^## \[(\w+)\]$(.*?)(?=^## )", text, re.S | re.M):
        for names, unit in re.findall(r"^\| (`[^|]*) \|[^|]*\| ([^|]*?) *\|", table, re.M):
            for name in re.findall(r"`(\w+)`", names):
                listed[f"{section}.{name}"] = unit
    in_units = {key: unit for key, unit in listed.items() if re.fullmatch(r"[1LTF²/ ]+", unit)}
    strengths = {key: unit for key, unit in in_units.items() if re.match(r"slip\.\d", key)}
    assert set(strengths.values()) == {"L/T"}
    assert {key: unit for key, unit in in_units.items() if key not in strengths} == UNITS


def test_a_missing_library_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pint", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'nrchain\[units\]'"):
        Units(length=1e-6, time=1.0, force=1e-12).to_reduced("2 um")
