"""Critical strengths, against closed laws of rods and against growth in runs."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import nrchain
from nrchain.errors import SceneError
from nrchain.states.critical import critical_strength

STIFFNESS = 1e3
LINKS = {"elasticity.ratio": None, "elasticity.stretch": STIFFNESS, "elasticity.shear": STIFFNESS}


def euler_strength(scene):
    """V at which the prestress γ_T 7a²V/3d² is the load 4π² κ/L² of a rod with clamped ends."""
    chain, links = scene.chain, scene.chain.particles - 1
    stiffness = scene.moduli.bend * chain.spacing
    load = 4.0 * math.pi**2 * stiffness / (links * chain.spacing) ** 2
    return load * 3.0 * chain.spacing**2 / (7.0 * chain.radius**2 * scene.drag.translation)


def greenhill_strength(scene):
    """V at which the pre-moment M = γ_T 13a³V/18d² is the buckling moment of a clamped shaft.

    κψ″″ = iMψ‴ for ψ = u_y + i u_z, clamped at 0 and L, has its first solution at ML/κ = 2x with
    tan x = x (Greenhill's shaft with fixed ends). Links that shear add 3μ/λd² to the active law of
    3a, for all wavelengths (see the study continuum).
    """
    chain, links, moduli = scene.chain, scene.chain.particles - 1, scene.moduli
    moment = 2.0 * brentq(lambda x: math.sin(x) - x * math.cos(x), 4.0, 4.6)
    load = moment * moduli.bend / links
    rigid = load * 18.0 * chain.spacing**2 / (13.0 * chain.radius**3 * scene.drag.translation)
    return rigid / (1.0 + 3.0 * moduli.bend / (moduli.shear * chain.spacing**2))


@pytest.mark.parametrize(
    ("name", "key", "law"),
    [("buckling", "slip.2s", euler_strength), ("helix-left", "slip.3a", greenhill_strength)],
)
def test_critical_strengths_tend_to_those_of_rods_as_one_over_n_squared(name, key, law):
    counts, misses = np.array([24, 48, 96]), []
    for count in counts:
        scene = nrchain.load_scene(name, **{"chain.particles": int(count)}, **LINKS)
        expected = law(scene)
        found = critical_strength(scene, key, (0.5 * expected, 2.0 * expected))
        assert found.frequency == 0.0
        misses.append(abs(found.value / expected - 1.0))
    assert misses[0] < 0.02
    slopes = np.diff(np.log(misses)) / np.diff(np.log(counts - 1))
    assert slopes == pytest.approx(-2.0, abs=0.25)


def test_growth_changes_its_sign_at_the_critical_strength():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 10})
    found = critical_strength(scene, "slip.2s", (100.0, 400.0))
    assert found.error < 1e-6 * found.value
    for sign in (1.0, -1.0):
        near = nrchain.load_scene(scene, **{"slip.2s": found.value + sign * 1e-3})
        growth = nrchain.spectrum(near).leading.growth
        assert growth == pytest.approx(sign * 1e-3 * found.slope, rel=1e-3)


def test_a_clamped_pusher_that_swims_is_straight_between_buckling_and_flutter():
    """2s = 60: buckled without 3t, straight from about 400, oscillating from 700 to 800."""
    given = {"slip.2s": 60.0, "slip.3t": 1.0, "elasticity.ratio": 1e8}
    scene = nrchain.load_scene("buckling", **given)
    straight = critical_strength(scene, "slip.3t", (100.0, 500.0))
    flutter = critical_strength(scene, "slip.3t", (500.0, 1000.0))
    assert 300.0 < straight.value < 500.0
    assert 700.0 < flutter.value < 800.0
    assert straight.slope < 0.0 < flutter.slope
    assert straight.frequency == 0.0 < flutter.frequency


def test_a_bracket_without_a_change_of_stability_is_refused():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 6})
    with pytest.raises(SceneError, match=r"between = .*decays at both ends, with Re Λ = -"):
        critical_strength(scene, "slip.2s", (1.0, 2.0))
    with pytest.raises(SceneError, match="two different finite numbers"):
        critical_strength(scene, "slip.2s", (1.0, 1.0))
    with pytest.raises(SceneError, match=r"slip.2x.*must be a number.*slip.2s"):
        critical_strength(scene, "slip.2x", (1.0, 2.0))


def test_one_strength_of_a_list_has_a_threshold():
    """The last free sphere of a clamped chain pushes until the chain buckles."""
    strengths = [250.0] * 8
    scene = nrchain.load_scene("buckling", **{"chain.particles": 8, "slip.2s": strengths})
    found = nrchain.critical_strength(scene, "slip.2s[3]", (-1000.0, 1000.0))
    strengths[3] = found.value
    there = nrchain.spectrum(nrchain.load_scene(scene, **{"slip.2s": strengths}))
    assert abs(there.leading.growth) < 1e-8


def test_sensitivities_name_unknown_keys():
    found = nrchain.spectrum(nrchain.load_scene("buckling", **{"chain.particles": 6}))
    with pytest.raises(SceneError, match=r"keys = 'nosuch': must be among .*slip.2s"):
        found.sensitivities(keys=["nosuch"])
