"""What the site adds to Sphinx: pages of files above ``docs``, and public names room by room."""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType
from typing import Any

from sphinx.util.docutils import SphinxDirective

import nrchain

ROOT = Path(__file__).parents[1]

PROJECT = {
    f"project/{name.lower()}": f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG")
}
"""Pages that show a file of the repository, by its name."""


def show_project_file(app: Any, name: str, source: list[str]) -> None:
    """The text of README and its like, with links from their page; links to them from others."""
    up = "../" * name.count("/")
    if name in PROJECT:
        text = (ROOT / PROJECT[name]).read_text(encoding="utf-8")
        source[0] = re.sub(r"\]\((?!https?:|#)", "](../../", text).replace("](../../docs/", "](../")
    for page, file in PROJECT.items():
        source[0] = source[0].replace(f"]({up}../{file}", f"]({up}{page}.md")


def rewrite_docstring(
    app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Sections as lists of terms; |u| and left* are notation in a docstring, and no markup."""
    result: list[str] = []
    in_section = False
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if re.fullmatch("-{3,}", line):
            result[-1:] = [f".. rubric:: {result[-1]}", ""]
            in_section = True
        elif in_section and line and line[0] != " " and following.startswith("    "):
            result += ["", f"``{line}``"]
        elif line.lstrip().startswith(">>>"):
            result.append(line)
        else:
            result.append(escape_notation(line))
    lines[:] = result


def escape_notation(line: str) -> str:
    """A line of reStructuredText that shows what it says, but for literals and references."""
    parts = re.split(r"(``[^`]*``|:[\w:]+:`[^`]*`|`[^`]*`)", line)
    parts[::2] = [re.sub(r"([|*]|(?<=\w)_(?!\w))", r"\\\1", part) for part in parts[::2]]
    return "".join(parts)


def room_of(name: str) -> str:
    """The room of a public name: the folder of the package that holds it; "" for a ground file."""
    thing = getattr(nrchain, name)
    module = thing.__name__ if isinstance(thing, ModuleType) else thing.__module__
    _, room, *below = module.split(".")
    return room if below else ""


class PublicNames(SphinxDirective):
    """The docstrings of all public names of some rooms; of those without a page for ``others``."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[Any]:
        pages = Path(self.env.srcdir).glob("reference/*.md")
        named = {room for page in pages for room in rooms_of(page)}
        names = names_of(self.arguments[0].split(), named)
        lines = [line for name in names for line in documented(name)]
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def names_of(rooms: list[str], named: set[str]) -> list[str]:
    """Public names in some rooms; ``others`` are all rooms that no page names."""
    return [
        name
        for name in nrchain.__all__
        if room_of(name) in rooms or (rooms == ["others"] and room_of(name) not in named)
    ]


def rooms_of(page: Path) -> list[str]:
    """The rooms that a page of the reference names."""
    text = page.read_text(encoding="utf-8")
    return [
        room
        for rooms in re.findall(r"^```\{public-names\} (.*)$", text, re.M)
        for room in rooms.split()
    ]


def documented(name: str) -> list[str]:
    """Lines of a page that show a name and its members."""
    thing = getattr(nrchain, name)
    kind, target = "function", f"nrchain.{name}"
    options = []
    if isinstance(thing, ModuleType):
        kind, target = "module", thing.__name__
        options = [":members:", ":exclude-members: " + ", ".join(nrchain.__all__)]
    elif isinstance(thing, type):
        kind, options = "class", [":members:"]
        if issubclass(thing, BaseException):
            kind = "exception"
    options = [f"   {option}" for option in options]
    return [
        f"## nrchain.{name}",
        "",
        "```{eval-rst}",
        f".. auto{kind}:: {target}",
        *options,
        "```",
        "",
    ]


def setup(app: Any) -> dict[str, bool]:
    """What Sphinx calls."""
    app.connect("source-read", show_project_file)
    app.connect("autodoc-process-docstring", rewrite_docstring)
    app.add_directive("public-names", PublicNames)
    return {"parallel_read_safe": True}
