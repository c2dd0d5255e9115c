"""The command line: its commands, and one line for a command that is not understood.

The libraries that a command needs are imported when it runs: ``nrchain --help`` is immediate.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from nrchain.cli.branch import branch
from nrchain.cli.check import check
from nrchain.cli.cost import cost
from nrchain.cli.dispersion import dispersion
from nrchain.cli.effects import effects
from nrchain.cli.examples import CommandWithExamples, show_exit_codes
from nrchain.cli.exits import BROKEN_PIPE, REFUSED, report_unwritable_output, show
from nrchain.cli.export import export
from nrchain.cli.figure import figure
from nrchain.cli.phases import phases
from nrchain.cli.plan import plan
from nrchain.cli.plot import plot
from nrchain.cli.render import render
from nrchain.cli.resume import resume
from nrchain.cli.run import run
from nrchain.cli.scenes import scenes
from nrchain.cli.solid import solid
from nrchain.cli.spectrum import spectrum
from nrchain.cli.sweep import sweep
from nrchain.cli.terminal import discard_output, report, transliterate_output
from nrchain.version import __version__

_UsageError: Any = typer.BadParameter.__base__
"""The error of a command line that cannot be parsed; Typer has no public name for it."""


class _OneLineGroup(TyperGroup):
    """The commands, with one line for a command line that is not understood."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        super().format_help(ctx, formatter)
        show_exit_codes()

    def main(self, args: Sequence[str] | None = None, *given: Any, **options: Any) -> Any:
        words = sys.argv[1:] if args is None else list(args)
        options["standalone_mode"] = False
        options.setdefault("prog_name", "nrchain")
        try:
            code = super().main(words or ["--help"], *given, **options)
        except _UsageError as error:
            command = error.ctx.command_path if error.ctx else "nrchain"
            message = _in_our_words(" ".join(error.format_message().split()).rstrip("."))
            end = "" if message.endswith("?") else ";"
            report(f"{message}{end} see {command} --help")
            code = REFUSED
        except SystemExit as end:
            # Typer exits with 1 if the reader goes away while it prints a help text
            if not isinstance(end.__context__, BrokenPipeError):
                raise
            code = BROKEN_PIPE
        except OSError as error:
            discard_output()
            code = report_unwritable_output(error)
        sys.exit(code if isinstance(code, int) else 0)


WORDS = (
    ("Value error, ", ""),
    (", unable to parse string as a number", ""),
    (", unable to parse string as an integer", ""),
    ("Input should be a valid integer", "must be a whole number"),
    ("Input should be a valid number", "must be a number"),
    ("Input should be", "must be"),
)
"""Words of the libraries that read a command line, and what stands in their place."""


def _in_our_words(message: str) -> str:
    for theirs, ours in WORDS:
        message = message.replace(theirs, ours)
    return message


app = typer.Typer(
    name="nrchain",
    help="Simulate chains of active colloids with nonreciprocal interactions.",
    cls=_OneLineGroup,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in (
    run,
    check,
    plan,
    resume,
    scenes,
    effects,
    plot,
    figure,
    export,
    render,
    cost,
    solid,
    dispersion,
    spectrum,
    phases,
    branch,
    sweep,
):
    app.command(cls=CommandWithExamples)(command)


def _show_version(wanted: bool) -> None:
    if wanted:
        show(f"nrchain {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line with the arguments of the process."""
    transliterate_output()
    try:
        app()
    finally:
        try:
            if sys.stdout is not None:
                sys.stdout.flush()
        except OSError as error:
            discard_output()
            report_unwritable_output(error)
