"""Mutants of the package: which places are changed, and that tests run the changed code."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from validation.mutants.coverage_of import Covered
from validation.mutants.loading import VARIABLE
from validation.mutants.sites import mutants_of, mutated

ROOT = Path(__file__).parents[2]
SOURCE = '''
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy import ndarray

LIMIT = 3.0

@kernel
def compiled(x):
    return x + 1.0

def made(x: int | None = 2) -> float:
    """A text."""
    if x > 0 and not x == 5:
        note(x)
    return min(x, 7.0) / x
'''


@pytest.fixture
def found(tmp_path):
    (tmp_path / "module.py").write_text(SOURCE)
    return mutants_of(tmp_path, "module.py")


def test_every_mutant_changes_one_place_of_the_source(found):
    plain = ast.unparse(ast.parse(SOURCE)).splitlines()
    for mutant in found:
        changed = ast.unparse(mutated(SOURCE, mutant.number)).splitlines()
        assert len(changed) == len(plain)
        assert sum(a != b for a, b in zip(plain, changed, strict=True)) == 1


def test_kernels_thresholds_and_types_are_left_alone(found):
    assert {mutant.function for mutant in found} == {"made"}
    changes = {(mutant.before, mutant.after) for mutant in found}
    expected = {
        ("2", "3"),
        ("x > 0", "x <= 0"),
        ("x > 0", "x >= 0"),
        ("x == 5", "x != 5"),
        ("not x == 5", "not not x == 5"),
        ("x > 0 and (not x == 5)", "x > 0 or not x == 5"),
        ("note(x)", "None"),
        ("min(x, 7.0)", "max(x, 7.0)"),
        ("7.0", "14.0"),
        ("min(x, 7.0) / x", "min(x, 7.0) * x"),
    }
    assert expected <= changes


def test_a_program_that_a_test_starts_runs_the_mutant_and_not_the_file():
    path = "nrchain/errors.py"
    found = mutants_of(ROOT, path)
    mutant = next(m for m in found if m.function == "shorten" and m.before == "80")
    script = "from nrchain.errors import shorten; print(len(shorten('x' * 200)))"
    paths = os.pathsep.join([str(ROOT / "validation/mutants/startup"), str(ROOT)])
    environment = os.environ | {"PYTHONPATH": paths}

    def run(**further):
        command = [sys.executable, "-c", script]
        done = subprocess.run(
            command, env=environment | further, capture_output=True, text=True, check=True
        )
        return int(done.stdout)

    assert run() == 80
    assert run(**{VARIABLE: f"{ROOT / path}:{mutant.number}"}) == 81


def test_the_quickest_tests_of_a_line_come_first_and_keep_to_the_budget():
    covered = Covered({"p.py": {1: ["slow", "quick"], 2: ["other"]}}, {"slow": 9.0, "quick": 1.0})
    assert covered.tests("p.py", 1, 1, 20.0) == ["quick", "slow"]
    assert covered.tests("p.py", 1, 1, 5.0) == ["quick"]
    # a line that runs as the module is imported belongs to every test of the file
    assert covered.tests("p.py", 7, 7, 20.0) == ["other", "quick", "slow"]
