"""python -m validation: exit codes, results.json, and what a second run keeps."""

import json
import math
from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure


def good(recorder):
    recorder.step("measuring")
    recorder.check("holds", 1.0, 1.0, 1e-9, source="Eq. (one)")
    recorder.benchmark("sum", 1.0, 3.0, what="a sum")
    recorder.table("numbers", ["n", "name"], [(1, "`one`")], "Numbers.", first_page=True)
    recorder.text("It **holds**.")
    figure = Figure(figsize=(1, 1))
    figure.subplots().plot([0, 1])
    recorder.figure("A line", figure, "From 0 to 1.")


def bad(recorder):
    recorder.check("holds", 1.0, 1.0, 1e-9, source="s")
    recorder.check("fails <here>", 1.0, complex(2.0, -1.0), 1e-9, source="s")


def undefined(recorder):
    recorder.check("is a number", 1.0, math.nan, 1e-9, source="s")


def raising(recorder):
    recorder.check("holds", 1.0, 1.0, 1e-9, source="s")
    raise RuntimeError("out of fluid")


def results(folder):
    return json.loads((folder / "results.json").read_text(encoding="utf-8"), parse_constant=refuse)


def refuse(constant):
    raise AssertionError(f"{constant} is no JSON")


def named(entries, study):
    return [entry for entry in entries if entry["study"] == study]


def test_all_passing_exits_zero_and_leaves_a_report(register, command, tmp_path):
    register(good=good)
    result = command("-o", tmp_path)
    assert result.exit_code == 0
    assert "✓ holds" in result.stdout
    assert (tmp_path / "index.html").exists()


def test_the_records_have_the_documented_keys(register, command, tmp_path):
    register(good=good)
    command("-o", tmp_path)
    found = results(tmp_path)
    assert found.keys() == {"checks", "benchmarks", "tables", "studies", "environment"}
    [check] = found["checks"]
    assert check == {
        "study": "good",
        "name": "holds",
        "kind": "check",
        "predicted": 1.0,
        "measured": 1.0,
        "error": 0.0,
        "tolerance": 1e-9,
        "passed": True,
        "source": "Eq. (one)",
    }
    [benchmark] = found["benchmarks"]
    assert {key: benchmark[key] for key in ("name", "ours", "theirs", "ratio", "what")} == {
        "name": "sum",
        "ours": 1.0,
        "theirs": 3.0,
        "ratio": 3.0,
        "what": "a sum",
    }
    assert found["tables"][0]["rows"] == [[1, "`one`"]]
    assert found["environment"]["libraries"]["numpy"]


@pytest.mark.parametrize("failing", [bad, undefined, raising])
def test_a_failure_exits_one_and_the_rest_still_runs(register, command, tmp_path, failing):
    register(failing=failing, good=good)
    result = command("-o", tmp_path)
    assert result.exit_code == 1
    found = results(tmp_path)
    assert not all(check["passed"] for check in named(found["checks"], "failing"))
    assert all(check["passed"] for check in named(found["checks"], "good"))
    assert "fail" in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_a_study_that_raises_is_a_failed_check_with_its_message(register, command, tmp_path):
    register(raising=raising)
    result = command("-o", tmp_path)
    holds, stopped = results(tmp_path)["checks"]
    assert holds["passed"]
    assert not stopped["passed"]
    assert "out of fluid" in stopped["source"]
    assert "out of fluid" in result.stdout
    assert "out of fluid" in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_a_module_that_cannot_be_imported_fails_its_study(register, command, tmp_path, monkeypatch):
    register(gone=good, good=good)
    monkeypatch.delitem(__import__("sys").modules, "stub_gone")
    assert command("-o", tmp_path).exit_code == 1
    assert "stub_gone" in named(results(tmp_path)["studies"], "gone")[0]["error"]


def test_complex_numbers_are_pairs_and_what_is_none_is_a_word(register, command, tmp_path):
    register(bad=bad, undefined=undefined)
    command("-o", tmp_path)
    checks = {check["name"]: check for check in results(tmp_path)["checks"]}
    assert checks["fails <here>"]["measured"] == [2.0, -1.0]
    assert checks["is a number"]["measured"] == "nan"


def test_an_unknown_study_exits_two_and_names_the_known(register, command, tmp_path):
    register(good=good, bad=bad)
    result = command("god", "-o", tmp_path / "report")
    assert result.exit_code == 2
    assert "'god'" in result.stderr
    assert "good, bad" in result.stderr
    assert not (tmp_path / "report").exists()


def test_rerunning_one_study_keeps_the_others(register, command, tmp_path):
    register(good=good, bad=bad)
    assert command("-o", tmp_path).exit_code == 1
    before = results(tmp_path)
    register(bad=good)
    assert command("bad", "-o", tmp_path).exit_code == 0
    after = results(tmp_path)
    for key in ("checks", "benchmarks", "tables", "studies"):
        assert named(after[key], "good") == named(before[key], "good")
    assert [check["name"] for check in named(after["checks"], "bad")] == ["holds"]
    assert [study["study"] for study in after["studies"]] == ["good", "bad"]
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert page.count("<figure>") == 2
    assert "fails" not in page


def test_records_of_studies_that_are_no_more_are_dropped(register, command, tmp_path):
    register(old=bad)
    command("-o", tmp_path)
    from validation.report.studies import STUDIES

    del STUDIES["old"]
    register(good=good)
    assert command("-o", tmp_path).exit_code == 0
    assert {check["study"] for check in results(tmp_path)["checks"]} == {"good"}


@pytest.mark.parametrize("text", ["", "[]", '{"checks": 3}'])
def test_a_foreign_results_file_is_not_overwritten(register, command, tmp_path, text):
    register(good=good)
    (tmp_path / "results.json").write_text(text)
    result = command("-o", tmp_path)
    assert result.exit_code == 2
    assert "results.json" in result.stderr
    assert (tmp_path / "results.json").read_text() == text


def test_quick_reaches_the_study(register, command, tmp_path):
    seen = []

    def study(recorder):
        seen.append(recorder.quick)

    register(study=study)
    command("-o", tmp_path)
    command("--quick", "-o", tmp_path)
    assert seen == [False, True]
    assert results(tmp_path)["studies"][0]["quick"] is True


def test_the_list_names_every_study(register, command):
    register(good=good, bad=bad)
    result = command("--list")
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [f"{n:<16}The study {n}" for n in ("good", "bad")]


class _Tags(HTMLParser):
    """Every element is closed, and nothing is loaded from elsewhere."""

    EMPTY = frozenset({"meta", "img", "br"})

    def __init__(self):
        super().__init__()
        self.open, self.sources = [], []

    def handle_starttag(self, tag, attributes):
        if tag not in self.EMPTY:
            self.open.append(tag)
        self.sources += [value for key, value in attributes if key == "src"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_stands_by_itself(register, command, tmp_path):
    register(good=good, bad=bad, raising=raising)
    command("-o", tmp_path)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    tags = _Tags()
    tags.feed(text)
    assert not tags.open
    assert len(tags.sources) == 1
    assert tags.sources[0].startswith("data:image/png;base64,")
    assert "<strong>holds</strong>" in text
    assert "fails &lt;here&gt;" in text
    assert "<code>one</code>" in text
