"""results.json and index.html: the results of the studies, kept from run to run.

A new run of a study replaces its own records and keeps those of the others. Figures are PNG files
beside results.json; the page contains them and is one self-contained file.
"""

from __future__ import annotations

import json
import math
import os
import platform
import re
from dataclasses import asdict
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from validation.report.studies import STUDIES, Outcome

RESULTS, PAGE, FIGURES = "results.json", "index.html", "figures"
LISTS = ("checks", "benchmarks", "tables", "studies")
LIBRARIES = ("numpy", "scipy", "numba", "pystokes", "scikit-sundae", "h5py", "matplotlib")


class ReportError(Exception):
    """A report folder that cannot be extended."""


class Report:
    """The report in a folder: the records of the last run of each study.

    ``results`` is what results.json holds: the lists ``checks``, ``benchmarks``, ``tables`` and
    ``studies``, whose entries name their study, and ``environment``, of the last run. Complex
    numbers are pairs [re, im]; numbers that are not finite are the strings "nan", "inf", "-inf".
    Raises :class:`ReportError` if the folder has a results.json of another kind.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.results: dict[str, Any] = {key: [] for key in LISTS}
        path = folder / RESULTS
        if path.exists():
            try:
                old = json.loads(path.read_text(encoding="utf-8"))
                self.results = {key: _known(old[key]) for key in LISTS}
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                raise ReportError(f"{path}: not a report of these studies ({error!r})") from None
        self.results["environment"] = environment()

    def add(self, outcome: Outcome) -> None:
        """Replace the records of a study, and write file and page."""
        recorder = outcome.recorder
        new: dict[str, list[Any]] = {
            "checks": [asdict(check) for check in recorder.checks],
            "benchmarks": [asdict(benchmark) for benchmark in recorder.benchmarks],
            "tables": [asdict(table) for table in recorder.tables],
            "studies": [self._summary(outcome)],
        }
        for key in LISTS:
            kept = [entry for entry in self.results[key] if entry["study"] != recorder.study]
            order = list(STUDIES)
            self.results[key] = sorted(
                kept + _plain(new[key]), key=lambda entry: order.index(entry["study"])
            )
        self._write()

    def _summary(self, outcome: Outcome) -> dict[str, Any]:
        recorder = outcome.recorder
        return {
            "study": recorder.study,
            "title": STUDIES[recorder.study].title,
            "quick": recorder.quick,
            "seconds": round(outcome.seconds, 3),
            "finished": datetime.now(UTC).isoformat(timespec="seconds"),
            "passed": len(recorder.checks) - len(recorder.failed),
            "failed": len(recorder.failed),
            "error": outcome.error,
            "text": recorder.paragraphs,
            "figures": [
                {
                    "name": picture.name,
                    "caption": picture.caption,
                    "file": self._keep(recorder.study, picture.name, picture.png),
                }
                for picture in recorder.pictures
            ],
        }

    def _keep(self, study: str, name: str, png: bytes) -> str:
        stem = re.sub(r"[^a-z0-9]+", "-", f"{study}-{name}".lower()).strip("-")
        path = self.folder / FIGURES / f"{stem}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(png)
        return f"{FIGURES}/{path.name}"

    def _write(self) -> None:
        from validation.report.page import page

        self.folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(self.results, indent=1, ensure_ascii=False, allow_nan=False)
        _replace(self.folder / RESULTS, text + "\n")
        _replace(self.folder / PAGE, page(self.results, self.folder))


def environment() -> dict[str, Any]:
    """The machine and the versions of the libraries."""
    import nrchain

    return {
        "nrchain": nrchain.__version__,
        "python": platform.python_version(),
        "libraries": {name: _version(name) for name in LIBRARIES},
        "platform": platform.platform(),
        "processors": os.cpu_count(),
    }


def _version(library: str) -> str | None:
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return None


def _known(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [entry for entry in entries if entry["study"] in STUDIES]


def _plain(value: Any) -> Any:
    """The value as JSON types."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _replace(path: Path, text: str) -> None:
    """Write a file atomically: a reader sees either the old file or the new one."""
    draft = path.with_name(path.name + ".new")
    draft.write_text(text, encoding="utf-8")
    draft.replace(path)
