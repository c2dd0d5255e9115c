"""Operations of a compiled function, counted in its typed source, whatever the processor."""

from collections import Counter
from functools import cache

import numba
from numba import types

OPERATIONS = ("binop", "inplace_binop", "unary")


@cache
def count_operations(function, signature):
    """Arithmetic on real numbers, as ``""``, and calls of kernels by name, of a Python function.

    Of what is left of its text for arguments of these types, once branches on constants are
    decided: every place counts once, in loops too, and what a call does counts at each place.
    """
    fresh = numba.njit(function, error_model="numpy")
    fresh.compile(signature)
    notes = fresh.overloads[signature].type_annotation
    total = Counter()
    for expression, typed in notes.calltypes.items():
        kind = getattr(expression, "op", None)
        if kind in OPERATIONS and isinstance(typed.return_type, types.Float):
            total[""] += 1
        elif kind == "call":
            called = notes.typemap[expression.func.name]
            if isinstance(called, types.Dispatcher):
                inner = called.dispatcher.py_func
                total[inner.__module__.rpartition(".")[2]] += 1
                total.update(count_operations(inner, typed.args))
    return total
