"""Which checks pass, which fail, and what is recorded."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from validation.report.recorder import Recorder

numbers = st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-6)


@pytest.fixture
def recorder():
    return Recorder("trial")


def last(recorder):
    return recorder.checks[-1]


def test_a_check_is_relative_to_what_is_predicted(recorder):
    assert recorder.check("near", 100.0, 100.9, 0.01, source="s")
    assert not recorder.check("far", 100.0, 101.1, 0.01, source="s")
    assert last(recorder).error == pytest.approx(0.011)
    assert [check.name for check in recorder.failed] == ["far"]


def test_a_check_against_zero_or_on_request_is_absolute(recorder):
    assert recorder.check("zero", 0, 1e-12, 1e-11, source="s")
    assert not recorder.check("more than zero", 0, 1e-10, 1e-11, source="s")
    assert recorder.check("absolute", 100.0, 100.5, 1.0, source="s", relative=False)


@given(numbers, st.floats(1e-6, 0.5), st.sampled_from([-1, 1]))
def test_a_check_holds_just_within_its_tolerance(predicted, tolerance, side):
    recorder = Recorder("trial")
    inside, outside = (predicted * (1 + side * tolerance * by) for by in (0.999, 1.001))
    assert recorder.check("inside", predicted, inside, tolerance, source="s")
    assert not recorder.check("outside", predicted, outside, tolerance, source="s")


@pytest.mark.parametrize("bad", [math.nan, math.inf, complex(math.nan, 0)])
def test_numbers_that_are_none_fail_everywhere(recorder, bad):
    assert not recorder.check("measured", 1.0, bad, 1e9, source="s")
    assert not recorder.check("predicted", bad, 1.0, 1e9, source="s") or math.isinf(abs(bad))
    assert not recorder.difference("difference", 1.0, bad, 0.5, source="s")


def test_nan_is_within_no_bounds(recorder):
    assert not recorder.bound("most", math.nan, most=1.0, source="s")
    assert not recorder.bound("least", math.nan, least=1.0, source="s")


def test_complex_numbers_count_with_both_parts(recorder):
    assert recorder.check("close", 1 + 1j, 1 + 1.001j, 1e-3, source="s")
    assert not recorder.check("turned", 1 + 1j, 1 - 1j, 1e-3, source="s")


def test_numbers_may_be_numpys_or_fractions(recorder):
    assert recorder.check("numpy", np.float32(2.0), np.array([2.0]), 0.0, source="s")
    assert recorder.check("fraction", Fraction(1, 2), np.complex128(0.5), 0.0, source="s")
    assert type(recorder.checks[0].measured) is float
    with pytest.raises(ValueError, match="size 1"):
        recorder.check("array", 0.0, np.zeros(2), 0.0, source="s")


def test_a_known_difference_passes_only_while_it_is_as_large(recorder):
    assert recorder.difference("as stated", -4.0, -4.0, 1e-3, source="s")
    assert not recorder.difference("gone", -4.0, 0.0, 1e-3, source="s")
    assert not recorder.difference("other sign", -4.0, 4.0, 1e-3, source="s")
    assert not recorder.difference("grown", -4.0, -4.1, 1e-3, source="s")


@pytest.mark.parametrize(("stated", "tolerance"), [(0.0, 0.1), (2.0, 1.0), (2.0, math.nan)])
def test_a_difference_that_nothing_could_fail_is_refused(recorder, stated, tolerance):
    with pytest.raises(ValueError, match="would pass without a difference"):
        recorder.difference("empty", stated, stated, tolerance, source="s")


def test_bounds_hold_on_both_sides(recorder):
    assert recorder.bound("inside", 2.0, least=1.9, most=2.1, source="s")
    assert not recorder.bound("above", 2.2, least=1.9, most=2.1, source="s")
    assert last(recorder).predicted == 2.1
    assert last(recorder).error == pytest.approx(0.1)
    assert not recorder.bound("below", 1.8, least=1.9, most=2.1, source="s")
    assert last(recorder).predicted == 1.9
    with pytest.raises(ValueError, match="least"):
        recorder.bound("none", 1.0, source="s")


def test_a_bar_that_is_missed_is_missed_by_as_much_as_stated(recorder):
    assert recorder.shortfall("as stated", 120.0, asked=250.0, reached=100.0, source="s")
    assert last(recorder).kind == "shortfall"
    assert last(recorder).name == "as stated (250 asked for)"
    assert not recorder.shortfall("worse", 49.0, asked=250.0, reached=100.0, source="s")
    assert not recorder.shortfall("out of date", 201.0, asked=250.0, reached=100.0, source="s")
    assert not recorder.shortfall("not a time", 0.0, asked=250.0, reached=100.0, source="s")
    assert not recorder.shortfall("lost", math.nan, asked=250.0, reached=100.0, source="s")
    with pytest.raises(ValueError, match="meets the bar"):
        recorder.shortfall("met", 2.0, asked=2.0, reached=2.0, source="s")


def test_two_checks_of_one_name_are_refused(recorder):
    recorder.check("one", 1, 1, 0, source="s")
    with pytest.raises(ValueError, match="'one'"):
        recorder.check("one", 1, 1, 0, source="s")


def test_a_benchmark_keeps_how_much_faster_we_are(recorder):
    recorder.benchmark("task", 0.5, 2.0, what="sum over pairs")
    assert recorder.benchmarks[0].ratio == 4.0
    assert recorder.benchmarks[0].unit == "s"


def test_a_table_has_one_entry_a_column(recorder):
    recorder.table("t", ["a", "b"], [(1, np.float64(2.0)), (None, "x")], "caption", True)
    assert recorder.tables[0].rows == ((1, 2.0), (None, "x"))
    with pytest.raises(ValueError, match="1 entries in 2 columns"):
        recorder.table("t", ["a", "b"], [(1,)], "caption")


def test_a_figure_is_kept_as_png(recorder):
    figure = Figure(figsize=(1, 1))
    figure.subplots().plot([0, 1])
    recorder.figure("line", figure, "A line.")
    assert recorder.pictures[0].png.startswith(b"\x89PNG")


def test_a_listener_hears_of_checks_and_steps():
    heard = []

    class Listener:
        def checked(self, check):
            heard.append(check.name)

        def stepped(self, description):
            heard.append(description)

    recorder = Recorder("trial", listener=Listener())
    recorder.step("begin")
    recorder.check("one", 1, 1, 0, source="s")
    assert heard == ["begin", "one"]
