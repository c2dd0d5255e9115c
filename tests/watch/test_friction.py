"""Friction that is cut along the chain ends a run where it no longer dissipates energy."""

import numpy as np
import pytest

import nrchain
from nrchain.motion.definiteness import CutFriction
from nrchain.outcome import Cause, Stop
from nrchain.watch.friction import FrictionWatch

LINE = np.arange(10.0)[:, None] * [1.0, 0.0, 0.0]


def test_a_cut_that_holds_in_a_wide_chain_ends_a_run_at_contact():
    """Ten spheres in a line: twice their diameter apart μ is definite, at contact it is not."""
    cut = {"chain.spacing": 4.0, "friction": {"kind": "pairwise", "neighbours": 1}}
    scene = nrchain.load_scene({"chain.particles": 10, "run.end": 1.0}, **cut)
    watch = FrictionWatch(1, CutFriction(scene).least_mobility)
    watch.check(1.0, 4.0 * LINE)
    with pytest.raises(Stop, match="cut at 1 neighbours is no longer positive definite") as stop:
        watch.check(2.5, 2.01 * LINE)
    assert stop.value.cause is Cause.FRICTION
    assert stop.value.time == 2.5
