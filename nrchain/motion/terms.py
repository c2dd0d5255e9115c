"""(v, ω) = μ·(F, T) + Σ (u, w) by address: the terms of a model, for compiled code.

Elasticity and slip are terms in machine code, and so are every effect that provides one and the
friction between near neighbours. Other effects are called in Python. With friction that reaches
farther, or between clamped spheres, the whole model is one term in Python.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from nrchain._addresses import (
    Callback,
    Term,
    address_of,
    array_at,
    blocks_in,
    call,
    floats_at,
    integers_at,
    matrix_in,
    vector_in,
)
from nrchain._compile import constants, part
from nrchain.effects.base import Effect
from nrchain.motion.mobility import divide, divide_blocks
from nrchain.motion.pose_model import PoseModel


class Terms(NamedTuple):
    """The terms of a model as tables of addresses, and what turns wrenches into twists.

    Attributes
    ----------
    wrenches, twists
        (K, 2) integers: what adds (F, T) or (v, ω), and its table.
    wrench_blocks, twist_blocks
        (K, 2): what adds their derivatives, and its table.
    carrying_wrenches, carrying_twists
        (K, 2): as the first, for slip, fields and flows alone.
    drag
        γ_T and γ_R.
    held
        (N,) integers, 1 for clamped spheres.
    flags
        (3,): whether a sphere is clamped, whether terms depend on places in the lab, and whether
        frames are coupled.
    far
        (K, 2): what adds to a change of (F, T) beyond blocks, and its table.
    friction
        (1, 3): what applies the mobility of near neighbours, what adds its blocks, and its table;
        (0, 3) with one-body friction.
    wrenched, wrench_blocks_of
        (N, 6) and (N, 2w + 1, 6, 6): scratch for (F, T) and their derivatives with friction.
    """

    wrenches: np.ndarray
    twists: np.ndarray
    wrench_blocks: np.ndarray
    twist_blocks: np.ndarray
    carrying_wrenches: np.ndarray
    carrying_twists: np.ndarray
    drag: np.ndarray
    held: np.ndarray
    flags: np.ndarray
    far: np.ndarray
    friction: np.ndarray
    wrenched: np.ndarray
    wrench_blocks_of: np.ndarray


# Places of these tables among the arrays of a chain, after those of its chart.
(
    WRENCHES,
    TWISTS,
    WRENCH_BLOCKS,
    TWIST_BLOCKS,
    CARRYING_WRENCHES,
    CARRYING_TWISTS,
    DRAG,
    HELD,
    FLAGS,
    FAR,
    FRICTION,
    WRENCHED,
    WRENCH_BLOCKS_OF,
) = constants(range(13, 26))

(NO_BLOCKS,) = constants([-1])
"""The width of terms that add wrenches or twists."""


@part
def _call_all(t, which, positions, frames, out, width):
    """Call every term of a table; returns the first status that is not 0."""
    terms = matrix_in(t, which, integers_at)
    for k in range(terms.shape[0]):
        status = call(terms[k, 0], terms[k, 1], positions, frames, out, width)
        if status:
            return status
    return 0


@part
def _set_wrenches(t, wrenches, positions, frames):
    """Set (F, T) of the terms of a table in the scratch space; returns a status."""
    matrix_in(t, WRENCHED, floats_at)[:] = 0.0
    return _call_all(t, wrenches, positions, frames, t[WRENCHED, 0], NO_BLOCKS)


@part
def _add_friction_blocks(t, positions, frames, blocks):
    """blocks += the derivative of μ·(F, T); returns a status."""
    own = blocks_in(t, WRENCH_BLOCKS_OF, floats_at)
    own[:] = 0.0
    status = _call_all(t, WRENCH_BLOCKS, positions, frames, address_of(own), own.shape[1] // 2)
    if not status:
        status = _set_wrenches(t, WRENCHES, positions, frames)
    if status:
        return status
    friction, width = matrix_in(t, FRICTION, integers_at), blocks.shape[1] // 2
    at = friction[0, 1], friction[0, 2]
    return call(at[0], at[1], positions, t[WRENCHED, 0], address_of(blocks), width)


@part
def _fill(t, wrenches, twists, positions, frames, out):
    """out (N, 6) = the sum of the terms of two tables, wrenches with friction; returns a status."""
    out[:] = 0.0
    if t[wrenches, 1] and t[FRICTION, 1]:
        status = _set_wrenches(t, wrenches, positions, frames)
        if status:
            return status
        friction = matrix_in(t, FRICTION, integers_at)
        call(friction[0, 0], friction[0, 2], positions, t[WRENCHED, 0], address_of(out), NO_BLOCKS)
    elif t[wrenches, 1]:
        status = _call_all(t, wrenches, positions, frames, address_of(out), NO_BLOCKS)
        if status:
            return status
        drag = vector_in(t, DRAG, floats_at)
        divide(out, drag[0], drag[1])
    return _call_all(t, twists, positions, frames, address_of(out), NO_BLOCKS)


@part
def set_twists(t, positions, frames, twists):
    """twists (N, 6) = (v, ω) at poses at these addresses, 0 for clamped spheres; returns a status.

    ``t`` is the table of a chain; see :mod:`nrchain.motion.moving_chart`.
    """
    status = _fill(t, WRENCHES, TWISTS, positions, frames, twists)
    if vector_in(t, FLAGS, integers_at)[0]:
        held = vector_in(t, HELD, integers_at)
        for i in range(twists.shape[0]):
            if held[i]:
                twists[i] = 0.0
    return status


@part
def set_carrying_twists(t, positions, frames, twists):
    """twists (N, 6) = (v, ω) of slip, fields and flows alone; returns a status."""
    return _fill(t, CARRYING_WRENCHES, CARRYING_TWISTS, positions, frames, twists)


@part
def set_blocks(t, positions, frames, blocks):
    """blocks (N, 2w + 1, 6, 6) = ∂(v, ω)_i/∂(u, φ)_{i+m−w}; returns a status."""
    blocks[:] = 0.0
    width = blocks.shape[1] // 2
    if t[WRENCH_BLOCKS, 1] and t[FRICTION, 1]:
        status = _add_friction_blocks(t, positions, frames, blocks)
        if status:
            return status
    elif t[WRENCH_BLOCKS, 1]:
        status = _call_all(t, WRENCH_BLOCKS, positions, frames, address_of(blocks), width)
        if status:
            return status
        drag = vector_in(t, DRAG, floats_at)
        divide_blocks(blocks, drag[0], drag[1])
    return _call_all(t, TWIST_BLOCKS, positions, frames, address_of(blocks), width)


@part
def add_far(t, poses, out):
    """out (N, 6) = the change of the twists with ``poses`` (N, 6) that blocks leave out.

    Returns whether there is any.
    """
    found = 0
    out[:] = 0.0
    far = matrix_in(t, FAR, integers_at)
    for k in range(far.shape[0]):
        found |= call(far[k, 0], far[k, 1], address_of(poses), 0, address_of(out), NO_BLOCKS)
    drag = vector_in(t, DRAG, floats_at)
    divide(out, drag[0], drag[1])
    held = vector_in(t, HELD, integers_at)
    for i in range(out.shape[0]):
        if held[i]:
            out[i] = 0.0
    return found != 0


class ModelTerms:
    """The :class:`Terms` of a model, with all that their addresses refer to."""

    def __init__(self, model: PoseModel) -> None:
        self._callbacks: list[Callback] = []
        self._count = model.count
        is_whole = bool(model.friction) and not model.is_near
        wrenches, twists, carrying = self._whole(model) if is_whole else self._each(model)
        blocks: Carrying = wrenches, twists
        if not model.is_near:
            # products with the derivative need all of it to be taken at one place
            blocks = [], [self._in_python(model.twists, model.linearise)]
        own = np.zeros((model.count, 2 * model.wrench_reach + 1, 6, 6))
        friction = [model.friction.term(own)] if model.friction and model.is_near else []
        self._kept = *friction, *wrenches, *twists, *blocks[1], *carrying[1]
        self.tables = Terms(
            wrenches=_table((term.add, term) for term in wrenches),
            twists=_table((term.add, term) for term in twists),
            wrench_blocks=_table((term.add_blocks, term) for term in blocks[0]),
            twist_blocks=_table((term.add_blocks, term) for term in blocks[1]),
            carrying_wrenches=_table((term.add, term) for term in carrying[0]),
            carrying_twists=_table((term.add, term) for term in carrying[1]),
            drag=np.array(model.drag),
            held=model.held.astype(np.int64),
            flags=np.array([model.held.any(), model.needs_places, model.ties_frames], np.int64),
            far=_table((term.add_far, term) for term in blocks[0] if term.add_far),
            friction=np.array(
                [(f.add, f.add_blocks, f.context.ctypes.data) for f in friction], np.int64
            ).reshape(-1, 3),
            wrenched=np.zeros((model.count, 6)),
            wrench_blocks_of=own,
        )

    def raise_error(self) -> None:
        """Raise the exception of the Python term that failed last."""
        for callback in self._callbacks:
            callback.raise_error()

    def _whole(self, model: PoseModel) -> tuple[list[Term], list[Term], Carrying]:
        def add_carrying(positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
            twists += model.carrying_twists(positions, frames)

        whole = self._in_python(model.twists, model.linearise)
        return [], [whole], ([], [self._in_python(add_carrying, model.linearise)])

    def _each(self, model: PoseModel) -> tuple[list[Term], list[Term], Carrying]:
        wrenches, twists = list[Term](), list[Term]()
        carrying: Carrying = [], []
        if model.elasticity:
            wrenches.append(model.elasticity.term(model.count))
        if model.slip:
            term = model.slip.term()
            twists.append(term or self._in_python(model.slip.add_twists, model.linearise_slip))
            carrying[1].append(twists[0])
        for effect in model.further_effects:
            wrench = effect.gives == "wrench"
            term = effect.term() or self._of_effect(effect, wrench)
            (wrenches if wrench else twists).append(term)
            if effect.carries:
                carrying[0 if wrench else 1].append(effect.carrying_term() or term)
        return wrenches, twists, carrying

    def _of_effect(self, effect: Effect, wrench: bool) -> Term:
        def add_blocks(positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
            effect.linearise(positions, frames)
            effect.add_blocks(blocks)

        return self._in_python(effect.add_wrenches if wrench else effect.add_twists, add_blocks)

    def _in_python(self, add: Callable[..., object], add_blocks: Callable[..., object]) -> Term:
        count = self._count

        def adding(function: Callable[..., object]) -> Callback:
            def add_at(positions: int, frames: int, out: int, width: int) -> None:
                shape = (count, 6) if width < 0 else (count, 2 * width + 1, 6, 6)
                places, axes = array_at(positions, (count, 3)), array_at(frames, (count, 3, 3))
                function(places, axes, array_at(out, shape))

            return Callback(add_at)

        callbacks = adding(add), adding(add_blocks)
        self._callbacks += callbacks
        first, second = (callback.address for callback in callbacks)
        return Term(first, second, np.zeros(1, np.int64), callbacks)


Carrying = tuple[list[Term], list[Term]]
"""Terms of wrenches, and of twists, that may carry the chain as a whole."""


def _table(rows: Iterable[tuple[int, Term]]) -> np.ndarray:
    return np.array([(a, t.context.ctypes.data) for a, t in rows], np.int64).reshape(-1, 2)
