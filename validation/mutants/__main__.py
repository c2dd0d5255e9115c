"""``python -m validation.mutants``: change the package at one place, run its tests, and again.

Needs the extra ``mutants``. The suite runs once under coverage; each mutant then meets the tests of
its line, the quickest first, in a process of its own. What no test notices is listed, unless
``equivalent.toml`` says why no test could.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from validation.mutants.coverage_of import Covered, measure
from validation.mutants.sites import Mutant, mutants_of
from validation.mutants.trial import ROOT, can_collect, is_noticed

HERE = Path(__file__).parent

BUDGET = 60.0
"""Seconds that the tests of one mutant may take unmutated."""

PATIENCE = 5.0
"""Times that budget, plus a minute to load and compile, after which a mutant counts as noticed."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m validation.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=300, help="how many mutants to draw")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--only", default="", help="mutate only paths that contain this")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="tests side by side")
    parser.add_argument("--folder", type=Path, default=ROOT / "report" / "mutants")
    options = parser.parse_args()
    covered = measure(ROOT, options.folder)
    drawn = _draw(options.only, options.count, options.seed)
    chosen = sorted({test for mutant in drawn for test in _tests(mutant, covered)})
    if not can_collect(chosen):
        parser.error(f"the tests have changed since {options.folder} was made: remove it")
    with ThreadPoolExecutor(options.workers) as pool:
        noticed = list(pool.map(lambda mutant: _told(mutant, covered), drawn))
    excused = _excused()
    lived = [mutant for mutant, seen in zip(drawn, noticed, strict=True) if not seen]
    equal = [mutant for mutant in lived if _key(mutant) in excused]
    print(f"{len(drawn)} mutants, {sum(noticed)} noticed, {len(equal)} equivalent")
    (options.folder / "lived.txt").write_text("".join(f"{mutant}\n" for mutant in lived))
    for mutant in lived:
        print(f"lives: {mutant}  {excused.get(_key(mutant), '')}")
    missed = len(lived) - len(equal)
    sys.exit(0 if missed <= 0.1 * max(len(drawn) - len(equal), 1) else 1)


def _draw(only: str, count: int, seed: int) -> list[Mutant]:
    paths = sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "nrchain").rglob("*.py"))
    every = [mutant for path in paths if only in path for mutant in mutants_of(ROOT, path)]
    return random.Random(seed).sample(every, min(count, len(every)))


def _excused() -> dict[tuple[str, str, str, str], str]:
    """Mutants that change no result, each with the reason."""
    table = tomllib.loads((HERE / "equivalent.toml").read_text(encoding="utf-8"))
    keys = ("path", "function", "before", "after")
    return {tuple(e[k] for k in keys): e["because"] for e in table.get("mutant", [])}


def _key(mutant: Mutant) -> tuple[str, str, str, str]:
    return mutant.path, mutant.function, mutant.before, mutant.after


def _told(mutant: Mutant, covered: Covered) -> bool:
    began, tests = time.monotonic(), _tests(mutant, covered)
    seen = bool(tests) and is_noticed(mutant, tests, 60.0 + PATIENCE * BUDGET)
    took = time.monotonic() - began
    print(f"{'noticed' if seen else 'LIVES  '} {took:5.1f} s  {mutant}", flush=True)
    return seen


def _tests(mutant: Mutant, covered: Covered) -> list[str]:
    lines = mutant.before.count("\n")
    return covered.tests(mutant.path, mutant.line, mutant.line + lines, BUDGET)


if __name__ == "__main__":
    main()
