"""The rules by which parts of a chain give way: bonds, links and spheres, each with its numbers.

Each rule compares what the chain carries with what holds it, and returns the weaknesses it finds.
:func:`nrchain.planning.soundness.judge` applies them all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from nrchain.outcome import Cause
from nrchain.scene.scene import Scene
from nrchain.theory.line_loads import LineLoads
from nrchain.theory.straight_growth import StraightGrowth
from nrchain.theory.straight_state import StraightState

LARGEST_STRAIN = 0.3
"""T/λ∥d or T/λ⊥d above which a scene is out of the beam limit."""

LARGEST_TURN = 0.7
"""Turn of a link, in rad, above which it may snap over: springs weaken from π/4 = 0.785 on."""

LARGEST_THRUST = 1.0
"""T d/μ⊥ and T d/μ∥ above which the links of a bend may snap over or twist. The square root of
T d/μ⊥ is the turn that a thrust gives the links of a bend. The paper's springs twist a link that is
bent by β with a moment of order μ⊥β²."""

LARGEST_MOMENT = 0.3
"""Moment about the chain over μ∥ or μ⊥ above which the links of a bend may snap over."""

SHEARED = 0.5
"""A growing mode shears if links turn away from e₁ by more than this part of the turn of e₁."""

FOLDS = 1.0
"""Growth by e to this power over the run counts as growth."""


class Weak(StrEnum):
    """Which part of a chain gives way."""

    TOUCH = "spheres touch"
    TURN = "links turn over"
    STRETCH = "stretch"
    SHEAR = "shear"
    TWIST = "twist"
    BEND = "bend"
    FOLD = "fold"


@dataclass(frozen=True)
class Load:
    """The largest tension T of a link against λ∥d (stretch) or λ⊥d (shear), which hold the bond."""

    name: str
    symbol: str
    tension: float
    stiffness: float

    @property
    def strain(self) -> float:
        """|T|/λd: the strain of the bond, while it is small."""
        if not self.tension:
            return 0.0
        return abs(self.tension) / self.stiffness if self.stiffness else math.inf

    @property
    def holds(self) -> bool:
        """Whether the strain is at most :data:`LARGEST_STRAIN`."""
        return self.strain <= LARGEST_STRAIN


@dataclass(frozen=True)
class Weakness:
    """One way in which a chain gives way, in words with its numbers."""

    kind: Weak
    text: str


def bond_loads(scene: Scene, loads: LineLoads) -> tuple[Load, Load]:
    """The largest tension, against the modulus of stretch and against that of shear."""
    tension, d = float(loads.tension[np.argmax(np.abs(loads.tension))]), scene.chain.spacing
    moduli = scene.moduli
    return (
        Load("stretch", "λ∥d", tension, moduli.stretch * d),
        Load("shear", "λ⊥d", tension, moduli.shear * d),
    )


def straight_weaknesses(scene: Scene, state: StraightState) -> list[Weakness]:
    """What fails while the chain is still straight."""
    when, link = f"at about t = {state.time:.3g}", state.link
    if state.stopped is Cause.TOUCH:
        text = f"spheres {link} and {link + 1} of the straight chain touch {when}"
        return [Weakness(Weak.TOUCH, text)]
    if state.stopped is Cause.TURN:
        text = f"link {link} of the straight chain turns over about e₁ {when}"
        return [Weakness(Weak.TURN, text)]
    found = []
    strain = state.lengths / scene.chain.spacing - 1.0
    most = int(np.argmax(np.abs(strain)))
    if abs(strain[most]) > LARGEST_STRAIN:
        way = "longer" if strain[most] > 0.0 else "shorter"
        text = f"link {most} of the straight chain becomes {abs(strain[most]):.2g} d {way}"
        found.append(Weakness(Weak.STRETCH, text))
    most = int(np.argmax(np.abs(state.turns)))
    if abs(state.turns[most]) > LARGEST_TURN:
        text = f"link {most} of the straight chain twists by {abs(state.turns[most]):.2g} rad"
        found.append(Weakness(Weak.TWIST, text))
    return found


def bond_weaknesses(scene: Scene, loads: LineLoads, carried: LineLoads) -> list[Weakness]:
    """Bonds that the tension stretches or shears too far."""
    found = []
    bent = carried is not loads
    for load, straight in zip(bond_loads(scene, carried), bond_loads(scene, loads), strict=True):
        worst = max(load, straight, key=lambda one: one.strain)
        if worst.holds:
            continue
        what = "bonds give way" if load.name == "stretch" else "links turn away from e₁"
        ratio = math.copysign(worst.strain, worst.tension)
        part = f"is {ratio:.2g} times {load.symbol} = {load.stiffness:.3g}, and"
        if not load.stiffness:
            part = f"has no {load.symbol} against it, and"
        whose = " in a bend" if bent and worst is load else ""
        text = f"the tension T = {worst.tension:.3g} of a link{whose} {part} {what}"
        found.append(Weakness(Weak.STRETCH if load.name == "stretch" else Weak.SHEAR, text))
    return found


def growth_weaknesses(scene: Scene, growth: StraightGrowth, bends: bool) -> list[Weakness]:
    """Growing modes that tear the chain apart, or turn its links over."""
    found = []
    if growth.along.rate * scene.run.end >= FOLDS:
        text = f"bonds stretch unstably, {_tenfold(growth.along.rate)}"
        found.append(Weakness(Weak.STRETCH, text))
    across = growth.across
    if bends and across.shear > SHEARED:
        text = f"bonds shear unstably, {_tenfold(across.rate)}"
        found.append(Weakness(Weak.SHEAR, text))
    if bends and across.phase > LARGEST_TURN:
        text = (
            f"a bend grows {_tenfold(across.rate)}; at slopes of 1 each link turns by"
            f" {across.phase:.2g} rad and may snap over"
        )
        found.append(Weakness(Weak.BEND, text))
    return found


def bend_weaknesses(scene: Scene, carried: LineLoads) -> list[Weakness]:
    """Links of a bend that tensions and moments turn over, twist or fold."""
    found = []
    moduli, d = scene.moduli, scene.chain.spacing
    thrust = float(np.abs(carried.tension).max()) * d
    if moduli.bend and thrust > LARGEST_THRUST * moduli.bend:
        text = (
            f"the tension |T| = {thrust / d:.3g} turns each link of a bend by up to"
            f" √(|T| d/μ⊥) = {math.sqrt(thrust / moduli.bend):.2g} rad, and links may snap over"
        )
        found.append(Weakness(Weak.BEND, text))
    elif moduli.twist and thrust > LARGEST_THRUST * moduli.twist:
        text = (
            f"the tension |T| = {thrust / d:.3g} twists the links of a bend with moments of up to"
            f" |T| d = {thrust:.3g}, more than μ∥ = {moduli.twist:.3g} holds"
        )
        found.append(Weakness(Weak.TWIST, text))
    moment = float(np.abs(carried.moment).max())
    springs = [modulus for modulus in (moduli.twist, moduli.bend) if modulus]
    if springs and moment > LARGEST_MOMENT * min(springs):
        text = (
            f"the moment {moment:.3g} about the chain is {moment / min(springs):.2g} times the"
            " smaller of μ∥ and μ⊥, and links of a bend may snap over"
        )
        found.append(Weakness(Weak.TWIST, text))
    if scene.chain.ends == "free":
        text = (
            "the ends are free, so bends grow until the chain folds up: spheres of distant parts"
            " may touch, and links may turn over"
        )
        found.append(Weakness(Weak.FOLD, text))
    return found


def _tenfold(rate: float) -> str:
    return f"tenfold every {math.log(10) / rate:.3g} time units"
