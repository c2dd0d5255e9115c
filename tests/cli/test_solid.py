"""``nrchain solid``: the table of moduli, what they make of the chain, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from support.command_line import assert_refused, call

import nrchain


def rows(text):
    """Cells of the lines of a table by their first word."""
    found = [line.split() for line in text.splitlines() if line.strip()]
    return {cells[0]: cells for cells in found}


def test_solid_prints_the_moduli_of_the_scene():
    result = call("solid", "buckling")
    assert result.exit_code == 0, result.stderr
    table = rows(result.stdout)
    found = nrchain.moduli(nrchain.load_scene("buckling"))
    for symbol in found.symmetry.symbols():
        *_, slip, elasticity, _ = table[symbol]
        for shown, part in ((slip, found.active), (elasticity, found.elastic)):
            value = part.symbols()[symbol]
            assert float(shown) == pytest.approx(value, rel=1e-5, abs=1e-9)
    assert "slip: transversely isotropic, apolar, achiral" in result.stdout
    assert "the other 21 of 28 constants vanish by the symmetry of the slip" in result.stdout
    assert "hyperelastic" in result.stdout
    assert "source: net torque per length 0 at rest, up to 1.76 per strain" in result.stdout


def test_solid_says_what_is_odd_and_what_has_no_source():
    assert "odd: the stress has no energy" in call("solid", "helix-left").stdout
    assert "no source" in call("solid", "passive").stdout
    # in uniform strain the stress of 3t has an energy
    assert "odd" not in call("solid", "wave", "--stress", "cut").stdout.replace("_odd_", "")


def test_solid_marks_the_moduli_that_depend_on_the_wavelength():
    shown = call("solid", "helix-left", "--set", "slip.neighbours=all").stdout
    coefficient = nrchain.moduli(nrchain.load_scene("helix-left")).active.symbols()["C_perp_F_tau"]
    assert float(rows(shown)["C_perp_F_tau"][-1]) == pytest.approx(coefficient, rel=1e-5)
    assert "ln(1/qd)" in shown


def test_solid_prints_full_blocks_without_transverse_isotropy():
    axis = "slip.2s={strength=50.0, axis=[0.0, 1.0, 1.0]}"
    result = call("solid", "passive", "--set", axis)
    assert "not transversely isotropic" in result.stdout
    table = rows(result.stdout)
    scene = nrchain.load_scene("passive", **{"slip.2s": {"strength": 50.0, "axis": [0, 1, 1]}})
    found = nrchain.moduli(scene)
    shown = [float(cell.replace("·", "0")) for cell in table["F2"][2:]]
    np.testing.assert_allclose(shown, found.total.C[1], rtol=1e-5, atol=1e-8)


def test_a_scene_without_uniform_states_is_refused():
    assert_refused(call("solid", "buckling", "--set", "field.force=[0.0, 0.0, 1.0]"), "field")
    assert_refused(call("solid", "bucklin"), "did you mean 'buckling'")


def test_rounding_is_not_printed_as_a_source():
    shown = call("solid", "buckling").stdout
    assert "net torque per length 0 at rest, up to 1.76 per strain" in shown
    assert "net force" not in shown
    assert "e-1" not in "".join(line for line in shown.splitlines() if line.startswith("source"))
