"""What is not named, has no strength or vanishes by symmetry is in no code and in no model."""

import re

import numba
import numpy as np
import pytest
from support.operations import count_operations
from support.poses import random_chain

import nrchain
from nrchain import slip_modes
from nrchain.hydrodynamics import friction, pairs
from nrchain.hydrodynamics.pair_law import PairLaw
from nrchain.motion.model import Model
from nrchain.potential import chain as cosserat
from nrchain.potential.chain import TERMS

E1 = (1.0, 0.0, 0.0)
MODES = ("2s", "3a", "3t", "4a")
ZEROS = {"slip.3a": 0.0, "slip.3t": [0.0] * 6, "slip.4a": 0.0, "field.force": [0, 0, 0]}
ZEROS |= {"flow.gradient": [[0.0] * 3] * 3, "steric.kind": "none"}


def make(**changes):
    return nrchain.load_scene({"chain.particles": 6, "run.end": 1.0}, **changes)


def arithmetic(law):
    """Products and sums in the text of a law, of one pair."""
    return len(re.findall(r" [*+-] |\+=", law.source))


def operations(make_kernel, terms, isotropic, *outputs):
    """Arithmetic of a kernel, and its calls of the modules that hold the terms."""
    vectors, numbers = numba.float64[:, ::1], numba.float64
    signature = (vectors, numba.float64[:, :, ::1], *[numbers] * 6, *outputs)
    return count_operations(make_kernel(terms, isotropic).py_func, signature)


def count_calls(monkeypatch, scene):
    """The kernels that one right-hand side and one Jacobian call, by name; none of them is run."""
    calls = []

    def counting(module, name):
        make_kernel = getattr(module, name)

        def counted(*arguments):
            kernel = make_kernel(*arguments)

            def run(*values):
                calls.append(kernel.py_func.__qualname__)

            return run

        monkeypatch.setattr(module, name, counted)

    for module, names in (
        (pairs, ("twist_kernel", "product_kernel", "block_kernel")),
        (cosserat, ("wrench_kernel", "block_kernel")),
        (friction, ("_twist_kernel", "_product_kernel")),
    ):
        for name in names:
            counting(module, name)
    model, poses = Model(scene), random_chain(6, spacing=10.0)
    model.twists(*poses)
    model.linearise(*poses, np.empty((6, 2 * model.reach + 1, 6, 6)))
    monkeypatch.undo()
    return calls


@pytest.mark.parametrize("friction_kind", ["one-body", "pairwise"])
def test_zero_strengths_run_the_very_kernels_of_a_scene_without_them(monkeypatch, friction_kind):
    absent = make(**{"slip.2s": 100.0, "friction": friction_kind})
    zero = make(**{"slip.2s": 100.0, "friction": friction_kind}, **ZEROS)
    expected = count_calls(monkeypatch, absent)
    assert expected
    assert count_calls(monkeypatch, zero) == expected


def test_nothing_named_runs_nothing(monkeypatch):
    slack = dict.fromkeys(TERMS, 0.0)
    scene = make(elasticity=slack, **ZEROS, **{"friction": "pairwise", "slip.neighbours": "all"})
    model = Model(scene)
    # no wrench, and so no friction to carry it
    assert model.friction is None
    assert not model.slip
    assert not model.elasticity
    assert count_calls(monkeypatch, scene) == []


def test_four_modes_have_twice_the_arithmetic_of_one():
    """What all-pairs sums of one mode take 1.6 times less time for; the geometry is in common."""
    alone, four = (PairLaw.of(labels, [E1] * len(labels)) for labels in (("2s",), MODES))
    assert arithmetic(four) > 2.0 * arithmetic(alone)


@pytest.mark.parametrize("label", MODES)
def test_what_a_mode_lacks_is_not_in_its_code(label):
    """3t turns nothing; the flow of 2s is along n alone, those of 3a and 4a along e × n alone."""
    mode, source = slip_modes.find(label), PairLaw.of([label], [E1]).source
    for field, table in (("u", mode.flow()), ("w", mode.spin())):
        written = set(re.findall(rf"{field}0 \+= f \* (\w)0", source))
        assert written == {{"n": "n", "e": "e", "x": "m"}[basis] for basis, _ in table}


@pytest.mark.parametrize("label", ["3a", "3t", "4a"])
def test_finite_size_leaves_modes_alone_that_it_does_not_change(label):
    sources = {PairLaw.of([label], [E1], finite).source for finite in (False, True)}
    assert len(sources) == 1
    changes = {f"slip.{label}": 10.0, "slip.finite_size": True}
    assert "finite size" not in [effect.name for effect in Model(make(**changes)).effects]


WRENCHES, BLOCKS = numba.float64[:, ::1], numba.float64[:, :, :, ::1]
KERNELS = [
    (cosserat.wrench_kernel, (WRENCHES,)),
    (cosserat.energy_kernel, ()),
    (cosserat.block_kernel, (BLOCKS,)),
]


@pytest.mark.parametrize(
    ("make_kernel", "outputs", "isotropic"),
    # each kernel, and both measures
    [(*KERNELS[0], False), (*KERNELS[0], True), (*KERNELS[1], True), (*KERNELS[2], False)],
)
def test_terms_without_a_modulus_take_their_arithmetic_along(make_kernel, outputs, isotropic):
    """What strains and what turns have nothing in common but the loop over links."""
    every, strained, turned, bent, none = (
        operations(make_kernel, terms, isotropic, *outputs)
        for terms in (TERMS, ("stretch", "shear"), ("twist", "bend"), ("bend",), ())
    )
    assert strained + turned == every + none
    assert none[""] < bent[""] < turned[""] < every[""]


@pytest.mark.parametrize("term", TERMS)
@pytest.mark.parametrize(("make_kernel", "outputs"), KERNELS[:2])
def test_a_term_calls_itself_and_no_other(make_kernel, outputs, term):
    calls = operations(make_kernel, (term,), False, *outputs)
    assert [other for other in TERMS if calls[other]] == [term]
