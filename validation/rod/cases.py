"""Five chains whose groups stay the same as they grow, and the smooth curve that they start from.

With d, a and η fixed and L = (N − 1) d, strengths fall with N so that

    2s: F̃ L²/κ,    3a: A L/κ,    3t: f̃ L³/κ,    4a: H L²/κ       (κ = κ_R)

stay fixed, where A = (13/12)(a³/d) Γ_T V and H = −(363/10)(a⁴/d³) Γ_T V. Times are in Γ_T L⁴/κ_R.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import nrchain
from nrchain import Scene, rod

RADIUS, SPACING, VISCOSITY = 0.8, 7.0, 1.3

FIRM = 100.0
"""λ d²/μ."""

CELLS, POINTS = 256, 6
"""Gauss–Legendre cells and points by which a start is integrated."""


@dataclass(frozen=True)
class Case:
    """Groups of the modes, ends, the end time, and the largest angles of the start."""

    title: str
    groups: Mapping[str, float]
    end: float
    ends: str = "free"
    angles: tuple[float, float] = (1.0, 0.5)
    axial: float | None = None
    """κ_T L²/κ_R, of a chain that has to stretch to deflect; None for λ d²/μ = :data:`FIRM`."""


CASES = {
    "2s": Case("a pusher buckles", {"2s": 80.0}, 0.012, "clamped", (0.02, 0.006), 3000.0),
    "3a": Case("3a coils", {"3a": 14.0}, 0.006, angles=(0.4, 0.2)),
    "3t": Case("a wave of 3t", {"3t": 60.0}, 0.0012, angles=(1.4, 0.8)),
    "4a": Case("a spiral of 4a", {"4a": 25.0}, 0.0012, angles=(1.4, 0.8)),
    "mix": Case("a mix of all four", {"2s": 20.0, "3a": 10.0, "3t": 30.0, "4a": 10.0}, 0.0012),
}

_POWERS = {"2s": (2, -7 / 3, 1, 2), "3a": (3, 13 / 12, 1, 1), "3t": (3, 4 / 5, 3, 3)}
_POWERS["4a"] = (4, -363 / 10, 3, 2)


def chain_of(case: Case, particles: int, **changes: Any) -> Scene:
    """The chain of a case with this number of spheres."""
    mu = 6.0 * math.pi * VISCOSITY * RADIUS * SPACING**2
    length, kappa = (particles - 1) * SPACING, mu * SPACING
    drag = 6.0 * math.pi * VISCOSITY * RADIUS / SPACING
    slip: dict[str, object] = {"neighbours": 1}
    for label, group in case.groups.items():
        radius, number, spacing, power = _POWERS[label]
        unit = number * RADIUS**radius / SPACING**spacing * drag
        slip[label] = math.copysign(group, 1.0) * kappa / length**power / abs(unit)
    firm = case.axial * (SPACING / length) ** 2 if case.axial else FIRM
    stiff = {"stretch": firm * mu / SPACING**2, "shear": firm * mu / SPACING**2}
    base = {
        "chain": {
            "particles": particles, "spacing": SPACING, "radius": RADIUS,
            "viscosity": VISCOSITY, "ends": case.ends,
        },
        "elasticity": {**stiff, "bend": mu, "twist": mu},
        "slip": slip,
        "run": {
            "end": case.end * drag * length**4 / kappa, "snapshots": 2, "rtol": 1e-7, "atol": 1e-7,
        },
    }  # fmt: skip
    return nrchain.load_scene(base, **changes)


def start(case: Case, length: float, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses at s (M,) on a smooth curve, straight at its ends, with e₁ along it.

    Free chains start without strain ε: the tangent turns by α about e₃ and β about e₂. Clamped
    chains start at x = s, lifted by up to ``case.angles`` over L along y and z.
    """
    x = places / length
    if case.ends == "clamped":
        bump = np.sin(np.pi * x) ** 4 * np.stack([1.0 + x, 1.0 - x])
        lift = np.array(case.angles)[:, None] * bump
        slope = np.array(case.angles)[:, None] * (
            4.0 * np.pi * np.sin(np.pi * x) ** 3 * np.cos(np.pi * x) * np.stack([1.0 + x, 1.0 - x])
            + np.sin(np.pi * x) ** 4 * np.array([[1.0], [-1.0]])
        )
        turns = np.stack([np.arctan(slope[0]), -np.arctan(slope[1] / np.hypot(1.0, slope[0]))], 1)
        return length * np.column_stack([x, *lift]), _frames(turns)
    edges = np.linspace(0.0, 1.0, CELLS + 1)
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    inside = edges[:-1, None] + 0.5 / CELLS * (nodes + 1.0)
    sums = np.zeros((CELLS + 1, 3))
    sums[1:] = np.cumsum(0.5 / CELLS * np.einsum("q,cqp->cp", weights, _tangents(case, inside)), 0)
    cell = np.minimum((x * CELLS).astype(int), CELLS - 1)
    half = 0.5 * (x - edges[cell])
    within = edges[cell][:, None] + half[:, None] * (nodes + 1.0)
    rest = half[:, None] * np.einsum("q,mqp->mp", weights, _tangents(case, within))
    return length * (sums[cell] + rest), _frames(_turns(case, x))


def _turns(case: Case, x: np.ndarray) -> np.ndarray:
    bump, cosine = np.sin(np.pi * x) ** 3, np.cos(np.pi * x)
    first, second = case.angles
    return np.stack([first * bump * (1.0 + 0.6 * cosine), second * bump * cosine], axis=-1)


def _tangents(case: Case, x: np.ndarray) -> np.ndarray:
    alpha, beta = np.moveaxis(_turns(case, x), -1, 0)
    return np.stack(
        [np.cos(alpha) * np.cos(beta), np.sin(alpha) * np.cos(beta), -np.sin(beta)], axis=-1
    )


def _frames(turns: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(Rotation.from_euler("ZY", turns).as_matrix().swapaxes(1, 2))


def rod_motion(
    case: Case, scene: Scene, *, tolerance: float = 1e-8, **options: Any
) -> tuple[rod.CosseratRod, np.ndarray, np.ndarray]:
    """The rod of a scene, and its poses at the end."""
    shape = rod.rod_of(scene, **{"degree": 10, **options})
    begin = start(case, shape.length, shape.places)
    motion = shape.simulate(*begin, times=[0.0, scene.run.end], rtol=tolerance)
    return shape, motion.positions[-1], motion.frames[-1]


def chain_positions(case: Case, scene: Scene) -> np.ndarray:
    """Positions of the spheres at the end."""
    places = SPACING * np.arange(scene.chain.particles)
    positions, frames = start(case, places[-1], places)
    found = nrchain.simulate(scene, positions=positions, frames=frames)
    if found.status != "completed":
        raise RuntimeError(f"{case.title}: {found.reason}")
    return found.positions[-1]


def distance(case: Case, particles: int, *, tolerance: float = 1e-7, **options: Any) -> float:
    """max |r_chain − r_rod|/L at the end."""
    scene = chain_of(case, particles, **{"run.rtol": tolerance, "run.atol": tolerance})
    shape, positions, frames = rod_motion(case, scene, tolerance=0.1 * tolerance, **options)
    places = SPACING * np.arange(particles)
    expected, _ = shape.at(places, positions, frames)
    apart = chain_positions(case, scene) - expected
    return float(np.linalg.norm(apart, axis=1).max() / shape.length)
