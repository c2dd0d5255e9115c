"""What changes if every sphere feels all others, and not only its neighbours?

For each mode, the active rate of a wave with all pairs over that with nearest neighbours, against
qd: in closed form, as polylogarithms (:mod:`nrchain.rod.reach`); from the lattice operator; and
from simulations of periodic chains with all their images. Then how many neighbours k are enough;
what friction between the spheres adds; and what all of it does to the paper's buckling, coil, wave
and spiral. The source of the answers is the pair laws: a flow at distance m d acts as at d, with
its strength divided by a power of m, and m qd in place of qd.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain import Branch, rod
from nrchain.theory.lattice_sums import Reach
from nrchain.theory.rod.reach import Direction
from validation.long_range import figures, friction, scenes, settling
from validation.long_range.runs import WAVES, Run, simulated_rate
from validation.report.recorder import Recorder
from validation.report.uniform_chains import (
    FLUID,
    LIMP,
    SPACING,
    STRENGTHS,
    branch_rates,
    scaled,
    uniform_chain,
)

ZETA = 1.2020569031595942
EXACT = 1e-12
READ_AT = 0.05
"""qd of the table on the first page."""

LEVELS = (0.1, 0.01, 0.001)
NAMES = {"transverse": "bending", "longitudinal": "along x"}


def study(recorder: Recorder) -> None:
    recorder.step("lattice sums and lattice operator")
    _closed_forms(recorder)
    _limits(recorder)
    recorder.step("how many neighbours")
    needed = _neighbours_needed(recorder)
    simulated = _simulations(recorder)
    _table(recorder, simulated, needed)
    figures.draw(recorder, simulated)
    friction.compare(recorder)
    recorder.step("two spheres settle")
    settling.compare(recorder)
    scenes.compare(recorder)
    recorder.text(
        "**Long-range flows.** The stresslet (2s) and the torque dipole (3a) gain a logarithm: the "
        "longer the wave the more spheres act on it, without end, so that no number of neighbours "
        "is enough for all waves. The source dipole (3t) and the octupole (4a) converge to ζ(3). "
        "For 3t the limits do not commute: at any finite reach the wave has no third order in qd "
        "from the force, with all pairs it has −(1/15)(a³V/d⁴)(qd)³. Friction between the spheres "
        "speeds up what elasticity does, again by a logarithm, and leaves what slip does alone to "
        "(a/d)²(qd)²; it shifts the balance of the two towards elasticity."
    )


def lattice_ratio(
    label: str,
    phases: np.ndarray,
    reach: Reach = "all",
    direction: Direction = "transverse",
    radius: float = 1.0,
) -> np.ndarray:
    """Λ_k/Λ_1 of the slip alone, from the lattice operator."""
    transverse = direction == "transverse"
    branch = Branch.BEND_PLUS if transverse else Branch.STRETCH
    changes = (LIMP if transverse else FLUID) | {"chain.radius": radius}
    every, nearest = (
        branch_rates(
            uniform_chain({label: scaled(label, radius)}, changes | {"slip.neighbours": k}),
            phases,
            branch,
        )
        for k in (reach, 1)
    )
    return (every / nearest).real


def _closed_forms(recorder: Recorder) -> None:
    """Closed forms have leading order in a/d: exact for slender chains, and always along x."""
    phases = np.array([0.02, 0.1, 0.5, 1.5])
    for label, direction in WAVES:
        for reach in (2, 30, "all"):
            law = rod.reach_ratio(label, phases, reach, direction)
            for radius in (1e-4, 1.0):
                measured = lattice_ratio(label, phases, reach, direction, radius)
                worst = np.abs(measured / law - 1)
                exact = direction == "longitudinal" or label == "3t"
                # the torques of the slip, and the friction of rotation: (a/d)², at short waves
                allowed = EXACT if exact else 2 * (radius / 10.0) ** 2 * phases**2 + 1e-11
                recorder.bound(
                    f"{label} {NAMES[direction]}, {reach} over nearest, a/d = {radius / 10:g}: "
                    "lattice less closed form, over what is allowed",
                    np.max(worst / allowed),
                    most=1.0,
                    source="Σ over m, as polylogarithms; 2 (a/d)² (qd)² for what is left out",
                )


def _limits(recorder: Recorder) -> None:
    """The logarithm of 2s and 3a, and ζ(3) of 3t and 4a, on the lattice operator."""
    tiny = np.array([1e-3])
    logarithms: tuple[tuple[str, Direction, float], ...] = (
        ("2s", "transverse", 3 / 2),
        ("3a", "transverse", 4 / 3),
        ("2s", "longitudinal", 3 / 2),
    )
    for label, direction, constant in logarithms:
        name = f"{label} {NAMES[direction]}"
        ratio = lattice_ratio(label, np.array([1e-3, 2e-3]), direction=direction)
        recorder.check(
            f"{name}: all over nearest is {constant:.4g} − ln qd",
            constant,
            (ratio + np.log([1e-3, 2e-3]))[0],
            2e-6,
            source="Li₃ at small phase",
        )
        recorder.check(
            f"{name}: gain for each halving of qd is ln 2",
            math.log(2),
            ratio[0] - ratio[1],
            1e-5,
            source="Li₃ at small phase",
        )
    for label, direction in WAVES:
        if label in ("2s", "3a"):
            continue
        recorder.check(
            f"{label} {NAMES[direction]}: all over nearest is ζ(3)",
            ZETA,
            lattice_ratio(label, tiny, direction=direction)[0],
            5e-6,
            source="Li₄ and Li₃ at small phase",
        )
    long = np.array([0.02])
    recorder.difference(
        "3t: third order in qd that only an endless sum has, over 2ζ(3) qd",
        -1 / (12 * ZETA),
        (lattice_ratio("3t", long)[0] / ZETA - 1) / long[0] ** 2,
        1e-3,
        source="the q³ term of Eq. 3t_beam_lim vanishes for every single distance",
    )
    ratio = lattice_ratio("4a", long)[0]
    recorder.check(
        "4a: next order, (qd)² (ln qd − 7/4 + ζ(3))/4",
        ZETA - 7 / 4,
        4 * (ratio - ZETA) / long[0] ** 2 - math.log(long[0]),
        5e-3,
        source="Li₅ and Li₄ at small phase",
    )


def _neighbours_needed(recorder: Recorder) -> dict[tuple[str, str], list[int]]:
    """k for each level: from the sums, and from the lattice operator."""
    needed: dict[tuple[str, str], list[int]] = {}
    phases = np.array([READ_AT])
    for label, direction in WAVES:
        counts = [rod.neighbours_needed(label, READ_AT, level, direction) for level in LEVELS]
        needed[label, direction] = counts
        every = lattice_ratio(label, phases, "all", direction)[0]
        for level, count in zip(LEVELS, counts, strict=True):
            found = math.inf
            for k in range(count + 1, max(count - 3, 0), -1):
                away = abs(lattice_ratio(label, phases, k, direction)[0] / every - 1)
                if away >= level:
                    break
                found = k
            recorder.check(
                f"{label} {NAMES[direction]}: neighbours for {100 * level:g} % at qd = {READ_AT}",
                count,
                found,
                0,
                source="partial sums over m",
                relative=False,
            )
    return needed


def _simulations(recorder: Recorder) -> list[Run]:
    """Rates of periodic chains of one wave: passive, nearest neighbours and all pairs."""
    counts = (24, 64) if recorder.quick else (12, 16, 24, 32, 48, 64, 96, 128)
    runs = []
    for label, direction in WAVES:
        for count in counts:
            recorder.step(f"simulation of {label} {NAMES[direction]}, {count} spheres")
            run = simulated_rate(label, count, direction)
            runs.append(run)
            name = f"{label} {NAMES[direction]}, qd = 2π/{count}"
            recorder.check(
                f"{name}: simulated active rate, all pairs",
                _paper_rate(run) * complex(rod.reach_ratio(label, run.phase, "all", direction)),
                run.active,
                2e-3 + 2 * (run.phase / SPACING) ** 2,
                source="Appendix C times the lattice sum; 2 (a/d)² (qd)², and μ/λd² of 2e-4",
            )
            recorder.check(
                f"{name}: simulated Λ, all pairs",
                run.lattice_all,
                run.all,
                1e-4,
                source="lattice operator of the same chain",
            )
            recorder.check(
                f"{name}: active rate, all over nearest, simulated",
                run.lattice_ratio,
                run.ratio,
                1e-4,
                source="lattice operator of the same chain",
            )
    return runs


def _paper_rate(run: Run) -> complex:
    """The active rate with nearest neighbours by the paper's discrete equations, λ → ∞."""
    theory = rod.Rod(strengths={run.label: STRENGTHS[run.label]})
    q = np.array([run.phase / SPACING])
    if run.direction == "longitudinal":
        return complex(rod.discrete_operator(theory, q)[0, 0, 0])
    return complex(rod.beam_rates(theory, q)[0, 0])


def _table(recorder: Recorder, runs: list[Run], needed: dict[tuple[str, str], list[int]]) -> None:
    limits = {
        ("2s", "transverse"): "3/2 − ln qd",
        ("3a", "transverse"): "4/3 − ln qd",
        ("3t", "transverse"): "ζ(3)",
        ("4a", "transverse"): "ζ(3)",
        ("2s", "longitudinal"): "3/2 − ln qd",
        ("3t", "longitudinal"): "ζ(3)",
    }
    rows = []
    for label, direction in WAVES:
        of_kind = [r for r in runs if (r.label, r.direction) == (label, direction)]
        run = min(of_kind, key=lambda r: abs(math.log(r.phase / READ_AT)))
        closed = rod.reach_ratio(label, READ_AT, "all", direction)
        rows.append(
            (
                f"{label} {NAMES[direction]}",
                limits[label, direction],
                float(closed),
                float(lattice_ratio(label, np.array([READ_AT]), "all", direction)[0]),
                f"{run.ratio:.4f} at {run.phase:.3f}",
                *needed[label, direction],
            )
        )
        reference = rod.reach_limit(label, READ_AT, direction)
        recorder.check(
            f"{label} {NAMES[direction]}: limit law at qd = {READ_AT}",
            float(reference),
            float(closed),
            2e-3,
            source="expansion of the polylogarithms",
        )
    recorder.table(
        "What all pairs change",
        ["Wave", "qd → 0", f"Sum, qd = {READ_AT}", "Lattice", "Simulated, at qd",
         *(f"k for {100 * level:g} %" for level in LEVELS)],
        rows,
        "Active rate with all pairs over that with nearest neighbours, and the number k of "
        f"neighbours on each side within 10 %, 1 % and 0.1 % of all pairs at qd = {READ_AT}.",
        first_page=True,
    )  # fmt: skip
