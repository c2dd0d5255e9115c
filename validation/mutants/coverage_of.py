"""Which tests run each line of the package, and how long each test takes."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Covered:
    """The tests ``lines[path][line]`` that run a line, and the ``seconds[test]`` of each."""

    lines: dict[str, dict[int, list[str]]]
    seconds: dict[str, float]

    def tests(self, path: str, first: int, last: int, budget: float) -> list[str]:
        """The quickest tests of these lines, or else of the file, within a budget of seconds."""
        by_line = self.lines.get(path, {})
        found = {t for line in range(first, last + 1) for t in by_line.get(line, ()) if t}
        if not found:
            found = {test for tests in by_line.values() for test in tests if test}
        chosen: list[str] = []
        spent = 0.0
        for test in sorted(found, key=lambda test: (self.seconds.get(test, 0.1), test)):
            spent += self.seconds.get(test, 0.1)
            if chosen and spent > budget:
                break
            chosen.append(test)
        return chosen


def measure(root: Path, folder: Path) -> Covered:
    """Run the suite once under coverage, unless ``folder`` holds what an earlier run found."""
    folder.mkdir(parents=True, exist_ok=True)
    data, times = folder / "coverage.sqlite", folder / "times.xml"
    if not (data.exists() and times.exists()):
        settings = folder / "coveragerc"
        settings.write_text(f"[run]\ndata_file = {data}\n")
        subprocess.run(
            [
                *(sys.executable, "-m", "pytest", "--cov=nrchain", "--cov-context=test"),
                *(f"--cov-config={settings}", "--cov-report=", f"--junitxml={times}"),
            ],
            cwd=root,
            check=False,
        )
    return Covered(_lines(root, data), _seconds(times))


def _lines(root: Path, data: Path) -> dict[str, dict[int, list[str]]]:
    from coverage import CoverageData

    found = CoverageData(basename=str(data))
    found.read()
    lines: dict[str, dict[int, list[str]]] = {}
    for name in found.measured_files():
        path = Path(name).resolve().relative_to(root.resolve()).as_posix()
        by_line = found.contexts_by_lineno(name)
        lines[path] = {
            line: sorted({context.partition("|")[0] for context in contexts})
            for line, contexts in by_line.items()
        }
    return lines


def _seconds(times: Path) -> dict[str, float]:
    """Test by test: JUnit's class names are the paths of the files, with dots."""
    seconds: dict[str, float] = {}
    for case in xml.parse(times).getroot().iter("testcase"):
        if len(case.findall("failure") + case.findall("error")):
            raise RuntimeError(f"{case.get('name')} fails on the package as it is")
        file = case.get("classname", "").replace(".", "/") + ".py"
        seconds[f"{file}::{case.get('name')}"] = float(case.get("time", 0.0))
    return seconds
