"""The part of the README that is made from a report: its own lines, and no others."""

import json
from pathlib import Path

import pytest

from validation.report.build import ReportError
from validation.report.readme import BEGIN, END, FIGURES, update
from validation.report.studies import STUDIES

README = Path(__file__).parents[2] / "README.md"


@pytest.fixture
def report(tmp_path):
    """A report of full runs in which every study passed and one bar is not met."""
    folder = tmp_path / "report"
    (folder / "figures").mkdir(parents=True)
    shown = {study: name for study, name, _ in FIGURES}
    studies = [
        {
            "study": name,
            "title": study.title,
            "quick": False,
            "seconds": 2.0,
            "passed": 3,
            "failed": 0,
            "figures": [{"name": shown[name], "file": f"figures/{name}.png"}]
            if name in shown
            else [],
        }
        for name, study in STUDIES.items()
    ]
    for name in shown:
        (folder / "figures" / f"{name}.png").write_bytes(name.encode())
    bar = {"name": "slow (9 asked for)", "kind": "shortfall", "measured": 4.0, "source": "a | b"}
    task = {"name": "near run against the recipe", "ours": 0.5, "theirs": 2.0, "ratio": 4.0}
    reach = {
        "name": "What all pairs change",
        "columns": ["Wave", "limit", "sum", "lattice", "k"],
        "rows": [["2s", "ln", 4.5, 4.25, 3]],
    }
    write(folder, {"studies": studies, "checks": [bar], "benchmarks": [task], "tables": [reach]})
    return folder


def write(folder, results):
    (folder / "results.json").write_text(json.dumps(results), encoding="utf-8")


def test_what_lies_between_the_marks_is_replaced_and_nothing_else(tmp_path, report):
    readme = tmp_path / "README.md"
    readme.write_text(f"above\n{BEGIN}\nstale\n{END}\nbelow\n", encoding="utf-8")
    for _ in range(2):  # a second time changes nothing
        update(readme, report)
        text = readme.read_text(encoding="utf-8")
        assert text.startswith(f"above\n{BEGIN}\n")
        assert text.endswith(f"\n{END}\nbelow\n")
        assert "stale" not in text
        for line in (
            "| 2s | ln | 4.5 | 4.25 |",
            "| near run against the recipe | 500 ms | 2 s | 4 |",
            "| slow (9 asked for) | 4 | a \\| b |",
            f"| {STUDIES['cost'].title} | 3 of 3 | 2 s |",
        ):
            assert text.count(line) == 1
    for study, _, caption in FIGURES:
        assert f"![{caption}](validation/images/{study}.png)" in text
        copied = tmp_path / "validation" / "images" / f"{study}.png"
        assert copied.read_bytes() == study.encode()


def test_what_cannot_be_made_is_refused_and_leaves_the_readme(tmp_path, report):
    readme = tmp_path / "README.md"
    readme.write_text("no marks", encoding="utf-8")
    with pytest.raises(ReportError, match="two lines"):
        update(readme, report)
    marked = f"{BEGIN}\n{END}\n"
    readme.write_text(marked, encoding="utf-8")
    (report / "figures" / "cost.png").unlink()
    with pytest.raises(ReportError, match="no such figure"):
        update(readme, report)
    results = json.loads((report / "results.json").read_text(encoding="utf-8"))
    results["studies"][0]["quick"] = True
    write(report, results)
    with pytest.raises(ReportError, match="no full run of pair_laws"):
        update(readme, report)
    with pytest.raises(ReportError, match="not a report"):
        update(readme, tmp_path)
    assert readme.read_text(encoding="utf-8") == marked


def test_the_readme_shows_every_study():
    text = README.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    for study in STUDIES.values():
        assert study.title in text
