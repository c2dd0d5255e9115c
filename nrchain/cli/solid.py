"""``nrchain solid``: the solid that the chain of a scene makes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from nrchain.cli.arguments import Changes, Json, SceneName, load
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import solid_record
from nrchain.cli.tables import entries_table, moduli_table
from nrchain.cli.terminal import paragraph

if TYPE_CHECKING:
    from nrchain.theory.rod.coarse_graining import Moduli
    from nrchain.theory.rod.material import Material


@examples(
    "nrchain solid wave",
    "nrchain solid buckling --set slip.4a=500 --stress cut",
)
@one_line_errors()
def solid(
    scene: SceneName,
    changes: Changes = None,
    stress: Annotated[
        Literal["linear", "cut"],
        typer.Option(
            help="Stress of linear response, the paper's, or that of a cut through a uniformly"
            " strained chain."
        ),
    ] = "linear",
    as_json: Json = False,
) -> None:
    """Show the elastic moduli of the chain, their symmetry, and what kind of solid they make."""
    from nrchain.theory.rod.coarse_graining import moduli
    from nrchain.theory.rod.constants import SYMBOLS
    from nrchain.theory.rod.material import Material

    loaded, _ = load(scene, changes, lines=not as_json)
    found = moduli(loaded, stress)
    material = Material(found.total, found.drag, found.error)
    if as_json:
        show_json(solid_record(found, material.odd, material.sourced))
        return
    symmetry = found.symmetry
    show(paragraph(f"slip: {symmetry}"), soft_wrap=True)
    if symmetry.isotropic:
        show(moduli_table(found), whole=True)
        rest = len(SYMBOLS) - len(symmetry.symbols())
        if rest:
            show(f"the other {rest} of {len(SYMBOLS)} constants vanish by the symmetry of the slip")
    else:
        show(entries_table(found), whole=True)
    lines = [f"moduli: {material.symmetry}", *_lines(found, material)]
    show(*map(paragraph, lines), soft_wrap=True)
    if stress == "linear":
        show("--stress cut gives the stress at finite strain, which does the work in cycles")


def _lines(found: Moduli, material: Material) -> Iterator[str]:
    """What the moduli make of the chain, one sentence a line."""
    import numpy as np

    if material.odd:
        worst = float(np.abs(material.oddness).max())
        yield f"odd: the stress has no energy, C_ab − C_ba up to {worst:.3g}"
    else:
        yield "hyperelastic: C is symmetric, the stress has an energy"
    if material.sourced:
        for name, rows in (("force", slice(0, 3)), ("torque", slice(3, 6))):
            values = material.constants.presource[rows], material.constants.H[rows]
            bounds = found.error.presource[rows], found.error.H[rows]
            # what is within its error is rounding
            known = [np.where(np.abs(v) > b, v, 0.0) for v, b in zip(values, bounds, strict=True)]
            rest, strained = float(np.linalg.norm(known[0])), float(np.abs(known[1]).max())
            sizes = f"{rest:.3g} at rest, up to {strained:.3g} per strain"
            if rest or strained:
                yield f"source: net {name} per length {sizes}"
    else:
        yield "no source: the interactions conserve momentum and angular momentum"
    along, across, about, turning = found.drag.diagonal()[[0, 1, 3, 4]]
    yield (
        f"drag per length: {along:.4g} along and {across:.4g} across, of rotation {about:.4g} about"
        f" e₁ and {turning:.4g} about an axis across"
    )
    if found.logarithm.largest() > 0.0:
        yield "all pairs: some moduli depend on the wavelength, add the last column times ln(1/qd)"
