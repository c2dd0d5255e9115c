"""A clamped chain of pushers through its first three buckling points, and coils of both hands."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

import nrchain
from validation.report.recorder import Recorder
from validation.states.confirmed import rate_in_run

ISSUE = {"elasticity.ratio": 1e8, "elasticity.measure": "isotropic"}
LINKS = {
    "elasticity.ratio": None,
    "elasticity.stretch": 1e3,
    "elasticity.shear": 1e3,
    "elasticity.measure": "isotropic",
}

WITHIN = 1e-2
"""Of rates in runs and rates of modes."""

SQUARE_ROOT = 0.02
"""Of the exponent of amplitudes near a threshold and 1/2."""

STRAIGHT_LINE = 1e-7
"""Of thresholds by two ways, relative."""


def euler_loads() -> list[float]:
    """F L²/κ at which a rod with clamped ends buckles: sin(x/2) (sin(x/2) − (x/2) cos(x/2)) = 0."""
    odd = brentq(lambda x: math.sin(x) - x * math.cos(x), 4.0, 4.6)
    return [4.0 * math.pi**2, 4.0 * odd**2, 16.0 * math.pi**2]


def buckling(recorder: Recorder) -> nrchain.BranchDiagram:
    """The branches of pushers, N = 20; their thresholds also for N = 40 and 80."""
    scene = nrchain.load_scene("buckling", **ISSUE)
    found = nrchain.continue_state(scene, {"slip.2s": (0.0, 250.0)}, branches=4, step=0.03)
    points = found.branches[0].special
    recorder.bound(
        "2s, N = 20: pitchforks of the straight chain below V = 250",
        sum(point.kind == "pitchfork" for point in points),
        least=3,
        most=3,
        source="three Euler loads",
    )
    for number, point in enumerate(points):
        crossing = _crossing(scene, point.value, 2 * number)
        recorder.check(
            f"2s, N = 20: pitchfork {number + 1} and the zero of the spectrum",
            crossing,
            point.value,
            STRAIGHT_LINE * crossing,
            source="bisection of the eigenvalues of the straight chain",
        )
    for number, branch in enumerate(found.branches[1:]):
        _check_square_root(recorder, f"2s, branch {number + 1}", branch, points[number].value)
        _confirm(recorder, f"2s, branch {number + 1}", branch)
    _against_euler(recorder)
    return found


def _crossing(scene: nrchain.Scene, expected: float, index: int) -> float:
    """The strength at which the rate number ``index`` of the straight chain vanishes."""

    def rate(value: float) -> float:
        at = nrchain.load_scene(scene, **{"slip.2s": value})
        return float(nrchain.spectrum(at).rates[index].real)

    return float(brentq(rate, 0.98 * expected, 1.02 * expected, xtol=1e-10 * expected))


def _against_euler(recorder: Recorder) -> None:
    """Thresholds of chains with stiff links over Euler's, extrapolated in (N − 1)⁻²."""
    ratios = []
    for count in (40, 80):
        scene = nrchain.load_scene("buckling", **LINKS, **{"chain.particles": count})
        chain, links = scene.chain, count - 1
        stiffness = scene.moduli.bend * chain.spacing
        unit = stiffness / (links * chain.spacing) ** 2
        unit *= 3.0 * chain.spacing**2 / (7.0 * chain.radius**2 * scene.drag.translation)
        top = 1.15 * unit * euler_loads()[-1]
        found = nrchain.continue_state(scene, {"slip.2s": (0.0, top)}, branches=1)
        values = np.array([point.value for point in found.special[:3]])
        ratios.append(values / unit / euler_loads())
    short, long = 39**2, 79**2
    limits = (long * ratios[1] - short * ratios[0]) / (long - short)
    for number, limit in enumerate(limits):
        recorder.check(
            f"2s: threshold {number + 1} of long chains over Euler's load of the prestress",
            1.0,
            limit,
            3e-3,
            source="γ_T 7a²V/3d² = 4π², 4 · 4.4934², 16π² times κ/L²",
        )


def coils(recorder: Recorder) -> None:
    """3a of both signs: the same thresholds, and coils that are mirror images."""
    diagrams = []
    for sign in (1.0, -1.0):
        scene = nrchain.load_scene("helix-left", **LINKS, **{"chain.particles": 20})
        along = {"slip.3a": (0.0, sign * 14000.0)}
        diagrams.append(nrchain.continue_state(scene, along, branches=2, step=0.03))
    right, left = (found.branches[1] for found in diagrams)
    points = [found.branches[0].special for found in diagrams]
    for number, (one, other) in enumerate(zip(*points, strict=True)):
        recorder.check(
            f"3a, N = 20: threshold {number + 1} of V < 0 and of V > 0",
            one.value,
            -other.value,
            STRAIGHT_LINE * one.value,
            source="mirror images",
        )
    hands = [_hand(branch.positions[-1]) for branch in (right, left)]
    recorder.bound(
        "3a: hands of the two coils, product of their writhing sums over their squares",
        hands[0] * hands[1] / max(abs(hands[0]), abs(hands[1])) ** 2,
        least=-1.0 - 1e-6,
        most=-1.0 + 1e-6,
        source="mirror images",
    )
    recorder.check(
        "3a: amplitudes of the two coils at |V| = 14000",
        right.amplitude[-1],
        left.amplitude[-1],
        1e-6 * right.amplitude[-1],
        source="mirror images",
    )
    _check_square_root(recorder, "3a coils", right, points[0][0].value)
    for word, branch in (("V > 0", right), ("V < 0", left)):
        _confirm(recorder, f"3a coils, {word}", branch)


def _hand(positions: np.ndarray) -> float:
    """Σ (t_i × t_{i+1}) · t_{i+2}: positive for right-handed chains."""
    links = np.diff(positions, axis=0)
    return float(np.sum(np.cross(links[:-2], links[1:-1]) * links[2:]))


def _check_square_root(
    recorder: Recorder, name: str, branch: nrchain.StateBranch, onset: float
) -> None:
    """Amplitudes of the first states of a branch grow as the square root."""
    away = np.abs(branch.values - onset)
    near = np.flatnonzero((away > 0.0) & (away < 0.05 * abs(onset)))[:5]
    slope = np.polyfit(np.log(away[near]), np.log(branch.amplitude[near]), 1)[0]
    recorder.check(
        f"{name}: exponent of the amplitude at its onset",
        0.5,
        slope,
        SQUARE_ROOT,
        source="a pitchfork",
    )


def _confirm(recorder: Recorder, name: str, branch: nrchain.StateBranch) -> None:
    """A run returns to, or leaves, the state in the middle of a branch at the leading rate."""
    state = branch.state(len(branch) // 2)
    mode = state.spectrum.leading
    rate = rate_in_run(state, mode)
    doing = "return" if mode.growth < 0.0 else "departure"
    recorder.check(
        f"simulated: {name}, {doing} over the leading rate",
        1.0,
        rate / mode.growth,
        WITHIN,
        source="a run that starts off the state by 1e-4 a",
    )
