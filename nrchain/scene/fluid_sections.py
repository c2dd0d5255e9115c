"""The sections ``[slip]`` and ``[friction]``: how spheres drive the fluid and feel each other.

Each class is a table of the TOML and each field a key of it, see :mod:`nrchain.inputs.rules`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, cast

from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip import E1, STRENGTH, Slip
from nrchain.hydrodynamics.slip_mode import is_label
from nrchain.inputs.about import About
from nrchain.inputs.names import SURE, nearest
from nrchain.inputs.rules import (
    Section,
    choice,
    flag,
    is_number,
    is_whole,
    optional,
    rule,
    section,
    unknown,
)
from nrchain.scene.effect_sections import with_registration_hint
from nrchain.scene.fixed_table import FixedTable

Kind = Literal["one-body", "pairwise"]
Backend = Literal["native", "pystokes"]

PYSTOKES_MODES = ("2s", "3a", "3t", "4a")
"""The modes that PyStokes has a routine for."""

NEIGHBOURS = rule(
    "a whole number of at least 1, or 'all'",
    lambda v: v == "all" or (is_whole(v) and 1 <= v < 2**63),
    near=lambda v: v.lower() if isinstance(v, str) else v,
)
"""The rule of a reach: neighbours on each side along the chain, or all pairs."""


LEAST_ACCURACY = 1e-11
"""Smallest error that sums by a tree can promise; rounding is near."""

ACCURACY = rule(
    f"a number from {LEAST_ACCURACY:g} to 0.1, or 'direct'",
    lambda v: v == "direct" or (is_number(v) and LEAST_ACCURACY <= v <= 0.1),
    lambda v: v if isinstance(v, str) else float(v),
    near=lambda v: v.lower() if isinstance(v, str) else v,
)
"""The rule of an accuracy of sums over all pairs: a relative error, or direct sums."""


class SlipModes(FixedTable[Slip]):
    """The slip of each mode, by the label of the mode."""

    __slots__ = ()


def _read_modes(key: str, value: Any) -> SlipModes:
    """The rule of ``modes``: a table of mode labels, each with what :func:`_read_slip` takes."""
    if not isinstance(value, Mapping):
        raise SceneError(key, value, "must be a table of mode labels and strengths or Slips")
    slips = {label: _read_slip(label, given) for label, given in value.items()}
    return SlipModes({label: slip for label, slip in slips.items() if slip is not None})


def _read_slip(label: str, given: Any) -> Slip | None:
    """The slip of one mode, from a Slip, a table or strengths. None removes the mode."""
    key = SlipSpec.key(label)
    labels = [mode.label for mode in slip_modes.modes()]
    if label not in labels:
        error = unknown(key, given, SlipSpec.names())
        if is_label(label) and not nearest(label, SlipSpec.names(), SURE):
            raise with_registration_hint(error, "a mode", "nrchain.register")
        raise error
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
    """The active modes, how many neighbours feel their flow, and which code sums it.

    ``neighbours`` counts neighbours on each side along the chain. ``finite_size`` keeps the factors
    (1 + a²∇²/6)(1 + a²∇²/(4l + 2)), which change the velocity of 2s only; without them the pair
    laws are the paper's, to leading order in a/r.

    ``accuracy`` is the largest error of a sum over all pairs, of slip or friction, relative to the
    largest twist; by default ``run.rtol``. Long open chains are summed by a tree to this accuracy.
    ``"direct"`` sums every pair.
    """

    path: ClassVar[str] = "slip"
    set_by_auto: ClassVar[tuple[str, ...]] = ("neighbours", "finite_size")
    modes: Annotated[Mapping[str, Slip], _read_modes] = SlipModes()
    neighbours: Annotated[int | Literal["all"], NEIGHBOURS] = 1
    finite_size: Annotated[bool, flag()] = False
    accuracy: Annotated[float | Literal["direct"] | None, optional(ACCURACY)] = None
    backend: Annotated[Backend, choice(Backend)] = "native"
    about: ClassVar[Mapping[str, About]] = {
        "neighbours": About(
            "k",
            "",
            'whole number ≥ 1, "all"',
            "how many neighbours on each side feel the slip flow of a sphere",
        ),
        "finite_size": About("", "", "true, false", "add the (a/r)² correction of the 2s velocity"),
        "accuracy": About(
            "ε",
            "",
            '1e-11 to 0.1, "direct"',
            "largest error of sums over all pairs, relative to the largest value; "
            "run.rtol if not set",
        ),
        "backend": About(
            "",
            "",
            '"native", "pystokes"',
            'what computes the pair laws; "pystokes" needs an open chain',
        ),
    }

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
        """The section of a raw table. Every key that is not an option is a mode."""
        if not isinstance(table, Mapping):
            raise SceneError(cls.path, table, "must be a table")
        options = cls.spellings()
        given = {k: v for k, v in table.items() if k in options and v is not None}
        return cls(modes={k: v for k, v in table.items() if k not in options}, **given)

    def to_mapping(self) -> dict[str, Any]:
        """The raw table of the section: the options, then one key for each mode."""
        given = {name: getattr(self, name) for name in self.spellings()}
        table = {name: value for name, value in given.items() if value is not None}
        for label, slip in self.modes.items():
            table[label] = slip.strength if slip.axis == E1 else slip.to_mapping()
        return table


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionSpec(Section):
    """How forces become velocities: sphere by sphere, or also through the fluid between them.

    ``one-body`` gives each sphere the Stokes drag of a sphere in unbounded fluid. ``pairwise``
    takes the Rotne–Prager–Yamakawa mobilities of all pairs within ``neighbours`` places along the
    chain. ``friction = "pairwise"`` is short for that kind with all pairs.
    """

    path: ClassVar[str] = "friction"
    set_by_auto: ClassVar[tuple[str, ...]] = ("kind", "neighbours")
    kind: Annotated[Kind, choice(Kind)] = "one-body"
    neighbours: Annotated[int | Literal["all"], NEIGHBOURS] = "all"
    backend: Annotated[Backend, choice(Backend)] = "native"
    about: ClassVar[Mapping[str, About]] = {
        "kind": About(
            "",
            "",
            '"one-body", "pairwise"',
            "each sphere moves by its own drag, or also through the fluid between "
            "spheres (Rotne–Prager–Yamakawa)",
        ),
        "neighbours": About("k", "", 'whole number ≥ 1, "all"', "reach of pairwise friction"),
        "backend": About(
            "",
            "",
            '"native", "pystokes"',
            'what computes the mobilities; "pystokes" needs an open chain',
        ),
    }


def read_friction(key: str, value: Any) -> FrictionSpec:
    """The rule of ``friction``: a section, or its kind alone."""
    if isinstance(value, str):
        return FrictionSpec(kind=cast(Kind, value))
    return section(FrictionSpec)(key, value)
