"""Absolute and convective instability: closed forms, and the growth of a push on the lattice."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from support.selection import few_of

from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.theory.lattice import lattice_operator
from nrchain.theory.rod import (
    Material,
    Symbol,
    base_motion,
    instability,
    rod_instability,
    rod_waves,
)


def symbol(*coefficients):
    """Λ = Σ c_n (iq)ⁿ."""
    return Symbol([[[c]] for c in coefficients], [[[1.0]]])


def mix(dipole, bend=1.0, **changes):
    """2s and 3t in a chain that hardly shears; ``bend`` is over γ_T d²."""
    mu = bend * 600.0 * math.pi
    table = {
        **{"chain.particles": 12, "run.end": 1.0, "slip.2s": 100.0, "slip.3t": dipole},
        **{"elasticity.bend": mu, "elasticity.twist": mu},
        **{"elasticity.stretch": 1e5, "elasticity.shear": 1e5},
    }
    return load_scene(table | changes)


@pytest.mark.parametrize("velocity", [0.0, 1.0, 1.98, 2.02, 5.0])
def test_ginzburg_landau_is_absolute_below_twice_the_root_of_growth_and_diffusion(velocity):
    """Λ = μ − iVq − Dq² has Λ* = μ − V²/4D at q* = −iV/2D."""
    mu, D = 0.3, 2.0
    V = velocity * math.sqrt(mu * D)
    found = instability(symbol(mu, -V, D))
    assert found.kind == ("absolute" if velocity < 2.0 else "convective")
    assert found.rate == pytest.approx(mu - V**2 / (4.0 * D), abs=1e-12)
    assert found.wavenumber == pytest.approx(-0.5j * V / D, abs=1e-9)
    assert found.growth == pytest.approx(mu)
    assert max(found.slope, found.residual) < 1e-10
    low, high = sorted(found.apart)
    assert low < 0.0 < high


SPREADING = (2 + math.sqrt(7)) / 3 * math.sqrt(2 * (math.sqrt(7) - 1) / 3)
"""Speed at which Λ = q² − q⁴ spreads, 1.6220 (Dee and Langer 1983)."""


@pytest.mark.parametrize("factor", [-1.001, -0.999, 0.999, 1.001])
def test_the_spreading_speed_of_a_bending_band_is_known(factor):
    found = instability(symbol(0.0, 0.0, -1.0, 0.0, -1.0).moving(factor * SPREADING))
    assert found.kind == ("absolute" if abs(factor) < 1.0 else "convective")
    assert abs(found.rate.real) < 0.002


def test_advected_swift_hohenberg():
    """Λ = r − (1 − q²)² − iVq: its saddles are the roots of a cubic, the pinch the highest."""
    r, V = 0.2, 0.9
    found = instability(symbol(r - 1.0, -V, -2.0, 0.0, -1.0))
    rates = [
        r - (1 - q * q) ** 2 - 1j * V * q
        for q in np.roots([-4.0, 0.0, 4.0, -1j * V])
        if abs(q.real) > 1e-6
    ]
    assert min(abs(found.rate - rate) for rate in rates) < 1e-10
    assert found.kind == "absolute"


def test_a_saddle_that_is_no_pinch_does_not_count():
    """Λ = q² − q⁴ + icq has a third saddle at imaginary q, whose Λ is larger: no pinch."""
    c = 1.0
    saddles = np.roots([-4.0, 0.0, 2.0, 1j * c])
    rates = [q**2 - q**4 + 1j * c * q for q in saddles]
    pinch = instability(symbol(0.0, c, -1.0, 0.0, -1.0))
    real = [rate.real for q, rate in zip(saddles, rates, strict=True) if abs(q.real) > 1e-9]
    assert pinch.rate.real == pytest.approx(max(real))
    assert max(rate.real for rate in rates) != pytest.approx(pinch.rate.real)


def test_coupled_waves_have_the_pinch_of_the_faster():
    """Two fields in a rotated basis: a branch that decays does not matter."""
    turn = np.array([[math.cos(0.4), -math.sin(0.4)], [math.sin(0.4), math.cos(0.4)]])
    diagonal = [np.diag([1.0, -2.0]), np.diag([-1.2, 0.5]), np.diag([1.0, 3.0])]
    found = instability(Symbol(np.array([turn @ part @ turn.T for part in diagonal]), [np.eye(2)]))
    assert found.rate == pytest.approx(1.0 - 1.2**2 / 4.0)


def test_decaying_waves_are_stable():
    found = instability(symbol(-0.1, 1.0, 1.0))
    assert found.kind == "stable"
    assert cmath.isnan(found.rate)
    assert rod_instability(Material.of(load_scene("passive"))).kind == "stable"
    assert rod_instability(Material.of(load_scene("wave"))).kind == "stable"


def test_growth_without_bound_is_refused():
    with pytest.raises(SceneError, match="grows without bound"):
        instability(symbol(0.0, 0.0, -1.0))


def push(scene, times, spheres=4096):
    """u_y of the pushed sphere (n,): ∫ exp(M(q)t) dq/2π of the exact lattice."""
    phases = 2.0 * np.pi * np.fft.fftfreq(spheres)
    values, vectors = np.linalg.eig(lattice_operator(scene, phases / scene.chain.spacing))
    inverse = np.linalg.inv(vectors)
    weights = vectors[:, 1] * inverse[:, :, 1]
    return np.array([(weights * np.exp(values * t)).sum().real / spheres for t in times])


def growth_of(signal, times):
    """Λ of Re(A exp(Λt))/√t, from the recurrence of equal steps."""
    g = signal * np.sqrt(times)
    size = np.exp(np.linspace(0.0, 1.0, len(g)) * math.log(abs(g[-1] / g[0])))
    rows = np.stack([g[1:-1], g[:-2]], axis=1) / size[1:-1, None]
    first, second = np.linalg.lstsq(rows, g[2:] / size[1:-1], rcond=None)[0]
    root = (first + cmath.sqrt(first**2 + 4.0 * second)) / 2.0
    return cmath.log(root) / (times[1] - times[0])


@pytest.mark.parametrize("dipole", few_of([800.0, 1600.0], {800.0}))
def test_a_push_on_the_lattice_grows_as_the_pinch_of_the_rod(dipole):
    """At its place, and to relative order (qd)²: fourfold bend halves q*."""
    errors = []
    for bend in (4.0, 16.0):
        scene = mix(dipole / math.sqrt(bend), bend)
        found = rod_instability(Material.of(scene), beam=False)
        assert found.kind == "absolute"
        times = bend * np.arange(1600.0, 2000.0, 8.0)
        measured = growth_of(push(scene, times), times)
        rate = complex(found.rate.real, abs(found.rate.imag))
        errors.append(abs(complex(measured.real, abs(measured.imag)) - rate) / abs(rate))
        phase = abs(found.wavenumber) * scene.chain.spacing
        assert errors[-1] < phase**2
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_an_observer_at_rest_in_the_lab_sees_another_instability():
    """3t carries the chain at V⁰ and its waves back: fixed in the lab, the push stays."""
    material = Material.of(mix(4000.0))
    assert rod_instability(material).kind == "convective"
    V = base_motion(material)[0]
    assert rod_instability(material, velocity=-V).kind == "absolute"


def test_anisotropic_rods_are_classified_too():
    """2s across the chain: the growing wave of the two planes rules, full blocks or beam limit."""
    across = {"slip.2s": {"strength": -200.0, "axis": [0.0, 1.0, 0.0]}}
    material = Material.of(mix(500.0, **across))
    assert not material.symmetry.isotropic
    found = [rod_instability(material, beam=beam) for beam in (True, False)]
    assert found[0].kind == found[1].kind == "absolute"
    assert found[0].rate == pytest.approx(found[1].rate, rel=0.02)
    fastest = abs(found[1].fastest)
    assert found[1].growth == pytest.approx(rod_waves(material, [fastest]).growth.max(), rel=1e-6)


def test_hands_that_differ_are_both_looked_at():
    """The mirror image of a chiral chain has the same instability, in waves of the other hand."""
    rates = []
    for sign in (1.0, -1.0):
        scene = mix(600.0, **{"slip.3a": sign * 2000.0, "slip.4a": sign * 5000.0})
        rates.append(rod_instability(Material.of(scene)).rate)
    assert rates[0].real == pytest.approx(rates[1].real, rel=1e-9)


def test_the_pinch_lies_on_a_branch_of_the_rod():
    material = Material.of(mix(1000.0))
    found = rod_instability(material, beam=False)
    assert max(found.slope, found.residual) < 1e-9
    waves = rod_waves(material, [abs(found.fastest)])
    assert found.growth == pytest.approx(waves.growth.max(), rel=1e-9)
