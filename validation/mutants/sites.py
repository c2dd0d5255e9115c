"""One place of the source changed at a time: what a test suite has to notice.

Operators are swapped for their neighbours, comparisons turned round, numbers and truth values
changed, conditions negated, minima and maxima, any and all exchanged, and calls made for their
effect left out. Whether a bound itself belongs to a range is changed for whole numbers only: floats
hardly ever lie on one. Kernels are not touched: their machine code on disk would hide the change.
Nor are the named thresholds of a module: they are chosen, and a test that pins one tests nothing.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.USub: ast.UAdd,
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}

BOUNDS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
}

EXCHANGED = {"min": "max", "max": "min", "any": "all", "all": "any", "floor": "ceil"}

SKIPPED_KEYWORDS = {"stacklevel", "indent", "cache", "maxsize"}
"""Arguments that change no result."""

Change = Callable[[], None]


@dataclass(frozen=True)
class Mutant:
    """A change of one file: where, in which function, and the code before and after."""

    path: str
    number: int
    line: int
    function: str
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line} {self.function}: {self.before}  →  {self.after}"


@dataclass(frozen=True)
class _Site:
    node: ast.AST
    function: str
    change: Change


def mutants_of(root: Path, path: str) -> list[Mutant]:
    """Every mutant of a file, numbered in the order of the source."""
    source = (root / path).read_text(encoding="utf-8")
    found = []
    for number in range(len(_sites(ast.parse(source)))):
        site = _sites(ast.parse(source))[number]
        before = ast.unparse(site.node)
        site.change()
        after = ast.unparse(ast.fix_missing_locations(site.node))
        line = getattr(site.node, "lineno", 0)
        found.append(Mutant(path, number, line, site.function, before, after))
    return found


def mutated(source: str, number: int) -> ast.Module:
    """The syntax tree of a source with its mutant of that number."""
    tree = ast.parse(source)
    _sites(tree)[number].change()
    return ast.fix_missing_locations(tree)


def _sites(tree: ast.Module) -> list[_Site]:
    return list(_visit(tree, ""))


def _visit(node: ast.AST, function: str) -> Iterator[_Site]:
    for change in _changes(node):
        yield _Site(node, function, change)
    for child in _children(node):
        inside = function
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            if _is_compiled(child):
                continue
            inside = f"{function}.{child.name}".lstrip(".")
        yield from _visit(child, inside)


def _children(node: ast.AST) -> Iterator[ast.AST]:
    """The parts of a node in which a change may change a result."""
    skipped: list[ast.AST | None] = []
    if isinstance(node, ast.FunctionDef):
        arguments = node.args
        every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
        skipped = [*node.decorator_list, node.returns, *every, arguments.vararg, arguments.kwarg]
        yield from (default for default in arguments.defaults)
        yield from (default for default in arguments.kw_defaults if default is not None)
        skipped.append(arguments)
    elif isinstance(node, ast.ClassDef):
        skipped = list(node.decorator_list)
    elif isinstance(node, ast.Module):
        skipped = [part for part in node.body if _is_threshold(part)]
    elif _is_typing(node) or (isinstance(node, ast.keyword) and node.arg in SKIPPED_KEYWORDS):
        return
    yield from (child for child in ast.iter_child_nodes(node) if child not in skipped)


def _is_typing(node: ast.AST) -> bool:
    """Whether a node is there for type checkers alone."""
    if isinstance(node, ast.If):
        return ast.unparse(node.test) == "TYPE_CHECKING"
    return isinstance(node, ast.Subscript) and ast.unparse(node.value) == "Literal"


def _is_threshold(statement: ast.stmt) -> bool:
    """Whether a statement gives a number its name."""
    return (
        isinstance(statement, ast.Assign)
        and isinstance(statement.value, ast.Constant)
        and type(statement.value.value) in (int, float)
    )


def _is_compiled(node: ast.FunctionDef | ast.ClassDef) -> bool:
    """Whether a function is a kernel, or makes one of the functions within it."""
    if any(ast.unparse(d).startswith("kernel") for d in node.decorator_list):
        return True
    if isinstance(node, ast.ClassDef):
        return False
    names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
    return bool(names & {"kernel", "compile_sum", "prange"})


def _changes(node: ast.AST) -> Iterator[Change]:
    if isinstance(node, ast.BinOp | ast.BoolOp | ast.UnaryOp | ast.AugAssign):
        if isinstance(node, ast.BinOp) and _is_type(node):
            return
        if type(node.op) in OPERATORS:
            yield _set(node, "op", OPERATORS[type(node.op)]())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield _set(node, "operand", _negated(node.operand))
    elif isinstance(node, ast.Compare):
        for k, operator in enumerate(node.ops):
            if type(operator) in OPERATORS:
                yield _put(node.ops, k, OPERATORS[type(operator)]())
            if type(operator) in BOUNDS and any(map(_is_whole, (node.left, *node.comparators))):
                yield _put(node.ops, k, BOUNDS[type(operator)]())
    elif isinstance(node, ast.Constant):
        yield from _changed_constant(node)
    elif isinstance(node, ast.If | ast.While | ast.IfExp):
        if not _is_typing(node):
            yield _set(node, "test", _negated(node.test))
    elif isinstance(node, ast.Call):
        name = node.func
        if isinstance(name, ast.Name) and name.id in EXCHANGED:
            yield _set(name, "id", EXCHANGED[name.id])
        elif isinstance(name, ast.Attribute) and name.attr in EXCHANGED:
            yield _set(name, "attr", EXCHANGED[name.attr])
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield _set(node, "value", ast.Constant(None))


def _is_whole(node: ast.expr) -> bool:
    """Whether an expression is a whole number, as far as its text tells."""
    number = isinstance(node, ast.Constant) and type(node.value) is int
    return number or ast.unparse(node).startswith("len(")


def _is_type(node: ast.BinOp) -> bool:
    """Whether ``A | B`` joins types."""
    last = node.right
    named = isinstance(last, ast.Name) and last.id[:1].isupper()
    nothing = isinstance(last, ast.Constant) and last.value is None
    return isinstance(node.op, ast.BitOr) and (named or nothing)


def _changed_constant(node: ast.Constant) -> Iterator[Change]:
    if isinstance(node.value, bool):
        yield _set(node, "value", not node.value)
    elif isinstance(node.value, int):
        yield _set(node, "value", node.value + 1)
    elif isinstance(node.value, float):
        yield _set(node, "value", 2.0 * node.value if node.value else 1.0)


def _negated(condition: ast.expr) -> ast.expr:
    return ast.UnaryOp(ast.Not(), condition)


def _set(node: ast.AST, name: str, value: object) -> Change:
    return lambda: setattr(node, name, value)


def _put(items: list, place: int, value: ast.AST) -> Change:
    def change() -> None:
        items[place] = value

    return change
