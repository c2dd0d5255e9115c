"""How accurate is friction between spheres? Two spheres under equal or opposite forces.

Rotne, Prager and Yamakawa keep the terms to (a/r)³. The exact answers: along the line of centres,
the series in bispherical coordinates of Stimson and Jeffery (Proc. R. Soc. A 111, 110, 1926), for
opposite forces of Brenner (Chem. Eng. Sci. 16, 242, 1961); across it, the resolved solution of the
Stokes equations in the package (:mod:`nrchain.hydrodynamics.resolved`), which the series check in
turn. Far apart the error is −(15/4)(a/r)⁴ along and −(17/16)(a/r)⁶ across (Jeffrey
and Onishi, J. Fluid Mech. 139, 261, 1984).
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from nrchain.hydrodynamics.friction import PairFriction
from nrchain.hydrodynamics.resolved import resolved_twists
from validation.report.recorder import Recorder

Array = NDArray[np.float64]

CASES = {
    "in step, along": (np.array([1.0, 0.0, 0.0]), 1.0),
    "in step, across": (np.array([0.0, 1.0, 0.0]), 1.0),
    "opposed, along": (np.array([1.0, 0.0, 0.0]), -1.0),
    "opposed, across": (np.array([0.0, 1.0, 0.0]), -1.0),
}
"""Direction of the force on the sphere at larger x, the line of centres being x; and that on the
other over it."""


def along(distance: float, in_step: bool = True) -> float:
    """U/U₀ of two equal spheres, r/a = ``distance`` apart, pushed along their line of centres.

    1/λ with λ = (4/3) sinh α Σ n(n+1)/((2n−1)(2n+3)) |1 − (4 sinh²(n+½)α − (2n+1)² sinh²α) /
    (2 sinh(2n+1)α + (2n+1) sinh 2α)| and r = 2a cosh α for equal forces; for opposite ones 4 cosh²
    and the other sign before (2n+1).
    """
    alpha, sign = math.acosh(distance / 2.0), 1 if in_step else -1
    total = 0.0
    for n in range(1, 100_000):
        odd = 2 * n + 1
        if odd * alpha > 600.0:
            break
        # without the difference of two numbers near 1: 4 sinh²(x/2) = 2 cosh x − 2
        rest = 2 - 2 * sign * math.exp(-odd * alpha)
        rest += odd * math.sinh(2 * alpha) + (odd * math.sinh(alpha)) ** 2
        below = 2 * math.sinh(odd * alpha) + sign * odd * math.sinh(2 * alpha)
        total += n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * rest / below
    return 3.0 / (4.0 * math.sinh(alpha) * total)


def exact(distance: float, case: str) -> float:
    """U/U₀ by the series along the line of centres, and by the resolved solution across it."""
    if case.endswith("along"):
        return along(distance, case.startswith("in step"))
    return resolved(distance, case, 18 if distance < 2.3 else 12 if distance < 3.5 else 8)


def rotne_prager_yamakawa(distance: float, case: str) -> float:
    """U/U₀ by the friction of the package."""
    positions, wrenches = _pair(distance, case)
    twists = np.zeros((2, 6))
    PairFriction(2, 1, 1.0, 1.0).apply(positions, wrenches, twists)
    return float(twists[1, :3] @ CASES[case][0]) * 6 * math.pi


def resolved(distance: float, case: str, order: int) -> float:
    """U/U₀ by the resolved solution with multipoles up to ``order``."""
    positions, wrenches = _pair(distance, case)
    forces = (wrenches[:, :3], wrenches[:, 3:])
    velocities, _ = resolved_twists(positions, None, {}, wrenches=forces, order=order)
    return float(velocities[1] @ CASES[case][0]) * 6 * math.pi


def _pair(distance: float, case: str) -> tuple[Array, Array]:
    positions = np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])
    wrenches = np.zeros((2, 6))
    direction, other = CASES[case]
    wrenches[1, :3], wrenches[0, :3] = direction, other * direction
    return positions, wrenches


def compare(recorder: Recorder) -> None:
    _exact(recorder)
    _far(recorder)
    distances = [2.1, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0]
    if recorder.quick:
        distances = [2.5, 4.0, 10.0]
    errors: dict[str, list[float]] = {case: [] for case in CASES}
    rows: list[list[float | str]] = []
    for distance in distances:
        row: list[float | str] = [distance]
        for case in CASES:
            velocity = exact(distance, case)
            errors[case].append(rotne_prager_yamakawa(distance, case) / velocity - 1)
            row += [velocity, f"{errors[case][-1]:+.1e}".replace("-", "−")]
        rows.append(row)
    columns = [part for case in CASES for part in (f"{case}: U/U₀", "RPY error")]
    recorder.table(
        "Two spheres",
        ["r/a", *columns],
        rows,
        "Velocity of two spheres under equal or opposite forces along or across their line of "
        "centres, over that of a single one; and the relative error of the Rotne–Prager–Yamakawa "
        "mobilities. Pair mobilities to (a/r)³ do not include the lubrication of opposed spheres "
        "near contact; elastic forces of a chain push its spheres in opposite directions.",
    )
    at_ten = distances.index(10.0)
    recorder.bound(
        "RPY error at r = 10a, the paper's spacing, in step and opposed",
        max(abs(error[at_ten]) for error in errors.values()),
        most=5e-4,
        source="(15/4)(a/r)⁴, over U/U₀",
    )
    recorder.figure(
        "two spheres",
        _draw(distances, errors),
        "Error of the Rotne–Prager–Yamakawa mobilities for two spheres against their distance, and "
        "its known limits far apart (lines).",
    )


def _exact(recorder: Recorder) -> None:
    """The series against its limit of touching spheres, and against the resolved solution."""
    recorder.check(
        "Stimson–Jeffery: touching spheres, F/6πηaU",
        0.6451,
        1 / along(2.000001),
        2e-4,
        source="Cooley and O'Neill, Proc. Camb. Phil. Soc. 66, 407 (1969)",
    )
    for distance, order, tolerance in ((2.5, 12, 1e-4), (4.0, 8, 1e-8)):
        for case in ("in step, along", "opposed, along"):
            recorder.check(
                f"resolved spheres and the series, {case}, r = {distance:g}a",
                exact(distance, case),
                resolved(distance, case, order),
                tolerance,
                source="series in bispherical coordinates",
            )


def _far(recorder: Recorder) -> None:
    """(exact − RPY)/(U₀ (a/r)^n), extrapolated to s = 0 from two distances."""
    s = np.array([1 / 40, 1 / 20])
    missing = [(along(1 / x) - rotne_prager_yamakawa(1 / x, "in step, along")) / x**4 for x in s]
    recorder.check(
        "in step, along: what RPY leaves out, over (a/r)⁴",
        -15 / 4,
        (missing[0] * s[1] ** 2 - missing[1] * s[0] ** 2) / (s[1] ** 2 - s[0] ** 2),
        5e-3,
        source="Jeffrey and Onishi, x₁₁ᵃ",
    )
    s = np.array([1 / 12, 1 / 8])
    missing = [
        (resolved(1 / x, "in step, across", 8) - rotne_prager_yamakawa(1 / x, "in step, across"))
        / x**6
        for x in s
    ]
    recorder.check(
        "in step, across: what RPY leaves out, over (a/r)⁶",
        -17 / 16,
        (missing[0] * s[1] ** 2 - missing[1] * s[0] ** 2) / (s[1] ** 2 - s[0] ** 2),
        0.05,
        source="Jeffrey and Onishi, y₁₁ᵃ",
    )


def _draw(distances: list[float], errors: dict[str, list[float]]) -> Figure:
    figure = Figure(figsize=(4.8, 3.5))
    panel = figure.subplots()
    for (case, values), marker, color in zip(
        errors.items(), ("o", "s", "^", "v"), ("0.0", "0.45", "0.0", "0.45"), strict=True
    ):
        panel.loglog(distances, np.abs(values), marker, color=color, mfc="white", label=case)
    far = np.array([3.5, 22.0])
    panel.plot(far, 15 / 4 / far**4, color="0.6", linewidth=0.8)
    panel.plot(far, 17 / 16 / far**6, color="0.6", linewidth=0.8)
    panel.text(12.0, 3e-4, "(15/4)(a/r)⁴", color="0.3")
    panel.text(6.5, 4e-7, "(17/16)(a/r)⁶", color="0.3")
    panel.set(xlabel="distance r / a", ylabel="|U − U exact| / U exact")
    panel.set_xticks([2, 3, 5, 10, 20], ["2", "3", "5", "10", "20"])
    panel.set_xticks([], minor=True)
    panel.legend(loc="upper right")
    return figure
