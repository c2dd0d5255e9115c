"""Will the chain of a scene hold? Its bonds, its links, its spheres, judged as they are.

A chain is judged by its own straight state and by how it leaves it:

- what the links carry (:mod:`nrchain.theory.line_loads`) against the moduli that hold them;
- whether the straight chain comes to rest, or its spheres touch and its links turn over
  (:mod:`nrchain.theory.straight_state`);
- what grows about the state it comes to (:mod:`nrchain.theory.straight_growth`): bonds that stretch
  or shear by themselves, or bends, which then carry what straight links were spared.

A bend lets the ends of a chain go: between clamps and on a ring its links then carry up to what
they would with free ends. Under a thrust T a bend turns each link by √(T d/μ⊥), an elastica's
curvature √(T/B) with B = μ⊥ d, times d (Landau and Lifshitz, Theory of Elasticity, sec. 19).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from nrchain.outcome import Cause
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene, load_scene, require_scene
from nrchain.theory.line_loads import LineLoads, line_loads
from nrchain.theory.straight_growth import StraightGrowth, straight_growth
from nrchain.theory.straight_state import StraightState, straight_state
from nrchain.wording import brief

LARGEST_STRAIN = 0.3
"""T/λ∥d or T/λ⊥d beyond which a scene is called out of the beam limit."""

LARGEST_TURN = 0.7
"""Turn of a link, in radians, beyond which it may snap over: springs weaken from π/4 = 0.785 on."""

LARGEST_THRUST = 1.0
"""T d/μ⊥, the square of the turn that a thrust gives the links of a bend, beyond which they do; and
T d/μ∥: the paper's springs of bend twist a link that is bent by β with a moment of order μ⊥β²."""

LARGEST_MOMENT = 0.3
"""Torque along the chain over μ∥ or μ⊥ beyond which the links of a bend may snap over."""

SHEARED = 0.5
"""A growing mode shears if links turn away from e₁ by more than this part of what e₁ turns."""

FOLDS = 1.0
"""Growth by e to this power over the run is told."""

LARGE = 0.1
"""Slopes to which a bend must grow for what its links then carry to be judged."""


class Weak(StrEnum):
    """What of a chain gives way."""

    TOUCH = "spheres touch"
    TURN = "links turn over"
    STRETCH = "stretch"
    SHEAR = "shear"
    TWIST = "twist"
    BEND = "bend"
    FOLD = "fold"


@dataclass(frozen=True)
class Load:
    """The largest tension of a link against one of the two moduli that hold the bonds, times d."""

    name: str
    symbol: str
    tension: float
    stiffness: float

    @property
    def strain(self) -> float:
        """|T|/λd: how far bonds give way, while that is little."""
        if not self.tension:
            return 0.0
        return abs(self.tension) / self.stiffness if self.stiffness else math.inf

    @property
    def holds(self) -> bool:
        """Whether that is little."""
        return self.strain <= LARGEST_STRAIN


@dataclass(frozen=True)
class Weakness:
    """One way in which a chain gives way, with its numbers in words."""

    kind: Weak
    text: str


@dataclass(frozen=True)
class Judgement:
    """What the straight chain of a scene carries, comes to and grows, and where it gives way.

    ``loads`` are those of the straight chain, ``carried`` those that bends may bring about: they
    differ where ends are held or a ring closes, and bends become large within the run (``bends``).
    ``growth`` is None of a chain that does not stay straight until the run is over.
    """

    loads: LineLoads
    carried: LineLoads
    state: StraightState
    growth: StraightGrowth | None
    bends: bool
    weaknesses: tuple[Weakness, ...]

    __repr__ = brief

    @property
    def sound(self) -> bool:
        """Whether nothing was found to give way."""
        return not self.weaknesses


def judge(scene: Scene) -> Judgement:
    """The loads, the straight state and the growth of a scene, and what of it gives way.

    Raises :class:`~nrchain.errors.SceneError` for a chain that does not stay straight, see
    :func:`~nrchain.theory.line_loads.line_loads`, and FloatingPointError beyond the range of
    floats.

    >>> from nrchain import load_scene
    >>> judge(load_scene("buckling")).sound
    True
    >>> long = load_scene("buckling", **{"chain.particles": 64, "chain.ends": "free"})
    >>> {weakness.kind.value for weakness in judge(long).weaknesses} >= {"stretch"}
    True
    """
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        state = straight_state(require_scene(scene))
        loads = line_loads(scene)
        growth = None if state.stopped else straight_growth(scene, state)
        bends = growth is not None and _becomes_large(scene, growth)
        carried = loads
        if bends and scene.chain.ends != "free":
            carried = line_loads(load_scene(scene, **{"chain.ends": "free"}))
    found = [*_of_the_line(scene, state), *_of_the_loads(scene, loads, carried)]
    if growth is not None:
        found += _of_the_growth(scene, growth, bends)
    if bends:
        found += _of_the_bends(scene, carried)
    return Judgement(loads, carried, state, growth, bends, tuple(found))


def bond_loads(scene: Scene, loads: LineLoads) -> tuple[Load, Load]:
    """The largest tension against stretch and against shear."""
    tension, d = float(loads.tension[np.argmax(np.abs(loads.tension))]), scene.chain.spacing
    moduli = scene.moduli
    return (
        Load("stretch", "λ∥d", tension, moduli.stretch * d),
        Load("shear", "λ⊥d", tension, moduli.shear * d),
    )


def _becomes_large(scene: Scene, growth: StraightGrowth) -> bool:
    """Whether bends grow by e and more, and from the slopes of the start to ``LARGE``."""
    folds = growth.across.rate * scene.run.end
    positions, frames = initial_poses(scene)
    offsets = np.linalg.norm(positions[:, 1:] - positions[:, 1:].mean(axis=0), axis=1)
    tilts = np.linalg.norm(frames[:, 0, 1:], axis=1)
    slope = max(float(offsets.max()) / scene.chain.spacing, float(tilts.max()))
    return folds >= FOLDS and slope > 0.0 and math.log(slope) + folds >= math.log(LARGE)


def _of_the_line(scene: Scene, state: StraightState) -> list[Weakness]:
    """What becomes of the chain while it is straight."""
    when, link = f"at about t = {state.time:.3g}", state.link
    if state.stopped is Cause.TOUCH:
        text = f"spheres {link} and {link + 1} of the straight chain come to touch {when}"
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


def _of_the_loads(scene: Scene, loads: LineLoads, carried: LineLoads) -> list[Weakness]:
    """The tension against the moduli of the bonds."""
    found = []
    bent = carried is not loads
    for load, straight in zip(bond_loads(scene, carried), bond_loads(scene, loads), strict=True):
        worst = max(load, straight, key=lambda one: one.strain)
        if worst.holds:
            continue
        what = "bonds give way" if load.name == "stretch" else "tangents turn away from e₁"
        part = f"is {worst.strain:.2g} of {load.symbol} = {load.stiffness:.3g}, and"
        if not load.stiffness:
            part = f"meets no {load.symbol}:"
        whose = " that bends bring about" if bent and worst is load else ""
        text = f"the tension {worst.tension:.3g} of a link{whose} {part} {what}"
        found.append(Weakness(Weak.STRETCH if load.name == "stretch" else Weak.SHEAR, text))
    return found


def _of_the_growth(scene: Scene, growth: StraightGrowth, bends: bool) -> list[Weakness]:
    """Modes that tear the chain apart, or turn its links over."""
    found = []
    if growth.along.rate * scene.run.end >= FOLDS:
        text = f"bonds stretch by themselves, {_tenfold(growth.along.rate)}"
        found.append(Weakness(Weak.STRETCH, text))
    across = growth.across
    if bends and across.shear > SHEARED:
        text = f"bonds shear by themselves, {_tenfold(across.rate)}"
        found.append(Weakness(Weak.SHEAR, text))
    if bends and across.phase > LARGEST_TURN:
        text = (
            f"links turn by {across.phase:.2g} rad each where the slopes of the bend that grows,"
            f" {_tenfold(across.rate)}, reach 1, and may snap over"
        )
        found.append(Weakness(Weak.BEND, text))
    return found


def _of_the_bends(scene: Scene, carried: LineLoads) -> list[Weakness]:
    """What tensions and moments do to the links of a bend."""
    found = []
    moduli, d = scene.moduli, scene.chain.spacing
    thrust = float(np.abs(carried.tension).max()) * d
    if moduli.bend and thrust > LARGEST_THRUST * moduli.bend:
        text = (
            f"a tension of {thrust / d:.3g} turns each link of a bend by up to"
            f" √(T d/μ⊥) = {math.sqrt(thrust / moduli.bend):.2g} rad, and links may snap over"
        )
        found.append(Weakness(Weak.BEND, text))
    elif moduli.twist and thrust > LARGEST_THRUST * moduli.twist:
        text = (
            f"a tension of {thrust / d:.3g} twists the links of a bend with moments of up to"
            f" T d = {thrust:.3g}, which μ∥ = {moduli.twist:.3g} does not hold"
        )
        found.append(Weakness(Weak.TWIST, text))
    moment = float(np.abs(carried.moment).max())
    springs = [modulus for modulus in (moduli.twist, moduli.bend) if modulus]
    if springs and moment > LARGEST_MOMENT * min(springs):
        text = (
            f"a moment of {moment:.3g} about the chain is {moment / min(springs):.2g} of what twist"
            " and bend hold, and links of a bend may snap over"
        )
        found.append(Weakness(Weak.TWIST, text))
    if scene.chain.ends == "free":
        text = (
            "bends grow until the chain folds up, for its ends are free: spheres of distant parts"
            " may touch, and links may turn over"
        )
        found.append(Weakness(Weak.FOLD, text))
    return found


def _tenfold(rate: float) -> str:
    return f"tenfold every {math.log(10) / rate:.3g} time units"
