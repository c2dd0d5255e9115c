"""The sections of a scene: each class is a table of the TOML, each field a key of it.

The rule in an annotation says what its key allows; ``check`` refuses what only several keys of
the section show to be wrong. Values are checked on construction and are plain, hashable Python.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, cast

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip import E1, STRENGTH, Slip
from nrchain.hydrodynamics.slip_mode import is_label
from nrchain.inputs.arrays import GivenArray, array_of
from nrchain.inputs.names import SURE, nearest, unknown_name
from nrchain.inputs.rules import (
    Section,
    choice,
    flag,
    is_whole,
    number,
    optional,
    rule,
    section,
    unknown,
    whole,
)
from nrchain.scene.extensions import extensions

Ends = Literal["free", "clamped", "periodic"]
Kind = Literal["one-body", "pairwise"]
Measure = Literal["paper", "isotropic"]
Backend = Literal["native", "pystokes"]
Integrator = Literal["cvode", "radau", "scipy-bdf"]
_Entry = TypeVar("_Entry")
Shape = Literal["straight", "sine", "helix-left", "helix-right", "random", "given"]

POSES = ("positions", "frames")
"""The keys of a start that are arrays."""

PYSTOKES_MODES = ("2s", "3a", "3t", "4a")
"""The modes that PyStokes has a routine for."""

_ROUNDED = "coordinates are rounded to 1e-16 of themselves, and below no step would be accepted"
NEIGHBOURS = rule(
    "a whole number of at least 1, or 'all'",
    lambda v: v == "all" or (is_whole(v) and 1 <= v < 2**63),
    near=lambda v: v.lower() if isinstance(v, str) else v,
)


class _FixedTable(Mapping[str, _Entry]):
    """Entries by name: immutable, compared and hashed by value."""

    __slots__ = ("_entries",)

    def __init__(self, entries: Mapping[str, _Entry] | None = None) -> None:
        self._entries = dict(entries or {})

    def __getitem__(self, name: str) -> _Entry:
        if name not in self._entries:
            raise unknown_name(name, self._entries)
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __hash__(self) -> int:
        return hash(frozenset(self._entries.items()))

    def __repr__(self) -> str:
        return repr(self._entries)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._entries,)


class SlipModes(_FixedTable[Slip]):
    """The slip of each mode by its label."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainSpec(Section):
    """N spheres of radius a, a distance d apart at rest, in a fluid of viscosity η."""

    path: ClassVar[str] = "chain"
    particles: Annotated[int, whole(least=2)]
    spacing: Annotated[float, number(above=0)] = 10.0
    radius: Annotated[float, number(above=0)] = 1.0
    viscosity: Annotated[float, number(above=0)] = 1.0
    ends: Annotated[Ends, choice(Ends)] = "free"

    def check(self) -> None:
        if not self.spacing > 2 * self.radius:
            allowed = f"must exceed two radii, {2 * self.radius!r}, or the spheres overlap"
            raise SceneError("chain.spacing", self.spacing, allowed)


@dataclass(frozen=True, slots=True, kw_only=True)
class ElasticitySpec(Section):
    """Either R of λ∥ = λ⊥ = R μ⊥ γ_R / (γ_T d⁴ (N−1)⁴), or λ∥ (stretch) and λ⊥ (shear).

    R is 1e7 when neither is given. μ⊥ (bend) is γ_T d² and μ∥ (twist) is μ⊥ unless given. A
    modulus of 0 takes its term out of the potential. Source: paper, Appendix D. ``measure`` is
    that of twist and bend: the paper's, or its transversely isotropic form, which spares a chain
    that spins the wobble of the former (see :mod:`nrchain.potential.chain`).
    """

    path: ClassVar[str] = "elasticity"
    ratio: Annotated[float | None, optional(number(above=0))] = None
    stretch: Annotated[float | None, optional(number(least=0))] = None
    shear: Annotated[float | None, optional(number(least=0))] = None
    twist: Annotated[float | None, optional(number(least=0))] = None
    bend: Annotated[float | None, optional(number(least=0))] = None
    measure: Annotated[Measure, choice(Measure)] = "paper"

    def check(self) -> None:
        given = [name for name in ("stretch", "shear") if getattr(self, name) is not None]
        if self.ratio is not None and given:
            key = f"elasticity.{given[0]}"
            allowed = (
                f"elasticity.ratio = {self.ratio!r} gives the stiffness too; keep one of these two"
                " ways of giving it, and take the other out"
            )
            raise SceneError(key, getattr(self, given[0]), allowed)
        if len(given) == 1:
            missing = "shear" if given == ["stretch"] else "stretch"
            allowed = f"must be given along with elasticity.{given[0]}, or both left to the ratio"
            raise SceneError(f"elasticity.{missing}", NOT_GIVEN, allowed)


def _read_modes(key: str, value: Any) -> SlipModes:
    """The rule of ``modes``: a table of known labels, each with what :func:`_read_slip` takes."""
    if not isinstance(value, Mapping):
        raise SceneError(key, value, "must be a table of mode labels and strengths or Slips")
    slips = {label: _read_slip(label, given) for label, given in value.items()}
    return SlipModes({label: slip for label, slip in slips.items() if slip is not None})


def _read_slip(label: str, given: Any) -> Slip | None:
    """The slip of a mode given as a Slip, a table or strengths; None takes the mode out."""
    key = SlipSpec.key(label)
    labels = [mode.label for mode in slip_modes.modes()]
    if label not in labels:
        refusal = unknown(key, given, SlipSpec.names())
        if is_label(label) and not nearest(label, SlipSpec.names(), SURE):
            raise register_first(refusal, "A mode", "nrchain.register")
        raise refusal
    if given is None or isinstance(given, Slip):
        return given
    if not isinstance(given, Mapping):
        return Slip(STRENGTH(key, given))
    try:
        return Slip.from_mapping(given)
    except SceneError as error:
        raise SceneError(f"{key}.{error.key}", error.value, error.allowed) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipSpec(Section):
    """The modes of slip, how many neighbours along the chain feel them, and who sums them.

    ``finite_size`` keeps the factors (1 + a²∇²/6)(1 + a²∇²/(4l + 2)), which change the velocity
    of 2s only; without them the laws are the paper's leading order in a/r.
    """

    path: ClassVar[str] = "slip"
    modes: Annotated[Mapping[str, Slip], _read_modes] = SlipModes()
    neighbours: Annotated[int | Literal["all"], NEIGHBOURS] = 1
    finite_size: Annotated[bool, flag()] = False
    backend: Annotated[Backend, choice(Backend)] = "native"

    def check(self) -> None:
        for label in self.modes:
            if self.backend == "pystokes" and label not in PYSTOKES_MODES:
                allowed = f"has no routine for mode {label}, only for {', '.join(PYSTOKES_MODES)}"
                raise SceneError("slip.backend", self.backend, allowed)

    @classmethod
    def spellings(cls) -> tuple[str, ...]:
        """The options: the keys of the section that are not modes."""
        return tuple(name for name in cls.rules() if name != "modes")

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """The options and the modes."""
        return (*cls.spellings(), *(mode.label for mode in slip_modes.modes()))

    @classmethod
    def from_mapping(cls, table: Mapping[str, Any]) -> Self:
        """The section of a raw table, in which every key that is not an option is a mode."""
        if not isinstance(table, Mapping):
            raise SceneError(cls.path, table, "must be a table")
        options = cls.spellings()
        given = {k: v for k, v in table.items() if k in options and v is not None}
        return cls(modes={k: v for k, v in table.items() if k not in options}, **given)

    def to_mapping(self) -> dict[str, Any]:
        """The raw table of the section: the options, then one key a mode."""
        table = {name: getattr(self, name) for name in self.spellings()}
        for label, slip in self.modes.items():
            table[label] = slip.strength if slip.axis == E1 else slip.to_mapping()
        return table


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionSpec(Section):
    """How forces become velocities: each sphere by itself, or through the fluid between them.

    ``pairwise`` takes the Rotne–Prager–Yamakawa mobilities of all pairs within ``neighbours``
    places. ``friction = "pairwise"`` is short for that kind with all pairs.
    """

    path: ClassVar[str] = "friction"
    kind: Annotated[Kind, choice(Kind)] = "one-body"
    neighbours: Annotated[int | Literal["all"], NEIGHBOURS] = "all"
    backend: Annotated[Backend, choice(Backend)] = "native"


def register_first(refusal: SceneError, what: str, register: str) -> SceneError:
    """The refusal of a name that may stand for something of one's own, which is not known yet."""
    end = "" if refusal.allowed.endswith("?") else "."
    allowed = (
        f"{refusal.allowed}{end} {what} of one's own must be registered again, with {register}, in"
        " every process before a scene or a trajectory that names it is opened"
    )
    return SceneError(refusal.key, refusal.value, allowed)


def read_friction(key: str, value: Any) -> FrictionSpec:
    """The rule of ``friction``: a section, or its kind alone."""
    if isinstance(value, str):
        return FrictionSpec(kind=cast(Kind, value))
    return section(FrictionSpec)(key, value)


class EffectSections(_FixedTable[Section]):
    """The sections that further effects add to a scene, by name: those that are not all default."""

    __slots__ = ()

    def __init__(self, sections: Mapping[str, Section] | None = None) -> None:
        given = sections or {}
        super().__init__({name: s for name, s in given.items() if s != type(s)()})


def read_effects(key: str, value: Any) -> EffectSections:
    """The rule of ``further``: a table of sections by name, each that of an effect known."""
    if not isinstance(value, Mapping):
        raise SceneError(key, value, "must be a table of sections")
    sections = {}
    for name, given in value.items():
        kind = extensions().section_kind(name)
        if kind is None:
            raise unknown(name, given, extensions().section_kinds())
        sections[name] = section(kind)(name, given)
    return EffectSections(sections)


@dataclass(frozen=True, slots=True, kw_only=True)
class StartSpec(Section):
    """The shape at t = 0: amplitude a length, wavenumber in units of π/L (periodic: 2π/L).

    A negative amplitude of a sine or a helix shifts its phase by half a turn; that of a random
    shape is a standard deviation, and not negative. A shape that is given is ``positions (N, 3)``
    and ``frames (N, 3, 3)``, rows e_1, e_2, e_3; those left out are of the straight chain. A run
    that is handed poses records them so, and is made again from its scene alone.
    """

    path: ClassVar[str] = "start"
    shape: Annotated[Shape, choice(Shape)] = "straight"
    amplitude: Annotated[float, number()] = 0.1
    wavenumber: Annotated[float, number(above=0)] = 1.0
    seed: Annotated[int, whole(least=0)] = 0
    positions: Annotated[GivenArray | None, optional(array_of(3))] = None
    frames: Annotated[GivenArray | None, optional(array_of(3, 3))] = None

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
            allowed = "is for start.shape = 'given'; take it out, or set that"
            raise SceneError(key, getattr(self, given[0]), allowed)
        if self.shape == "random" and self.amplitude < 0:
            allowed = "must be at least 0 for a random shape, whose standard deviation it is"
            raise SceneError("start.amplitude", self.amplitude, allowed)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSpec(Section):
    """From t = 0 to ``end``, with snapshots at equal times, both ends among them.

    ``rtol`` and ``atol`` bound the error of one step: √mean((error/(``atol`` + ``rtol`` |y|))²) < 1
    over the coordinates y of all spheres, how far each has come (``atol``: in radii) and turned (in
    radians) from a base that drifts and spins as the chain does. With the backward differences of
    ``cvode`` the error at the end is some tens to some hundreds of times as large where the chain
    relaxes, buckles or coils; a motion that forgets nothing, as of free spheres in a flow, adds
    the errors of its steps up over all the run.
    Below 1e-14 an ``atol`` asks for less than coordinates of the size of a radius can hold: the
    implicit equations of a step are then never solved, and steps shrink without end.
    ``max_steps`` and ``max_seconds`` are what one run, or one resumption of it, may spend.
    """

    path: ClassVar[str] = "run"
    end: Annotated[float, number(above=0)]
    snapshots: Annotated[int, whole(least=2)] = 101
    rtol: Annotated[float, number(least=1e-14, most=1e-1)] = 1e-7
    atol: Annotated[float, number(least=1e-14, most=1e-1, reason=_ROUNDED)] = 1e-7
    integrator: Annotated[Integrator, choice(Integrator)] = "cvode"
    max_steps: Annotated[int | None, optional(whole(least=1))] = None
    max_seconds: Annotated[float | None, optional(number(above=0))] = None
