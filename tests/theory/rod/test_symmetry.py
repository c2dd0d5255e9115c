"""Classes of constants from the group action: the paper's printed tables, and averages."""

from __future__ import annotations

import numpy as np
import pytest

from nrchain.errors import SceneError, UnknownNameError
from nrchain.scene.loading import load_scene
from nrchain.theory.rod import (
    SYMBOLS,
    Constants,
    Symmetry,
    classes,
    measured_symmetry,
    slip_symmetry,
    symmetry_of_modes,
)
from nrchain.theory.rod.constants import parts_of
from nrchain.theory.rod.symmetry import ref, rot, transform
from validation.solid.printed import CLASSES as PRINTED

AXES = [
    {},
    {"2s": (1, 0, 0)},
    {"4a": (-1, 0, 0)},
    {"3a": (1, 0, 0), "3t": (1, 0, 0)},
    {"2s": (1, 0, 0), "4a": (1, 0, 0)},
    {"2s": (1, 1, 0)},
    {"3t": (0, 0, 2)},
    {"3a": (0, 1, 1), "3t": (1, 0, 0)},
    {"2s": (1, 2, 3), "4a": (3, -1, 2)},
]


def random_constants(seed=1):
    rng = np.random.default_rng(seed)
    return Constants(*(rng.normal(size=shape) for shape in ((6, 6), (6, 6), (6,), (6,))))


def sizes(value):
    return Constants.of().map(lambda part: part + value)


def test_classes_are_those_of_the_printed_table():
    found = classes()
    assert len(found) == 28
    for (polar, chiral), symbols in PRINTED.items():
        assert {s for s, c in found.items() if c == (polar, chiral)} == set(symbols.split())


@pytest.mark.parametrize("kind", [rot, ref])
@pytest.mark.parametrize("angle", [0.3, 1.1, 2.9])
def test_classes_do_not_depend_on_the_direction_across_the_rod(kind, angle):
    given = Constants.named({symbol: 1.0 + n for n, symbol in enumerate(SYMBOLS)})
    np.testing.assert_allclose(
        list(transform(given, kind(angle)).symbols().values()),
        list(transform(given, kind()).symbols().values()),
        atol=1e-13,
    )


def test_only_three_constants_of_a_block_survive_rotations_about_the_rod():
    average = Symmetry(True, (np.eye(3),)).average(random_constants())
    rebuilt = Constants.named(average.symbols())
    for part, whole in zip(parts_of(average), parts_of(rebuilt), strict=True):
        np.testing.assert_allclose(part, whole, atol=1e-15)


@pytest.mark.parametrize("axes", AXES, ids=str)
def test_allowed_entries_are_those_of_the_average_over_the_group(axes):
    """The average of random constants vanishes where, and only where, nothing is allowed."""
    symmetry = symmetry_of_modes(axes)
    average, allowed = symmetry.average(random_constants()), symmetry.allowed()
    for part, mask in zip(parts_of(average), parts_of(allowed), strict=True):
        np.testing.assert_array_equal(np.abs(part) > 1e-12, mask)


@pytest.mark.parametrize("axes", AXES, ids=str)
def test_symmetries_are_found_again_in_constants_that_have_them(axes):
    symmetry = symmetry_of_modes(axes)
    found = measured_symmetry(symmetry.average(random_constants()), sizes(1e-12))
    for name in ("isotropic", "apolar", "achiral", "centred"):
        assert getattr(found, name) == getattr(symmetry, name), name
    assert found.symbols() == symmetry.symbols()


def test_a_symmetry_broken_by_more_than_the_error_is_not_found():
    broken = Constants.named({"C_par_F_eps": 1.0, "f_pre": 1e-3})
    assert not measured_symmetry(broken, sizes(1e-4)).apolar
    assert measured_symmetry(broken, sizes(1e-3)).apolar


def test_a_chain_has_the_constants_of_the_classes_of_its_modes():
    """2s with 4a: a mirror across the chain forbids the mixed classes."""
    scene = load_scene("passive", **{"slip.2s": 1.0, "slip.4a": 2.0, "slip.3a": 0.0})
    symmetry = slip_symmetry(scene)
    mixed = PRINTED[False, False] + " " + PRINTED[True, True]
    assert set(symmetry.symbols()) == set(mixed.split())
    assert str(symmetry).endswith("unchanged by a mirror across e₁")


def test_symbols_and_blocks_are_inverse():
    values = {symbol: 1.0 + n for n, symbol in enumerate(SYMBOLS)}
    assert Constants.named(values).symbols() == pytest.approx(values)
    with pytest.raises(UnknownNameError, match="C_perp_F_eps"):
        Constants.named({"C_perp_F_ep": 1.0})


def test_an_axis_of_no_length_is_refused():
    with pytest.raises(SceneError, match="axis of 2s"):
        symmetry_of_modes({"2s": (0, 0, 0)})
