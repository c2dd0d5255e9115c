"""Kernels that only kernels call reach the compiler's optimiser once, in the code that calls them.

Numba optimises every function and generates its machine code before it links the function into a
caller, where both happen again. With functions that call functions the same instructions are
optimised at every level, and machine code is made that never runs. A :class:`PartCompiler` stops at
instructions that can be linked: a kernel is optimised once, with all that it calls.
"""

from __future__ import annotations

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.cpu import _dynfunc
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering


class KernelFlags(Flags):
    """Options of a compilation, which Numba compares at every operation of a function."""

    def __hash__(self) -> int:
        return _HASH

    def __eq__(self, other: object) -> bool:
        if isinstance(other, KernelFlags):
            return self is other or self._values == other._values
        return super().__eq__(other)


_HASH = hash(Flags())


class KernelCompiler(Compiler):
    """Numba's compiler, with options that compare fast."""

    def __init__(
        self,
        typing: Any,
        target: Any,
        library: Any,
        arguments: Any,
        result: Any,
        flags: Any,
        local: Any,
    ) -> None:
        super().__init__(typing, target, library, arguments, result, KernelFlags(flags), local)


class PartLibrary(JITCodeLibrary):
    """Instructions of a function and of those it calls, to be linked into others."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Declare(LoweringPass):
    """Tell other kernels where to find a function without machine code."""

    _name = "nrchain_declare_part"

    def __init__(self) -> None:
        LoweringPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        lowered, library = state.cr, state.library
        described = lowered.fndesc
        place = _dynfunc.make_function(
            described.lookup_module(), described.qualname, "", 0, lowered.env, (library,)
        )
        state.targetctx.insert_user_function(place, described, [library])
        state.reload_init.extend(library._reload_init)
        state["cr"] = lowered._replace(cfunc=place)
        return True


class PartCompiler(KernelCompiler):
    """Numba's compiler, up to instructions that can be linked."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags.no_compile = True
        self.state.library = PartLibrary(self.state.targetctx.codegen(), "part")

    def define_pipelines(self) -> Any:
        (manager,) = super().define_pipelines()
        manager.add_pass_after(_Declare, NativeLowering)
        manager.finalize()
        return [manager]


class Kernel(CPUDispatcher):
    """A kernel that Python calls; other kernels link ``part``, unless it is compiled already."""

    part: Any

    @property
    def _numba_type_(self) -> Any:
        return super()._numba_type_ if self.overloads else self.part._numba_type_


def with_part(kernel: Any, part: Any) -> Kernel:
    """A kernel as Numba declares it, which other kernels call as this part."""
    kernel.__class__, kernel.part = Kernel, part
    return kernel
