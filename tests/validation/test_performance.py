"""Times and errors are measured as stated."""

import time

import numpy as np
import pytest

from nrchain import load_scene, simulate
from nrchain.scene.toml import parse_assignment
from validation.performance import growth, roofline, start_up
from validation.performance.scenes import buckling
from validation.performance.timing import (
    Timed,
    in_child,
    in_turns,
    loosest,
    miss,
    ours,
    theirs,
)


def test_tasks_taking_turns_are_timed_per_call():
    found = in_turns(
        {"short": lambda: time.sleep(1e-3), "long": lambda: time.sleep(5e-3)}, rounds=3
    )
    assert found["short"].shape == (3,)
    assert found["short"].min() >= 1e-3
    assert found["long"].min() >= 5e-3
    assert np.median(found["short"]) < np.median(found["long"])


def test_the_loosest_tolerance_that_meets_an_error():
    def run(tolerance):
        return Timed(tolerance, 10 * tolerance, 0.0, 0, 0)

    assert loosest(run, 1e-4).tolerance == pytest.approx(1e-5)
    assert loosest(run, 1e-4, first=1e-6).tolerance == pytest.approx(1e-6)
    with pytest.raises(ArithmeticError, match="no tolerance"):
        loosest(run, 1e-20)


def test_an_error_is_the_largest_distance_in_radii():
    true = simulate(buckling(4, **{"run.end": 1.0, "chain.radius": 2.0}))
    moved = true.positions.copy()
    moved[3, 2] += [3.0, 0.0, 4.0]
    assert miss(moved, true) == pytest.approx(2.5)
    assert miss(moved[:-1], true) == np.inf
    assert ours(true.scene, true.scene.run.rtol, true).error == 0.0


def test_a_rival_that_breaks_down_meets_no_error():
    def solve(*arguments):
        raise ArithmeticError

    true = simulate(buckling(4, **{"run.end": 1.0}))
    assert theirs(solve, true.scene, 1e-3, true).error == np.inf


def test_exponents_are_those_of_long_chains():
    counts = [16, 256, 512, 1024]
    assert growth.exponent(counts, [1.0, *(n**1.5 for n in counts[1:])]) == pytest.approx(1.5)


def test_the_memory_of_a_child_is_its_own():
    pytest.importorskip("resource")
    found = in_child(growth.wavy(16, 1e-3))
    assert 20 < found["mebibytes"] < 1000
    assert found["steps"] > 0


def test_a_child_that_dies_says_why():
    scene = load_scene("passive")
    object.__setattr__(scene.chain, "particles", -1)
    with pytest.raises(ChildProcessError, match=r"-1 spheres died: .*chain\.particles"):
        in_child(scene)


@pytest.mark.parametrize("words", start_up.COMBINATIONS)
def test_further_scenes_differ_from_the_shipped_one(words):
    changes = dict(parse_assignment(change) for change in start_up.COMBINATIONS[words])
    assert load_scene("buckling", **changes) != load_scene("buckling")


def test_a_child_that_works_takes_the_time_it_worked(tmp_path):
    """Sleep is no work."""
    work = "import time\nwhile time.process_time() < 0.5: pass"
    assert start_up.processor_time(["-c", work], tmp_path) >= 0.5
    assert start_up.processor_time(["-c", "import time; time.sleep(0.5)"], tmp_path) < 0.5


def test_the_parts_of_a_run_are_all_that_it_counts():
    """Calls of the functions of a run's equation, against the counters of the run itself."""
    scene = load_scene("buckling", **{"chain.particles": 7, "run.end": 20.0})
    found = roofline.measure(scene, rounds=1)
    counters, calls = simulate(scene).counters, found.calls
    parts = {name: calls[which] for which, name in roofline.PARTS.items()}
    assert parts["right-hand sides"] == counters["evaluations"]
    assert parts["Jacobians"] == counters["jacobians"]
    assert parts["real solves"] + parts["complex solves"] == counters["solves"]
    assert parts["Jacobians"] <= parts["factors"] <= parts["real solves"]
    assert min(found.seconds.values()) > 0.0
