"""Will the chain hold, and do the tolerances resolve it? What a scene's numbers say before it runs.

The paper's laws, and the picture of a bending chain, hold in the beam limit: bonds that neither
stretch nor shear. The stiffness rule λ ∝ (N−1)⁻⁴ loses it quickly as chains grow. With R = 1e7,
N = 64 and 2s at V = 100, λd is 1.6 against a tension of 44, and a free chain tears itself apart
within 80 time units.
"""

from __future__ import annotations

import numpy as np

from nrchain.effects.shared.slip_flow import active_modes
from nrchain.errors import SceneError
from nrchain.planning.flow_forces import stokeslet_warning
from nrchain.planning.remedies import remedy
from nrchain.planning.soundness import Judgement, Weak, judge
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene, require_scene
from nrchain.watch.seed import BARELY, seed_warning

STEPS_PER_NOISE = 0.3
"""Steps CVODE takes for every ``atol`` by which rounding moves a sphere: measured, N = 64."""

NOISE_STEPS = 5000
"""More steps than this for the rounding of stiff springs alone are worth a warning."""


Judged = Judgement | SceneError | ArithmeticError
"""A judgement, or why there is none."""


def warnings(scene: Scene, found: Judged | None = None) -> list[str]:
    """What to know before a scene runs, one sentence each with its numbers and a remedy.

    Empty for a scene whose chain is judged to hold (:func:`nrchain.planning.soundness.judge`),
    whose tolerance is above the rounding of its springs, whose start is above that tolerance where
    it grows, and which keeps no smaller flow beside a larger one that it drops. A chain that does
    not stay straight by itself (axes that turn it across itself, a field across it that is not
    shared alike) cannot be judged, which is said instead. ``found`` is the judgement of the scene,
    if that is known.
    """
    own = judged(require_scene(scene)) if found is None else found
    told = [_soundness_warning(scene, own), _rounding_warning(scene), _start_warning(scene)]
    told.append(stokeslet_warning(scene, *initial_poses(scene)))
    return [text for text in told if text]


def judged(scene: Scene) -> Judged:
    """The judgement of a scene, or why there is none."""
    try:
        return judge(require_scene(scene))
    except (SceneError, ArithmeticError) as error:
        return error
    except np.linalg.LinAlgError as error:
        return ArithmeticError(str(error))


def rounding_drift(scene: Scene) -> float:
    """ε λ L/γ_T: the velocity that the rounding of coordinates gives a sphere through its springs.

    A coordinate of size L is known to εL, a link strains by as much over d, and its springs, of
    stiffness λ, answer with a force that no step can resolve.
    """
    stiffness = max(scene.moduli.stretch, scene.moduli.shear)
    return float(np.finfo(float).eps) * stiffness * scene.length / scene.drag.translation


def _soundness_warning(scene: Scene, found: Judged) -> str:
    if not isinstance(found, Judgement):
        if not active_modes(scene):
            return ""
        return f"what the slip does to the bonds cannot be judged beforehand: {found}"
    if found.sound:
        return ""
    kinds = {weakness.kind for weakness in found.weaknesses}
    what = "out of the beam limit" if kinds & {Weak.STRETCH, Weak.SHEAR} else "the chain gives way"
    texts = "; ".join(weakness.text for weakness in found.weaknesses)
    return f"{what}: {texts}; {remedy(scene)}"


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


def _start_warning(scene: Scene) -> str:
    start = scene.start
    large = abs(start.amplitude) >= BARELY * scene.run.atol * scene.chain.radius
    if start.shape not in ("straight", "given") and large:
        return ""
    return seed_warning(scene, *initial_poses(scene))
