"""Waves of height a/10 and open ends, which the paper measures: how they change the rates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import nrchain
from nrchain import Branch, Rod, measure
from nrchain.theory.rod import dispersion
from validation.continuum.runs import GAMMA_T, D, exact, wave_scene
from validation.report.recorder import Recorder

FREE_FREE = 4.730040744862704
"""βL of the slowest bending mode of a beam with free ends, cos βL cosh βL = 1."""

MODES: dict[str, tuple[float, str, measure.Kind]] = {
    "": (0.0, "sine", "y"),
    "2s": (100.0, "sine", "y"),
    "3a": (5000.0, "helix-left", "left"),
    "3t": (1000.0, "sine", "y"),
    "4a": (10000.0, "helix-right", "right"),
}


@dataclass(frozen=True)
class High:
    """Relative change of the rate of a passive wave by its height a/10: measured and predicted."""

    count: int
    measured: float
    predicted: float


@dataclass(frozen=True)
class Free:
    """A fit to a free chain of N spheres, and the law at its q = π/L."""

    label: str
    strength: float
    count: int
    fit: measure.ShapeFit
    law: complex


def tension(recorder: Recorder) -> list[High]:
    """A helix of height A around a period that cannot shorten is under the tension λd(Aq)²/2.

    Its amplitude then follows Ȧ = ΛA − (λd²/2γ_T) q⁴ |A|² A, which for real Λ is solved by
    |A|⁻² = (|A₀|⁻² − k/Λ) exp(−2Λt) + k/Λ with k = λd²q⁴/2γ_T.
    """
    found = []
    for count in (24, 40, 64, 96):
        x = 2 * math.pi / count
        scene = nrchain.load_scene(
            wave_scene("", 0.0, count, "helix-right", amplitude=0.1),
            **{"run.end": 0.5 / x**4, "run.atol": 1e-11},
        )
        wave = measure.wave(nrchain.simulate(scene))
        start = scene.run.end / 20
        rate = measure.rate(wave, start).growth.value
        linear = exact(scene, x, Branch.BEND_PLUS).real
        k = scene.moduli.stretch * (x * x / D) ** 2 / (2 * GAMMA_T)
        inverse = (np.abs(wave.amplitude[0]) ** -2 - k / linear) * np.exp(-2 * linear * wave.time)
        solution = (inverse + k / linear) ** -0.5 + 0j
        expected = measure.rate(
            measure.Wave(wave.time, solution, 0 * wave.time, wave.wavenumber), start
        ).growth.value
        found.append(High(count, rate / linear - 1.0, expected / linear - 1.0))
        recorder.check(
            f"a wave of height a/10 on a periodic passive chain, N = {count}: change of its rate",
            found[-1].predicted,
            found[-1].measured,
            0.02,
            source="tension λd(Aq)²/2 of a helix around a period that cannot shorten",
        )
    return found


def free_chains(recorder: Recorder) -> list[Free]:
    """Half a wavelength on free chains, fitted as the paper does."""
    counts = (17, 33) if recorder.quick else (17, 33, 49, 65)
    found = []
    for label, (strength, shape, kind) in MODES.items():
        for v in {"2s": (-strength, strength)}.get(label, (strength,)):
            found += [_free(label, v, shape, kind, n) for n in counts]
    recorder.table(
        "free chains",
        ("mode", "V", "N", "fit: Re Λ", "law: Re Λ", "fit: Im Λ", "law: Im Λ", "misfit"),
        [
            (f.label or "passive", f.strength, f.count,
             *(f"{v:.3g}" for v in (f.fit.rate.value.real, f.law.real, f.fit.rate.value.imag,
                                    f.law.imag)), f"{f.fit.misfit:.2f}")
            for f in found
        ],
        "Free chains that start from half a wavelength of height a/10, fitted with a plane wave of "
        "q = π/L from a tenth of the run on (0.3 passive decay times; 3t and 4a: 0.3 rad; 3a: at "
        "most until the fastest wave has grown e-fold). Misfit: residual of the fit, relative to "
        "the shape.",
    )  # fmt: skip
    _pushers_do_not_buckle(recorder, found)
    for count in counts[1:]:
        _slowest_mode(recorder, count)
    _say(recorder, found)
    return found


def _scene(label: str, strength: float, shape: str, count: int) -> nrchain.Scene:
    return nrchain.load_scene(
        {
            "chain": {"particles": count},
            "elasticity": {"ratio": 1e12},
            "slip": {label: strength} if label else {},
            "start": {"shape": shape, "amplitude": 0.1},
            "run": {"end": 1.0, "rtol": 1e-8, "atol": 1e-11},
        }
    )


def _free(label: str, strength: float, shape: str, kind: measure.Kind, count: int) -> Free:
    scene = _scene(label, strength, shape, count)
    x = scene.wavevector * D
    law = complex(
        dispersion.transverse(Rod.of(scene), scene.wavevector, -1 if kind == "left" else 1)
    )
    end = 0.3 / (abs(law) if law.imag else x**4)
    if label == "3a":
        end = min(end, 1.0 / _fastest(scene))
    scene = nrchain.load_scene(scene, **{"run.end": end})
    fit = measure.fit_shape(nrchain.simulate(scene), kind=kind, start=end / 10)
    return Free(label, strength, count, fit, law)


def _fastest(scene: nrchain.Scene) -> float:
    """The largest growth rate of left-handed waves, which dominate all slower ones in the end."""
    q = np.linspace(0.0, 1.0, 1000) / D
    return float(dispersion.transverse(Rod.of(scene), q, -1).real.max())


def _pushers_do_not_buckle(recorder: Recorder, found: list[Free]) -> None:
    """On free chains the elastic tension cancels the prestress, and with it the buckling term."""
    passive = {f.count: f.fit.rate.growth.value for f in found if not f.label}
    for f in found:
        if f.label == "2s":
            recorder.check(
                f"2s on a free chain, V = {f.strength:+g}, N = {f.count}: rate over the passive",
                1.0,
                f.fit.rate.growth.value / passive[f.count],
                0.02,
                source="the end spheres stretch or squeeze the springs until they balance the "
                "prestress",
            )
    for strength in (100.0, -100.0):
        scene = nrchain.load_scene(_scene("2s", strength, "straight", 33), **{"run.end": 1.0})
        ends = nrchain.simulate(scene).positions[-1, 15:18:2, 0]
        strain = (ends[1] - ends[0]) / (2 * D) - 1.0
        recorder.check(
            f"2s on a free chain, V = {strength:+g}: tension of its springs",
            7 * GAMMA_T * strength / (3 * D**2),
            scene.moduli.stretch * D * strain,
            1e-3,
            source="minus the prestress, Eq. (2s_prestress)",
        )


def _slowest_mode(recorder: Recorder, count: int) -> None:
    """At late times a passive chain decays as a beam with free ends, half a spacing longer."""
    scene = _scene("", 0.0, "sine", count)
    law = -((FREE_FREE / count) ** 4)
    scene = nrchain.load_scene(scene, **{"run.end": 3.0 / abs(law)})
    rate = measure.rate(measure.wave(nrchain.simulate(scene), kind="y")).growth.value
    recorder.check(
        f"free passive chain, N = {count}: decay of its slowest mode",
        law,
        rate,
        2.0 / count**2 + 1e-4,
        source="−(κ_R/Γ_T)(4.730/Nd)⁴: a beam with free ends that bears the friction of N spheres",
    )


def _say(recorder: Recorder, found: list[Free]) -> None:
    longest = max(f.count for f in found)
    ratio = {f.label: f.fit.rate.value for f in found if f.count == longest and f.strength >= 0}
    law = {f.label: f.law for f in found if f.count == longest and f.strength >= 0}
    recorder.text(
        f"**What free ends do** (N = {longest}, half a wavelength, read as the paper reads it). A "
        "sine is no mode of a free beam: at first its middle relaxes with the law while the ends "
        "straighten, so that the fit to a passive chain gives "
        f"{ratio[''].real / law[''].real:.2f} of the law, and what is left in the end is the free "
        "beam's own slowest mode, (4.730/π)⁴ ≈ 5.1 times as fast. A free chain of pushers does "
        f"not buckle: the law says {law['2s'].real:+.2g}, the fit {ratio['2s'].real:+.2g}. Its end "
        "spheres are pushed outwards until the springs carry just the opposite of the prestress, "
        "and a rod under no net tension has no term in u″. The instability of Eq. (2s_tr_displ) "
        "needs ends that are held, or a period. Travelling waves keep "
        f"{ratio['3t'].imag / law['3t'].imag:.3f} (3t) and {ratio['4a'].imag / law['4a'].imag:.3f} "
        "(4a) of their frequency."
    )
