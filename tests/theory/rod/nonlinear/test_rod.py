"""Motions of the rod: energy, rigid motions, mirrors, known solutions, and refused input."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nrchain import Material, SceneError, rod

PASSIVE = Material.from_symbols(
    C_par_F_eps=900.0, C_perp_F_eps=700.0, C_par_M_tau=0.7, C_perp_M_tau=1.1,
    Gamma_T=1.3, Gamma_R=0.02,
)  # fmt: skip
ACTIVE = Material.from_symbols(
    C_par_F_eps=900.0, C_perp_F_eps=700.0, C_par_M_tau=0.7, C_perp_M_tau=1.1,
    Gamma_T=1.3, Gamma_R=0.02, F_pre=-5.0, M_pre=0.5, f_pre=20.0, m_pre=1.0, C_odd_M_tau=0.3,
    H_perp_f_tau=4.0, H_odd_m_tau=1.0,
)  # fmt: skip
CHIRAL = ("M_pre", "m_pre", "C_odd_M_tau", "H_perp_f_tau", "H_odd_m_tau")
TIMES = [0.0, 2e-3, 5e-3]
ARC = [0.0, 0.0, 0.0, 0.8, 0.3, 2.0]


@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_energy_of_a_passive_rod_falls(ends):
    shape = rod.CosseratRod(PASSIVE, 1.2, ends=ends)
    times = np.concatenate([[0.0], np.geomspace(1e-6, 0.3, 30)])
    positions, frames = shape.bent(ARC)
    positions[:, 2] += 0.1 * np.sin(2.0 * np.pi * shape.places / 1.2) ** 2
    motion = shape.simulate(positions, frames, times=times, rtol=1e-7)
    energies = [shape.energy(*poses) for poses in zip(motion.positions, motion.frames, strict=True)]
    assert np.diff(energies).max() <= 1e-9 * energies[0]
    assert energies[-1] < 0.5 * energies[0]


def test_a_moved_start_moves_the_solution():
    shape = rod.CosseratRod(ACTIVE, 1.2)
    turn, shift = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix(), np.array([3.0, -1.0, 2.0])
    positions, frames = shape.bent(ARC)
    first = shape.simulate(positions, frames, times=TIMES, rtol=1e-9)
    second = shape.simulate(positions @ turn.T + shift, frames @ turn.T, times=TIMES, rtol=1e-9)
    assert np.abs(second.positions - first.positions @ turn.T - shift).max() < 1e-9
    assert np.abs(second.frames - first.frames @ turn.T).max() < 1e-9


def test_a_rod_of_the_other_hand_moves_as_the_mirror_image():
    """The mirror z → −z: axial vectors change sign, and e₃ stays right-handed as −e₃."""
    signs = {name: -1.0 if name in CHIRAL else 1.0 for name in rod.SYMBOLS}
    values = {k: signs[k] * v for k, v in ACTIVE.constants.symbols().items()}
    other = Material.from_symbols(Gamma_T=1.3, Gamma_R=0.02, **values)
    image = np.diag([1.0, 1.0, -1.0])
    shape, mirrored = (rod.CosseratRod(m, 1.2) for m in (ACTIVE, other))
    positions, frames = shape.bent(ARC)
    first = shape.simulate(positions, frames, times=TIMES, rtol=1e-9)
    flipped = frames @ image
    flipped[:, 2] *= -1.0
    second = mirrored.simulate(positions @ image, flipped, times=TIMES, rtol=1e-9)
    assert np.abs(second.positions - first.positions @ image).max() < 1e-9


def test_pre_sources_translate_and_spin_a_straight_rod():
    material = Material.from_symbols(
        C_par_F_eps=50.0, C_perp_F_eps=50.0, C_par_M_tau=1.0, C_perp_M_tau=1.0,
        Gamma_T=2.0, Gamma_R=0.1, f_pre=3.0, m_pre=0.7,
    )  # fmt: skip
    shape = rod.CosseratRod(material, 1.5, elements=1, degree=6)
    positions, frames = shape.bent(np.zeros(6))
    motion = shape.simulate(positions, frames, times=[0.0, 2.0])
    expected = frames @ Rotation.from_rotvec([2.0 * 0.7 / 0.1, 0.0, 0.0]).as_matrix().T
    assert np.abs(motion.positions[-1] - positions - [2.0 * 3.0 / 2.0, 0.0, 0.0]).max() < 1e-9
    assert np.abs(motion.frames[-1] - expected).max() < 1e-9


def test_nodes_and_places_between_them_agree():
    shape = rod.CosseratRod(PASSIVE, 1.2, elements=2, degree=12)
    places = np.linspace(0.0, 1.2, 7)
    found = shape.at(places, *shape.bent(ARC))
    from nrchain.theory.rod.helix import Helix

    for part, expected in zip(found, Helix(np.array(ARC)).poses(places), strict=True):
        assert np.abs(part - expected).max() < 1e-10


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"length": 0.0}, "length = 0.0: must be above 0"),
        ({"elements": 0}, "elements = 0: must be an integer of at least 1"),
        ({"elements": 2, "ends": "periodic"}, "elements = 2: must be an integer of at least 3"),
        ({"degree": 1.5}, "degree = 1.5: must be an integer of at least 2"),
        ({"ends": "pinned"}, "ends"),
        ({"end_length": -1.0}, "end_length = -1.0: must be at least 0"),
        ({"quadratic": np.zeros((6, 6))}, "quadratic"),
    ],
)
def test_a_rod_that_cannot_be_is_refused(changes, text):
    with pytest.raises(SceneError, match=text.replace("(", "\\(")):
        rod.CosseratRod(PASSIVE, **({"length": 1.0} | changes))


def test_a_rod_without_drag_is_refused():
    with pytest.raises(SceneError, match="must be positive definite for the rod to move"):
        rod.CosseratRod(Material.from_numbers(np.eye(6)), 1.0)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"times": [0.0, 0.0]}, "times"),
        ({"rtol": 0.0}, "rtol = 0.0: must lie between 0 and 1"),
        ({"positions": np.zeros((3, 3))}, "positions"),
    ],
)
def test_a_motion_that_cannot_be_is_refused(changes, text):
    shape = rod.CosseratRod(PASSIVE, 1.0)
    positions, frames = shape.bent(np.zeros(6))
    given = {"positions": positions, "frames": frames, "times": [0.0, 1.0]} | changes
    with pytest.raises(SceneError, match=text):
        shape.simulate(**given)
