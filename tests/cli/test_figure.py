"""``nrchain figure``: which files it writes, what it says, and what it refuses."""

import json

import pytest
from support.command_line import assert_refused, call

from nrchain.cli.exits import REFUSED
from nrchain.cli.figure import chosen_figures
from nrchain.figures.catalogue import NUMBERS


def test_a_figure_is_written_and_says_what_it_was_checked_against(tmp_path):
    options = ("-o", tmp_path / "paper", "--width", "one", "--format", "svg", "--title")
    answer = call("figure", "3", *options)
    assert answer.exit_code == 0, answer.stderr
    path = tmp_path / "paper" / "figure-3.svg"
    assert path.read_text().startswith("<?xml")
    assert answer.stdout.splitlines()[0] == str(path)
    assert "2s: entries are in units of 0.0467 γ_T V" in answer.stdout
    assert max(map(len, answer.stdout.splitlines()[1:])) <= 80


def test_what_exists_is_replaced_only_on_request_and_before_time_is_spent(tmp_path):
    mine = tmp_path / "figure-7.pdf"
    mine.write_bytes(b"dear")
    # of all figures, none is drawn
    assert_refused(call("figure", "all", "-o", tmp_path), mine, "--overwrite")
    assert [path.name for path in tmp_path.iterdir()] == ["figure-7.pdf"]
    assert mine.read_bytes() == b"dear"
    (tmp_path / "figure-3.pdf").write_bytes(b"old")
    shown = call("figure", "3", "-o", tmp_path, "--overwrite", "--json")
    (record,) = json.loads(shown.stdout)["figures"]
    assert (record["number"], record["picture"]) == ("3", str(tmp_path / "figure-3.pdf"))
    assert any(line.startswith("2s: entries") for line in record["remarks"])
    assert (tmp_path / "figure-3.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    "words",
    [
        ("2",),
        ("3", "--width", "three"),
        ("3", "--format", "gif"),
        ("four",),
        ("1,2",),
        ("5-3",),
        ("1-all",),
        ("3,",),
    ],
)
def test_other_figures_and_formats_are_refused(tmp_path, words):
    answer = call("figure", *words, "-o", tmp_path)
    assert answer.exit_code == REFUSED
    assert "Value error" not in answer.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("given", "found"),
    [
        (["1,4"], ["1", "4"]),
        (["1", "4"], ["1", "4"]),
        (["1,3-5"], ["1", "3", "4", "5"]),
        (["1,3,4...7"], ["1", "3", "4", "5", "6", "7"]),
        (["7", "4…7", "4"], ["4", "5", "6", "7"]),
        (["4", "all"], list(NUMBERS)),
    ],
)
def test_lists_and_ranges_name_figures(given, found):
    assert chosen_figures(given) == found


def test_each_figure_of_a_list_is_refused_where_its_file_exists(tmp_path):
    (tmp_path / "figure-4.pdf").write_bytes(b"mine")
    assert_refused(call("figure", "3,4", "-o", tmp_path), tmp_path / "figure-4.pdf", "--overwrite")


@pytest.mark.slow
def test_all_figures_are_drawn(tmp_path):
    answer = call("figure", "all", "-o", tmp_path, "--format", "png")
    assert answer.exit_code == 0, answer.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"figure-{n}.png" for n in NUMBERS]
    assert all(path.stat().st_size > 50_000 for path in tmp_path.iterdir())
