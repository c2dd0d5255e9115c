"""Krylov iteration and products of all pairs find what dense matrices do."""

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain.comoving import dense, krylov, relative
from nrchain.states import spectrum as spectra
from nrchain.states import transient
from nrchain.states.newton import find_steady_state
from nrchain.theory.line_loads import straight_poses

LINKS = {"elasticity": {"ratio": None, "stretch": 100.0, "shear": 100.0}}
CHAINS = {
    "clamped pushers": ("buckling", {"slip.2s": 30.0}),
    "free swimmers": ("wave", {}),
    "free spinners": ("spiral-left", {}),
    "flutter": ("buckling", {"slip.2s": 10.0, "slip.3t": 200.0, "slip.3a": 1000.0}),
    "ring": ("buckling", {"chain.ends": "periodic", "slip.3t": 400.0, "slip.4a": 300.0}),
}


def scene_of(name, count):
    base, changes = CHAINS[name]
    return nrchain.load_scene(base, **LINKS, **changes, **{"chain.particles": count})


@pytest.mark.parametrize("name", few_of(CHAINS, CHAINS.keys() - {"flutter"}))
def test_the_leading_rates_are_found_without_all_others(name):
    scene = scene_of(name, 40)
    state = find_steady_state(scene, straight_poses(scene))
    point = relative.RelativeChain(scene, state.poses).at(state.poses)
    every = dense.all_rates(point)
    abscissa = transient.numerical_abscissa(dense.shape_matrix(point))
    assert krylov.numerical_abscissa(point) == pytest.approx(abscissa, rel=1e-7)
    found = krylov.leading_rates(point, 10, abscissa)
    assert len(found) >= 10
    assert found[:8] == pytest.approx(every[:8], rel=1e-6)


def test_a_long_chain_has_the_modes_of_near_neighbours(monkeypatch):
    scene = scene_of("flutter", 30)
    whole = nrchain.spectrum(scene)
    monkeypatch.setattr(spectra, "DENSE", 10)
    part = nrchain.spectrum(scene)
    assert not part.is_whole
    for one, other in zip(whole.modes[:4], part.modes[:4], strict=True):
        assert abs(one.rate - other.rate) <= one.error + other.error
        assert one.multiplicity == other.multiplicity
    slopes = [found.sensitivities(keys=["slip.3t"])["slip.3t"] for found in (whole, part)]
    assert slopes[0] == pytest.approx(slopes[1], rel=1e-6)


@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_products_of_all_pairs_give_the_rates_of_the_matrix(ends, monkeypatch):
    far = {"slip.neighbours": "all", "slip.accuracy": "direct", "friction": "pairwise"}
    changes = {"chain.particles": 10, "chain.ends": ends, "slip.2s": 20.0, "slip.3t": 30.0}
    scene = nrchain.load_scene("buckling", **LINKS, **changes, **far)
    whole = nrchain.spectrum(scene)
    monkeypatch.setattr(spectra, "DENSE", 5)
    monkeypatch.setattr(relative, "DENSE", 5)
    part = nrchain.spectrum(scene, modes=6)
    assert not part.is_whole
    for mode in part.modes[:3]:
        assert np.isnan(mode.condition)
        assert np.abs(whole.rates - mode.rate).min() <= 1e-9 * abs(mode.rate)
    assert part.leading.rate == pytest.approx(whole.leading.rate, rel=1e-9)
    with pytest.raises(nrchain.SceneError, match=r"chain.particles = 10: must be at most"):
        part.sensitivities()
