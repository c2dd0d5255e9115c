"""The public functions for scripts, and a mode that a user adds in one place."""

import subprocess
import sys

import numpy as np
import pytest
from support.poses import pose_derivative, random_chain

import nrchain
from nrchain import slip_modes
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.planning.plan import plan
from nrchain.planning.regime import warnings
from nrchain.theory.rod import beam_rates, continuum_operator, discrete_operator, transverse

ALL = {"2s": 1.5, "3a": -2.0, "3t": 0.7, "4a": 1.1}


def active(positions, frames, slip=ALL, **options):
    return np.concatenate(nrchain.active_wrenches(positions, frames, slip, **options), axis=1)


@pytest.mark.parametrize("label", ALL)
def test_action_is_not_reaction(label):
    positions, frames = random_chain(2)
    wrench = active(positions, frames, {label: 1.0})
    force = wrench[:, :3].sum(axis=0)
    moment = (np.cross(positions, wrench[:, :3]) + wrench[:, 3:]).sum(axis=0)
    assert np.abs(force).max() > 0.05 * np.abs(wrench[:, :3]).max()
    assert np.abs(moment).max() > 0.05 * np.abs(wrench).max()


@pytest.mark.parametrize("label", ALL)
@pytest.mark.parametrize("backend", ["native", "pystokes"])
def test_torque_is_half_the_curl_of_the_force_law(label, backend):
    # a probe with no slip in the field of one sphere: T/γ_R = ½ ∇ × (F/γ_T)
    positions, frames = random_chain(2)
    slip = {label: np.array([0.0, 2.0])}
    step = 1e-5

    def wrench(shift):
        moved = positions + np.array([shift, np.zeros(3)])
        return active(moved, frames, slip, backend=backend)[0]

    slope = np.array(
        [(wrench(step * k)[:3] - wrench(-step * k)[:3]) / (2 * step) for k in np.eye(3)]
    )
    curl = np.array(
        [slope[1, 2] - slope[2, 1], slope[2, 0] - slope[0, 2], slope[0, 1] - slope[1, 0]]
    )
    torque = wrench(np.zeros(3))[3:]
    assert torque == pytest.approx(4 / 3 * curl / 2, abs=1e-7)


def test_viscosity_scales_wrenches_only():
    positions, frames = random_chain(4)
    assert active(positions, frames, viscosity=3.0) == pytest.approx(3 * active(positions, frames))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"slip": {"2x": 1.0}}, "known modes are .*did you mean '2s'"),
        ({"slip": {"2s": [1.0, 2.0]}}, r"shape must be \(5,?\)"),
        ({"slip": {"2s": float("nan")}}, "finite"),
        ({"neighbours": 0}, "neighbours"),
        ({"neighbours": True}, "neighbours"),
        ({"neighbours": "some"}, "neighbours"),
        ({"radius": -1.0}, "radius"),
        ({"viscosity": "thick"}, "viscosity"),
        ({"backend": "fast"}, "backend"),
        ({"positions": np.zeros((5, 2))}, "positions"),
        ({"positions": np.zeros((5, 3))}, "must not coincide"),
        ({"frames": np.ones((5, 3, 3))}, "orthonormal"),
        ({"frames": None}, "frames"),
        ({"positions": "here"}, "positions"),
        ({"slip": None}, r"^slip = None: must be a table of mode labels"),
        ({"slip": [1.0]}, r"^slip = \[1.0\]: must be a table"),
        ({"slip": "2s"}, "^slip = '2s': must be a table"),
        ({"slip": {"2s": None}}, r"slip\['2s'\] = None: must be numbers"),
        ({"slip": {"2s": "strong"}}, r"slip\['2s'\] = 'strong'"),
        ({"slip": {"2s": "5"}}, r"slip\['2s'\] = '5'"),
        ({"slip": {"2s": True}}, r"slip\['2s'\] = True"),
        ({"slip": {"2s": [True] * 5}}, r"slip\['2s'\]"),
        ({"slip": {"2s": [[1.0], 2.0]}}, r"slip\['2s'\]"),
        ({"slip": {"2s": {"strength": 1.0, "axes": [1, 0, 0]}}}, r"slip\['2s'\].axes.*'axis'"),
        ({"slip": {"2s": {}}}, r"slip\['2s'\].strength is not given"),
        ({"slip": {2: 1.0}}, "slip mode = 2: known modes"),
        ({"finite_size": "no"}, "finite_size = 'no': must be true or false"),
        ({"radius": True}, "radius = True"),
    ],
)
def test_bad_arguments_are_named(changes, message):
    positions, frames = random_chain(5)
    arguments = {"positions": positions, "frames": frames, "slip": ALL} | changes
    with pytest.raises(SceneError, match=message):
        nrchain.active_wrenches(**arguments)


@pytest.mark.parametrize("backend", ["native", "pystokes"])
@pytest.mark.parametrize(
    "changes",
    [{"radius": 1e200}, {"viscosity": 1e308}, {"positions": 1e-200}, {"slip": {"2s": 1e308}}],
)
def test_wrenches_beyond_the_range_of_floats_are_refused(backend, changes):
    positions, frames = random_chain(3)
    changes = dict(changes)
    positions = positions * changes.pop("positions", 1.0)
    slip = changes.pop("slip", {"2s": 1e5}), 3.0
    with pytest.raises(nrchain.SceneError, match="range of floating point"):
        nrchain.active_wrenches(
            positions, frames, slip[0], **{"radius": slip[1], "backend": backend} | changes
        )


@pytest.mark.parametrize("law", [nrchain.elastic_wrenches, nrchain.elastic_energy])
def test_elasticity_beyond_the_range_of_floats_is_refused(law):
    positions, frames = random_chain(3)
    moduli = dict.fromkeys(["stretch", "shear", "twist", "bend"], 1e100)
    with pytest.raises(nrchain.SceneError, match="range of floating point"):
        law(1e150 * positions, frames, spacing=1.0, **moduli)


def test_a_slip_may_be_the_table_of_a_scene_file():
    positions, frames = random_chain(5)
    table = {"strength": [1.0, 2.0, 3.0, 4.0, 5.0], "axis": [0.0, 3.0, 4.0]}
    slip = nrchain.Slip((1.0, 2.0, 3.0, 4.0, 5.0), axis=(0.0, 3.0, 4.0))
    np.testing.assert_array_equal(
        active(positions, frames, {"3a": table}), active(positions, frames, {"3a": slip})
    )


@pytest.mark.parametrize(
    "call",
    [
        nrchain.simulate,
        nrchain.describe,
        nrchain.steady_velocity,
        nrchain.steady_stress,
        nrchain.Rod.of,
        lambda scene: nrchain.lattice_rates(scene, [0.1]),
        plan,
        warnings,
    ],
)
@pytest.mark.parametrize("given", [None, "buckling", {"chain": {"particles": 4}}, 3])
def test_what_is_no_scene_is_refused_with_how_to_come_by_one(call, given):
    with pytest.raises(SceneError, match="load_scene makes one") as caught:
        call(given)
    assert caught.value.key == "scene"


@pytest.mark.parametrize("waves", ["all", [0.1, "x"], float("nan"), [0.1, np.inf], None, 1j])
def test_wavenumbers_are_finite_numbers(waves):
    scene = nrchain.load_scene("buckling")
    rod = nrchain.Rod.of(scene)
    for call in (nrchain.lattice_rates, nrchain.lattice_operator):
        with pytest.raises(SceneError, match="wavenumbers"):
            call(scene, waves)
    for law in (discrete_operator, continuum_operator, beam_rates, transverse):
        with pytest.raises(SceneError, match="wavenumbers"):
            law(rod, waves)


@pytest.mark.parametrize("law", [discrete_operator, continuum_operator, beam_rates, transverse])
def test_one_wavenumber_gives_what_a_list_of_it_does(law):
    rod = nrchain.Rod.of(nrchain.load_scene("buckling"))
    np.testing.assert_array_equal(law(rod, 0.03), law(rod, [0.03])[0])


@pytest.fixture
def quadrupole():
    """The axial potential quadrupole −a⁴ V ∇∇∇(1/r) : ee / 6, given by its velocity alone."""
    mode = slip_modes.SlipMode(
        label="4t",
        name="potential quadrupole",
        order=4,
        polar=False,
        chiral=False,
        velocity={("n", 4): ("-1/2", 0, "5/2"), ("e", 4): (0, -1)},
    )
    yield slip_modes.register(mode)
    slip_modes.unregister("4t")


def test_a_mode_registered_in_one_place_works_everywhere(quadrupole):
    positions, frames = random_chain(5)
    forces, torques = nrchain.active_wrenches(positions, frames, {"4t": 2.0}, neighbours="all")
    # u = V (a/r)⁴ [(5c² − 1) n/2 − c e], without vorticity
    expected = np.zeros((5, 3))
    for i in range(5):
        for j in set(range(5)) - {i}:
            x = positions[i] - positions[j]
            r = np.linalg.norm(x)
            c = frames[j, 0] @ x / r
            expected[i] += 12 * np.pi / r**4 * ((5 * c**2 - 1) / 2 * x / r - c * frames[j, 0])
    assert forces == pytest.approx(expected, rel=1e-12)
    assert np.abs(torques).max() < 1e-13
    scene = nrchain.load_scene("passive", **{"slip.4t": 50.0, "run.end": 10.0})
    assert nrchain.Scene.from_toml(scene.to_toml()) == scene
    assert nrchain.simulate(scene).status == "completed"
    model = Model(nrchain.load_scene(scene, chain={"particles": 5, "ends": "free"}))
    blocks = np.zeros((5, 7, 6, 6))
    model.linearise(positions, frames, blocks)
    numeric = pose_derivative(model.twists, positions, frames)
    assert blocks[2, 3] == pytest.approx(numeric[2, :, 2], abs=1e-7 * np.abs(numeric).max())


def test_a_mode_pystokes_lacks_is_refused_there(quadrupole):
    with pytest.raises(SceneError, match="4t"):
        nrchain.active_wrenches(*random_chain(3), {"4t": 1.0}, backend="pystokes")


def test_import_is_light():
    script = (
        "import nrchain, sys; print([m for m in ('numba', 'scipy', 'h5py') if m in sys.modules])"
    )
    shown = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert shown.stdout.strip() == "[]"


def test_every_public_name_exists():
    for name in nrchain.__all__:
        assert getattr(nrchain, name) is not None
    with pytest.raises(AttributeError):
        nrchain.no_such_name  # noqa: B018
