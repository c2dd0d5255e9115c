"""Everything public survives pickle, copies and process pools unchanged."""

from __future__ import annotations

import copy
import importlib
import math
import multiprocessing
import pickle
import pkgutil
import subprocess
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, is_dataclass
from inspect import isfunction
from types import ModuleType

import numpy as np
import pytest
from support.selection import few_of
from support.specimens import SPECIMENS, scene, trajectory

import nrchain
from nrchain import errors, outcome
from nrchain.errors import NOT_GIVEN, SceneError

PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)
METHODS = multiprocessing.get_all_start_methods()


def names() -> dict[str, object]:
    """Everything public by its shortest name: of the package, then of its public modules."""
    public = {name: getattr(nrchain, name) for name in nrchain.__all__}
    modules = {name: thing for name, thing in public.items() if isinstance(thing, ModuleType)}
    found = {f"nrchain.{name}": public[name] for name in public.keys() - modules.keys()}
    for name, module in modules.items():
        functions = filter(isfunction, vars(module).values())
        given = {str(f.__annotations__.get("return")) for f in functions}
        for inner, thing in vars(module).items():
            home = str(getattr(thing, "__module__", ""))
            own = home.startswith(module.__name__)
            if (
                (own or (home.startswith("nrchain") and inner in given))
                and not inner.startswith("_")
                and thing not in found.values()
            ):
                found[f"nrchain.{name}.{inner}"] = thing
    return found


def classes() -> dict[str, type]:
    return {name: thing for name, thing in names().items() if isinstance(thing, type)}


def alike(first: object, second: object) -> bool:
    """Whether two things are of one type and of equal content, arrays bit for bit."""
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return np.array_equal(first, second, equal_nan=first.dtype.kind in "fc")
    if isinstance(first, BaseException):
        same = str(first) == str(second) and alike(first.args, second.args)
        return same and alike(vars(first), vars(second))
    if is_dataclass(first):
        return all(alike(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))
    if isinstance(first, dict):
        return list(first) == list(second) and all(alike(first[k], second[k]) for k in first)
    if isinstance(first, list | tuple):
        return len(first) == len(second) and all(map(alike, first, second))
    if isinstance(first, nrchain.Effect):
        return alike(first.scene, second.scene)
    if type(first).__eq__ is object.__eq__ and hasattr(first, "__dict__"):
        return first is second or alike(vars(first), vars(second))
    if isinstance(first, float) and math.isnan(first):
        return math.isnan(second)
    return first == second


def copies(thing: object) -> dict[str, object]:
    found = {f"protocol {p}": pickle.loads(pickle.dumps(thing, p)) for p in PROTOCOLS}
    return found | {"copy": copy.copy(thing), "deepcopy": copy.deepcopy(thing)}


def test_every_public_class_has_a_specimen():
    missing = classes().keys() - SPECIMENS.keys()
    assert not missing, f"add one of each to SPECIMENS: {missing}"
    assert not SPECIMENS.keys() - classes().keys()


@pytest.mark.parametrize("name", SPECIMENS)
def test_what_is_public_survives_every_protocol_and_copy(name):
    specimen, kind = SPECIMENS[name](), classes()[name]
    of_kind = specimen if isinstance(specimen, list) else [specimen]
    abstract = kind in (nrchain.Effect, nrchain.OneBodyEffect, nrchain.Section)
    assert of_kind
    assert abstract or all(type(one) is kind for one in of_kind)
    for way, again in copies(specimen).items():
        assert alike(specimen, again), way


def test_public_functions_are_pickled_by_name():
    for name, thing in names().items():
        if not isinstance(thing, type) and isfunction(thing):
            assert all(again is thing for again in copies(thing).values()), name


def exceptions() -> list[type[BaseException]]:
    """Every exception of the package, public or not: all may be raised in a worker."""
    found: set[type[BaseException]] = set()
    for module in pkgutil.walk_packages(nrchain.__path__, "nrchain."):
        if not module.name.endswith("__main__"):
            members = vars(importlib.import_module(module.name)).values()
            found |= {m for m in members if isinstance(m, type) and issubclass(m, BaseException)}
    return sorted(
        (kind for kind in found if kind.__module__.startswith("nrchain.")),
        key=lambda kind: kind.__qualname__,
    )


ARGUMENTS = {
    SceneError: ("chain.spacing", 1.0, "must exceed two radii"),
    outcome.Settled: (1.5, "settled in a steady state"),
    outcome.Stop: (nrchain.Cause.TOUCH, 1.5, "spheres 3 and 4 touch"),
    errors.PlatformError: (),
}


@pytest.mark.parametrize("kind", exceptions(), ids=lambda kind: kind.__name__)
def test_every_exception_survives_with_its_notes(kind):
    error = kind(*ARGUMENTS.get(kind, ("what happened",)))
    error.add_note("while a test looked on")
    for way, again in copies(error).items():
        assert alike(error, again), way
        assert repr(again) == repr(error), way


def test_a_key_that_was_not_given_is_the_same_in_another_process():
    error = pickle.loads(pickle.dumps(SceneError("run.end", NOT_GIVEN, "must be given")))
    assert error.value is NOT_GIVEN
    assert str(error) == "run.end is not given: must be given"


class Unloadable:
    """Pickled without trouble, and trouble where it is unpickled."""

    def __reduce__(self):
        return Unloadable, ("one argument too many",)


UNPICKLED = {"function": lambda: 0, "class": Unloadable(), "iterator": [open, iter("ab")]}


@pytest.mark.parametrize("value", UNPICKLED.values(), ids=UNPICKLED)
def test_a_value_that_cannot_be_pickled_is_shown_as_it_was(value):
    error = SceneError("chain.spacing", value, "must be a number")
    for again in (pickle.loads(pickle.dumps(error, p)) for p in PROTOCOLS):
        assert str(again) == str(error)
        assert again.key == "chain.spacing"


@pytest.mark.parametrize("method", METHODS)
def test_pools_hand_over_scenes_trajectories_and_refusals(method):
    """A refusal that could not be unpickled left the pool waiting for ever."""
    context = multiprocessing.get_context(method)
    with warnings.catch_warnings():
        # from Python 3.12 on a fork beside threads, such as those of BLAS, warns
        warnings.simplefilter("ignore", DeprecationWarning)
        with context.Pool(1) as pool:
            wrong = pool.apply_async(nrchain.load_scene, ("passive",), {"chain.spacing": 1.0})
            with pytest.raises(SceneError, match=r"chain\.spacing = 1\.0") as refusal:
                wrong.get(timeout=60)
            assert (refusal.value.key, refusal.value.value) == ("chain.spacing", 1.0)
            again = pool.apply_async(nrchain.simulate, (scene(),)).get(timeout=60)
        assert again.scene == scene()
        assert np.allclose(again.positions, trajectory().positions, rtol=0, atol=1e-6)
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            future = pool.submit(nrchain.load_scene, "passive", **{"run.end": -1.0})
            with pytest.raises(SceneError, match=r"run\.end = -1\.0"):
                future.result(timeout=60)


SHARED = """
import multiprocessing, sys
import nrchain
from nrchain.hydrodynamics.sharing import PARALLEL_PAIRS

def last(strength):
    changes = {
        "chain.particles": 160, "slip.neighbours": "all", "slip.2s": strength,
        "friction": "pairwise", "flow.gradient": [[0, 0.01, 0], [0, 0, 0], [0, 0, 0]],
        "run.end": 0.1, "run.snapshots": 2, "start.shape": "sine",
    }
    assert 2 * 160**2 > PARALLEL_PAIRS
    return nrchain.simulate(nrchain.load_scene("passive", **changes)).positions[-1].tobytes()

if __name__ == "__main__":
    own = last(40.0)
    for method in sys.argv[1:]:
        with multiprocessing.get_context(method).Pool(1) as pool:
            theirs = pool.map_async(last, [40.0, 40.0]).get(timeout=60)
        print(method, "same" if theirs == [own, own] else "differ", flush=True)
"""


@pytest.mark.parametrize("methods", few_of([METHODS, ["fork"]], [["fork"]]), ids="-".join)
def test_a_pool_that_starts_after_a_sum_over_threads_gives_the_same_run(methods, tmp_path):
    """A forked child has none of its parent's threads: OpenMP ends it, and the pool waits."""
    program = tmp_path / "shared.py"
    program.write_text(SHARED)
    # the first run may compile kernels, and those of a first run differ in rounding
    subprocess.run([sys.executable, program], check=True)
    ended = subprocess.run(
        [sys.executable, program, *methods], capture_output=True, text=True, check=False
    )
    assert ended.stdout == "".join(f"{method} same\n" for method in methods), ended.stderr
