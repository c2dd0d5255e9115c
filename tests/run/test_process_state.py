"""A run leaves the state of its process unchanged, also while it goes on."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from support.process_state import changes, handlers, state
from support.selection import few_of

import nrchain
from nrchain.accuracy import cost
from nrchain.analysis import measure
from nrchain.errors import NrchainError, SceneError, TrajectoryError
from nrchain.hydrodynamics import sharing
from nrchain.planning import auto, estimate, plan
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.shared_steps import SharedStepRun
from nrchain.run import preparation
from nrchain.view import effect_plots, plots

SHORT = {"chain.particles": 6, "run.end": 2.0, "run.snapshots": 5}


def scene(name="buckling", **more):
    return nrchain.load_scene(name, **(SHORT | more))


@pytest.fixture(scope="module")
def trajectory(tmp_path_factory):
    return nrchain.simulate(scene(), output=tmp_path_factory.mktemp("runs") / "done")


def stopped():
    trajectory = nrchain.simulate(scene(**{"run.max_steps": 3}))
    assert trajectory.status == "stopped"


def cannot_step(folder):
    """A run whose integrator fails."""

    class Wild(preparation.Loop):
        def __init__(self, chain, *rest):
            super().__init__(chain, *rest)
            twists = chain.model.twists

            def wild(positions, frames, out=None):
                found = twists(positions, frames, out)
                if chain.evaluations > 100:
                    found[:, :3] += 1e12 * np.sin(1e17 * positions)
                return found

            chain.model.twists = wild

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(preparation, "Loop", Wild)
        wild = scene(**{"run.integrator": "cvode"})
        ended = nrchain.simulate(wild, output=folder / "wild")
    assert ended.cause is nrchain.Cause.STEP


def refused():
    with pytest.raises(SceneError):
        nrchain.load_scene("buckling", **{"chain.spacing": 1.0})
    with pytest.raises(SceneError):
        nrchain.simulate(scene(), positions=np.zeros((6, 3)), frames=np.zeros((6, 3, 3)))


def interrupted(folder):
    def stop(progress):
        if progress.snapshot == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nrchain.simulate(scene(), output=folder / "interrupted", progress=stop)
    assert nrchain.resume(folder / "interrupted").status == "completed"


def unwritable(folder):
    file = folder / "file"
    file.write_text("in the way")
    with pytest.raises(TrajectoryError):
        nrchain.simulate(scene(), output=file / "below")


ACTS = {
    "completed": lambda folder, done: nrchain.simulate(scene(), output=folder / "a"),
    "many": lambda folder, done: list(nrchain.simulate_many([scene()] * 3, folder / "many")),
    "radau": lambda folder, done: nrchain.simulate(scene(**{"run.integrator": "radau"})),
    "scipy-bdf": lambda folder, done: nrchain.simulate(scene(**{"run.integrator": "scipy-bdf"})),
    "pystokes": lambda folder, done: nrchain.simulate(
        scene(**{"slip.backend": "pystokes", "run.max_steps": 3})
    ),
    "stopped": lambda folder, done: stopped(),
    "cannot step": lambda folder, done: cannot_step(folder),
    "refused": lambda folder, done: refused(),
    "interrupted": lambda folder, done: interrupted(folder),
    "unwritable": lambda folder, done: unwritable(folder),
    "auto": lambda folder, done: auto.choose(scene(effects="auto", tolerance=0.1)),
    "contributions": lambda folder, done: nrchain.contribution_sizes(done),
    "cost": lambda folder, done: cost.work_precision(scene(), budget=0.05),
    "estimate": lambda folder, done: estimate.estimate_effects(scene(), budget=0.02),
    "plan": lambda folder, done: plan.plan(scene()),
    "measure": lambda folder, done: measure.straightness(done),
    "open": lambda folder, done: nrchain.Trajectory.open(done.path),
    "draw": lambda folder, done: plots.save_chain(done, folder / "chain.png"),
    "draw in space": lambda folder, done: plots.save_chain(done, folder / "a.pdf", view="3d"),
    "draw effects": lambda folder, done: effect_plots.save_effects(done, folder / "a.svg"),
}


@pytest.mark.parametrize("act", ACTS)
def test_the_process_is_left_as_it_was(act, trajectory, tmp_path):
    ACTS[act](tmp_path, trajectory)  # what libraries set when they are imported is theirs
    (tmp_path / "again").mkdir()
    before, signals = state(), handlers()
    ACTS[act](tmp_path / "again", trajectory)
    assert not changes(before, state())
    assert not changes(signals, handlers())


@pytest.mark.parametrize("integrator", ["cvode", "radau", "scipy-bdf"])
def test_process_state_does_not_change_during_a_run(integrator):
    seen = []
    before = state()
    with np.errstate(divide="raise", under="warn"):
        before["floating-point errors"] = np.geterr() | {"call": np.geterrcall()}
        nrchain.simulate(
            scene(**{"run.integrator": integrator}),
            progress=lambda progress: seen.append(changes(before, state())),
        )
    assert len(seen) == 5
    assert not any(seen)


def test_the_arithmetic_between_the_steps_of_paired_runs_is_their_consumers():
    pair = SharedStepRun([scene(), scene(**{"slip.2s": 90.0})], starting_poses(scene()), 1e-6)
    before = np.geterr()
    assert [np.geterr() for _ in pair.advance([0.5, 1.0, 2.0])] == [before] * 3


def test_a_run_in_a_thread_leaves_signals_alone():
    signals, seen = handlers(), []

    def look(progress):
        seen.append(changes(signals, handlers()))

    with ThreadPoolExecutor(1) as pool:
        pool.submit(nrchain.simulate, scene(), progress=look).result()
    assert len(seen) == 5
    assert not any(seen)


def task(number):
    """The result of one of several kinds of runs, as bytes or text."""
    try:
        if number % 5 == 4:
            nrchain.load_scene("buckling", **{"chain.spacing": -float(number)})
        steps = {"run.max_steps": 20} if number % 5 == 3 else {}
        integrator = ("cvode", "cvode", "radau")[number % 3]
        strength = {"slip.2s": 100.0 + number, "run.integrator": integrator}
        ended = nrchain.simulate(scene(**strength, **steps))
    except NrchainError as error:
        return str(error)
    return ended.positions.tobytes(), ended.reason


def test_threads_run_while_others_print_and_change_process_state(capsys):
    """A regression: ``print`` wrote nothing while simulations ran in threads."""
    expected = [task(number) for number in range(20)]
    ours, lines = sys.stdout, 0
    with ThreadPoolExecutor(4) as pool, warnings.catch_warnings():
        running = [pool.submit(task, number) for number in range(20)]
        warnings.simplefilter("error", ResourceWarning)
        mine = list(warnings.filters)
        while not all(future.done() for future in running):
            print("line", lines)
            lines += 1
            with np.errstate(all="warn"):
                os.environ["NRCHAIN_OF_ANOTHER"] = str(lines)
                assert sys.stdout is ours
                assert list(warnings.filters) == mine
                assert set(np.geterr().values()) == {"warn"}
        assert os.environ.pop("NRCHAIN_OF_ANOTHER") == str(lines)
    assert [future.result() for future in running] == expected
    print("the end")
    assert capsys.readouterr().out == "".join(f"line {n}\n" for n in range(lines)) + "the end\n"


SUMS = """
import sys
from concurrent.futures import ThreadPoolExecutor
import nrchain
from nrchain.hydrodynamics import sharing

def scene(strength):
    changes = {
        "chain.particles": 160, "slip.neighbours": "all", "slip.2s": strength,
        "run.end": 0.1, "run.snapshots": 2, "start.shape": "sine",
    }
    return nrchain.load_scene("passive", **changes)

def bits(trajectory):
    return trajectory.positions[-1].tobytes()

def last(strength):
    return bits(nrchain.simulate(scene(strength)))

last(40.0)  # may compile kernels
list(nrchain.simulate_many([scene(40.0)] * 2, workers=2))
if not sys.argv[1:]:
    sys.exit()
expected = [last(40.0 + number) for number in range(6)]
with ThreadPoolExecutor(3) as pool:
    found = list(pool.map(last, [40.0 + number for number in range(6)]))
members = nrchain.simulate_many([scene(40.0 + number) for number in range(6)], workers=2)
many = {member.index: bits(member.result()) for member in members}
print("same" if found == expected == [many[index] for index in range(6)] else "differ")
print(sharing.layer())
"""


@pytest.mark.parametrize("layer", few_of(["omp", "workqueue"], {"workqueue"}))
def test_threads_share_sums_over_threads(layer, tmp_path):
    """Numba's work queue ends a process that enters it from two threads at once.

    ``simulate_many`` sums on one thread a run, with the same bits.
    """
    program = tmp_path / "sums.py"
    program.write_text(SUMS)
    environment = os.environ | {"NUMBA_THREADING_LAYER": layer, "NUMBA_NUM_THREADS": "2"}
    for more in ([], ["go on"]):  # kernels that are compiled differ in rounding from kept ones
        ended = subprocess.run(
            [sys.executable, program, *more],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
    if "No threading layer could be loaded" in ended.stderr:
        pytest.skip(f"numba has no {layer} here")
    assert ended.stdout == f"same\n{layer}\n", ended.stderr


@pytest.mark.parametrize(("layer", "second"), [("omp", True), ("tbb", True), ("workqueue", False)])
def test_a_second_thread_enters_only_layers_that_allow_it(monkeypatch, layer, second):
    monkeypatch.setattr(sharing, "layer", lambda: layer)
    shared, inside, leave = [], threading.Event(), threading.Event()

    def first(parallel):
        shared.append(parallel)
        inside.set()
        assert leave.wait(60.0)

    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(sharing.add, lambda parallel: lambda: first(parallel), True)
        assert inside.wait(60.0)
        sharing.add(lambda parallel: lambda: shared.append(parallel), True)
        leave.set()
        waiting.result()
    sharing.add(lambda parallel: lambda: shared.append(parallel), True)
    assert shared == [True, second, True]


def test_what_is_to_take_one_thread_takes_one_and_only_there():
    shared = []

    def look():
        sharing.add(lambda parallel: lambda: shared.append(parallel), True)

    with sharing.one_thread(), ThreadPoolExecutor(1) as pool:
        look()
        pool.submit(look).result()
    look()
    assert shared == [False, True, True]


OF_THE_PROCESS = {
    "catch_warnings", "simplefilter", "filterwarnings", "resetwarnings",
    "redirect_stdout", "redirect_stderr", "dup2", "chdir", "umask", "setlocale", "putenv",
    "seterr", "seterrcall", "set_printoptions", "setrecursionlimit", "setswitchinterval",
    "rc_context", "rcdefaults", "rc", "switch_backend", "pyplot", "set_num_threads", "basicConfig",
}  # fmt: skip
"""Names of what changes a process as a whole; its filters of warnings, too, are not a thread's."""

OF_THE_PROGRAM = {"__main__.py", "cli"}
"""The command line, which has its process to itself."""


def test_no_module_names_what_changes_a_process():
    package = Path(nrchain.__file__).parent
    for path in package.rglob("*.py"):
        if OF_THE_PROGRAM & set(path.relative_to(package).parts):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            named = {getattr(node, "attr", ""), getattr(node, "id", "")}
            if isinstance(node, ast.ImportFrom | ast.Import):
                named |= {part for alias in node.names for part in alias.name.split(".")}
            assert not named & OF_THE_PROCESS, f"{path}:{getattr(node, 'lineno', '')}"


def test_importing_changes_no_environment(tmp_path):
    package = Path(nrchain.__file__).parent
    modules = sorted(
        ".".join(path.relative_to(package.parent).with_suffix("").parts)
        for path in package.rglob("*.py")
        if path.name not in ("__init__.py", "__main__.py")
    )
    program = (
        "import importlib, os, sys; before = dict(os.environ), sys.stdout, os.getcwd()\n"
        f"for name in {modules}: importlib.import_module(name)\n"
        "assert (dict(os.environ), sys.stdout, os.getcwd()) == before"
    )
    plain = {"PATH": os.environ["PATH"], "HOME": str(tmp_path)}
    subprocess.run([sys.executable, "-c", program], check=True, env=plain)
