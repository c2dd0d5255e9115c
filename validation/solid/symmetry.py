"""Do the classes and signs of the paper follow from Rot and Ref, and do chains have them?"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

import nrchain
from nrchain import Scene, SlipMode, rod, slip_modes
from nrchain.theory.rod.constants import parts_of
from nrchain.theory.rod.helix import Helix
from nrchain.theory.rod.symmetry import ref, rot
from validation.report.recorder import Recorder
from validation.report.uniform_chains import FLUID, STRENGTHS, uniform_chain
from validation.solid.printed import CLASSES, SIGNS

STRAIN = np.array([0.05, -0.04, 0.06, 0.008, -0.011, 0.006])
"""A finite strain without symmetry, for d = 10."""

OWN_MODES = (
    SlipMode("5v", "vortices", 5, False, True, {("x", 5): (0, -3, 0, 7)}),
    SlipMode(
        "4p",
        "potential quadrupole",
        4,
        False,
        False,
        {("n", 4): ("-3/2", 0, "15/2"), ("e", 4): (0, -3)},
    ),
)
"""Two harmonic flows beyond the four of the paper."""


def compare(recorder: Recorder) -> None:
    """Record the classes, the signs and the symmetry of random mixes."""
    _classes(recorder)
    _signs(recorder)
    with _own_modes():
        _mixes(recorder, 10 if recorder.quick else 50)


def _classes(recorder: Recorder) -> None:
    found = rod.classes()
    for (polar, chiral), symbols in CLASSES.items():
        for symbol in symbols.split():
            recorder.check(
                f"class of {symbol}: 2 if polar, plus 1 if chiral",
                2 * polar + chiral,
                2 * found[symbol].polar + found[symbol].chiral,
                0.0,
                source="Table syms; the action of Rot and Ref on its block",
            )
    recorder.check(
        "constants in the two tables", len(rod.SYMBOLS), len(found), 0.0, source="Table syms"
    )


def _signs(recorder: Recorder) -> None:
    """Table signs, measured on finite strains, stresses and sources of a chain.

    2s and springs have all symmetries: a chain whose strain is transformed has the transformed
    stress. The springs have the isotropic measure; the paper's is isotropic to linear order only.
    """
    scene = uniform_chain({"2s": STRENGTHS["2s"]}, {"elasticity.measure": "isotropic"})
    for operation in (rot, ref):
        S = operation(0.4)
        after = strain_after(S)
        given, moved = (rod.uniform_response(scene, strain) for strain in (STRAIN, after))
        vectors = dict(
            zip(SIGNS, np.reshape([
                (STRAIN, after), (given.stress, moved.stress), (given.source, moved.source)
            ], (3, 2, 2, 3)).swapaxes(1, 2).reshape(6, 2, 3), strict=True)
        )  # fmt: skip
        for name, (before, later) in vectors.items():
            polarity_dependent, axial = SIGNS[name]
            changes = polarity_dependent if operation is rot else axial
            recorder.check(
                f"sign of {name} under {operation.__name__.title()}, at finite strain",
                -1.0 if changes else 1.0,
                (S @ before) @ later / (before @ before),
                1e-8,
                source="Table signs",
            )


def strain_after(operation: np.ndarray) -> np.ndarray:
    """The strain of the helix of ``STRAIN`` after S on its spheres, reversed if S reverses e₁.

    r′ and e_a′ by differences of fourth order: h = Rᵀr′ and Π^ = RᵀR′.
    """
    step, places = 0.05, np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    positions, rotations = Helix(STRAIN).at(operation[0, 0] * step * places)
    h = weights @ (positions @ operation.T)
    turn = np.einsum("n,nab->ab", weights, operation @ rotations @ operation.T)
    return np.array([h[0] - 1.0, h[1], h[2], turn[2, 1], turn[0, 2], turn[1, 0]])


@contextmanager
def _own_modes() -> Iterator[None]:
    for mode in OWN_MODES:
        nrchain.register(mode)
    try:
        yield
    finally:
        for mode in OWN_MODES:
            slip_modes.unregister(mode.label)


def random_mix(seed: int) -> Scene:
    """One to five modes of random strength; a third of the mixes has axes off e₁."""
    rng = np.random.default_rng(seed)
    labels = [*STRENGTHS, *(mode.label for mode in OWN_MODES)]
    slip = {}
    for label in rng.choice(labels, size=rng.integers(1, 6), replace=False):
        axis = rng.choice([-1.0, 1.0]) * np.eye(3)[0]
        if seed % 3 == 0:
            axis = np.eye(3)[rng.integers(3)] if seed % 2 else rng.normal(size=3)
        slip[f"slip.{label}"] = {"strength": 10.0 * rng.normal(), "axis": axis.tolist()}
    reach = {"slip.neighbours": int(rng.integers(1, 4))}
    return nrchain.load_scene(
        {"chain.particles": 8, "chain.spacing": 4.0, "run.end": 1.0} | slip | reach | FLUID
    )


def _mixes(recorder: Recorder, count: int) -> None:
    """The largest entry that symmetry forbids, over its error; and symmetries found again."""
    rows: dict[str, list[float]] = {}
    for stress in ("linear", "cut"):
        worst, lost = 0.0, 0
        for seed in range(count):
            scene = random_mix(seed)
            found = nrchain.moduli(scene, stress)
            worst = max(worst, forbidden(found))
            measured = rod.measured_symmetry(found.total, _bounds(found))
            names = ("isotropic", "apolar", "achiral", "centred")
            kept = [getattr(measured, n) >= getattr(found.symmetry, n) for n in names]
            lost += len(names) - sum(kept)
            if stress == "linear":
                key = f"{len(found.symmetry.group())} operations, {found.symmetry}"
                rows.setdefault(key, []).append(_allowed_share(found))
        recorder.bound(
            f"{count} random mixes, {stress} stress: largest forbidden entry, over its error",
            worst,
            most=1.0,
            source="Curie's principle: what symmetry forbids vanishes",
        )
        recorder.check(
            f"{count} random mixes, {stress} stress: symmetries of the slip not found again",
            0,
            lost,
            0.0,
            source="measured constants, within their errors",
        )
    recorder.table(
        "Symmetry of random mixes",
        ["Symmetry of the slip", "Mixes", "Entries that symmetry allows, of 84"],
        [(key, len(shares), float(np.mean(shares))) for key, shares in sorted(rows.items())],
        "Mixes of one to five of six modes, two of them not the paper's, with random strengths and "
        "one to three neighbours; every third mix has axes off e₁.",
    )


def _bounds(found: rod.Moduli) -> rod.Constants:
    """Errors, and the rounding of the transformations, of the constants of a mix."""
    size = 1e-12 * found.total.largest()
    return found.error.map(lambda part: part + size)


def forbidden(found: rod.Moduli) -> float:
    """The largest entry that the symmetry of the slip forbids, over its error."""
    worst = 0.0
    for value, mask, bound in zip(
        *map(parts_of, (found.total, found.symmetry.allowed(), _bounds(found))), strict=True
    ):
        worst = max(worst, float(np.max(np.abs(value)[~mask] / bound[~mask], initial=0.0)))
    return worst


def _allowed_share(found: rod.Moduli) -> float:
    return float(sum(np.sum(mask) for mask in parts_of(found.symmetry.allowed())))
