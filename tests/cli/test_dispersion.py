"""``nrchain dispersion``: its table, its picture, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from support.command_line import assert_refused, call

import nrchain
from nrchain.theory.lattice import Branch

FEW = ("--set", "chain.particles=6")
"""So few spheres that the modes of the chain are left out of the picture."""


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def cells(text, branch):
    """The cells of the row of a branch in the table of growth."""
    row, _ = (line for line in text.splitlines() if line.strip().startswith(branch))
    return row.strip().removeprefix(branch).split()


def test_the_table_has_every_theory_at_the_fastest_wavenumber(tmp_path):
    result = call("dispersion", "buckling", "-o", "d.svg")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "d.svg"
    assert (tmp_path / "d.svg").read_text().startswith("<?xml")
    scene = nrchain.load_scene("buckling")
    phase, lattice, rod, beam, *_ = map(float, cells(result.stdout, "bend +"))
    q = phase / scene.chain.spacing
    growth = nrchain.lattice_rates(scene, [0.97 * q, q, 1.03 * q])[:, Branch.BEND_PLUS].real
    assert growth.argmax() == 1
    assert lattice == pytest.approx(growth[1], rel=1e-3)
    material = nrchain.Material.of(scene)
    for shown, limit in ((rod, False), (beam, True)):
        expected = nrchain.rod.rod_waves(material, [q], beam=limit).growth[0, 0]
        assert shown == pytest.approx(expected, rel=1e-3)


def test_the_picture_lies_beside_the_runs(tmp_path):
    picture = tmp_path / "runs" / "wave-dispersion.png"
    picture.parent.mkdir()
    picture.write_bytes(b"of a command before")
    result = call("dispersion", "wave", *FEW)
    assert result.exit_code == 0, result.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_named_picture_is_replaced_only_on_request(tmp_path):
    mine = tmp_path / "mine.png"
    mine.write_bytes(b"dear")
    assert_refused(call("dispersion", "wave", "-o", mine), mine, "--overwrite")
    assert mine.read_bytes() == b"dear"
    assert call("dispersion", "wave", *FEW, "-o", mine, "--overwrite").exit_code == 0
    assert mine.read_bytes() != b"dear"
    assert_refused(call("dispersion", "wave", "-o", "a.doc"), ".png, .pdf, .svg")


@pytest.mark.parametrize(
    ("change", "key"),
    [("slip.neighbours=all", "slip.neighbours"), ("friction.kind=pairwise", "friction.neighbours")],
)
def test_the_lattice_alone_is_drawn_where_moduli_diverge(change, key):
    result = call("dispersion", "buckling", *FEW, "--set", change)
    assert result.exit_code == 0
    assert f"note: {key} = 'all' has no rod" in result.stderr
    assert "the lattice is drawn alone" in result.stderr
    assert "beam limit" not in result.stdout
    assert len(cells(result.stdout, "bend +")) == 2


def test_scenes_without_uniform_states_are_refused():
    field = call("dispersion", "buckling", "--set", "field.force=[0.0, 0.0, 1.0]")
    assert_refused(field, "field", "varies along a strained chain")
    strengths = str([1.0] * 19 + [2.0])
    assert_refused(call("dispersion", "buckling", "--set", f"slip.2s={strengths}"), "slip.2s")


def test_anisotropic_chains_that_spin_are_shown_along_their_axes():
    axis = "slip.3t={strength=1000.0, axis=[1.0, 0.5, 0.0]}"
    result = call("dispersion", "spiral-left", *FEW, "--set", axis)
    assert result.exit_code == 0, result.stderr
    assert "axes that spin with the chain" in result.stdout


def test_branches_of_the_lattice_are_continuous():
    """Near qd = π the columns of lattice_rates exchange for 3t; those drawn do not jump."""
    found = nrchain.dispersion(nrchain.load_scene("wave"))
    steps = np.abs(np.diff(found.lattice, axis=0)).max(axis=0)
    assert np.all(steps < 0.1 * np.abs(found.lattice).max(axis=0))


def test_modes_of_the_chain_are_drawn_as_points(tmp_path):
    """A clamped chain of 20 has 18 free spheres, and a short one is said to have no points."""
    points = []
    for name, change in (("long", "chain.particles=20"), ("short", "chain.particles=10")):
        result = call("dispersion", "buckling", "-o", f"{name}.svg", "--set", change)
        assert result.exit_code == 0, result.stderr
        points.append((tmp_path / f"{name}.svg").read_text().count("<use "))
    assert "the modes of the chain are not drawn: chain.particles = 10" in result.stderr
    assert points[0] - points[1] >= 2 * 6 * 18


def test_a_chain_without_a_straight_state_gets_no_advice_for_runs():
    result = call("dispersion", "wave", "--set", "chain.ends=clamped")
    assert result.exit_code == 0
    assert (
        "the modes of the chain are not drawn: the straight chain has no state: spheres touch"
        in (result.stderr)
    )
    assert "steric" not in result.stderr
