"""The examples of the README on effects run, and do what is said of them."""

import re
from pathlib import Path

import numpy as np
import pytest
from support.poses import pose_derivative, random_chain

import nrchain
from nrchain.motion.model import Model
from nrchain.outcome import Cause

CHANGES = {"chain.particles": 5, "chain.ends": "free", "run.end": 10.0}
README = Path(__file__).parents[1] / "README.md"


def examples(heading):
    """The Python blocks of a section."""
    text = README.read_text(encoding="utf-8").partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return re.findall(r"```python\n(.*?)```", text, re.S)


def test_every_cause_of_a_stop_is_listed():
    listed = re.findall(r"^\| `([a-z-]+)` \|", README.read_text(encoding="utf-8"), re.M)
    assert set(Cause) <= set(listed)


def test_the_motion_is_taken_apart():
    decomposition, *_ = examples("Effects")
    names = {"nrchain": nrchain}
    exec(decomposition.replace('"buckling", **{', '"buckling", **{"run.end": 5.0, '), names)
    found = names["found"]
    total = sum(part.twist for part in found.values())
    assert total == pytest.approx(found.total.twist, abs=1e-12 * np.abs(found["bend"].twist).max())


def test_an_effect_of_ones_own():
    _, registration, check = examples("Effects")
    names = {"nrchain": nrchain, "__name__": "readme"}
    try:
        exec(registration, names)
        exec(check, names)
        scene = nrchain.load_scene(names["scene"], **CHANGES)
        tether, poses = names["Tether"](scene), random_chain(5)
        x = poses[0] - np.array([60.0, 0.0, 50.0])

        def force(positions, frames):
            wrenches = np.zeros((5, 6))
            tether.add_wrenches(positions, frames, wrenches)
            return wrenches

        assert np.linalg.norm(force(*poses)[:, :3], axis=1) == pytest.approx(2.0)
        assert ((force(*poses)[:, :3] * x).sum(axis=1) < 0.0).all()
        numeric = pose_derivative(force, *poses)
        own = tether.derivative(*poses)
        assert own == pytest.approx(numeric[range(5), :, range(5)], abs=1e-8)
        assert Model(scene).is_banded
        trajectory = nrchain.simulate(scene)
        # the point is off the chain along z, and the mean force too
        assert trajectory.positions[-1][:, 2].mean() > trajectory.positions[0][:, 2].mean() + 0.1
    finally:
        nrchain.unregister_effect(names["Tether"])
