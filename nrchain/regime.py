"""Is λd well above the active prestress? What a scene's numbers say before it runs.

The paper's laws, and the picture of a bending chain, hold in the beam limit: bonds that neither
stretch nor shear. The stiffness rule λ ∝ (N−1)⁻⁴ loses it quickly as chains grow. With R = 1e7,
N = 64 and 2s at V = 100, λd is 1.6 against a prestress of −44, and a free chain tears itself apart
within 80 time units.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.arguments import a_scene
from nrchain.errors import SceneError
from nrchain.lattice import Branch, lattice_rates, steady_stress
from nrchain.scene import DEFAULT_RATIO, Scene, load_scene

LARGEST_STRAIN = 0.3
"""Prestress over λ∥d beyond which a scene is called out of the beam limit."""

WAVENUMBERS = 64
"""How many waves, from one over the chain to two spheres long, are tried for growth."""

STEPS_PER_NOISE = 0.3
"""Steps CVODE takes for every ``atol`` by which rounding moves a sphere: measured, N = 64."""

NOISE_STEPS = 5000
"""More steps than this for the rounding of stiff springs alone are worth a warning."""


def warnings(scene: Scene) -> list[str]:
    """What to know before a scene runs, one sentence each with its numbers and a remedy.

    Empty for a scene in the beam limit whose tolerance is above the rounding of its springs.
    Chains that no plane wave describes (strengths that differ from sphere to sphere, axes that
    turn the chain across itself) are not judged by the beam limit.
    """
    return [text for text in (*_beam_warnings(a_scene(scene)), _rounding_warning(scene)) if text]


def _beam_warnings(scene: Scene) -> list[str]:
    if not scene.slip.modes:
        return []
    try:
        near = _one_body(scene)
        stress = steady_stress(near, spheres=max(scene.chain.particles // 2, 1))
        return [_strain_warning(scene, float(abs(stress[0]))), _growth_warning(scene, near)]
    except SceneError:
        return []


def rounding_drift(scene: Scene) -> float:
    """ε λ L/γ_T: the velocity that the rounding of coordinates gives a sphere through its springs.

    A coordinate of size L is known to εL, a link strains by as much over d, and its springs, of
    stiffness λ, answer with a force that no step can resolve.
    """
    stiffness = max(scene.moduli.stretch, scene.moduli.shear)
    return float(np.finfo(float).eps) * stiffness * scene.length / scene.drag.translation


def _rounding_warning(scene: Scene) -> str:
    moved = STEPS_PER_NOISE * rounding_drift(scene) * scene.run.end / scene.chain.radius
    steps = moved / scene.run.atol
    if steps <= NOISE_STEPS:
        return ""
    return (
        f"run.atol = {scene.run.atol:g} is below what rounding leaves of springs this stiff, and "
        f"takes some {steps:.1g} steps; no more accuracy is to be had below run.atol = "
        f"{moved / NOISE_STEPS:.1g}"
    )


def _one_body(scene: Scene) -> Scene:
    """The scene on an open chain with one-body friction: what decides stability is in it."""
    return load_scene(scene, friction="one-body")


def _strain_warning(scene: Scene, prestress: float) -> str:
    stiffness = scene.moduli.stretch * scene.chain.spacing
    if prestress <= LARGEST_STRAIN * stiffness:
        return ""
    remedy = "raise elasticity.stretch and elasticity.shear"
    if scene.elasticity.stretch is None:
        ratio = scene.elasticity.ratio or DEFAULT_RATIO
        needed = ratio * prestress / (LARGEST_STRAIN * stiffness)
        links = (scene.chain.particles - 1) * (ratio / needed) ** 0.25
        remedy = f"elasticity.ratio of {needed:.1e} or more holds them"
        if links >= 2:
            remedy += f", as do {math.floor(links) + 1} spheres or fewer at this ratio"
    return (
        f"out of the beam limit: the active prestress {prestress:.3g} is "
        f"{prestress / stiffness:.2g} of λ∥d = {stiffness:.3g}, and bonds give way; {remedy}"
    )


def _growth_warning(scene: Scene, near: Scene) -> str:
    d = scene.chain.spacing
    waves = np.linspace(math.pi / (scene.chain.particles * d), math.pi / d, WAVENUMBERS)
    try:
        rates = lattice_rates(near, waves, frame="spinning").real
    except FloatingPointError:
        return ""
    fast = rates[:, [Branch.STRETCH, Branch.SHEAR_PLUS, Branch.SHEAR_MINUS]]
    growth = float(fast.max())
    if growth * scene.run.end < 1.0:
        return ""
    return (
        f"bonds stretch or shear by themselves, tenfold every {math.log(10) / growth:.3g} time "
        "units, until the chain comes apart; stiffen it, or weaken the slip"
    )
