"""Friction between spheres changes elastic relaxation; it does not change the flows of slip.

With K(q) the springs and μ(q) the mobility, Λ = w†Kw/w†μ⁻¹w of an unsheared wave w. To the leading
order in qd that is the relaxation with one-body friction times

    1 + Σ 2 cos(mqd)(3a/4md)(1 + 2a²/3m²d²)      bending
    1 + Σ 2 cos(mqd)(3a/2md)(1 − 2a²/3m²d²)      along x, at every qd
    1 + Σ 2 cos(mqd)(a/md)³                      twist, at every qd

with Σ cos(mqd)/m = −ln(2 sin qd/2) for all pairs. Velocities of slip are not multiplied.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import nrchain
from nrchain import Branch, measure
from nrchain.theory.lattice_sums import Reach, cosine_sum
from nrchain.theory.rod.reach import Direction
from validation.report.periodic_waves import rate_of
from validation.report.recorder import Recorder
from validation.report.uniform_chains import (
    BENDING,
    LIMP,
    SPACING,
    branch_rates,
    scaled,
    uniform_chain,
)

Array = NDArray[np.float64]

MARGIN = 1.5
"""Bound on the neglected terms of bending, in (a/d)² (qd)²: rotation and its coupling to force."""

NAMES = {"2s": "growth rate", "3a": "growth rate", "3t": "wave", "4a": "rotation"}
PHASES = np.array([1e-3, 0.02, 0.1, 0.3])


def pairwise(reach: Reach = "all") -> dict[str, Any]:
    """Changes of a scene: friction between spheres."""
    return {"friction.kind": "pairwise", "friction.neighbours": reach}


def factor(phases: Array, wave: str, radius: float = 1.0, reach: Reach = "all") -> Array:
    """The factor of :mod:`validation.long_range.friction` of bending, stretch or twist."""
    s = radius / SPACING
    first, third = cosine_sum(1, phases, reach), cosine_sum(3, phases, reach)
    if wave == "twist":
        return 1 + 2 * s**3 * third
    if wave == "stretch":
        return 1 + 3 * s * first - 2 * s**3 * third
    return 1 + 1.5 * s * first + s**3 * third


def compare(recorder: Recorder) -> None:
    recorder.step("friction on the lattice")
    _on_the_lattice(recorder)
    _stated_values(recorder)
    _beside_slip(recorder)
    simulated = _periodic(recorder)
    recorder.step("friction on an open chain")
    opened = _open_chain(recorder)
    recorder.figure(
        "friction",
        _draw(simulated, opened),
        "Relaxation with friction between all spheres over that with one-body friction, a/d = 0.1: "
        "lines, the sums of the Rotne–Prager–Yamakawa mobilities; symbols, simulated chains, "
        "periodic with all images and, filled, the middle of an open chain with all pairs.",
    )


def _on_the_lattice(recorder: Recorder) -> None:
    branches = {
        "bending": Branch.BEND_PLUS,
        "stretch": Branch.STRETCH,
        "twist": Branch.TWIST,
    }
    for wave, branch in branches.items():
        for reach in (1, 20, "all"):
            for radius in (1.0, 3.0):
                changes = BENDING | {"chain.radius": radius}
                rates = [
                    branch_rates(uniform_chain({}, changes | friction), PHASES, branch)
                    for friction in (pairwise(reach), {})
                ]
                away = np.abs((rates[0] / rates[1]).real / factor(PHASES, wave, radius, reach) - 1)
                name = f"{wave}, friction of {reach} neighbours, a/d = {radius / SPACING:g}"
                source = "Fourier sums of the Rotne–Prager–Yamakawa mobilities"
                if wave == "bending":
                    size = np.max(away / ((radius / SPACING) ** 2 * PHASES**2 + 1e-11))
                    recorder.bound(
                        f"{name}: lattice less factor, over (a/d)² (qd)²",
                        size,
                        most=MARGIN,
                        source=source,
                    )
                else:
                    recorder.check(
                        f"{name}: lattice over factor, less 1", 0, away.max(), 1e-12, source=source
                    )


def _stated_values(recorder: Recorder) -> None:
    passive = [uniform_chain({}, BENDING | friction) for friction in (pairwise(), {})]
    for phase, stated in ((0.1, 1.35), (0.02, 1.59)):
        with_pairs, alone = (branch_rates(scene, np.array([phase]))[0].real for scene in passive)
        recorder.check(
            f"bending relaxes {stated} times faster at qd = {phase}",
            stated,
            with_pairs / alone,
            4e-3,
            source="1 + Σ 2 cos(mqd)(3a/4md)(1 + 2a²/3m²d²), a/d = 0.1",
        )


def _beside_slip(recorder: Recorder) -> None:
    """In the beam limit the force that keeps a wave unsheared adds a flow of order (a/d)²(qd)²."""
    for label, name in NAMES.items():
        rates = [
            branch_rates(
                uniform_chain({label: scaled(label)}, LIMP | friction), np.array([0.05, 0.1])
            )
            for friction in (pairwise(), {})
        ]
        away = np.abs(rates[0] / rates[1] - 1) / (0.01 * np.array([0.05, 0.1]) ** 2)
        recorder.bound(
            f"{label}: {name} with friction between all spheres, relative change over (a/d)²(qd)²",
            away.max(),
            most=MARGIN,
            source="slip velocities enter once",
        )


def _periodic(recorder: Recorder) -> dict[str, list[tuple[float, float]]]:
    found: dict[str, list[tuple[float, float]]] = {"bending": [], "stretch": []}
    for count in (24, 40) if recorder.quick else (12, 24, 40, 64, 96):
        for wave in found:
            recorder.step(f"simulation of friction, {wave}, {count} spheres")
            direction: Direction = "longitudinal" if wave == "stretch" else "transverse"
            alone, _ = rate_of(count, direction)
            together, lattice = rate_of(count, direction, pairwise())
            phase = 2 * np.pi / count
            found[wave].append((phase, (together / alone).real))
            name = f"{wave} at qd = 2π/{count}, friction between all spheres"
            recorder.check(
                f"{name}: simulated Λ", lattice, together, 5e-4, source="lattice operator"
            )
            recorder.check(
                f"{name}: simulated, over one-body friction",
                factor(np.array([phase]), wave)[0],
                (together / alone).real,
                5e-4 + (MARGIN * 0.01 * phase**2 if wave == "bending" else 0.0),
                source="sum of the Rotne–Prager–Yamakawa mobilities",
            )
    return found


def _open_chain(recorder: Recorder) -> tuple[float, float]:
    """The middle of a long open chain, before the ends matter: no images, no period."""
    count, waves = 160, 20
    measured, phase = [], 0.0
    for friction in (pairwise(), {}):
        changes = {
            "chain.particles": count,
            "chain.ends": "free",
            "elasticity.stretch": 1e4,
            "elasticity.shear": 1e4,
            "start.shape": "sine",
            "start.amplitude": 1e-3,
            "start.wavenumber": waves,
            "run.snapshots": 31,
            "run.rtol": 1e-6,
            "run.atol": 1e-9,
        }
        scene = nrchain.load_scene({"run.end": 1.0} | changes | friction)
        q = scene.wavevector
        phase = q * SPACING
        scene = nrchain.load_scene(scene, **{"run.end": 0.5 / phase**4})
        trajectory = nrchain.simulate(scene)
        measured.append(_middle_rate(trajectory, q))
    ratio = measured[0] / measured[1]
    recorder.check(
        f"bending at qd = {phase:.3f} in the middle of an open chain of {count}, friction between "
        "all pairs: simulated, over one-body friction",
        factor(np.array([phase]), "bending")[0],
        ratio,
        1e-2,
        source="sum of the Rotne–Prager–Yamakawa mobilities; the ends are left out of the fit",
    )
    return phase, ratio


def _middle_rate(trajectory: nrchain.Trajectory, q: float) -> float:
    """d ln A/dt of the sine in the middle two fifths of the chain."""
    positions = trajectory.positions
    count = positions.shape[1]
    middle = slice(3 * count // 10, 7 * count // 10)
    s = SPACING * np.arange(count)[middle]
    basis = np.stack([np.cos(q * s), np.sin(q * s), np.ones(len(s)), s - s.mean()], axis=1)
    found = np.linalg.lstsq(basis, positions[:, middle, 1].T, rcond=None)[0]
    amplitude = found[0] - 1j * found[1]
    spectrum = measure.Wave(trajectory.time, amplitude, np.zeros(len(trajectory.time)), q)
    return measure.rate(spectrum).growth.value


def _draw(simulated: dict[str, list[tuple[float, float]]], opened: tuple[float, float]) -> Figure:
    figure = Figure(figsize=(4.8, 3.5))
    panel = figure.subplots()
    phases = np.geomspace(0.01, np.pi, 200)
    for wave, style, marker, name in (
        ("stretch", "--", "s", "along x"),
        ("bending", "-", "o", "bending"),
    ):
        panel.semilogx(phases, factor(phases, wave), style, color="0.4", label=f"{name}, sum")
        x, y = zip(*simulated[wave], strict=True)
        panel.plot(x, y, marker, color="0.0", mfc="white", label=f"{name}, simulated")
    panel.plot(*opened, "o", color="0.0", label="bending, open chain")
    panel.axhline(1, color="0.8", linewidth=0.8)
    panel.set(xlabel="qd", ylabel="Λ / Λ with one-body friction")
    panel.legend(loc="upper right")
    return figure
