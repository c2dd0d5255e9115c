"""The sections ``[chain]``, ``[elasticity]``, ``[start]`` and ``[run]``.

Each class is a table of the TOML and each field a key of it. The rule in an annotation says what
its key allows, see :mod:`nrchain.inputs.rules`; ``check`` holds the rules for keys of one section
together. A section checks its values when it is made, and keeps them as plain, hashable Python.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.inputs.about import About
from nrchain.inputs.arrays import GivenArray, array_of
from nrchain.inputs.rules import Section, choice, flag, number, optional, whole

Ends = Literal["free", "clamped", "periodic"]
Measure = Literal["paper", "isotropic"]
Integrator = Literal["auto", "cvode", "radau", "scipy-bdf"]
Until = Literal["end", "settled"]
Shape = Literal["straight", "sine", "helix-left", "helix-right", "random", "given"]

POSES = ("positions", "frames")
"""The keys of ``[start]`` that are arrays."""

LEAST_TOLERANCE = 1e-14
"""Of ``run.rtol`` and ``run.atol``."""

TIGHTER = 10.0
"""What ``run.verify`` divides both tolerances by."""

_ROUNDED = (
    "coordinates are rounded to 1e-16 of their size, and the integrator accepts no step that must"
    " be more accurate"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainSpec(Section):
    """N spheres of radius a, a distance d apart at rest, in a fluid of viscosity η."""

    path: ClassVar[str] = "chain"
    particles: Annotated[int, whole(least=2)]
    spacing: Annotated[float, number(above=0)] = 10.0
    radius: Annotated[float, number(above=0)] = 1.0
    viscosity: Annotated[float, number(above=0)] = 1.0
    ends: Annotated[Ends, choice(Ends)] = "free"
    about: ClassVar[Mapping[str, About]] = {
        "particles": About("N", "", "whole number ≥ 2", "number of spheres"),
        "spacing": About("d", "L", "> 2a", "rest distance of neighbours"),
        "radius": About("a", "L", "> 0", "radius of a sphere"),
        "viscosity": About("η", "F T/L²", "> 0", "viscosity of the fluid"),
        "ends": About(
            "",
            "",
            '"free", "clamped", "periodic"',
            '"clamped" holds both end spheres in place; "periodic" repeats the chain along x',
        ),
    }

    def check(self) -> None:
        if not self.spacing > 2 * self.radius:
            allowed = f"must exceed two radii, {2 * self.radius!r}, or the spheres overlap"
            raise SceneError("chain.spacing", self.spacing, allowed)


@dataclass(frozen=True, slots=True, kw_only=True)
class ElasticitySpec(Section):
    """Either R of λ∥ = λ⊥ = R μ⊥ γ_R / (γ_T d⁴ (N−1)⁴), or λ∥ (stretch) and λ⊥ (shear).

    R (``ratio``) is 1e7 when neither is given. μ⊥ (bend) is γ_T d² and μ∥ (twist) is μ⊥ unless
    given. A modulus of 0 removes its term from the potential. Source: paper, Appendix D.

    ``measure`` is how twist and bend are measured: as in the paper, or transversely isotropic. A
    chain that spins about its axis wobbles under the first and not under the second (see
    :mod:`nrchain.potential.chain`).
    """

    path: ClassVar[str] = "elasticity"
    ratio: Annotated[float | None, optional(number(above=0))] = None
    stretch: Annotated[float | None, optional(number(least=0))] = None
    shear: Annotated[float | None, optional(number(least=0))] = None
    twist: Annotated[float | None, optional(number(least=0))] = None
    bend: Annotated[float | None, optional(number(least=0))] = None
    measure: Annotated[Measure, choice(Measure)] = "paper"
    about: ClassVar[Mapping[str, About]] = {
        "ratio": About(
            "R",
            "",
            "> 0",
            "λ∥ = λ⊥ = R μ⊥ γ_R / (γ_T d⁴ (N−1)⁴), the paper's rule. R = 1e7 if "
            "neither ratio nor the stiffnesses are set",
        ),
        "stretch": About(
            "λ∥", "F/L", "≥ 0, together with shear", "stiffness of the bonds along e₁"
        ),
        "shear": About(
            "λ⊥", "F/L", "≥ 0, together with stretch", "stiffness of the bonds across e₁"
        ),
        "twist": About("μ∥", "F L", "≥ 0", "stiffness of twist; equal to μ⊥ if not set"),
        "bend": About(
            "μ⊥", "F L", "≥ 0", "stiffness of bend; γ_T d² in the units of the scene if not set"
        ),
        "measure": About("", "", '"paper", "isotropic"', "form of the twist and bend energies"),
    }

    def check(self) -> None:
        given = [name for name in ("stretch", "shear") if getattr(self, name) is not None]
        if self.ratio is not None and given:
            allowed = (
                "gives the stiffness in two ways, together with elasticity.ratio ="
                f" {self.ratio:g}; remove one of the two"
            )
            raise SceneError(self.key(given[0]), getattr(self, given[0]), allowed)
        if len(given) == 1:
            missing = "shear" if given == ["stretch"] else "stretch"
            allowed = (
                f"must be given along with elasticity.{given[0]}; or leave out both, and"
                " elasticity.ratio sets them"
            )
            raise SceneError(self.key(missing), NOT_GIVEN, allowed)


@dataclass(frozen=True, slots=True, kw_only=True)
class StartSpec(Section):
    """The shape at t = 0: ``amplitude`` a length, ``wavenumber`` in π/L (periodic: 2π/L).

    A negative amplitude shifts the phase of a sine or a helix by π. The amplitude of a random shape
    is the standard deviation of the offsets, and not negative. The shape ``given`` takes
    ``positions (N, 3)`` and ``frames (N, 3, 3)``, whose rows are e_1, e_2, e_3; the one that is
    left out is that of the straight chain. A run that is handed poses records them in this way, so
    that its scene alone repeats it.
    """

    path: ClassVar[str] = "start"
    shape: Annotated[Shape, choice(Shape)] = "straight"
    amplitude: Annotated[float, number()] = 0.1
    wavenumber: Annotated[float, number(above=0)] = 1.0
    seed: Annotated[int, whole(least=0)] = 0
    positions: Annotated[GivenArray | None, optional(array_of(3))] = None
    frames: Annotated[GivenArray | None, optional(array_of(3, 3))] = None
    about: ClassVar[Mapping[str, About]] = {
        "shape": About(
            "",
            "",
            '"straight", "sine", "helix-left", "helix-right", "random", "given"',
            "shape of the centre line",
        ),
        "amplitude": About(
            "A",
            "L",
            'a number; ≥ 0 for "random"',
            "height of the shape; standard deviation of random offsets",
        ),
        "wavenumber": About(
            "",
            "π/L",
            "> 0, at least two spheres a wave; whole on a periodic chain",
            "in units of π/L for open chains and 2π/L for periodic ones, L the length of the chain",
        ),
        "seed": About("", "", "whole number ≥ 0", "of random offsets"),
        "positions": About("r", "L", '(N, 3), with shape "given"', "positions of the spheres"),
        "frames": About(
            "e_k", "", '(N, 3, 3), with shape "given"', "rows e₁, e₂, e₃ of each sphere"
        ),
    }

    def check(self) -> None:
        given = [name for name in POSES if getattr(self, name) is not None]
        if self.shape == "given" and not given:
            allowed = (
                "must come with start.positions (N, 3), start.frames (N, 3, 3) or both; a"
                " trajectory file keeps them in parameters/start, and"
                " nrchain.Trajectory.open(path).scene has them"
            )
            raise SceneError("start.shape", self.shape, allowed)
        if self.shape != "given" and given:
            key = self.key(given[0])
            allowed = "is for start.shape = 'given'; remove it, or set that shape"
            raise SceneError(key, getattr(self, given[0]), allowed)
        if self.shape == "random" and self.amplitude < 0:
            allowed = "must be at least 0: it is the standard deviation of a random shape"
            raise SceneError("start.amplitude", self.amplitude, allowed)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSpec(Section):
    """From t = 0 to ``end``, with ``snapshots`` at equal intervals, both ends included.

    ``rtol`` and ``atol`` set the error of the run: equal, its largest error, in radii and radians,
    is at most ten times as large on nine scenes of ten, with the integrator that ``"auto"`` takes.
    For that they bound the error of one step:
    √mean((error/(``atol`` + ``rtol`` |y|))²) < c over the coordinates y of all spheres, with c = 1
    for ``radau``, 1/20 for ``cvode`` and 1/30 for ``scipy-bdf``. A coordinate is how far a sphere
    has moved (``atol`` in radii) or turned (in radians) from a base that drifts and spins with the
    chain. Where a motion keeps its errors, as that of free spheres in a flow does, the errors of
    all steps add up. ``atol`` must be at least 1e-14: coordinates of the size of a radius hold no
    more digits, and steps would shrink without end.

    ``integrator = "auto"`` is ``radau`` where interactions reach a few neighbours along the chain,
    and ``cvode`` with interactions of all pairs.

    ``verify`` estimates the error at each snapshot, from a second run with both tolerances divided
    by :data:`TIGHTER`.

    ``until = "settled"`` ends the run at the first snapshot at which the chain has settled in a
    state or a cycle (:mod:`nrchain.watch.settled`); ``end`` is then the latest end.

    ``max_steps`` and ``max_seconds`` limit one run, or one resumption of it.
    """

    path: ClassVar[str] = "run"
    end: Annotated[float, number(above=0)]
    snapshots: Annotated[int, whole(least=2)] = 101
    rtol: Annotated[float, number(least=LEAST_TOLERANCE, most=1e-1)] = 1e-6
    atol: Annotated[float, number(least=LEAST_TOLERANCE, most=1e-1, reason=_ROUNDED)] = 1e-6
    integrator: Annotated[Integrator, choice(Integrator)] = "auto"
    max_steps: Annotated[int | None, optional(whole(least=1))] = None
    max_seconds: Annotated[float | None, optional(number(above=0))] = None
    verify: Annotated[bool, flag()] = False
    until: Annotated[Until, choice(Until)] = "end"
    about: ClassVar[Mapping[str, About]] = {
        "end": About("", "T", "> 0", "the run goes from t = 0 to here"),
        "snapshots": About(
            "", "", "whole number ≥ 2", "recorded states at equal times, start and end included"
        ),
        "rtol": About("", "", "1e-14 to 0.1", "relative tolerance"),
        "atol": About("", "a, rad", "1e-14 to 0.1", "absolute tolerance, in radii and radians"),
        "integrator": About(
            "", "", '"auto", "cvode", "radau", "scipy-bdf"', "scheme of the time steps"
        ),
        "max_steps": About("", "", "whole number ≥ 1", "budget of one run or one resumption"),
        "max_seconds": About("", "s", "> 0", "budget of wall time, likewise"),
        "verify": About("", "", "true, false", "estimate the error at each snapshot"),
        "until": About(
            "",
            "",
            '"end", "settled"',
            '"settled": end at the snapshot at which the chain has settled, end at the latest',
        ),
    }

    def check(self) -> None:
        for name in ("rtol", "atol") if self.verify else ():
            tolerance, least = getattr(self, name), TIGHTER * LEAST_TOLERANCE
            if tolerance < least:
                allowed = (
                    f"must be at least {least:g} with run.verify, which runs the scene again with "
                    f"run.{name} / {TIGHTER:g}"
                )
                raise SceneError(self.key(name), tolerance, allowed)
