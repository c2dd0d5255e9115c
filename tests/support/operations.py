"""Operations of a kernel, counted in its typed source, whatever the processor."""

from collections import Counter
from functools import cache
from types import SimpleNamespace

from numba import types
from numba.core import compiler, compiler_machinery
from numba.core.registry import cpu_target

OPERATIONS = ("binop", "inplace_binop", "unary")


@cache
def count_operations(function, signature):
    """Arithmetic on real numbers, as ``""``, and calls of kernels by name, of a Python function.

    Of what is left of its text for arguments of these types, once branches on constants are
    decided: every place counts once, in loops too, and what a call does counts at each place.
    """
    notes = typed_source(function, signature)
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


def typed_source(function, signature):
    """The types of all calls and variables of a function, for which no machine code is made."""
    flags = compiler.Flags()
    flags.nrt, flags.error_model = True, "numpy"
    contexts = cpu_target.typing_context, cpu_target.target_context
    options = {"return_type": None, "flags": flags, "locals": {}, "pipeline_class": _Typing}
    return compiler.compile_extra(*contexts, function, signature, **options)


@compiler_machinery.register_pass(mutates_CFG=False, analysis_only=True)
class _KeepTypes(compiler_machinery.FunctionPass):
    """Takes the types as the result of the compilation."""

    _name = "keep_types"

    def __init__(self):
        super().__init__()

    def run_pass(self, state):
        state.cr = SimpleNamespace(calltypes=state.calltypes, typemap=state.typemap)
        return False


class _Typing(compiler.CompilerBase):
    """The passes of Numba up to the rewriting of typed code."""

    def define_pipelines(self):
        passes = compiler_machinery.PassManager("typing")
        builder = compiler.DefaultPassBuilder
        for define in (builder.define_untyped_pipeline, builder.define_typed_pipeline):
            passes.passes.extend(define(self.state).passes)
        passes.add_pass(_KeepTypes, "keep the types")
        passes.finalize()
        return [passes]
