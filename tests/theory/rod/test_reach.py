"""How far neighbours count: closed forms against the lattice, and their limits for long waves."""

from __future__ import annotations

import numpy as np
import pytest

from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.theory.lattice import Branch, lattice_rates
from nrchain.theory.lattice_sums import power_sum
from nrchain.theory.rod import neighbours_needed, reach_limit, reach_ratio, reach_sum
from nrchain.theory.rod.reach import KINDS

PHASES = np.array([0.05, 0.1, 0.3, 1.0, 2.5])


def rates(mode, direction, reach, radius):
    """The active rate alone: no bending, and no stretch or no shear."""
    stiffness = 1e14 if direction == "transverse" else 0.0
    chain = load_scene(
        {
            "chain": {"particles": 20, "radius": radius},
            "elasticity": {"stretch": stiffness, "shear": stiffness, "twist": 0.0, "bend": 0.0},
            "slip": {"neighbours": reach, mode: 1000.0},
            "run.end": 1.0,
        }
    )
    branch = Branch.BEND_PLUS if direction == "transverse" else Branch.STRETCH
    return lattice_rates(chain, PHASES / 10.0)[:, branch]


@pytest.mark.parametrize("reach", [4, "all"])
@pytest.mark.parametrize(("mode", "direction"), KINDS)
def test_ratios_are_those_of_the_lattice(mode, direction, reach):
    """Up to the active torque, which is (a/d)² small: a tenth of the radius, a hundredth of it."""
    closed = reach_ratio(mode, PHASES, reach, direction)
    errors = [
        np.abs(
            rates(mode, direction, reach, radius) / rates(mode, direction, 1, radius) / closed - 1
        )
        for radius in (1.0, 0.1)
    ]
    assert errors[0].max() < 0.03
    assert np.all(errors[1] < 0.03 * errors[0] + 2e-12)
    assert np.abs(closed - 1).max() > 0.1


@pytest.mark.parametrize(("mode", "direction"), KINDS)
def test_limits_for_long_waves(mode, direction):
    theta = np.array([1e-3, 1e-2])
    off = np.abs(reach_ratio(mode, theta, "all", direction) - reach_limit(mode, theta, direction))
    if direction == "transverse" and mode in ("3t", "4a"):
        assert np.all(off < 40 * theta**4 * np.abs(np.log(theta)))
    else:
        assert np.all(off < theta**2 * (1 + np.abs(np.log(theta))))


def test_numbers_worth_remembering():
    assert reach_ratio("2s", 0.05) == pytest.approx(4.50, abs=0.005)
    assert reach_ratio("2s", 1e-4) == pytest.approx(1.5 - np.log(1e-4), rel=1e-8)
    assert reach_ratio("3a", 1e-4) == pytest.approx(4 / 3 - np.log(1e-4), rel=1e-6)
    assert reach_ratio("3t", 1e-4) == pytest.approx(power_sum(3), rel=1e-8)
    assert reach_ratio("4a", 1e-4) == pytest.approx(power_sum(3), rel=1e-7)


def test_third_order_of_3t_cancels_for_every_distance_and_not_for_all_of_them():
    theta = np.array([1e-2, 2e-2])
    for reach in (1, 5):
        linear = 2 * power_sum(3, reach) * theta
        assert np.all(np.abs(reach_sum("3t", theta, reach) - linear) < 2 * theta**5 * reach**2)
    every = (reach_sum("3t", theta) - 2 * power_sum(3) * theta) / theta**3
    np.testing.assert_allclose(every, -1 / 6, rtol=1e-4)


def test_neighbours_needed_is_the_last_one_outside():
    for mode, direction in KINDS:
        for error in (0.1, 0.01):
            k = neighbours_needed(mode, 0.1, error, direction)
            every = reach_sum(mode, 0.1, "all", direction)
            off = [abs(reach_sum(mode, 0.1, n, direction) / every - 1) for n in (k - 1, k, k + 1)]
            assert off[0] >= error
            assert max(off[1:]) < error
    assert neighbours_needed("2s", 0.05, 0.1) > 10 * neighbours_needed("3t", 0.05, 0.1)


def test_what_has_no_active_rate_is_refused():
    with pytest.raises(SceneError, match="3a longitudinal"):
        reach_ratio("3a", 0.1, "all", "longitudinal")
    with pytest.raises(SceneError, match="error"):
        neighbours_needed("2s", 0.1, 2.0)
