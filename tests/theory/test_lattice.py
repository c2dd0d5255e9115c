"""The lattice operator against differenced twists of the simulated chain, and its branches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrchain import slip_modes
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.scene.loading import load_scene
from nrchain.theory.lattice import (
    Branch,
    lattice_operator,
    lattice_rates,
    steady_rotation,
    steady_stress,
    steady_velocity,
)
from nrchain.theory.straight_chain import StraightChain

STRENGTHS = {"2s": 30.0, "3a": -400.0, "3t": 500.0, "4a": 3000.0}
BASE = {"chain.particles": 10, "chain.spacing": 4.0, "run.end": 1.0, "elasticity.ratio": 1e4}


def scene(modes=STRENGTHS, **changes):
    slips = {f"slip.{label}": value for label, value in modes.items()}
    return load_scene(BASE | slips | {key.replace("__", "."): v for key, v in changes.items()})


def pairwise(neighbours):
    return {"friction__kind": "pairwise", "friction__neighbours": neighbours}


def rotation(vector):
    """exp(φ×) by Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    if angle == 0.0:
        return np.eye(3)
    sine, versine = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2
    return np.eye(3) + sine * cross + versine * cross @ cross


def twists_at(model, spacing, poses):
    """Twists of a straight chain displaced and turned by ``poses`` (N, 6)."""
    positions = poses[:, :3].copy()
    positions[:, 0] += spacing * np.arange(model.count)
    frames = np.array([rotation(p[3:]).T for p in poses])
    return model.twists(positions, frames)


def differenced(model, spacing, poses, step=1e-4):
    """d twists along ``poses``, by a central difference of fourth order."""
    at = [twists_at(model, spacing, n * step * poses) for n in (-2, -1, 1, 2)]
    return (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step)


def measured_operator(chain, phase, sphere=0):
    """M(q) of a sphere of the simulated chain, with Ω0 × φ, from real plane waves."""
    model, spacing = Model(chain), chain.chain.spacing
    wave = np.exp(1j * phase * (np.arange(model.count) - sphere))
    straight = twists_at(model, spacing, np.zeros((model.count, 6)))
    operator = np.zeros((6, 6), complex)
    for column, unit in enumerate(np.eye(6)):
        for factor, part in ((1.0, wave.real), (1j, wave.imag)):
            change = differenced(model, spacing, part[:, None] * unit)[sphere]
            operator[:, column] += factor * change
    spin = straight[sphere, 3]
    operator[4, 5] -= spin
    operator[5, 4] += spin
    return operator


@pytest.mark.parametrize("friction", [{}, pairwise(1), pairwise(23)])
@pytest.mark.parametrize("neighbours", [1, 3, 14])
def test_operator_is_the_derivative_of_the_periodic_chain(neighbours, friction):
    chain = scene(
        slip__neighbours=neighbours, slip__finite_size=True, chain__ends="periodic", **friction
    )
    for n in (1, 4):
        phase = 2 * math.pi * n / 10
        expected = measured_operator(chain, phase)
        operator = lattice_operator(chain, phase / 4.0)
        np.testing.assert_allclose(operator, expected, atol=1e-9 * np.abs(expected).max())


FORCES = {
    "along": {"force": [3.0, 0, 0], "torque": [5.0, 0, 0], "body_force": [-40.0, 0, 0]},
    "across": {"force": [30.0, -20.0, 50.0], "torque": [-40.0, 0, 0]},
    "with the spheres": {"body_force": [20.0, 60.0, -30.0], "body_torque": [50.0, 0, 0]},
}


@pytest.mark.parametrize("neighbours", [1, 3, 14])
@pytest.mark.parametrize("field", FORCES)
def test_uniform_forces_through_the_fluid_have_plane_waves(field, neighbours):
    """Against differences of the simulated chain, and V0 and Ω0 with them."""
    chain = scene(
        {"2s": 30.0, "3t": 500.0},
        **{"chain__ends": "periodic", "chain__radius": 0.7, "chain__viscosity": 2.3},
        **pairwise(neighbours),
        field=FORCES[field],
    )
    straight = twists_at(Model(chain), 4.0, np.zeros((10, 6)))[0]
    np.testing.assert_allclose(steady_velocity(chain), straight[:3], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(steady_rotation(chain), straight[3:], rtol=1e-12, atol=1e-14)
    turns_with_it = field == "with the spheres"
    for n in (1, 4):
        phase = 2 * math.pi * n / 10
        expected = measured_operator(chain, phase)
        if turns_with_it:
            # seen along axes that spin with it, from the same derivative
            spin = straight[3]
            expected[4, 5] += spin
            expected[5, 4] -= spin
            expected[1, 2] += spin
            expected[2, 1] -= spin
        frame = "spinning" if turns_with_it else "lab"
        operator = lattice_operator(chain, phase / 4.0, frame=frame)
        np.testing.assert_allclose(operator, expected, atol=1e-9 * np.abs(expected).max())
        rates = lattice_rates(chain, phase / 4.0, frame=frame)
        eigenvalues = np.linalg.eigvals(operator)
        for value in rates:
            assert np.abs(eigenvalues - value).min() < 1e-9 * np.abs(eigenvalues).max()
    if field != "along":
        with pytest.raises(SceneError, match="use frame="):
            lattice_rates(chain, 0.1, frame="lab" if turns_with_it else "spinning")


def test_a_chain_that_turns_past_a_force_of_the_lab_has_no_axes_of_its_own():
    field = {"force": [0, 3.0, 0], "body_force": [0, 20.0, 0], "torque": [9.0, 0, 0]}
    both = scene({}, field=field, **pairwise(2))
    for frame in ("lab", "spinning"):
        with pytest.raises(SceneError, match="no axes have steady coefficients"):
            lattice_rates(both, 0.1, frame=frame)
    # what one of them asks for is enough without the other
    for less, frame in (({"force": [0, 0, 0]}, "spinning"), ({"body_force": [0, 0, 0]}, "lab")):
        assert np.isfinite(
            lattice_rates(scene({}, field=field | less, **pairwise(2)), 0.1, frame=frame)
        ).all()


@pytest.mark.parametrize(
    "gradient",
    [
        [[0, 0, 0], [0, 0, 0.7], [0, 0, 0]],
        [[0, 0, 0], [0, 0.4, 0.3], [0, 0.3, -0.4]],
        [[0, 0, 0], [0, 0, -0.6], [0, 0.6, 0]],
    ],
)
@pytest.mark.parametrize("friction", [{}, pairwise(3)])
def test_a_flow_across_the_chain_has_plane_waves(gradient, friction):
    flow = {"gradient": gradient, "disturbance": False}
    chain = scene({"2s": 30.0}, chain__ends="periodic", flow=flow, **friction)
    straight = twists_at(Model(chain), 4.0, np.zeros((10, 6)))[0]
    np.testing.assert_allclose(steady_rotation(chain), straight[3:], rtol=1e-12, atol=1e-14)
    for n in (1, 4):
        phase = 2 * math.pi * n / 10
        expected = measured_operator(chain, phase)
        operator = lattice_operator(chain, phase / 4.0)
        np.testing.assert_allclose(operator, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("flow", "reason"),
    [
        ({"gradient": [[0.2, 0, 0], [0, -0.1, 0], [0, 0, -0.1]]}, "stretches a straight chain"),
        ({"gradient": [[0, 0.5, 0], [0, 0, 0], [0, 0, 0]]}, "across it"),
        ({"gradient": [[0, 0, 0], [0, 0, 0.7], [0, 0, 0]]}, "flow.disturbance = false"),
    ],
)
def test_a_flow_that_the_lattice_does_not_hold_is_refused_for_what_it_does(flow, reason):
    with pytest.raises(SceneError, match=reason):
        lattice_rates(scene({}, flow={"disturbance": reason.endswith("false")} | flow), 0.1)


def test_stress_is_that_of_slip_whatever_else_acts():
    expected = steady_stress(scene(), spheres=5)
    for changes in (
        {"flow": {"gradient": [[0.2, 0, 0], [0, -0.1, 0], [0, 0, -0.1]]}},
        {"field": {"force": [1.0, 2.0, 0], "torque": [0, 1.0, 0]}} | pairwise("all"),
    ):
        np.testing.assert_array_equal(steady_stress(scene(**changes), spheres=5), expected)


@pytest.mark.parametrize(
    ("changes", "key", "offers_all"),
    [
        ({"slip__neighbours": 1_000_001}, "slip.neighbours", True),
        (pairwise(1_000_001), "friction.neighbours", True),
        (pairwise(1_000_001) | {"field": {"force": [0, 0, 1.0]}}, "friction.neighbours", False),
    ],
)
def test_a_reach_too_long_to_be_summed_names_its_key(changes, key, offers_all):
    with pytest.raises(SceneError, match="at most 1000000") as caught:
        lattice_rates(scene(**changes), 0.1)
    assert caught.value.key == key
    assert ("'all'" in caught.value.allowed) is offers_all
    if offers_all:
        last = key.replace(".", "__")
        assert np.isfinite(lattice_rates(scene(**(changes | {last: "all"})), 0.1)).all()
    else:
        with pytest.raises(SceneError, match="without limit: use a number"):
            lattice_rates(scene(**(changes | pairwise("all"))), 0.1)


def test_rates_are_the_eigenvalues_of_a_whole_periodic_chain():
    """All 6N eigenvalues of the differenced Jacobian of a chain are the rates of its waves."""
    chain = scene(slip__neighbours=3, chain__ends="periodic", chain__particles=8)
    model, size = Model(chain), 48
    jacobian = np.empty((size, size))
    for column in range(size):
        unit = np.zeros(size)
        unit[column] = 1.0
        jacobian[:, column] = differenced(model, 4.0, unit.reshape(8, 6)).ravel()
    spin = twists_at(model, 4.0, np.zeros((8, 6)))[0, 3]
    for sphere in range(8):
        jacobian[6 * sphere + 4, 6 * sphere + 5] -= spin
        jacobian[6 * sphere + 5, 6 * sphere + 4] += spin
    wavenumbers = 2 * math.pi * np.arange(8) / (8 * 4.0)
    rates = list(lattice_rates(chain, wavenumbers).ravel())
    for value in np.linalg.eigvals(jacobian):
        nearest = int(np.argmin(np.abs(np.array(rates) - value)))
        assert abs(rates.pop(nearest) - value) < 1e-6 * np.abs(jacobian).max()


def test_all_pairs_are_the_middle_of_a_long_open_chain():
    chain = scene(slip__neighbours="all", chain__particles=801, elasticity__ratio=1e10)
    phase = 1.3
    expected = measured_operator(chain, phase, sphere=400)
    operator = lattice_operator(chain, phase / 4.0)
    np.testing.assert_allclose(operator, expected, atol=1e-7 * np.abs(expected).max())
    straight = twists_at(Model(chain), 4.0, np.zeros((801, 6)))[400]
    np.testing.assert_allclose(steady_velocity(chain), straight[:3], rtol=1e-5, atol=1e-12)
    np.testing.assert_allclose(steady_rotation(chain), straight[3:], rtol=1e-9, atol=1e-12)


def test_friction_of_all_pairs_is_that_of_the_middle_of_a_long_open_chain():
    """The ends cut the 1/r mobility off, with an error of 1/(N sin θ/2)."""
    chain = scene({}, chain__particles=1601, elasticity__ratio=1e14, **pairwise("all"))
    phase = 1.3
    expected = measured_operator(chain, phase, sphere=800)
    operator = lattice_operator(chain, phase / 4.0)
    np.testing.assert_allclose(operator, expected, atol=1e-3 * np.abs(expected).max())
    one_body = lattice_operator(scene({}, elasticity__ratio=1e14, chain__particles=1601), phase / 4)
    assert np.abs(operator - one_body).max() > 0.1 * np.abs(expected).max()


def test_mobility_in_closed_form():
    """Fourier sums of the Rotne–Prager–Yamakawa mobilities along a line, all pairs."""
    a, d, theta = 1.0, 4.0, np.array([0.05, 0.7, 3.0])
    m = np.arange(1, 100_001)[:, None]
    first = -np.log(2 * np.sin(theta / 2))
    third = (np.cos(m * theta) / m**3).sum(axis=0)
    sines = (np.sin(m * theta) / m**2).sum(axis=0)
    own, s = 1 / (6 * math.pi * a), a / d
    along = own * (1 + 3 * s * first - 2 * s**3 * third)
    across = own * (1 + 1.5 * s * first + s**3 * third)
    turning = (1 - s**3 * third) / (8 * math.pi * a**3)
    twisting = (1 + 2 * s**3 * third) / (8 * math.pi * a**3)
    mobility = StraightChain(scene(**pairwise("all"))).mobility(theta)
    diagonal = np.stack([along, across, across, twisting, turning, turning], axis=-1)
    np.testing.assert_allclose(np.einsum("nii->ni", mobility), diagonal, rtol=1e-8)
    turned = 2j * sines / (8 * math.pi * d**2)
    np.testing.assert_allclose(mobility[:, 2, 4], turned, rtol=1e-8)
    np.testing.assert_allclose(mobility, mobility.conj().swapaxes(-1, -2), atol=1e-17)
    assert np.linalg.eigvalsh(mobility).min() > 0


@pytest.mark.parametrize("neighbours", [2, "all"])
def test_friction_between_spheres_changes_what_elasticity_does_and_not_slip(neighbours):
    """Along x nothing couples: stretch and twist relax μ(q) times faster, and slip stays."""
    q = np.array([1e-6, 0.02, 0.7])
    chain, alone = scene(**pairwise(neighbours)), scene()
    mobility = StraightChain(chain).mobility(q * 4.0) * chain.drag[0]
    twisted = StraightChain(chain).mobility(q * 4.0) * chain.drag[1]
    slip, passive = lattice_rates(scene(elasticity__ratio=None, elasticity__stretch=0.0,
        elasticity__shear=1.0, elasticity__twist=0.0), q), lattice_rates(scene({}), q)  # fmt: skip
    rates = lattice_rates(chain, q)
    expected = passive[:, Branch.STRETCH] * mobility[:, 0, 0] + slip[:, Branch.STRETCH]
    np.testing.assert_allclose(rates[:, Branch.STRETCH], expected, rtol=1e-12)
    expected = passive[:, Branch.TWIST] * twisted[:, 3, 3]
    np.testing.assert_allclose(rates[:, Branch.TWIST], expected, rtol=1e-12)
    np.testing.assert_array_equal(steady_velocity(chain), steady_velocity(alone))


def test_friction_of_all_pairs_has_no_part_at_zero_wavenumber():
    rates = lattice_rates(scene(**pairwise("all")), [0.0, 1e-9])
    assert np.isfinite(rates).all()
    np.testing.assert_allclose(rates[0], rates[1], rtol=1e-6, atol=1e-5)


def test_friction_that_is_not_dissipative_is_refused():
    """Nearest neighbours alone, almost touching, squeezed against each other at θ = π."""
    chain = scene({}, chain__spacing=2.01, **pairwise(1))
    assert np.isfinite(lattice_rates(chain, 0.1)).all()
    with pytest.raises(SceneError, match=r"friction\.neighbours.*positive definite"):
        lattice_rates(chain, math.pi / 2.01)
    assert np.isfinite(lattice_rates(scene({}, chain__spacing=2.01, **pairwise("all")), 1.5)).all()


def test_all_pairs_are_the_limit_of_many_neighbours():
    """The remainder after k neighbours falls as its leading power: 1/k² of the 2s torque."""
    q = np.array([0.01, 0.2])
    every = lattice_operator(scene(slip__neighbours="all"), q)
    errors = [
        np.abs(lattice_operator(scene(slip__neighbours=k), q) - every).max() for k in (1000, 4000)
    ]
    assert errors[1] < errors[0] / 10
    assert errors[1] < 1e-6


def test_steady_motion_in_closed_form():
    a, d, zeta3, zeta5 = 1.0, 4.0, 1.2020569031595942, 1.0369277551433699
    for reach, three, five in ((1, 1.0, 1.0), (2, 1.125, 1 + 1 / 32), ("all", zeta3, zeta5)):
        chain = scene(slip__neighbours=reach)
        np.testing.assert_allclose(
            steady_velocity(chain), [0.8 * a**3 * 500 / d**3 * three, 0, 0], rtol=1e-14
        )
        np.testing.assert_allclose(
            steady_rotation(chain), [-363 / 5 * a**4 * 3000 / d**5 * five, 0, 0], rtol=1e-14
        )


@pytest.mark.parametrize("neighbours", [1, 2, "all"])
def test_stress_is_what_one_half_of_a_chain_does_to_the_other(neighbours):
    right = {label: (0.0,) * 5 + (value,) * 5 for label, value in STRENGTHS.items()}
    half = scene(right, slip__neighbours=neighbours)
    twists = np.zeros((10, 6))
    straight = np.zeros((10, 3))
    straight[:, 0] = 4.0 * np.arange(10)
    Model(half).add_slip_twists(straight, np.tile(np.eye(3), (10, 1, 1)), twists)
    expected = twists[:5].sum(axis=0) * np.repeat(half.drag, 3)
    stress = steady_stress(scene(slip__neighbours=neighbours), spheres=5)
    np.testing.assert_allclose(stress, expected, rtol=1e-13, atol=1e-10)


def test_stress_of_endless_halves():
    gamma_t, gamma_r = scene().drag
    stress = steady_stress(scene({"2s": 30.0}))
    assert stress[0] == pytest.approx(-7 / 3 * 30.0 / 16 * gamma_t, rel=1e-14)
    every = steady_stress(scene({"3a": 50.0}, slip__neighbours="all"))
    zeta3 = 1.2020569031595942
    assert every[3] == pytest.approx(-13 / 12 * 50.0 / 4**4 * gamma_r * zeta3, rel=1e-14)
    assert steady_stress(scene({"2s": 30.0}, slip__neighbours="all"))[0] == -math.inf


mode_strengths = st.fixed_dictionaries(
    {label: st.floats(-2 * v, 2 * v) if v > 0 else st.floats(2 * v, -2 * v)
     for label, v in STRENGTHS.items()}
)  # fmt: skip


@settings(deadline=None, max_examples=25)
@given(
    mode_strengths,
    st.floats(1e-3, 3.1),
    st.sampled_from([1, 4, "all"]),
    st.floats(0.0, 1e5),
    st.floats(0.0, 1e5),
    st.sampled_from([{}, pairwise(3), pairwise("all")]),
)
def test_branches(modes, phase, neighbours, stretch, shear, friction):
    """Rates are eigenvalues of the operator; signs of q, hands and frames are related as stated."""
    chain = scene(
        modes,
        slip__neighbours=neighbours,
        elasticity__ratio=None,
        elasticity__stretch=stretch,
        elasticity__shear=shear,
        **friction,
    )
    q = np.array([phase, -phase, phase + 2 * math.pi]) / 4.0
    rates = lattice_rates(chain, q)
    scale = np.abs(lattice_operator(chain, q)).max()
    values = np.linalg.eigvals(lattice_operator(chain, q[0]))
    polynomial = np.poly(rates[0] / scale)
    np.testing.assert_allclose(polynomial, np.poly(values / scale), atol=1e-11)
    swapped = [Branch.BEND_MINUS, Branch.BEND_PLUS, 2, 3, Branch.SHEAR_MINUS, Branch.SHEAR_PLUS]
    np.testing.assert_allclose(rates[1], rates[0, swapped].conj(), atol=1e-13 * scale)
    np.testing.assert_allclose(rates[2], rates[0], atol=1e-9 * scale)
    spin = steady_rotation(chain)[0]
    shift = 1j * spin * np.array([branch.hand for branch in Branch])
    spinning = lattice_rates(chain, q, frame="spinning")
    np.testing.assert_allclose(rates, spinning + shift, atol=1e-11 * (scale + abs(spin)))


@pytest.mark.parametrize("friction", [{}, pairwise("all")])
@pytest.mark.parametrize("neighbours", [1, "all"])
def test_long_waves_separate_bending_from_shear(neighbours, friction):
    """For q → 0 bending is free and shear has a gap; stiffness changes neither."""
    rates = {
        stiffness: lattice_rates(
            scene(
                slip__neighbours=neighbours,
                elasticity__ratio=None,
                elasticity__stretch=stiffness,
                elasticity__shear=stiffness,
                **friction,
            ),
            [1e-4, 1e-2],
        )
        for stiffness in (1e8, 1e12, 1e15)
    }
    turning = StraightChain(scene(**friction)).mobility(np.zeros(1))[..., 4, 4].item().real
    gap = 1e8 * 4.0**2 * turning
    assert rates[1e8][0, Branch.SHEAR_PLUS].real == pytest.approx(-gap, rel=1e-5)
    assert np.abs(rates[1e8][0, [Branch.BEND_PLUS, Branch.BEND_MINUS]]).max() < 0.02
    bend = [Branch.BEND_PLUS, Branch.BEND_MINUS, Branch.TWIST]
    np.testing.assert_allclose(rates[1e15][:, bend], rates[1e12][:, bend], rtol=1e-8)
    np.testing.assert_allclose(rates[1e12][:, bend], rates[1e8][:, bend], rtol=1e-5)


def test_right_handed_helices_of_positive_wavenumber_are_plus():
    """3a of negative strength winds a chain into right-handed helices (paper, Fig. 5)."""
    rates = lattice_rates(scene({"3a": -400.0}, elasticity__bend=0.0), [0.05])[0]
    assert rates[Branch.BEND_PLUS].real > 0 > rates[Branch.BEND_MINUS].real
    assert [branch.hand for branch in Branch] == [1, -1, 0, 0, 1, -1]


def test_shapes_follow_the_wavenumbers():
    chain = scene()
    assert lattice_rates(chain, 0.1).shape == (6,)
    assert lattice_rates(chain, np.zeros((3, 2))).shape == (3, 2, 6)
    assert lattice_operator(chain, np.zeros((3, 2))).shape == (3, 2, 6, 6)


def make_mode(monkeypatch, label, velocity, polar=False):
    mode = slip_modes.SlipMode(
        label=label, name=label, order=2, polar=polar, chiral=False, velocity=velocity
    )
    monkeypatch.setitem(slip_modes._MODES, label, mode)


def test_a_registered_mode_of_many_powers(monkeypatch):
    """A mode that is the sum of two has the sum of their operators."""
    quadrupole = {("n", 4): ("-1/2", 0, "5/2"), ("e", 4): (0, -1)}
    make_mode(monkeypatch, "8q", quadrupole)
    make_mode(monkeypatch, "9z", dict(slip_modes.find("2s").velocity) | quadrupole)
    q = np.array([0.01, 0.3, 0.7])
    for neighbours in (1, "all"):
        options = {"slip__neighbours": neighbours, "elasticity__ratio": 1e-3}
        one = scene({"9z": 7.0}, **options)
        expected = lattice_operator(scene({"2s": 7.0, "8q": 7.0}, **options), q)
        np.testing.assert_allclose(
            lattice_operator(one, q), expected, atol=1e-13 * np.abs(expected).max()
        )


def test_a_flow_without_an_endless_sum_is_refused(monkeypatch):
    make_mode(monkeypatch, "1s", {("n", 1): (0, 1), ("e", 1): (1,)}, polar=True)
    with pytest.raises(SceneError, match=r"slip\.neighbours"):
        lattice_rates(scene({"1s": 1.0}, slip__neighbours="all"), [0.1])
    velocity = steady_velocity(scene({"1s": 1.0}, slip__neighbours=3))
    assert velocity[0] == pytest.approx(2 * 2 / 4.0 * (1 + 1 / 2 + 1 / 3), rel=1e-14)


def test_other_axes():
    """Anisotropic chains where the straight chain is steady, and those where it is not."""
    across = (0.0, 1.0, 0.0)
    soft = {"elasticity__ratio": None, "elasticity__stretch": 1.0, "elasticity__shear": 1.0}
    puller = scene({"2s": {"strength": 30.0, "axis": across}}, **soft)
    q = np.array([0.05, 0.3])
    rates, values = lattice_rates(puller, q), np.linalg.eigvals(lattice_operator(puller, q))
    order = np.sort_complex
    np.testing.assert_allclose(order(rates), order(values), rtol=1e-9, atol=1e-9)
    shear = rates[0, [Branch.SHEAR_PLUS, Branch.SHEAR_MINUS]].real
    assert np.ptp(shear) > 0.3 * np.abs(shear).max()

    sideways = scene({"3t": {"strength": 500.0, "axis": across}})
    np.testing.assert_allclose(
        steady_velocity(sideways), [0, -2 / 5 * 500.0 / 4**3, 0], rtol=1e-14, atol=1e-14
    )
    reversed_axis = scene({"3t": {"strength": 500.0, "axis": (-2.0, 0.0, 0.0)}})
    np.testing.assert_allclose(
        lattice_rates(reversed_axis, q), lattice_rates(scene({"3t": -500.0}), q), rtol=1e-12
    )
    with pytest.raises(SceneError, match="no straight steady state"):
        lattice_rates(scene({"2s": {"strength": 30.0, "axis": (1.0, 1.0, 0.0)}}), q)

    spinning = scene({"2s": {"strength": 30.0, "axis": across}, "4a": 3000.0})
    with pytest.raises(SceneError, match="spinning"):
        lattice_rates(spinning, q)
    assert lattice_rates(spinning, q, frame="spinning").shape == (2, 6)


def test_what_is_no_uniform_chain_is_refused():
    with pytest.raises(SceneError, match=r"slip\.2s.*uniform chain"):
        lattice_rates(scene({"2s": tuple(range(10))}), [0.1])
    same = scene({"2s": (30.0,) * 10})
    np.testing.assert_array_equal(
        lattice_rates(same, [0.1]), lattice_rates(scene({"2s": 30.0}), [0.1])
    )
    with pytest.raises(SceneError, match="frame"):
        lattice_rates(same, [0.1], frame="moving")
