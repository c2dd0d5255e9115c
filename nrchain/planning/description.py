"""What a scene simulates, what it leaves out and which of its keys have no effect, in words."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from nrchain.effects.flow import Flow, FlowSpec
from nrchain.effects.registry import effects
from nrchain.effects.shared.slip_flow import active_modes, reach_text
from nrchain.effects.strain import Strain
from nrchain.effects.strain_size import FiniteSizeOfStrain
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip import Slip
from nrchain.notebook import table_html
from nrchain.planning.integrator import integrator_of
from nrchain.planning.pair_sums import sum_over_pairs, unused_accuracy
from nrchain.planning.regime import warnings
from nrchain.scene.chain_sections import ElasticitySpec, StartSpec
from nrchain.scene.fluid_sections import FrictionSpec, SlipSpec
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.wording import brief, span

Row = tuple[str, str]


@dataclass(frozen=True)
class Description:
    """What a scene simulates and leaves out, as rows (effect, one line), with warnings.

    ``without_effect`` are the keys that differ from their default and change nothing, with reasons.
    """

    simulated: list[Row]
    left_out: list[Row]
    warnings: list[str]
    without_effect: list[Row] = field(default_factory=list)

    __repr__ = brief

    def _repr_html_(self) -> str:
        headed = {
            "simulated": self.simulated,
            "left out": self.left_out,
            "without effect": self.without_effect,
        }
        rows = [(head, *row) for head, found in headed.items() for row in found]
        rows += [("warning", "", text) for text in self.warnings]
        return table_html("What the scene simulates", rows, ("", "effect", "details"))


def describe(scene: Scene) -> Description:
    """The effects that a scene simulates, those it leaves out, and warnings about its run.

    >>> from nrchain import load_scene
    >>> describe(load_scene("buckling", **{"chain.particles": 8})).warnings
    []
    """
    simulated, left_out = effect_rows(scene)
    return Description(simulated, left_out, warnings(scene), without_effect(scene))


def effect_rows(scene: Scene) -> tuple[list[Row], list[Row]]:
    """The effects that a scene simulates, and those it leaves out."""
    simulated: list[Row] = []
    left_out: list[Row] = []
    for effect in effects():
        if effect.key.startswith(("slip.", "flow.", "friction.")):
            continue
        if effect.acts(require_scene(scene)):
            simulated.append((effect.name, effect.detail(scene)))
        else:
            left_out.append((effect.name, effect.absence))
    if scene.moduli.twist or scene.moduli.bend:
        simulated.append(("measure of twist and bend", scene.elasticity.measure))
    _describe_slip(scene, simulated, left_out)
    _describe_flow(scene, simulated, left_out)
    _describe_friction(scene, simulated, left_out)
    if way := sum_over_pairs(scene):
        simulated.append(("sum over all pairs", way))
    left_out.append(("other effects", "Brownian motion"))
    run = scene.run
    scheme = integrator_of(scene)
    chosen = f"{run.integrator}: {scheme}" if scheme != run.integrator else scheme
    simulated.append(("integrator", f"{chosen}, rtol {run.rtol:g}, atol {run.atol:g}"))
    return simulated, left_out


def _describe_slip(scene: Scene, simulated: list[Row], left_out: list[Row]) -> None:
    reach = scene.slip.neighbours
    where = reach_text(reach)
    for label, mode in scene.slip.modes.items():
        strength = np.asarray(mode.strength)
        text = span(f"{strength.min():g}", f"{strength.max():g}")
        if np.any(strength):
            simulated.append((f"slip {label}", f"strength {text}, {where}"))
        else:
            left_out.append((f"slip {label}", "strength 0"))
    acting = active_modes(scene)
    if not acting:
        return
    simulated.append(("pair laws of slip", scene.slip.backend))
    if corrected := [label for label in acting if _has_finite_size(label)]:
        (simulated if scene.slip.finite_size else left_out).append(
            ("finite size", f"(a/r)² in the velocity of {', '.join(corrected)}")
        )
    if reach != "all":
        left_out.append(("long range", f"slip flows beyond {where}"))


def _describe_flow(scene: Scene, simulated: list[Row], left_out: list[Row]) -> None:
    """Rows on the disturbance of a background flow, if there is a flow."""
    if not Flow.acts(scene):
        left_out.append((Flow.name, Flow.absence))
        return
    simulated.append((Flow.name, Flow.detail(scene)))
    if not Strain.acts(scene):
        left_out.append((Strain.name, Strain.absence))
        return
    simulated.append((Strain.name, Strain.detail(scene)))
    size, reach = FiniteSizeOfStrain, Flow.section(scene).neighbours
    (simulated if size.acts(scene) else left_out).append((size.name, size.summary))
    if reach != "all":
        left_out.append(("long range of strain", f"disturbances beyond {reach_text(reach)}"))


def _describe_friction(scene: Scene, simulated: list[Row], left_out: list[Row]) -> None:
    friction = scene.friction
    if friction.kind == "one-body":
        simulated.append(("friction", "one-body"))
        left_out.append(("friction between spheres", "Rotne–Prager–Yamakawa mobilities"))
        return
    where = reach_text(friction.neighbours)
    simulated.append(("friction", f"pairwise, {where}, {friction.backend}"))
    left_out.append(("near field", "lubrication and reflections, of order (a/r)⁴"))
    if friction.neighbours != "all":
        left_out.append(("long range of friction", f"mobilities beyond {where}"))


def without_effect(scene: Scene) -> list[Row]:
    """The keys that differ from their default and change nothing, each with the reason."""
    rows = [*_unused_slip(scene), *_unused_flow(scene), *_unused_elasticity(scene)]
    rows += _unused_start(scene)
    friction = scene.friction
    if friction.kind == "one-body":
        for name in ("neighbours", "backend"):
            if getattr(friction, name) != getattr(FrictionSpec(), name):
                rows.append((friction.key(name), "friction.kind is 'one-body'"))
    return rows


def _unused_slip(scene: Scene) -> list[Row]:
    rows, acting, slip = [], active_modes(scene), scene.slip
    for label, mode in slip.modes.items():
        if label not in acting and mode.axis != Slip(0.0).axis:
            rows.append((f"{SlipSpec.key(label)}.axis", f"the strength of {label} is 0"))
    if not acting:
        names = [name for name in slip.spellings() if name != "accuracy"]
        changed = (name for name in names if getattr(slip, name) != getattr(SlipSpec(), name))
        rows += [(slip.key(name), "no mode has a strength") for name in changed]
    elif slip.finite_size and not any(_has_finite_size(label) for label in acting):
        rows.append(("slip.finite_size", f"the flow of {', '.join(acting)} has no such correction"))
    if slip.accuracy is not None and (reason := unused_accuracy(scene)):
        rows.append(("slip.accuracy", reason))
    return rows


def _unused_flow(scene: Scene) -> list[Row]:
    """Keys of the disturbance, where the flow has no strain or spheres do not disturb it."""
    flow = Flow.section(scene)
    if Strain.acts(scene):
        return []
    names, why = ["neighbours", "finite_size"], "flow.disturbance is false"
    if not (flow.matrix + flow.matrix.T).any():
        names, why = ["disturbance", *names], "flow.gradient has no strain"
    changed = (name for name in names if getattr(flow, name) != getattr(FlowSpec(), name))
    return [(flow.key(name), why) for name in changed]


def _unused_elasticity(scene: Scene) -> list[Row]:
    rows, elasticity, moduli = [], scene.elasticity, scene.moduli
    if elasticity.measure != ElasticitySpec().measure and not (moduli.twist or moduli.bend):
        rows.append(("elasticity.measure", "no link resists twist or bend"))
    if elasticity.ratio is not None and not moduli.bend:
        rows.append(("elasticity.ratio", "it multiplies elasticity.bend, which is 0"))
    return rows


_USED = {
    "straight": (),
    "sine": ("amplitude", "wavenumber"),
    "helix-left": ("amplitude", "wavenumber"),
    "helix-right": ("amplitude", "wavenumber"),
    "random": ("amplitude", "seed"),
    # nrchain.measure takes this wave unless another is named
    "given": ("wavenumber",),
}
"""The keys that each shape uses."""


def _unused_start(scene: Scene) -> list[Row]:
    start = scene.start
    given = [
        name
        for name in ("amplitude", "wavenumber", "seed")
        if getattr(start, name) != getattr(StartSpec(), name) and name not in _USED[start.shape]
    ]
    return [(start.key(name), f"start.shape is {start.shape!r}") for name in given]


def _has_finite_size(label: str) -> bool:
    mode = slip_modes.find(label)
    return mode.flow(finite_size=True) != mode.flow()
