"""Plane waves on a periodic chain against the continuum laws of the paper, mode by mode.

A periodic chain of N = 64 at R = 1e12 starts from a helix (for 3t a sine) of one wavelength,
qd = 2π/64. The complex amplitude A(t) = Σ_j (y + iz)_j exp(−iqjd) of the wave then follows
A ∝ exp(Λt). The laws are the leading order in qd: they must be met to (qd)², up to the coefficient
of their next term. The start is a/1000 high: a period that cannot shorten puts a wave under the
tension λd(Aq)²/2, which at a/10 and this stiffness is 4 % of the bending of the passive chain.
"""

import numpy as np
import pytest

import nrchain

COUNT = 64
QD = 2 * np.pi / COUNT
D = 10.0


def measured_rate(slip, shape, end, neighbours=1):
    """d log A / dt between a third of the run, when transients are gone, and its end."""
    scene = nrchain.load_scene(
        {
            "chain": {"particles": COUNT, "ends": "periodic"},
            "elasticity": {"ratio": 1e12},
            "slip": slip | {"neighbours": neighbours},
            "start": {"shape": shape, "amplitude": 1e-3},
            "run": {"end": end, "snapshots": 301, "rtol": 1e-8, "atol": 1e-12},
        }
    )
    trajectory = nrchain.simulate(scene)
    assert trajectory.status == "completed"
    hand = -1 if shape == "helix-left" else 1
    side = trajectory.positions[..., 1] + 1j * trajectory.positions[..., 2]
    wave = side @ np.exp(-1j * hand * QD * np.arange(COUNT))
    log = np.log(np.abs(wave)) + 1j * np.unwrap(np.angle(wave))
    return (log[-1] - log[100]) / (trajectory.time[-1] - trajectory.time[100])


def passive():
    return -(QD**4)


def test_passive_chain_relaxes_as_q_to_the_fourth():
    # −κ_R q⁴/Γ_T = −(qd)⁴ in the units μ = γ_T d²; the stencils keep the next order small
    rate = measured_rate({}, "helix-right", 3000.0)
    assert rate.real == pytest.approx(passive(), rel=QD**2)
    assert rate.imag == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("strength", [100.0, -100.0])
def test_2s_grows_or_decays_as_q_squared(strength):
    law = 7 / 3 * strength / D**3 * QD**2 + passive()
    rate = measured_rate({"2s": strength}, "helix-right", 600.0)
    assert rate.real == pytest.approx(law, rel=QD**2)
    assert rate.imag == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("shape", "hand"), [("helix-right", 1.0), ("helix-left", -1.0)])
def test_3a_grows_for_one_hand_as_q_cubed(shape, hand):
    strength = 5000.0
    law = -hand * 13 / 18 * strength / D**4 * QD**3 + passive()
    rate = measured_rate({"3a": strength}, shape, 1500.0)
    assert rate.real == pytest.approx(law, rel=3 * QD**2)
    assert rate.imag == pytest.approx(0, abs=1e-9)


def test_3t_carries_its_wave_at_v0():
    strength = 1000.0
    rate = measured_rate({"3t": strength}, "sine", 400.0)
    v0 = 4 / 5 * strength / D**3
    assert rate.imag == pytest.approx(v0 / D * QD, rel=QD**2)
    assert rate.real == pytest.approx(passive(), rel=3 * QD**2)


@pytest.mark.parametrize("strength", [10000.0, -10000.0])
def test_4a_turns_its_wave_as_q_squared(strength):
    rate = measured_rate({"4a": strength}, "helix-right", 100.0)
    law = 363 / 10 * strength / D**5 * QD**2
    assert rate.imag == pytest.approx(law, rel=QD**2)
    assert rate.real == pytest.approx(passive(), rel=0.05)


@pytest.mark.slow
def test_all_pairs_change_2s_by_a_logarithm():
    # Σ(1 − cos mqd)/m³ over 1 − cos qd, cut where the chain's k neighbours end
    reach = np.arange(1, 257)
    factor = np.sum((1 - np.cos(reach * QD)) / reach**3) / (1 - np.cos(QD))
    assert factor == pytest.approx(1.5 - np.log(QD), rel=5e-3)
    law = factor * 7 / 3 * 100 / D**3 * QD**2 + passive()
    rate = measured_rate({"2s": 100.0}, "helix-right", 200.0, neighbours=256)
    assert rate.real == pytest.approx(law, rel=QD**2)
