"""ẏ = f(t, y) of a chain by address: the equation that compiled steps of Radau IIA integrate.

Every function gets the address of one table, with the arrays of a chart, of the terms of a model,
of what steps share, of a Jacobian and its factors, and of the search for contacts. y is (6N,), for
all spheres in their order along the chain, and zero for clamped spheres.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from nrchain._addresses import (
    ROW,
    blocks_in,
    call,
    carray,
    compile_term,
    complex_at,
    cube_in,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import inlined, part
from nrchain.motion.bend import BendCheck, is_bent
from nrchain.motion.block_elimination import Elimination
from nrchain.motion.chart_poses import room_to_turn
from nrchain.motion.charts import ChartedChain
from nrchain.motion.clearance import Clearance, is_clear
from nrchain.motion.integrators.base import StepChecks
from nrchain.motion.integrators.radau_steps import (
    AT,
    BEGIN,
    COMPONENTS,
    CONTEXT,
    COUNTS,
    END,
    EPSILON,
    FACTORISE,
    FIXED,
    FUNCTIONS,
    LENGTH,
    LINEARISE,
    LOOK,
    NUMBERS,
    PAST,
    PAST_NODES,
    POSES,
    PREDICTED,
    RATES,
    RENEW,
    ROOM,
    ROUNDING,
    RTOL,
    SCALE,
    SINGULAR,
    SOLVE_PAIR,
    SOLVE_REAL,
    STAGED,
    STAGES,
    STEP,
    STILL,
    TIME,
    TURN,
    VECTORS,
    Y,
    interpolate,
)
from nrchain.motion.integrators.radau_tableau import COMPLEX, REAL
from nrchain.motion.moving_chart import (
    PLACES,
    linearise,
    rebase,
    set_coordinates,
    set_lab_poses,
    set_y_rates,
)
from nrchain.motion.terms import HELD, ModelTerms
from nrchain.potential.link import add_block_product
from nrchain.types import Poses

# Places of arrays in the table, after those of chart and terms: what steps share, the two
# eliminations, and the checks of a step.
SHARED, SOLVERS, CLEARANCE, BEND = 26, 35, 38, 41
REAL_SCALE, PAIR_SCALE = SOLVERS + 1, SOLVERS + 2
(
    NUMBERS_AT,
    COUNTS_AT,
    VECTORS_AT,
    PAST_POSITIONS,
    PAST_FRAMES,
    ENDS,
    END_FRAMES,
    BLOCKS,
    AWAY,
) = range(SHARED, SOLVERS)
ARRAYS = 44


@inlined
def _vector(t, address):
    return carray(floats_at(address), t[VECTORS_AT, 2])


@part
def _rates(t, source, target):
    """target = f(AT, source)."""
    time = vector_in(t, NUMBERS_AT, floats_at)[AT]
    return set_y_rates(t, time, _vector(t, source), _vector(t, target))


@part
def _linearise(t, source, target):
    """Take J at (AT, source)."""
    time = vector_in(t, NUMBERS_AT, floats_at)[AT]
    blocks = blocks_in(t, BLOCKS, floats_at)
    return linearise(t, time, _vector(t, source), blocks)


@part
def _product(t, source, target):
    """target = J · source, with the blocks of J alone."""
    periodic = vector_in(t, CLEARANCE + 2, floats_at)[1] > 0.0
    n = t[BLOCKS, 1]
    out = carray(floats_at(target), (n, 6))
    out[:] = 0.0
    vector = carray(floats_at(source), (n, 6))
    add_block_product(blocks_in(t, BLOCKS, floats_at), vector, periodic, out)
    held = vector_in(t, HELD, integers_at)
    for i in range(n):
        if held[i]:
            out[i] = 0.0
    return 0


@part
def _factorise(t, source, target):
    """Factorise I − STEP J/λ for both λ."""
    step, solvers = vector_in(t, NUMBERS_AT, floats_at)[STEP], matrix_in(t, SOLVERS, integers_at)
    vector_in(t, REAL_SCALE, floats_at)[0] = step / REAL
    vector_in(t, PAIR_SCALE, complex_at)[0] = step / COMPLEX
    for k in range(2):
        if call(solvers[k, 0], solvers[k, 2], 0, 0, 0, 0):
            return SINGULAR
    return 0


@part
def _solve(t, source, k):
    """Solve for the real or the complex vector at ``source``, in place."""
    solvers = matrix_in(t, SOLVERS, integers_at)
    return call(solvers[k, 1], solvers[k, 2], source, 0, 0, 0)


@part
def _renew(t, source, target):
    """Change to a chart about the poses reached; PAST are the last stages in it."""
    numbers, counts = vector_in(t, NUMBERS_AT, floats_at), vector_in(t, COUNTS_AT, integers_at)
    vectors = matrix_in(t, VECTORS_AT, floats_at)
    past = blocks_in(t, PAST_FRAMES, floats_at)
    places = cube_in(t, PAST_POSITIONS, floats_at)
    ends, frames = matrix_in(t, ENDS, floats_at), cube_in(t, END_FRAMES, floats_at)
    time, length, staged = numbers[TIME], numbers[LENGTH], counts[STAGED]
    # three poses of the last step, and the poses reached
    for i in range(0 if staged else 3, 4):
        y = vectors[Y] if i == 3 else vectors[STILL] if i == 0 else vectors[STAGES + i - 1]
        at = time if i == 3 else time + length * PAST_NODES[i]
        set_lab_poses(t, at, y, ends if i == 3 else places[i], frames if i == 3 else past[i])
    status = rebase(t, time, ends, frames)
    if status:
        return status
    for i in range(3 if staged else 0):
        at = time + length * PAST_NODES[i]
        set_coordinates(t, at, vectors[STILL], places[i], past[i], vectors[PAST + i])
    vectors[Y] = 0.0
    counts[PREDICTED], counts[STAGED] = staged, 0
    numbers[BEGIN] = time
    # lab coordinates are known to rounding, and so are the changes of y
    furthest, least = 1.0, np.inf
    for value in ends.flat:
        furthest = max(furthest, abs(value))
    for value in vectors[SCALE]:
        least = min(least, value)
    numbers[ROUNDING] = 10.0 * EPSILON * furthest / least
    return 0


@part
def _turn(t, source, target):
    """ROOM = a quarter turn over the largest rotation of a sphere in the vector."""
    vector_in(t, NUMBERS_AT, floats_at)[ROOM] = room_to_turn(_vector(t, source))
    return 0


@part
def _look(t, source, target):
    """Whether a step has to be looked at: contacts, turned links, or a chain nearly straight."""
    vectors, before = matrix_in(t, VECTORS_AT, floats_at), matrix_in(t, PLACES, floats_at)
    ends, frames = matrix_in(t, ENDS, floats_at), cube_in(t, END_FRAMES, floats_at)
    time = vector_in(t, NUMBERS_AT, floats_at)[TIME]
    set_lab_poses(t, time, vectors[Y], ends, frames)
    clearance = Clearance(
        matrix_in(t, CLEARANCE, floats_at),
        vector_in(t, CLEARANCE + 1, floats_at),
        vector_in(t, CLEARANCE + 2, floats_at),
    )
    if not is_clear(clearance, before, ends, frames):
        return 1
    check = BendCheck(
        vector_in(t, BEND, integers_at),
        vector_in(t, BEND + 1, floats_at),
        vector_in(t, BEND + 2, floats_at),
    )
    return 0 if is_bent(check, ends, frames, vectors[Y]) else 1


@part
def _poses(t, positions, frames):
    """Poses in the lab at the time AT within the last step, at these addresses."""
    numbers, counts = vector_in(t, NUMBERS_AT, floats_at), vector_in(t, COUNTS_AT, integers_at)
    vectors, n, y = matrix_in(t, VECTORS_AT, floats_at), t[BLOCKS, 1], vector_in(t, AWAY, floats_at)
    interpolate(numbers, counts, vectors, numbers[AT], y)
    r, e = carray(floats_at(positions), (n, 3)), carray(floats_at(frames), (n, 3, 3))
    set_lab_poses(t, numbers[AT], y, r, e)
    return 0


def _equation(context, source, target, flag, which):
    """Call the function at a place of :mod:`~nrchain.motion.integrators.radau_steps`."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    if which == RATES:
        return _rates(t, source, target)
    if which == TURN:
        return _turn(t, source, target)
    if which in (SOLVE_REAL, SOLVE_PAIR):
        return _solve(t, source, which - SOLVE_REAL)
    if which == FACTORISE:
        return _factorise(t, source, target)
    if which == LINEARISE:
        return _linearise(t, source, target)
    if which == RENEW:
        return _renew(t, source, target)
    if which == LOOK:
        return _look(t, source, target)
    if which == POSES:
        return _poses(t, source, target)
    return _product(t, source, target)


@cache
def _entry() -> Any:
    return compile_term(_equation)


class ChainEquation:
    """The table of a charted chain and the functions that go with it.

    Attributes
    ----------
    functions
        Addresses, by the places of :mod:`~nrchain.motion.integrators.radau_steps`.
    numbers, counts, vectors, pair
        What steps share with the functions: see there.
    solvers
        (3, 3) addresses: factors, solutions and table of both eliminations; a row to spare.
    checks
        Which steps need no look; at first, none needs one.
    """

    def __init__(
        self, chain: ChartedChain, end: float, rtol: float, atol: np.ndarray, fixed: float
    ) -> None:
        model, count = chain.model, chain.model.count
        self._terms, self.checks = ModelTerms(model), _unchecked(count, model.period)
        self.numbers, self.counts = np.zeros(NUMBERS), np.zeros(COUNTS, np.int64)
        self.vectors = np.zeros((VECTORS, 6 * count))
        self.pair = np.zeros(6 * count, complex)
        scale = np.ones((count, 6))
        scale[chain.order] = atol.reshape(-1, 6)
        self.vectors[SCALE] = scale.ravel()
        self.numbers[[RTOL, END, FIXED, COMPONENTS]] = rtol, end, fixed, chain.dimension
        blocks = np.zeros((count, 2 * model.near_reach + 1, 6, 6))
        held, closes = self._terms.tables.held, model.period > 0.0
        kinds = float, complex
        self._eliminations = [Elimination(blocks, held, closes, kind) for kind in kinds]
        solvers = [(e.factorise_at, e.solve_at, e.table.ctypes.data) for e in self._eliminations]
        self.solvers = np.array([*solvers, (0, 0, 0)])
        shared = self.numbers, self.counts, self.vectors, np.zeros((3, count, 3))
        ends = np.zeros((3, count, 3, 3)), np.zeros((count, 3)), np.zeros((count, 3, 3))
        self._arrays = (
            *chain.chart,
            *self._terms.tables,
            *shared,
            *ends,
            blocks,
            np.zeros(6 * count),
            self.solvers,
            *(elimination.scale for elimination in self._eliminations),
            *self.checks.clearance,
            *self.checks.bend,
        )
        self._table = table_of(self._arrays)
        self.functions = np.zeros(FUNCTIONS, np.int64)
        entry = _entry()
        self.functions[:], self._call = entry.address, entry.ctypes
        self._address = self.functions[CONTEXT] = self._table.ctypes.data

    @property
    def has_far_pairs(self) -> bool:
        """Whether terms may have a derivative beyond their blocks."""
        return len(self._terms.tables.far) > 0

    def watch(self, checks: StepChecks) -> None:
        """Look at steps by these checks from now on."""
        if checks is not self.checks:
            self.checks = checks
            self._table[CLEARANCE:] = table_of([*checks.clearance, *checks.bend])

    def call(self, which: int, source: int, target: int = 0) -> int:
        """Call a direct function of the chain for vectors at these addresses; returns a status."""
        return self._call(self._address, source, target, 0, which)

    def poses_at(self, time: float) -> Poses:
        """Poses (N, 3) and (N, 3, 3) in the lab at a time within the last step."""
        count, self.numbers[AT] = len(self.pair) // 6, time
        positions, frames = np.empty((count, 3)), np.empty((count, 3, 3))
        self.call(POSES, positions.ctypes.data, frames.ctypes.data)
        return positions, frames

    def raise_error(self) -> None:
        """Raise the exception of the Python term that failed last."""
        self._terms.raise_error()


def _unchecked(count: int, period: float) -> StepChecks:
    """Checks that pass every step."""
    clearance = Clearance(np.zeros((count, 3)), np.zeros(1), np.array([-np.inf, period, 0.0]))
    bend = BendCheck.of(count, 1.0, period)
    bend.pause[0] = np.iinfo(np.int64).max
    return StepChecks(clearance, bend)
