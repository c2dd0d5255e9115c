"""Examples of a command, shown below its help text, and the exit codes below that of nrchain."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from typer.core import TyperCommand

from nrchain.cli.exits import show

Command = TypeVar("Command", bound=Callable[..., None])

WIDTH = 76
"""Most columns of an example."""

EXIT_CODES = {
    0: "done",
    2: "refused, with one line on standard error",
    3: "the run stopped early; what it reached is kept",
    130: "interrupted; what is finished is kept",
    141: "the reader of the output is gone, as under | head",
}
"""What each exit code of nrchain says."""


def examples(*lines: str) -> Callable[[Command], Command]:
    """Give a command its examples: two or more command lines that a user can type."""

    def add(command: Command) -> Command:
        vars(command)["examples"] = lines
        return command

    return add


class CommandWithExamples(TyperCommand):
    """A command whose help text ends with its examples."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        super().format_help(ctx, formatter)
        show(*_lines("Examples", getattr(self.callback, "examples", ())), soft_wrap=True)


def show_exit_codes() -> None:
    """Print the exit codes, as the end of the help text of nrchain."""
    codes = (f"{code:<5}{what}" for code, what in EXIT_CODES.items())
    show(*_lines("Exit codes", codes), soft_wrap=True)


def _lines(title: str, lines: Iterable[str]) -> list[str]:
    return [f" {title}:", *(f"   {line}" for line in lines)]
