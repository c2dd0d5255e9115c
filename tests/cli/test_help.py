"""Every command says what it takes, in which units, and shows examples that it would accept."""

from __future__ import annotations

import inspect
import re
import shlex
from pathlib import Path

import pytest
import typer
from support.command_line import call

import nrchain
from nrchain.cli.app import app
from nrchain.cli.examples import EXIT_CODES, WIDTH

GROUP = typer.main.get_command(app)
COMMANDS = GROUP.commands

UNITS = re.compile(r"radi|seconds|units? of|by d\b|units")
"""What the help of an option with a decimal number names: the unit of the number."""


def examples(name):
    return COMMANDS[name].callback.examples


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_two_examples_that_it_accepts(name):
    assert len(examples(name)) >= 2
    for example in examples(name):
        assert len(example) <= WIDTH
        program, command, *words = shlex.split(re.split(r" [|>]", example)[0])
        assert (program, command) == ("nrchain", name)
        COMMANDS[name].make_context(name, words)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_the_examples_within_80_columns(name):
    shown = call(name, "--help")
    assert shown.exit_code == 0
    lines = [line.rstrip() for line in shown.stdout.rstrip().splitlines()]
    assert max(map(len, lines)) <= 80
    assert lines[-len(examples(name)) :] == [f"   {example}" for example in examples(name)]


@pytest.mark.parametrize("name", COMMANDS)
def test_options_that_take_decimal_numbers_name_their_units(name):
    arguments = inspect.signature(COMMANDS[name].callback).parameters
    takes_decimals = {one.name for one in arguments.values() if "float" in str(one.annotation)}
    for option in COMMANDS[name].params:
        if option.name in takes_decimals:
            assert UNITS.search(option.help), f"{name} {option.opts[0]}: {option.help}"


def test_the_help_of_nrchain_has_all_exit_codes():
    shown = call("--help")
    assert max(map(len, shown.stdout.splitlines())) <= 80
    for code, what in EXIT_CODES.items():
        assert f"   {code:<5}{what}" in shown.stdout


def test_the_docs_list_all_exit_codes():
    text = (Path(nrchain.__file__).parents[1] / "docs" / "running.md").read_text(encoding="utf-8")
    assert {int(code) for code in re.findall(r"^\| (\d+) \|", text, re.M)} == set(EXIT_CODES)
