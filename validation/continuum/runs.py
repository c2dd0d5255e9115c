"""Simulated runs of single waves, and their rates by the continuum laws and the lattice.

Units of the paper: a = η = 1, d = 10, μ = γ_T d². With x = qd and s = (a/d)², the beam limit of the
discrete chain with nearest neighbours (λ → ∞: the tilt is tied to the slope of the displacement by
the stencils of the elastic potential, and rotation drags with γ_R) expands as

    passive       −x⁴ [1 − (1/12 + 4s/3) x² + …]
    2s            (7/3)(a²/d³) V x² [1 − x²/12 + …]
    3a            −(13/18)(a³/d⁴) V x³ [1 − (5/32 + s) x² + …]
    3t            (4i/5)(a³/d⁴) V x [1 − (4s/3) x² + …]
    4a            (363i/10)(a⁴/d⁵) V x² [1 − (1/4 + 4s/9) x² + …]
    3t along x    −(12i/5)(a³/d⁴) V x [1 − x²/6 + …]
    optical       −(λd²/γ_R) [1 + (4s/3 + μ/λd²) x² + …]

whose leading terms are the laws of the paper. The friction of the turning spheres gives −4s/3, the
slip torques +4s/3 (2s), s/3 (3a) and 8s/9 (4a); the rest are the finite differences.

A finite stiffness, ε = μ/λd², lets the tilt fall behind the slope by the factor 1 − εx². That adds
−εx² (passive), εx²/2 (3t), −2εx² (4a) and, because the x¹ terms of displacement and tilt cancel in
the force of 3a, 3ε to the brackets: **the law of 3a is off by 3ε however long the wave is**.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import nrchain
from nrchain import Branch, Rod, lattice_rates, measure
from nrchain.scene.poses import frames_along
from nrchain.theory.rod import dispersion

D = 10.0
S = 1.0 / D**2
GAMMA_T, GAMMA_R = 6 * math.pi, 8 * math.pi
BEND = GAMMA_T * D**2

TENSION = 1e-6
"""λA²/2μ of a start: tension of a wave of fixed period over the bending of its chain."""

Poses = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class Point:
    """One wave: its strength (or modulus), x = qd, and Λ from simulation, lattice and law."""

    strength: float
    x: float
    rate: measure.Rate
    lattice: complex
    law: complex

    slack: float = 0.0
    """ε = μ/λd²."""

    @property
    def miss(self) -> float:
        """|Λ − Λ_lattice| / |Λ_lattice|."""
        return abs(self.rate.value - self.lattice) / abs(self.lattice)


@dataclass(frozen=True)
class Series:
    """Waves of one branch at several strengths and lengths, and the law they are compared with.

    ``active`` is the part of Λ that changes sign with V (or all of the optical rate), ``next`` the
    coefficient of x² in the expansion above and ``slack`` (c, p) that of the term c ε x^p.
    """

    title: str
    strengths: tuple[float, ...]
    run: Callable[[float, int], Point]
    active: str
    next: float
    law: str
    slack: tuple[float, int] = (0.0, 0)


def bending(label: str, shape: str) -> Callable[[float, int], Point]:
    """Runs of bending waves on a periodic chain of N spheres and one wavelength, at R = 1e12."""
    kind: measure.Kind = "y" if shape == "sine" else "right"

    def run(strength: float, count: int) -> Point:
        lattice, law = bending_theory(label, strength, count)
        x = 2 * math.pi / count
        scene = nrchain.load_scene(
            wave_scene(label, strength, count, shape),
            **{"run.end": 1.0 / (abs(law + x**4) + x**4)},
        )
        rate = measure.rate(measure.wave(nrchain.simulate(scene), kind=kind))
        slack = scene.moduli.bend / (scene.moduli.shear * D**2)
        return Point(strength, x, rate, lattice, law, slack)

    return run


def bending_theory(label: str, strength: float, count: int) -> tuple[complex, complex]:
    """Λ of the right-handed bending wave around N spheres at R = 1e12: (lattice, law)."""
    x = 2 * math.pi / count
    scene = wave_scene(label, strength, count, "helix-right")
    law = complex(dispersion.transverse(Rod.of(scene), x / D))
    return exact(scene, x, Branch.BEND_PLUS), law


def wave_scene(
    label: str, strength: float, count: int, shape: str, amplitude: float | None = None
) -> nrchain.Scene:
    """One wavelength around a periodic chain at R = 1e12, so low that its tension is negligible."""
    stiffness = 1e12 * GAMMA_R / (GAMMA_T * D**4 * (count - 1) ** 4)
    height = math.sqrt(2 * TENSION / stiffness) if amplitude is None else amplitude
    return nrchain.load_scene(
        {
            "chain": {"particles": count, "ends": "periodic"},
            "elasticity": {"ratio": 1e12},
            "slip": {label: strength} if label else {},
            "start": {"shape": shape, "amplitude": height},
            "run": {"end": 1.0, "snapshots": 201, "rtol": 1e-9, "atol": 1e-12},
        }
    )


def longitudinal_wave(strength: float, count: int) -> Point:
    """A wave of u_x on a 3t chain with λ∥ = 1, soft enough for the wave to live long."""
    x = 2 * math.pi / count
    scene = _periodic(count, {"stretch": 1.0, "shear": 1e4}, {"3t": strength})
    law = complex(dispersion.longitudinal(Rod.of(scene), x / D))
    scene = nrchain.load_scene(scene, **{"run.end": 1.0 / abs(law)})
    positions, frames = _straight(count)
    positions[:, 0] += 1e-4 * np.cos(x * np.arange(count))
    trajectory = nrchain.simulate(scene, positions=positions, frames=frames)
    rate = measure.rate(measure.wave(trajectory, x / D, "x"))
    return Point(strength, x, rate, exact(scene, x, Branch.STRETCH), law)


def optical_wave(modulus: float, count: int) -> Point:
    """The shear of a passive chain with λ = ``modulus``, its frames tilted against a straight axis.

    The frames start at (cos, sin)(qs) across; the shear left in them decays with the gap.
    """
    x = 2 * math.pi / count
    scene = _periodic(count, {"stretch": modulus, "shear": modulus}, {})
    law = dispersion.optical(Rod.of(scene))
    scene = nrchain.load_scene(scene, **{"run.end": 3.0 / abs(law)})
    positions, _ = _straight(count)
    tilt = 1e-4 * np.exp(1j * x * np.arange(count))
    frames = frames_along(
        np.stack([np.sqrt(1.0 - np.abs(tilt) ** 2), tilt.real, tilt.imag], axis=1)
    )
    trajectory = nrchain.simulate(scene, positions=positions, frames=frames)
    rate = measure.rate(measure.wave(trajectory, x / D, "right", of="shear"))
    return Point(modulus, x, rate, exact(scene, x, Branch.SHEAR_PLUS), law)


def exact(scene: nrchain.Scene, x: float, branch: Branch) -> complex:
    """Λ of the infinite discrete chain."""
    return complex(lattice_rates(scene, x / D)[branch])


def _periodic(count: int, elasticity: dict, slip: dict) -> nrchain.Scene:
    return nrchain.load_scene(
        {
            "chain": {"particles": count, "ends": "periodic"},
            "elasticity": elasticity,
            "slip": slip,
            "run": {"end": 1.0, "snapshots": 101, "rtol": 1e-9, "atol": 1e-12},
        }
    )


def _straight(count: int) -> Poses:
    positions = np.zeros((count, 3))
    positions[:, 0] = D * np.arange(count)
    return positions, np.broadcast_to(np.eye(3), (count, 3, 3)).copy()


PASSIVE = Series(
    "passive",
    (0.0,),
    bending("", "helix-right"),
    "growth",
    -(1 / 12 + 4 * S / 3),
    "pass_ac",
    (-1.0, 2),
)

MODES = {
    "2s": Series(
        "2s", (-100.0, -50.0, 50.0, 100.0), bending("2s", "helix-right"),
        "growth", -1 / 12, "2s_tr_displ",
    ),
    "3a": Series(
        "3a", (-5000.0, -2500.0, 2500.0, 5000.0), bending("3a", "helix-right"),
        "growth", -(5 / 32 + S), "3a_trans_ac_disp", (3.0, 0),
    ),
    "3t": Series(
        "3t", (-1000.0, -500.0, 500.0, 1000.0), bending("3t", "sine"),
        "frequency", -4 * S / 3, "3t_trans_ac_disp", (0.5, 2),
    ),
    "4a": Series(
        "4a", (-10000.0, -5000.0, 5000.0, 10000.0), bending("4a", "helix-right"),
        "frequency", -(1 / 4 + 4 * S / 9), "4a_trans_ac_disp", (-2.0, 2),
    ),
}  # fmt: skip
"""The series of the paper's Figs. 4c, 5c, 6c and 7c."""

LONGITUDINAL = Series(
    "3t along the chain", (-1000.0, -500.0, 500.0, 1000.0), longitudinal_wave,
    "frequency", -1 / 6, "3t_long_tr_disp",
)  # fmt: skip

OPTICAL_MODULUS = 2e5
OPTICAL = Series(
    "optical", tuple(OPTICAL_MODULUS * f for f in (0.25, 0.5, 2.0, 1.0)), optical_wave,
    "growth", 4 * S / 3 + BEND / (OPTICAL_MODULUS * D**2), "pass_op",
)  # fmt: skip
"""The last modulus is the one whose next order is measured."""
