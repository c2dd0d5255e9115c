"""No scene ends but as documented, and what completes holds its invariants."""

import random
import resource

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import nrchain
from nrchain.errors import SceneError
from nrchain.outcome import Cause
from validation.hard_fuzz import fuzz, fuzzed
from validation.hard_gallery import GALLERY, REFUSED

MODES = [(), ("2s",), ("2s", "3a", "3t", "4a")]
STRENGTH = st.sampled_from([1e-12, 1.0, -100.0, 5000.0, 1e8, -1e150, 1e300])


@st.composite
def wild_scenes(draw):
    """Short chains of any stiffness and strength, with small budgets."""
    periodic = draw(st.booleans())
    steric = {"kind": draw(st.sampled_from(["none", "wca", "harmonic"]))}
    if steric["kind"] != "none":
        steric["strength"] = draw(st.sampled_from([1e-3, 1.0, 1e6]))
    return {
        "chain": {
            "particles": draw(st.integers(2, 6)),
            "spacing": draw(st.sampled_from([2.3, 4.0, 10.0])),
            "ends": "periodic" if periodic else draw(st.sampled_from(["free", "clamped"])),
        },
        "elasticity": {"ratio": draw(st.sampled_from([1e-3, 1e3, 1e7, 1e12]))},
        "slip": {
            "neighbours": draw(st.sampled_from([1, 3] if periodic else [1, 3, "all"])),
            **{label: draw(STRENGTH) for label in draw(st.sampled_from(MODES))},
        },
        "friction": draw(st.sampled_from(["one-body", "pairwise"])) if not periodic else "one-body",
        "steric": steric,
        "start": {
            "shape": draw(st.sampled_from(["straight", "sine", "helix-left", "random"])),
            "amplitude": draw(st.sampled_from([0.0, 1e-12, 0.1, 3.0, 1e200])),
        },
        "run": {
            "end": draw(st.sampled_from([1e-9, 1.0, 1e3])),
            "snapshots": 4,
            "max_steps": 60,
            "max_seconds": 5.0,
            "integrator": draw(st.sampled_from(["cvode", "radau", "scipy-bdf"])),
        },
    }


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(wild_scenes())
def test_every_scene_completes_is_refused_or_stops_for_a_cause(table):
    try:
        ended = nrchain.simulate(nrchain.load_scene(table))
    except SceneError:
        return
    assert (ended.status == "completed") == (ended.cause is None)
    assert ended.status in ("completed", "stopped")
    assert bool(ended.reason) == (ended.cause is not None)
    assert ended.cause is not Cause.ERROR
    assert (np.diff(ended.time) > 0).all()
    gram = np.einsum("...ak,...bk->...ab", ended.frames, ended.frames)
    assert np.abs(gram - np.eye(3)).max() < 1e-12
    if ended.status == "completed":
        assert len(ended.time) == 4


def test_fuzzed_scene_files_are_read_refused_or_run():
    fates, undocumented = fuzz(300, seed=7)
    assert undocumented == []
    assert fates["refused"] > 50
    assert fates.total() - fates["refused"] > 10


def test_the_fuzz_repeats_itself():
    assert fuzzed(random.Random(3)) == fuzzed(random.Random(3))


@pytest.mark.parametrize("case", [c for c in GALLERY if c.ends == (REFUSED,)], ids=lambda c: c.name)
def test_cases_of_the_gallery_that_are_refused(case):
    scene = case.scene()
    with pytest.raises(SceneError):
        nrchain.simulate(scene, **case.poses(scene))


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"chain.particles": 10**12}, "chain.particles"),
        ({"run.snapshots": 10**12}, "run.snapshots"),
    ],
)
def test_what_does_not_fit_the_memory_is_refused_at_once(changes, key):
    with pytest.raises(SceneError, match="GiB") as caught:
        nrchain.simulate(nrchain.load_scene("passive", **changes))
    assert caught.value.key == key


def test_every_cause_has_advice():
    assert all(cause.advice for cause in Cause)


@pytest.mark.slow
def test_memory_stays_flat_over_a_hundred_thousand_steps(tmp_path):
    # a chain that never comes to rest: the axis of its slip is tilted, and it tumbles
    scene = nrchain.load_scene(
        {
            "chain": {"particles": 4},
            "elasticity": {"stretch": 20.0, "shear": 20.0},
            "slip": {"4a": {"strength": 3000.0, "axis": [1.0, 0.3, 0.0]}},
            "start": {"shape": "random"},
            "run": {"end": 1e6, "snapshots": 1001, "max_steps": 100_000},
        }
    )
    nrchain.simulate(nrchain.load_scene(scene, **{"run.max_steps": 5000}), output=tmp_path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    stopped = nrchain.simulate(scene, output=tmp_path, overwrite=True)
    assert stopped.cause is Cause.BUDGET
    assert stopped.counters["steps"] == 100_000
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 4000, f"{grown} kB in 95 000 steps"
