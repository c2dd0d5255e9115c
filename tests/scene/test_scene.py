"""Scenes: what is refused and how it is said, the exact round trip, changes, derived numbers."""

import math
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrchain import slip_modes
from nrchain.effects.steric import StericSpec
from nrchain.errors import NOT_GIVEN, SceneError, TrajectoryError
from nrchain.hydrodynamics.slip import Slip
from nrchain.scene.chain_sections import ChainSpec, ElasticitySpec, RunSpec, StartSpec
from nrchain.scene.fluid_sections import FrictionSpec, SlipSpec
from nrchain.scene.loading import load_scene
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene
from nrchain.scene.toml import parse_assignment, scene_names, scene_path
from nrchain.trajectory.block import Block
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.writer import TrajectoryWriter

NAN, INF = math.nan, math.inf
BASE = {
    "chain.particles": 4,
    "slip.2s": 100.0,
    "run.end": 10.0,
}
PERIODIC = {"chain.ends": "periodic"}
SINE = {"start.shape": "sine"}
EXPLICIT = {"elasticity.stretch": 2.0, "elasticity.shear": 3.0}

# changes to BASE, the key that is named, and a part of the sentence on what is allowed
REFUSALS = [
    # unknown names
    ({"chains.particles": 4}, "chains", "did you mean 'chain'"),
    ({"particles": 4}, "particles", "did you mean 'chain.particles'"),
    ({"chain.partcles": 4}, "chain.partcles", "did you mean 'particles'"),
    ({"elasticity.bnd": None}, "elasticity.bnd", "did you mean 'bend'"),
    ({"slip.2x": 1.0}, "slip.2x", "did you mean '2s'"),
    ({"slip.4A": 1.0}, "slip.4A", "did you mean '4a'"),
    ({"slip.neighbors": 1}, "slip.neighbors", "did you mean 'neighbours'"),
    (
        {"slip.modes": {}},
        "slip.modes",
        "neighbours, finite_size, accuracy, backend, 2s, 3a, 3t, 4a",
    ),
    ({"slip.2s": {"strength": 1.0, "axes": [1, 0, 0]}}, "slip.2s.axes", "did you mean 'axis'"),
    (
        {"zzz": 1},
        "zzz",
        "there are chain, elasticity, slip, friction, start, run, title, effects, tolerance,"
        " steric, field, flow",
    ),
    ({"chain.particles.x": 1}, "chain.particles.x", "chain.particles is not a table"),
    ({"chain": {3: 1}}, "chain.3", "keys are strings"),
    # missing keys
    ({"chain": None}, "chain.particles", "a whole number of at least 2"),
    ({"run.end": None}, "run.end", "a finite number, above 0"),
    ({"slip.2s": {"axis": [1, 0, 0]}}, "slip.2s.strength", "a finite number"),
    # wrong types
    ({"chain": 4}, "chain", "a table of particles, spacing, radius, viscosity, ends"),
    ({"chain": RunSpec(end=1.0)}, "chain", "a table of particles, spacing"),
    ({"steric": "wca"}, "steric", "of kind, strength, range; did you mean steric.kind = 'wca'?"),
    ({"start": "sine"}, "start", "did you mean start.shape = 'sine'?"),
    (
        {"slip": 50.0},
        "slip",
        "a table of neighbours, finite_size, accuracy, backend, 2s, 3a, 3t, 4a",
    ),
    ({"2s": 50.0}, "2s", "did you mean 'slip.2s'?"),
    ({"slip.2s": "fast"}, "slip.2s", "a finite number, or a list with one for each sphere"),
    ({"slip.neighbours": "ALL"}, "slip.neighbours", "did you mean 'all'?"),
    ({"slip.finite_size": "True"}, "slip.finite_size", "true or false; did you mean true?"),
    ({"chain.particles": 1e3}, "chain.particles", "did you mean 1000?"),
    ({"run.max_steps": 10.0}, "run.max_steps", "did you mean 10?"),
    ({"chain.particles": 4.0}, "chain.particles", "a whole number"),
    ({"chain.particles": True}, "chain.particles", "a whole number"),
    ({"chain.particles": "4"}, "chain.particles", "a whole number"),
    ({"chain.spacing": "10"}, "chain.spacing", "a finite number, above 0"),
    ({"chain.spacing": True}, "chain.spacing", "a finite number, above 0"),
    ({"chain.spacing": [10.0]}, "chain.spacing", "a finite number, above 0"),
    ({"chain.ends": 1}, "chain.ends", "one of free, clamped, periodic"),
    ({"chain.ends": "clampd"}, "chain.ends", "did you mean 'clamped'"),
    ({"slip.finite_size": 1}, "slip.finite_size", "true or false"),
    ({"slip.backend": "numpy"}, "slip.backend", "one of native, pystokes"),
    ({"slip.accuracy": 0.0}, "slip.accuracy", "a number from 1e-11 to 0.1, or 'direct'"),
    ({"slip.accuracy": 0.2}, "slip.accuracy", "a number from 1e-11 to 0.1, or 'direct'"),
    ({"slip.accuracy": "Direct"}, "slip.accuracy", "did you mean 'direct'?"),
    ({"elasticity.measure": "isotropc"}, "elasticity.measure", "did you mean 'isotropic'"),
    ({"slip.2s": "strong"}, "slip.2s", "a finite number"),
    ({"slip.2s": [1.0, 2.0, "x", 3.0]}, "slip.2s[2]", "a finite number"),
    ({"slip.2s": [[1.0], 2.0, 3.0, 4.0]}, "slip.2s[0]", "a finite number"),
    ({"start.shape": "helix"}, "start.shape", "did you mean 'helix-"),
    ({"title": 3}, "title", "one line of printable text"),
    ({"title": "two\nlines"}, "title", "one line of printable text"),
    ({"title": "half a pair \ud800"}, "title", "one line of printable text"),
    # numbers out of range
    ({"chain.particles": 1}, "chain.particles", "at least 2"),
    ({"chain.particles": 2**63}, "chain.particles", "below 2^63"),
    ({"chain.spacing": NAN}, "chain.spacing", "a finite number, above 0"),
    ({"chain.spacing": INF}, "chain.spacing", "a finite number, above 0"),
    ({"chain.spacing": 10**400}, "chain.spacing", "a finite number, above 0"),
    ({"chain.radius": 0}, "chain.radius", "above 0"),
    ({"chain.radius": -1.0}, "chain.radius", "above 0"),
    ({"chain.viscosity": 0.0}, "chain.viscosity", "above 0"),
    ({"chain.spacing": 1.5}, "chain.spacing", "spheres overlap"),
    ({"chain.spacing": 2.0}, "chain.spacing", "must exceed two radii, 2.0"),
    ({"elasticity.ratio": 0.0}, "elasticity.ratio", "above 0"),
    ({"elasticity.bend": -1.0}, "elasticity.bend", "at least 0"),
    ({"elasticity.twist": INF}, "elasticity.twist", "at least 0"),
    ({**EXPLICIT, "elasticity.shear": -1.0}, "elasticity.shear", "at least 0"),
    ({"slip.2s": NAN}, "slip.2s", "a finite number"),
    ({"slip.2s": [1.0, NAN, 1.0, 1.0]}, "slip.2s[1]", "a finite number"),
    ({"slip.neighbours": 0}, "slip.neighbours", "at least 1, or 'all'"),
    ({"slip.neighbours": "some"}, "slip.neighbours", "at least 1, or 'all'"),
    ({"slip.neighbours": 1.0}, "slip.neighbours", "at least 1, or 'all'"),
    ({"slip.2s.axis": [0, 0, 0]}, "slip.2s.axis", "not all zero"),
    ({"slip.2s.axis": [1, 0]}, "slip.2s.axis", "three finite numbers"),
    ({"slip.2s.axis": [1, 0, NAN]}, "slip.2s.axis", "three finite numbers"),
    ({"slip.2s.axis": "x"}, "slip.2s.axis", "three finite numbers"),
    ({"slip.2s.axis": [1e200, 0, 0]}, "slip.2s.axis", "between 1e-100 and 1e100"),
    ({"start.amplitude": NAN}, "start.amplitude", "a finite number"),
    ({"start.wavenumber": 0}, "start.wavenumber", "above 0"),
    ({"start.seed": -1}, "start.seed", "at least 0"),
    ({"start.positions": [[0.0] * 3] * 4}, "start.positions", "is for start.shape = 'given'"),
    ({"start.frames": [np.eye(3)] * 4}, "start.frames", "is for start.shape = 'given'"),
    ({"start.seed": 2**63}, "start.seed", "below 2^63"),
    ({"run.end": 0}, "run.end", "above 0"),
    ({"run.snapshots": 1}, "run.snapshots", "at least 2"),
    ({"run.integrator": "rk45"}, "run.integrator", "one of auto, cvode, radau, scipy-bdf"),
    ({"run.max_steps": 0}, "run.max_steps", "at least 1"),
    ({"run.max_seconds": 0}, "run.max_seconds", "above 0"),
    ({"run.verify": "maybe"}, "run.verify", "must be true or false"),
    ({"run.until": "calm"}, "run.until", "one of end, settled"),
    ({"run.rtol": 1e-15}, "run.rtol", "at least 1e-14 and at most 0.1"),
    ({"run.rtol": 0.2}, "run.rtol", "at least 1e-14 and at most 0.1"),
    ({"run.atol": 0.0}, "run.atol", "at least 1e-14 and at most 0.1: coordinates are rounded"),
    ({"run.atol": 9e-15}, "run.atol", "at least 1e-14"),
    ({"run.atol": 0.2}, "run.atol", "at least 1e-14 and at most 0.1"),
    # starts that the lattice does not hold
    ({**SINE, "start.wavenumber": 3.001}, "start.wavenumber", "at most 3"),
    ({**SINE, "start.wavenumber": 3.0}, "start.wavenumber", "zero at every sphere"),
    ({**SINE, **PERIODIC, "start.wavenumber": 2}, "start.wavenumber", "zero at every sphere"),
    ({**SINE, **PERIODIC, "start.wavenumber": 3}, "start.wavenumber", "at most 2, a wave two"),
    ({"start.shape": "helix-left", "start.wavenumber": 4}, "start.wavenumber", "at most 3"),
    ({**SINE, "start.amplitude": -1e200}, "start.amplitude", "no more than 1e+06 times"),
    ({"start.shape": "random", "start.amplitude": -0.1}, "start.amplitude", "at least 0"),
    # keys that do not go together
    ({"slip.2s": [1.0, 2.0, 3.0]}, "slip.2s", "each of the 4 spheres, not 3"),
    ({"slip.2s": []}, "slip.2s", "each of the 4 spheres, not 0"),
    ({**EXPLICIT, "elasticity.ratio": 1e7}, "elasticity.stretch", "two ways"),
    ({"elasticity.shear": 1.0, "elasticity.ratio": 1e7}, "elasticity.shear", "two ways"),
    ({"elasticity.stretch": 1.0}, "elasticity.shear", "along with elasticity.stretch"),
    ({"elasticity.shear": 1.0}, "elasticity.stretch", "along with elasticity.shear"),
    ({**PERIODIC, "start.wavenumber": 1.5}, "start.wavenumber", "a whole number"),
    ({**PERIODIC, "friction.backend": "pystokes"}, "friction.backend", "no periodic images"),
    ({"friction": "pairwize"}, "friction.kind", "did you mean 'pairwise'"),
    ({"friction.neighbours": 0}, "friction.neighbours", "at least 1"),
    ({"friction.backend": "none"}, "friction.backend", "one of native, pystokes"),
    ({"friction": 3}, "friction", "must be a table"),
    ({**PERIODIC, "slip.backend": "pystokes"}, "slip.backend", "no periodic images"),
    ({**PERIODIC, "slip.neighbours": 10**8}, "slip.neighbours", "at most 100000 on a periodic"),
    (
        {**PERIODIC, "friction": {"kind": "pairwise", "neighbours": 2**63 - 1}},
        "friction.neighbours",
        "at most 100000 on a periodic",
    ),
    ({"slip.2s": {1: 1}}, "slip.2s.1", "there are strength, axis"),
    ({"slip.2s": 16**5000}, "slip.2s", "a finite number"),
    ({"run.snapshots": -(16**5000)}, "run.snapshots", "a whole number"),
    ({"title": [16**5000]}, "title", "one line of printable text"),
    ({"steric.strength": 1.0}, "steric.strength", "name steric.kind"),
    ({"steric.range": 3.0}, "steric.range", "name steric.kind"),
    ({"steric.kind": "wca"}, "steric.strength", "along with steric.kind"),
    ({"field.force": 1.0}, "field.force", "a list of 3 finite numbers"),
    ({"field.torque": [1.0, 2.0]}, "field.torque", "a list of 3 finite numbers"),
    ({"field.body_force": [0, 0, "x"]}, "field.body_force[2]", "a finite number"),
    ({"field.body_torque": [0, 0, math.inf]}, "field.body_torque[2]", "a finite number"),
    ({"flow.gradient": [1, 2, 3]}, "flow.gradient[0]", "a list of 3 finite numbers"),
    ({"flow.gradient": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "flow.gradient", "no trace"),
    ({"flow.disturbance": 1}, "flow.disturbance", "true or false"),
    ({"steric": {"kind": "soft"}}, "steric.kind", "one of none, wca, harmonic"),
    ({"steric": {"kind": "wca", "strength": 1, "range": 2.0}}, "steric.range", "exceed two radii"),
    ({"steric": {"kind": "wca", "strength": 1, "range": 11}}, "steric.range", "neighbours at rest"),
    # numbers that are too large or too small together
    ({"chain.spacing": 1e200}, "elasticity", "moduli beyond the range"),
    ({"elasticity.ratio": 1e300, "elasticity.bend": 1e300}, "elasticity", "moduli beyond"),
    ({"chain.radius": 1e200, "chain.spacing": 1e201}, "chain", "drag beyond"),
    ({"chain.radius": 1e-200}, "chain", "drag beyond"),
    ({"chain.particles": 2**62, "chain.spacing": 1e300, **EXPLICIT}, "chain", "length beyond"),
    (
        {"start.wavenumber": 1e308, "chain.spacing": 0.1, "chain.radius": 0.01},
        "start",
        "wavevector",
    ),
]


ADVICE = "Every process must register an? (mode|effect) of your own"


@pytest.mark.parametrize(
    ("changes", "meant"),
    [
        ({"slip.2S": 60.0}, "2s"),
        ({"slip.Neighbours": 2}, "neighbours"),
        ({"slip.neighbour": 2}, "neighbours"),
        ({"sterik": {"kind": "wca"}}, "steric"),
        ({"Slip": {"2s": 60.0}}, "slip"),
        ({"STERIC.kind": "wca"}, "steric"),
    ],
)
def test_a_name_that_is_nearly_one_is_offered_without_advice_for_ones_own(changes, meant):
    with pytest.raises(SceneError) as caught:
        scene_of(**changes)
    assert caught.value.allowed.endswith(f"; did you mean {meant!r}?")
    assert not re.search(ADVICE, caught.value.allowed)


@pytest.mark.parametrize("changes", [{"slip.4t": 60.0}, {"slip.7q": 1.0}, {"tether": {"force": 1}}])
def test_a_name_that_may_be_ones_own_comes_with_how_to_register_it(changes):
    with pytest.raises(SceneError, match=ADVICE) as caught:
        scene_of(**changes)
    assert "?." not in caught.value.allowed
    assert "; did you mean 't" not in caught.value.allowed


def scene_of(**changes):
    return load_scene(BASE, **changes)


@pytest.mark.parametrize(("changes", "key", "allowed"), REFUSALS)
def test_refused_with_key_value_and_what_is_allowed(changes, key, allowed):
    scene_of()
    with pytest.raises(SceneError) as caught:
        scene_of(**changes)
    assert caught.value.key == key
    assert allowed in caught.value.allowed
    said = "is not given: " if caught.value.value is NOT_GIVEN else "= "
    assert str(caught.value).startswith(f"{key} {said}")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"run.end": None}, "run.end is not given: must be a finite number, above 0"),
        ({"run": None}, "run.end is not given: must be a finite number, above 0"),
        ({"slip.2s": {"axis": [1, 0, 0]}}, "slip.2s.strength is not given: must be a finite"),
        ({"elasticity.shear": 1.0}, "elasticity.stretch is not given: must be given along with"),
        ({"effects": "auto"}, "tolerance is not given: must be given with effects = 'auto'"),
        ({"steric.kind": "wca"}, "steric.strength is not given: must be given along with"),
    ],
)
def test_a_missing_key_is_said_to_be_missing(changes, message):
    with pytest.raises(SceneError) as caught:
        scene_of(**changes)
    assert str(caught.value).startswith(message)


def test_the_shortest_wave_is_a_helix_and_a_negative_amplitude_half_a_turn():
    shortest = scene_of(**{"start.shape": "helix-right", "start.wavenumber": 3})
    assert initial_poses(shortest)[0][:, 1] == pytest.approx([0.1, -0.1, 0.1, -0.1])
    ahead, behind = (
        initial_poses(scene_of(**SINE, **{"start.amplitude": sign * 0.1}))[0] for sign in (1, -1)
    )
    np.testing.assert_array_equal(ahead[:, 1], -behind[:, 1])


def test_every_key_has_a_refusal():
    keys = {
        spec.key(n)
        for spec in (ChainSpec, ElasticitySpec, FrictionSpec, StericSpec, StartSpec, RunSpec)
        for n in spec.rules()
    }
    keys |= {SlipSpec.key(name) for name in SlipSpec.spellings()} | {"title"}
    assert keys <= {key for _, key, _ in REFUSALS}


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: ChainSpec(particles=1), "chain.particles"),
        (lambda: ChainSpec(particles=4, spacing=None), "chain.spacing"),
        (lambda: Slip(NAN), "strength"),
        (lambda: SlipSpec(modes={"2x": Slip(1.0)}), "slip.2x"),
        (lambda: SlipSpec(modes=[1.0]), "slip.modes"),
        (lambda: StartSpec(seed=1.5), "start.seed"),
        (lambda: RunSpec(end="long"), "run.end"),
        (lambda: Scene(chain=None, run=RunSpec(end=1.0)), "chain.particles"),
    ],
)
def test_sections_made_in_python_are_checked_too(make, key):
    with pytest.raises(SceneError) as caught:
        make()
    assert caught.value.key == key


def test_pystokes_is_refused_for_a_mode_it_lacks(monkeypatch):
    monkeypatch.setattr(slip_modes, "_MODES", dict(slip_modes._MODES))
    known = slip_modes.find("3t")
    slip_modes.register(
        slip_modes.SlipMode("9z", "made up", 3, True, False, velocity=known.velocity)
    )
    assert scene_of(**{"slip.9z": 1.0}).slip.modes["9z"] == Slip(1.0)
    with pytest.raises(SceneError, match="no routine for mode 9z"):
        scene_of(**{"slip.9z": 1.0, "slip.backend": "pystokes"})


def test_a_saved_run_of_a_registered_mode_says_to_register_it_again(tmp_path, monkeypatch):
    monkeypatch.setattr(slip_modes, "_MODES", dict(slip_modes._MODES))
    known = slip_modes.find("3t")
    slip_modes.register(
        slip_modes.SlipMode("9z", "made up", 3, True, False, velocity=known.velocity)
    )
    scene = scene_of(**{"slip.9z": 1.0})
    with TrajectoryWriter(tmp_path / "run.h5", scene, np.array([0.0, 10.0])) as writer:
        writer.write(0, Block.of_one(0.0, *initial_poses(scene), 0))
    assert Trajectory.open(tmp_path / "run.h5").scene == scene
    slip_modes.unregister("9z")
    with pytest.raises(
        TrajectoryError,
        match=r"slip\.9z .*must register a mode of your own, with nrchain\.reg",
    ):
        Trajectory.open(tmp_path / "run.h5")


# --- sources -----------------------------------------------------------------------------------


def test_a_misspelt_scene_is_answered_with_the_nearest():
    with pytest.raises(SceneError, match=r"passive.*did you mean 'buckling'"):
        load_scene("bucklng")
    with pytest.raises(SceneError, match=r"passive.*did you mean 'stable'"):
        scene_path("stabel")


@pytest.mark.parametrize(
    ("content", "allowed"),
    [
        (b"title = 'a'\n[chain\n", "line 2"),
        (b"title = 'a'\ntitle = 'b'\n", "valid TOML"),
        (b"title = '\xff'\n", "UTF-8 text; byte 9"),
        (b"a = " + b"[" * 10_000, "valid TOML"),
    ],
)
def test_unreadable_files_are_refused(tmp_path, content, allowed):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert caught.value.value == str(path)
    assert allowed in caught.value.allowed


@pytest.mark.parametrize("source", ["{}", "{}/missing.toml", "nul\0", 7, None, b"buckling"])
def test_sources_that_are_not_scenes_are_refused(tmp_path, source):
    if isinstance(source, str):
        source = source.format(tmp_path)
    with pytest.raises(SceneError) as caught:
        load_scene(source)
    assert caught.value.key == "scene"


@pytest.mark.parametrize("start", [b"", b"\xef\xbb\xbf"])
def test_files_tables_and_scenes_are_one_and_the_same(tmp_path, start):
    scene = scene_of(**{"slip.3a": [1, 2, 3, 4], "title": "Überschlag α"})
    path = tmp_path / "scene.toml"
    path.write_bytes(start + scene.to_toml().encode().replace(b"\n", b"\r\n"))
    assert load_scene(path) == load_scene(str(path)) == load_scene(scene) == scene
    assert load_scene(scene.to_mapping()) == scene


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_say_what_they_are(name):
    scene = load_scene(name)
    assert scene == load_scene(scene_path(name)) == Scene.from_toml(scene.to_toml())
    assert scene.title
    assert scene.elasticity.ratio is not None
    assert scene.moduli.bend == scene.drag.translation * scene.chain.spacing**2


def test_shipped_scenes_are_the_papers():
    drawn = {
        name: (
            scene.chain.ends,
            scene.start.shape,
            {k: v.strength for k, v in scene.slip.modes.items()},
        )
        for name, scene in ((name, load_scene(name)) for name in scene_names())
    }
    assert drawn == {
        "passive": ("clamped", "random", {}),
        "buckling": ("clamped", "random", {"2s": 100}),
        "stable": ("clamped", "random", {"2s": -100}),
        "helix-left": ("clamped", "random", {"3a": 5000}),
        "helix-right": ("clamped", "random", {"3a": -5000}),
        "wave": ("free", "sine", {"3t": 1000}),
        "spiral-left": ("free", "helix-left", {"4a": 10000}),
        "spiral-right": ("free", "helix-right", {"4a": -10000}),
    }


# --- round trip --------------------------------------------------------------------------------

finite = st.floats(allow_nan=False, allow_infinity=False)
sizes = st.floats(1e-3, 1e3)
moduli = st.one_of(st.just(0.0), st.floats(1e-6, 1e6))
axes = st.tuples(*[st.floats(-10, 10)] * 3).filter(lambda e: math.hypot(*e) > 1e-6)


def repulsions(radius):
    """None, or one that begins between contact and the shortest spacing of :func:`scenes`."""
    reach = st.just(2.0005 * radius)
    kinds = st.sampled_from(["wca", "harmonic"])
    return st.just(StericSpec()) | st.builds(StericSpec, kind=kinds, strength=sizes, range=reach)


@st.composite
def scenes(draw):
    particles = draw(st.integers(2, 6))
    periodic = draw(st.booleans())
    radius = draw(sizes)
    shape = draw(st.sampled_from(["straight", "sine", "helix-left", "random"]))
    held = (particles - 1) / 2 if periodic else 0.99 * (particles - 1)
    waving = shape in ("sine", "helix-left") and held >= 1
    shape = shape if waving or shape == "random" else "straight"
    longest = held if waving else 50.0
    strengths = st.one_of(finite, st.lists(finite, min_size=particles, max_size=particles))
    slips = st.builds(Slip, strengths, axes) | st.builds(Slip, strengths)
    ways = st.fixed_dictionaries({}, optional={"ratio": st.floats(1e-3, 1e13)}) | (
        st.fixed_dictionaries({"stretch": moduli, "shear": moduli})
    )
    return Scene(
        title=draw(st.text().filter(str.isprintable)),
        chain=ChainSpec(
            particles=particles,
            radius=radius,
            spacing=radius * draw(st.floats(2.001, 100)),
            viscosity=draw(sizes),
            ends="periodic" if periodic else draw(st.sampled_from(["free", "clamped"])),
        ),
        elasticity=ElasticitySpec(
            **draw(ways), twist=draw(st.none() | moduli), bend=draw(st.none() | moduli)
        ),
        slip=SlipSpec(
            modes=draw(st.dictionaries(st.sampled_from(["2s", "3a", "3t", "4a"]), slips)),
            neighbours=draw(st.integers(1, 9) | st.just("all")),
            finite_size=draw(st.booleans()),
            backend="native" if periodic else draw(st.sampled_from(["native", "pystokes"])),
        ),
        further={"steric": draw(repulsions(radius))},
        start=StartSpec(
            shape=shape,
            amplitude=draw(finite if shape == "straight" else st.floats(0.0, radius)),
            wavenumber=draw(st.integers(1, int(longest)) if periodic else st.floats(1e-3, longest)),
            seed=draw(st.integers(0, 2**63 - 1)),
        ),
        run=RunSpec(
            end=draw(st.floats(1e-300, 1e300)),
            snapshots=draw(st.integers(2, 10**6)),
            rtol=draw(st.floats(1e-13, 1e-1)),
            atol=draw(st.floats(1e-13, 1e-1)),
            max_steps=draw(st.none() | st.integers(1, 10**9)),
            max_seconds=draw(st.none() | st.floats(1e-3, 1e9)),
            verify=draw(st.booleans()),
        ),
    )


@settings(deadline=None)
@given(scenes())
def test_round_trip_is_exact(scene):
    again = Scene.from_toml(scene.to_toml())
    assert again == scene
    assert hash(again) == hash(scene)
    assert again.to_toml() == scene.to_toml()
    assert again.moduli == scene.moduli
    assert load_scene(scene) == pickle.loads(pickle.dumps(scene)) == scene


def test_scenes_that_differ_in_one_number_are_not_equal():
    scene = scene_of(**{"slip.2s": [1.0, 2.0, 3.0, 4.0]})
    assert scene != scene_of(**{"slip.2s": [1.0, 2.0, 3.0, math.nextafter(4.0, 5.0)]})
    assert scene != scene_of(**{"slip.3a": [1.0, 2.0, 3.0, 4.0], "slip.2s": None})


def test_the_order_of_modes_does_not_matter_to_equality():
    first = SlipSpec(modes={"2s": 1.0, "3a": 2.0})
    second = SlipSpec(modes={"3a": 2.0, "2s": 1.0})
    assert first == second
    assert hash(first) == hash(second)


def test_scenes_cannot_be_changed():
    scene = scene_of()
    with pytest.raises(AttributeError):
        scene.chain.particles = 5
    with pytest.raises(TypeError):
        scene.slip.modes["2s"] = Slip(1.0)


def test_values_are_kept_as_plain_python():
    scene = scene_of(
        **{
            "chain.particles": np.int64(3),
            "chain.spacing": 12,
            "slip.2s": np.linspace(0, 1, 3),
            "slip.3a": {"strength": np.float32(0.5), "axis": np.array([0, 1, 0])},
            "slip.finite_size": np.True_,
        }
    )
    assert type(scene.chain.particles) is int
    assert type(scene.chain.spacing) is float
    assert scene.slip.finite_size is True
    assert scene.slip.modes == {
        "2s": Slip((0.0, 0.5, 1.0)),
        "3a": Slip(0.5, axis=(0.0, 1.0, 0.0)),
    }
    assert all(type(v) is float for v in scene.slip.modes["2s"].strength)


# --- changes -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"slip.2s": 50}, {"2s": Slip(50.0)}),
        ({"slip.2s.axis": [0, 1, 0]}, {"2s": Slip(100.0, axis=(0.0, 1.0, 0.0))}),
        ({"slip.2s.axis": [0, 1, 0], "slip.2s": 5}, {"2s": Slip(5.0)}),
        ({"slip.2s": Slip(5.0, (0, 0, 1)), "slip.2s.strength": 6}, {"2s": Slip(6.0, (0, 0, 1))}),
        ({"slip.2s": None, "slip.3a": 5}, {"3a": Slip(5.0)}),
        ({"slip": {"3a": 5}}, {"2s": Slip(100.0), "3a": Slip(5.0)}),
        ({"slip": {"3a.strength": 5, "2s": None}}, {"3a": Slip(5.0)}),
        ({"slip": SlipSpec(modes={"3a": 5})}, {"3a": Slip(5.0)}),
        ({"slip": SlipSpec(modes={"3a": 5}), "slip.4a": 1}, {"3a": Slip(5.0), "4a": Slip(1.0)}),
        ({"slip": SlipSpec(modes={"3a": 5}), "slip.3a.strength": 1}, {"3a": Slip(1.0)}),
        ({"slip": None}, {}),
    ],
)
def test_changes_of_the_slip(changes, expected):
    assert scene_of(**changes).slip.modes == expected


def test_changes_reach_every_section_and_leave_the_source_alone():
    source = {"chain": {"particles": 4}, "run": {"end": 10.0}, "slip": {"2s": {"strength": 1.0}}}
    changes = {"chain.spacing": 12, "run": {"rtol": 1e-8}, "title": "t", "slip.2s.strength": 2.0}
    scene = load_scene(source, **changes)
    assert scene == Scene(
        chain=ChainSpec(particles=4, spacing=12.0),
        slip=SlipSpec(modes={"2s": Slip(2.0)}),
        run=RunSpec(end=10.0, rtol=1e-8),
        title="t",
    )
    assert source == {
        "chain": {"particles": 4},
        "run": {"end": 10.0},
        "slip": {"2s": {"strength": 1.0}},
    }


def test_a_shipped_ratio_is_replaced_only_on_request():
    with pytest.raises(SceneError, match="two ways"):
        load_scene("buckling", **EXPLICIT)
    scene = load_scene("buckling", **EXPLICIT, **{"elasticity.ratio": None})
    assert scene.moduli[:2] == (2.0, 3.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("slip.2s=50", ("slip.2s", 50)),
        (" chain.spacing = 1e1 ", ("chain.spacing", 10.0)),
        ("chain.ends=clamped", ("chain.ends", "clamped")),
        ('title="a = b"', ("title", "a = b")),
        ("title=a = b", ("title", "a = b")),
        ("slip.finite_size=true", ("slip.finite_size", True)),
        ("slip.2s=[1, 2]", ("slip.2s", [1, 2])),
        ("slip.2s={strength=1, axis=[0,1,0]}", ("slip.2s", {"strength": 1, "axis": [0, 1, 0]})),
        ("elasticity.ratio=", ("elasticity.ratio", None)),
        ("title=1\nend = 2", ("title", "1\nend = 2")),
    ],
)
def test_assignments(text, expected):
    assert parse_assignment(text) == expected


@pytest.mark.parametrize("text", ["", "slip.2s", "=5", ".2s=5", "slip.=5", "slip..2s=5"])
def test_what_is_not_an_assignment_is_refused(text):
    with pytest.raises(SceneError, match="key=value"):
        parse_assignment(text)


# --- derived numbers ---------------------------------------------------------------------------


def test_friction():
    scene = scene_of(**{"chain.radius": 2.0, "chain.viscosity": 0.5})
    assert scene.drag == pytest.approx((6 * math.pi, 32 * math.pi))


def test_the_stiffness_rule():
    """λ = R μ γ_R / (γ_T d⁴ (N−1)⁴), worked out by hand for N = 64, a = η = 1, d = 10."""
    scene = scene_of(**{"chain.particles": 64, "elasticity.ratio": 1e7})
    bend = 600 * math.pi
    stiffness = 1e7 * bend * 4 / 3 / (1e4 * 63**4)
    assert scene.moduli == pytest.approx((stiffness, stiffness, bend, bend))
    assert scene.moduli == scene_of(**{"chain.particles": 64}).moduli
    assert scene.moduli.stretch * 10 == pytest.approx(1.6, rel=0.01)


@pytest.mark.parametrize(
    ("elasticity", "expected"),
    [
        ({"stretch": 2.0, "shear": 3.0}, (2.0, 3.0, 600 * math.pi, 600 * math.pi)),
        ({"stretch": 2.0, "shear": 0.0, "twist": 4.0, "bend": 5.0}, (2.0, 0.0, 4.0, 5.0)),
        ({"ratio": 81.0, "bend": 7.5}, (1e-3, 1e-3, 7.5, 7.5)),
        ({"ratio": 81.0, "bend": 7.5, "twist": 0.0}, (1e-3, 1e-3, 0.0, 7.5)),
        ({"bend": 0.0}, (0.0, 0.0, 0.0, 0.0)),
    ],
)
def test_moduli(elasticity, expected):
    changes = {f"elasticity.{name}": value for name, value in elasticity.items()}
    assert scene_of(**changes).moduli == pytest.approx(expected)


@pytest.mark.parametrize(
    ("ends", "length", "period", "wavevector"),
    [
        ("free", 24.0, 0.0, 2 * math.pi / 24),
        ("clamped", 24.0, 0.0, 2 * math.pi / 24),
        ("periodic", 32.0, 32.0, 4 * math.pi / 32),
    ],
)
def test_length_period_and_wavevector(ends, length, period, wavevector):
    scene = scene_of(**{"chain.ends": ends, "chain.spacing": 8.0, "start.wavenumber": 2})
    assert (scene.length, scene.period) == (length, period)
    assert scene.wavevector == pytest.approx(wavevector)


def test_a_periodic_chain_may_have_more_neighbours_than_spheres():
    assert scene_of(**PERIODIC, **{"slip.neighbours": 9}).slip.neighbours == 9


def test_importing_scenes_stays_light():
    code = (
        "import sys, nrchain.scene.scene;"
        "print({'numpy', 'scipy', 'numba', 'h5py', 'matplotlib'} & set(sys.modules))"
    )
    printed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert printed.stdout.strip() == "set()"


@pytest.mark.parametrize("text", [None, b"title = 'x'", 5])
def test_what_is_no_toml_text_is_refused(text):
    with pytest.raises(SceneError, match="must be TOML text"):
        Scene.from_toml(text)


@pytest.mark.parametrize("kind", [Scene, ChainSpec, SlipSpec])
def test_what_is_no_table_is_refused(kind):
    with pytest.raises(SceneError, match="must be a table"):
        kind.from_mapping(None)
