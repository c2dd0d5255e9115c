"""Kernels that call others by address: what steps a chain is compiled once, whatever moves it.

A *term* adds one cause of motion to an array: machine code, or a Python function behind a callback.
All terms have one signature,

    status = f(context, positions, frames, out, width)

with addresses of contiguous arrays: a table of the term's own (int64), positions (N, 3), frames
(N, 3, 3), and the array it adds to, of wrenches or twists (N, 6) or of blocks
(N, 2 width + 1, 6, 6). The status is 0, or nonzero after an exception in Python.
"""

from __future__ import annotations

import ctypes
import math
import types as python_types
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from nrchain._compile import entry, rename

SIGNATURE = types.int32(*5 * (types.intp,))
_CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int32, *5 * (ctypes.c_ssize_t,))


def _call(
    typing: Any, function: Any, context: Any, positions: Any, frames: Any, out: Any, width: Any
) -> Any:
    """The status of the term at the address ``function``."""

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = arguments[0].type
        kind = ir.FunctionType(ir.IntType(32), 5 * [word]).as_pointer()
        return builder.call(builder.inttoptr(arguments[0], kind), arguments[1:])

    return types.int32(*6 * (types.intp,)), generate


call: Any = intrinsic(_call)
"""``call(function, context, positions, frames, out, width)``: the status of a term."""


def _pointer(element: Any, llvm: ir.Type) -> Any:
    def pointer(typing: Any, address: Any) -> Any:
        def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], llvm.as_pointer())

        return types.CPointer(element)(types.intp), generate

    # terms that differ in this alone have names of their own
    pointer.__name__ = f"pointer_to_{element}"
    return intrinsic(pointer)


floats_at: Any = _pointer(types.float64, ir.DoubleType())
"""A pointer to floats at an address, for :func:`carray` in kernels."""

integers_at: Any = _pointer(types.int64, ir.IntType(64))
"""A pointer to integers at an address, for :func:`carray` in kernels."""

_PAIR = ir.LiteralStructType([ir.DoubleType(), ir.DoubleType()])

complex_at: Any = _pointer(types.complex128, _PAIR)
"""A pointer to complex numbers at an address, for :func:`carray` in kernels."""

_ELEMENTS = {
    floats_at: (types.float64, ir.DoubleType()),
    integers_at: (types.int64, ir.IntType(64)),
    complex_at: (types.complex128, _PAIR),
}

ROW = 5
"""Integers in a table for each array: its address and the lengths of up to four axes."""


def table_of(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """(K, 5) addresses and shapes of contiguous arrays, by which compiled code finds them."""
    rows = []
    for array in arrays:
        if not array.flags.c_contiguous:
            raise ValueError("compiled code needs contiguous arrays")
        unused = (ROW - 1 - array.ndim) * (0,)
        rows.append((_data_address(array), *array.shape, *unused))
    return np.array(rows, np.int64).reshape(-1, ROW)


def _data_address(array: np.ndarray) -> int:
    """``array.ctypes.data`` in a third of the time: a run of a short chain needs many."""
    if array.size and array.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    return array.ctypes.data


def _packed(
    context: Any, builder: Any, kind: Any, address: Any, shape: Sequence[Any], size: int
) -> Any:
    """The contiguous array of this shape at an address, with elements of ``size`` bytes."""
    array = context.make_array(kind)(context, builder)
    strides = [ir.Constant(address.type, size)]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    data = builder.inttoptr(address, array.data.type)
    populate_array(array, data, shape, strides, strides[-1], meminfo=None)
    return array._getvalue()


def _carray(typing: Any, pointer: Any, shape: Any) -> Any:
    kind = types.Array(pointer.dtype, len(shape) if isinstance(shape, types.BaseTuple) else 1, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = builder.ptrtoint(arguments[0], context.get_value_type(types.intp))
        given: Any = shape if isinstance(shape, types.BaseTuple) else (shape,)
        lengths = [arguments[1]]
        if isinstance(shape, types.BaseTuple):
            lengths = cgutils.unpack_tuple(builder, arguments[1], len(shape))
        lengths = [
            context.cast(builder, length, integer, types.intp)
            for length, integer in zip(lengths, given, strict=True)
        ]
        size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        return _packed(context, builder, kind, address, lengths, size)

    return kind(pointer, shape), generate


carray: Any = intrinsic(_carray)
"""``carray(pointer, shape)``: the contiguous array at a pointer, as :func:`numba.carray`.

It is written out in its caller: Numba's own is compiled anew for every type and shape.
"""


def _address_of(typing: Any, array: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(array)(context, builder, arguments[0]).data
        return builder.ptrtoint(data, context.get_value_type(types.intp))

    return types.intp(array), generate


address_of: Any = intrinsic(_address_of)
"""``address_of(array)``: where its first element is."""


def _view(axes: int) -> Any:
    """The function of ``vector_in`` and others, for ``intrinsic``: written out in their callers."""

    def define(typing: Any, table: Any, k: Any, pointer: Any) -> Any:
        element, llvm = _ELEMENTS[pointer.typing_key]
        kind = types.Array(element, axes, "C")

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            rows = context.make_array(table)(context, builder, arguments[0])
            row = builder.mul(arguments[1], ir.Constant(arguments[1].type, ROW))
            address, *shape = (
                builder.load(builder.gep(rows.data, [builder.add(row, ir.Constant(row.type, m))]))
                for m in range(axes + 1)
            )
            return _packed(context, builder, kind, address, shape, context.get_abi_sizeof(llvm))

        return kind(table, types.intp, pointer), generate

    return intrinsic(define)


vector_in: Any = _view(1)
"""``vector_in(table, k, pointer)``: array k of a table, with one axis.

``pointer`` is :data:`floats_at` or another.
"""

matrix_in: Any = _view(2)
"""Array k of a table, with two axes."""

cube_in: Any = _view(3)
"""Array k of a table, with three axes."""

blocks_in: Any = _view(4)
"""Array k of a table, with four axes."""


@dataclass(frozen=True)
class Term:
    """One cause of motion by address: what adds it, what adds its blocks, and their table.

    ``keeps`` holds whatever the addresses refer to. ``add_far`` is 0 where blocks are the whole
    derivative. Otherwise ``add_far(context, poses, 0, out, -1)`` adds to ``out`` (N, 6) the product
    of ``poses`` (N, 6) with what the last blocks left out. It returns 0 if they left out nothing;
    with ``out`` = 0 it only tells.
    """

    add: int
    add_blocks: int
    context: np.ndarray
    keeps: tuple[Any, ...] = ()
    add_far: int = 0


def compile_term(function: Callable[..., int], **kernels: Any) -> Any:
    """Compile the ``function`` of a term; it refers to ``kernels`` by the names given here.

    Numba would not find a closure over a kernel in its cache again: kernels are globals.
    """
    return _compiled(function, tuple(kernels.items()))


@cache
def _compiled(function: Callable[..., int], kernels: tuple[tuple[str, Any], ...]) -> Any:
    names = {**function.__globals__, **dict(kernels)}
    bound = python_types.FunctionType(function.__code__, names, function.__name__)
    bound.__qualname__, bound.__module__ = function.__qualname__, function.__module__
    return entry(rename(bound, *(kernel.__name__ for _, kernel in kernels)), SIGNATURE)


class Callback:
    """Python code with the signature of a term: ``function(positions, frames, out, width)``.

    It gets addresses, see :func:`array_at`, and returns a status, None for 0. An exception becomes
    the status 1, which ends the compiled code that called it; :meth:`raise_error` raises it.
    """

    def __init__(self, function: Callable[[int, int, int, int], int | None]) -> None:
        self._function = function
        self._error: BaseException | None = None
        self._entry = _CALLBACK(self._call)

    @property
    def address(self) -> int:
        """Where compiled code calls it."""
        return ctypes.cast(self._entry, ctypes.c_void_p).value or 0

    def _call(self, context: int, positions: int, frames: int, out: int, width: int) -> int:
        try:
            return self._function(positions, frames, out, width) or 0
        except BaseException as error:
            self._error = error
            return 1

    def raise_error(self) -> None:
        """Raise the exception of the last call that failed, once."""
        error, self._error = self._error, None
        if error is not None:
            raise error


def array_at(address: int, shape: tuple[int, ...], kind: Any = float) -> np.ndarray:
    """The array of this shape, of floats or complex numbers, at an address."""
    size = math.prod(shape) * np.dtype(kind).itemsize
    return np.frombuffer((ctypes.c_char * size).from_address(address), kind).reshape(shape)
