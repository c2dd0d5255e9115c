"""Warnings about a scene before it runs: does the chain hold, do the tolerances resolve it?

The paper's laws, and the picture of a bending chain, hold in the beam limit: bonds that neither
stretch nor shear. With the stiffness rule λ ∝ (N−1)⁻⁴ long chains leave it quickly. With R = 1e7,
N = 64 and 2s at V = 100, λd is 1.6 against a tension of 44, and a free chain tears apart within 80
time units.
"""

from __future__ import annotations

import numpy as np

from nrchain.effects.shared.slip_flow import active_modes
from nrchain.errors import SceneError
from nrchain.motion.integrators import find_integrator
from nrchain.planning.integrator import integrator_of
from nrchain.planning.missing_stokeslets import stokeslet_warning
from nrchain.planning.remedies import remedy
from nrchain.planning.soundness import Judgement, judge
from nrchain.planning.weaknesses import Weak
from nrchain.scene.loading import require_scene
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene
from nrchain.watch.seed import BARELY, seed_warning

STEPS_PER_NOISE = 0.3
"""Steps of CVODE for each tolerance of a step by which rounding moves a sphere: measured at N = 64.
Radau takes none: every step starts in a chart of its own, in which positions are small numbers."""

NOISE_STEPS = 5000
"""More steps than this due to rounding alone are worth a warning."""


Judged = Judgement | SceneError | ArithmeticError
"""A judgement, or the error that prevents one."""


def warnings(scene: Scene, found: Judged | None = None) -> list[str]:
    """What to know before a scene runs: one sentence each, with numbers and a remedy.

    There are four, each for one condition that fails:

    - the chain holds (:func:`nrchain.planning.soundness.judge`); if it does not stay straight by
      itself, the warning says that it cannot be judged;
    - ``run.atol`` is above what rounding leaves of its springs;
    - a start that grows is above ``run.atol``;
    - the scene keeps no smaller flow beside a larger one that it drops.

    ``found`` is the judgement of the scene, if it is known.
    """
    judgement = try_judge(require_scene(scene)) if found is None else found
    found_warnings = [
        _soundness_warning(scene, judgement),
        _rounding_warning(scene),
        _start_warning(scene),
    ]
    found_warnings.append(stokeslet_warning(scene, *initial_poses(scene)))
    return [text for text in found_warnings if text]


def try_judge(scene: Scene) -> Judged:
    """The judgement of a scene, or the error that prevents one."""
    try:
        return judge(require_scene(scene))
    except (SceneError, ArithmeticError) as error:
        return error
    except np.linalg.LinAlgError as error:
        return ArithmeticError(str(error))


def rounding_drift(scene: Scene) -> float:
    """ε λ L/γ_T: the velocity that the rounding of coordinates gives a sphere through its springs.

    A coordinate of size L is known to εL. A link strains by εL/d, and its springs, of stiffness λ,
    answer with a force that no step can resolve.
    """
    stiffness = max(scene.moduli.stretch, scene.moduli.shear)
    return float(np.finfo(float).eps) * stiffness * scene.length / scene.drag.translation


def _soundness_warning(scene: Scene, found: Judged) -> str:
    if not isinstance(found, Judgement):
        if not active_modes(scene):
            return ""
        return f"whether the bonds hold against the slip cannot be judged before the run: {found}"
    if found.sound:
        return ""
    kinds = {weakness.kind for weakness in found.weaknesses}
    what = "out of the beam limit" if kinds & {Weak.STRETCH, Weak.SHEAR} else "the chain gives way"
    texts = "; ".join(weakness.text for weakness in found.weaknesses)
    return f"{what}: {texts}; {remedy(scene)}"


def _rounding_warning(scene: Scene) -> str:
    scheme = find_integrator(integrator_of(scene))
    if scheme.renews_chart:
        return ""
    moved = STEPS_PER_NOISE * rounding_drift(scene) * scene.run.end / scene.chain.radius
    moved /= scheme.share
    steps = moved / scene.run.atol
    if steps <= NOISE_STEPS:
        return ""
    return (
        f"run.atol = {scene.run.atol:g} is below the rounding of springs this stiff, and takes some"
        f" {steps:.1g} steps; the run gets no more accurate below run.atol ="
        f" {moved / NOISE_STEPS:.1g}"
    )


def _start_warning(scene: Scene) -> str:
    start = scene.start
    large = abs(start.amplitude) >= BARELY * scene.run.atol * scene.chain.radius
    if start.shape not in ("straight", "given") and large:
        return ""
    return seed_warning(scene, *initial_poses(scene))
