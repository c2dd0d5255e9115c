"""The results in the README and in docs/validation.md: made from a report, between two marks."""

import json
from pathlib import Path

import pytest

from validation.report.build import ReportError
from validation.report.readme import BEGIN, DETAILS, END, FIGURES, README, update
from validation.report.studies import STUDIES

ROOT = Path(__file__).parents[2]


@pytest.fixture
def report(tmp_path):
    """A report of full runs in which every study passed and one bar is not met."""
    folder = tmp_path / "report"
    (folder / "figures").mkdir(parents=True)
    shown = [(study, name) for study, name, _ in FIGURES]
    studies = [
        {
            "study": name,
            "title": study.title,
            "quick": False,
            "seconds": 2.0,
            "passed": 3,
            "failed": 0,
            "figures": [
                {"name": figure, "file": f"figures/{name}-{figure}.png"}
                for of, figure in shown
                if of == name
            ],
        }
        for name, study in STUDIES.items()
    ]
    for name, figure in shown:
        (folder / "figures" / f"{name}-{figure}.png").write_bytes(figure.encode())
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


@pytest.fixture
def root(tmp_path):
    """A folder with the two pages."""
    for page in (README, DETAILS):
        (tmp_path / page).parent.mkdir(exist_ok=True)
        (tmp_path / page).write_text(f"above\n{BEGIN}\nstale\n{END}\nbelow\n", encoding="utf-8")
    return tmp_path


def text_of(page):
    return page.read_text(encoding="utf-8")


def test_what_lies_between_the_marks_is_replaced_and_nothing_else(root, report):
    for _ in range(2):  # a second time changes nothing
        update(root, report)
        for page in (README, DETAILS):
            text = text_of(root / page)
            assert text.startswith(f"above\n{BEGIN}\n")
            assert text.endswith(f"\n{END}\nbelow\n")
            assert "stale" not in text
        assert text_of(root / README).count(f"| {STUDIES['cost'].title} | 3 of 3 | 2 s |") == 1
        for line in (
            "| 2s | ln | 4.5 | 4.25 |",
            "| near run against the recipe | 500 ms | 2 s | 4 |",
            "| slow (9 asked for) | 4 | a \\| b |",
        ):
            assert text_of(root / DETAILS).count(line) == 1
    for study, figure, caption in FIGURES:
        assert f"![{caption}](validation/images/{study}-{figure}.png)" in text_of(root / README)
        copied = root / "validation" / "images" / f"{study}-{figure}.png"
        assert copied.read_bytes() == figure.encode()


@pytest.mark.parametrize("page", [README, DETAILS])
def test_a_page_without_marks_is_refused_and_neither_page_changes(page, root, report):
    (root / page).write_text("no marks", encoding="utf-8")
    before = [text_of(root / p) for p in (README, DETAILS)]
    with pytest.raises(ReportError, match=f"{page.name}: must have the two lines"):
        update(root, report)
    assert [text_of(root / p) for p in (README, DETAILS)] == before


def test_a_report_that_is_not_complete_is_refused_and_leaves_the_pages(root, report):
    before = text_of(root / README)
    next((report / "figures").glob("cost-*.png")).unlink()
    with pytest.raises(ReportError, match="no such figure"):
        update(root, report)
    results = json.loads((report / "results.json").read_text(encoding="utf-8"))
    results["studies"][0]["quick"] = True
    write(report, results)
    with pytest.raises(ReportError, match="no full run of pair_laws"):
        update(root, report)
    with pytest.raises(ReportError, match="not a report"):
        update(root, root)
    assert text_of(root / README) == before


def test_the_readme_shows_every_study():
    text = text_of(ROOT / README).partition(BEGIN)[2].partition(END)[0]
    for study in STUDIES.values():
        assert study.title in text
