"""How much work does a chain do per cycle of strain, and is it that of its moduli?"""

from __future__ import annotations

import numpy as np

import nrchain
from nrchain import Material, Rod, Scene, rod
from nrchain.theory.rod.helix import Helix
from validation.report.recorder import Recorder
from validation.report.uniform_chains import FLUID, SPACING, STRENGTHS, uniform_chain

SCALES = np.repeat([1.0, 1.0 / SPACING], 3)
"""Strains of size 1: ε, and τ over 1/d."""

POINTS = 48
SPHERES = 5
"""Spheres of the chain whose pairs are followed one by one."""

SIZE = 0.04
"""Strain of the largest cycle."""

MIX = {"2s": 40.0, "3a": 2000.0, "3t": 300.0, "4a": 4000.0}
CHAINS = {label: {label: strength} for label, strength in STRENGTHS.items()} | {"mix": MIX}


def cycle(size: float) -> np.ndarray:
    """An ellipse of strains in a plane without symmetry, (POINTS, 6)."""
    first, second = np.random.default_rng(7).normal(size=(2, 6))
    return rod.strain_cycle(size * first * SCALES, size * second * SCALES, POINTS)


def chain(name: str) -> Scene:
    """The chain of a mode or of the mix, without elasticity."""
    return uniform_chain(CHAINS[name], FLUID)


def measured(scene: Scene, strains: np.ndarray) -> float:
    """−∮ (F·dε + M·dτ) per length, from the wrenches of the simulated spheres."""
    return rod.cycle_work(strains, rod.uniform_response(scene, strains).stress).value


def pair_work(name: str, size: float) -> float:
    """The work of the pairs of a short chain in their relative motion, per length.

    The half difference of the wrenches of two neighbours, about one point, times the difference of
    their twists, which are differences of fourth order of the poses.
    """
    places, step = SPACING * np.arange(SPHERES), 1e-3
    first, second = cycle(size)[[0, POINTS // 4]]
    total = 0.0
    for phase in 2 * np.pi / POINTS * np.arange(POINTS):
        shifts = phase + step * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
        strains = np.outer(np.cos(shifts), first) + np.outer(np.sin(shifts), second)
        poses = [Helix(strain).poses(places) for strain in strains]
        weights = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * step)
        velocities, turns = (np.tensordot(weights, [p[k] for p in poses], 1) for k in (0, 1))
        positions, frames = poses[2]
        rates = np.einsum("nka,nkb->nab", turns, frames)
        spins = np.stack([rates[:, 2, 1], rates[:, 0, 2], rates[:, 1, 0]], axis=1)
        twists = np.concatenate([velocities - np.cross(spins, positions), spins], axis=1)
        for i in range(SPHERES - 1):
            pair = slice(i, i + 2)
            forces, torques = nrchain.active_wrenches(positions[pair], frames[pair], CHAINS[name])
            moments = torques + np.cross(positions[pair], forces)
            across = 0.5 * np.concatenate([forces[0] - forces[1], moments[0] - moments[1]])
            total += across @ (twists[i] - twists[i + 1])
    return total * 2 * np.pi / POINTS / (SPACING * (SPHERES - 1))


def scale(scene: Scene) -> float:
    """The work of a modulus of the size of the largest, in a cycle of strain 1."""
    C = Material.of(scene, "cut").constants.C
    return float(np.pi * np.abs(C * SCALES[:, None] * SCALES).max())


def compare(recorder: Recorder) -> None:
    """Record the work in a general cycle, its order, and the work in planes of one modulus."""
    for name in CHAINS:
        _general(recorder, name)
    for name in ("3a", "4a", "mix"):
        recorder.check(
            f"{name}: work of the pairs of {SPHERES} spheres that move apart, over that of stress",
            1,
            pair_work(name, SIZE) / measured(chain(name), cycle(SIZE)),
            1e-8,
            source="the stress is conjugate to the strain at any strain",
        )
    _planes(recorder)
    _source_dipole(recorder)


def _general(recorder: Recorder, name: str) -> None:
    scene = chain(name)
    material, unit = Material.of(scene, "cut"), scale(scene)
    sizes = (SIZE, SIZE / 2)
    works = [measured(scene, cycle(size)) for size in sizes]
    apart = [w - material.work(cycle(size)).value for w, size in zip(works, sizes, strict=True)]
    over_area = [w / size**2 / unit for w, size in zip(works, sizes, strict=True)]
    recorder.check(
        f"{name}: work per cycle over its area, chain extrapolated to small strain",
        material.work(cycle(1.0)).value / unit if name in ("3a", "4a", "mix") else 0.0,
        (4.0 * over_area[1] - over_area[0]) / 3.0,
        2e-4 if name in ("3a", "4a", "mix") else 1e-5,
        source="Σ (C_ab − C_ba) A_ab; 2s and 3t have a symmetric C",
    )
    if name != "3t":
        recorder.check(
            f"{name}: order in strain of the work less that of the moduli",
            4,
            np.log2(apart[0] / apart[1]),
            0.02,
            source="terms of third order in the strain vanish in a centred cycle",
        )


def _planes(recorder: Recorder) -> None:
    """Cycles in the plane of two strains: single entries of Table moduli, as work."""
    axes = np.eye(6) * SCALES
    for label, (a, b), symbols, sign in (
        ("3a", (0, 3), ("C_par_F_tau", "C_par_M_eps"), 1.0),
        ("4a", (1, 2), ("C_odd_F_eps",), -2.0),
    ):
        scene = chain(label)
        works = []
        for size in (SIZE, SIZE / 2):
            strains = rod.strain_cycle(size * axes[a], size * axes[b], POINTS)
            works.append(measured(scene, strains) / (np.pi * size**2 * SCALES[a] * SCALES[b]))
        table = rod.moduli(Rod.of(scene))
        values = [table[symbol] for symbol in symbols]
        expected = values[0] - values[1] if len(values) == 2 else sign * values[0]
        recorder.check(
            f"{label}: work over area in the plane of strains {a + 1} and {b + 1}, at small strain",
            expected,
            (4.0 * works[1] - works[0]) / 3.0,
            1e-4,
            source=f"Table moduli: {', '.join(symbols)}",
        )


def _source_dipole(recorder: Recorder) -> None:
    """3t: the printed moduli are odd; the chain does no work in any cycle."""
    scene = chain("3t")
    strains = cycle(SIZE)
    unit = scale(scene) * SIZE**2
    recorder.check(
        "3t: work of the chain at finite strain, over that of a modulus",
        0,
        measured(scene, strains) / unit,
        1e-11,
        source="the flow of 3t has a potential, e·∇∇(1/r), and so have its stresses",
    )
    theory = Rod.of(scene)
    area = 0.5 * np.einsum("na,nb->ab", strains, np.roll(strains, -1, axis=0))
    area -= area.T
    # the polygon through the points of an ellipse is smaller than it by sin(x)/x, x = 2π/n
    area *= (2 * np.pi / POINTS) / np.sin(2 * np.pi / POINTS)
    recorder.difference(
        "3t: work that the printed C_odd_F_tau and C_odd_M_eps = 0 give, over its closed form",
        1.0,
        Material.of(scene).work(strains).value
        / (rod.moduli(theory)["C_odd_F_tau"] * (area[2, 4] - area[1, 5])),
        1e-9,
        source="linear response counts the gradient of a source as stress; the chain does no work",
    )
