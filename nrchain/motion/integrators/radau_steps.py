"""Steps of Radau IIA for ẏ = f(t, y) in compiled code: prediction, Newton, error, step length.

The equation is a table of functions by address, listed below: this file is compiled once for all
chains. It knows vectors and no spheres, and every step starts at y = 0 of new coordinates.

Hairer & Wanner, *Solving Ordinary Differential Equations II* (2nd ed., 1996), Sec. IV.8; named
constants are theirs.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain._addresses import address_of, call
from nrchain._compile import constants, kernel, part
from nrchain.motion.integrators.radau_tableau import (
    COMPLEX,
    ESTIMATE,
    FROM_COMPLEX,
    FROM_REAL,
    NODES,
    REAL,
    TO_COMPLEX,
    TO_REAL,
    cubics,
)

SAFETY = 0.9
SLOWEST, FASTEST = 0.2, 8.0
"""Smallest and largest ratio of a step to the one before."""

KEEP = 1.2
"""A step that could grow by less than this keeps its length and factors (Sec. IV.8, c_2)."""

FRESH_JACOBIAN = 1e-3
"""Rate of Newton's iteration above which the next step takes a new Jacobian (Sec. IV.8, ϑ)."""

NEWTON_TOLERANCE = 0.03
"""Largest error of the stages, in units of the tolerance per step (Sec. IV.8, κ)."""

ITERATIONS = 7
"""Newton iterations after which a step is shortened (Sec. IV.8, k_max)."""

PATIENCE = 50
"""Largest number of Newton iterations of a fixed step, which cannot be shortened."""

SMALLEST_ERROR = 1e-2
"""Errors below this, in units of the tolerance, do not speed up the predictive controller."""

EPSILON = float(np.finfo(float).eps)

WITHIN = cubics(NODES)
PAST_NODES = np.array([0.0, NODES[0], NODES[1]]) - 1.0
BEYOND = cubics(PAST_NODES)
"""Polynomials through the stages of a step, and their continuation to the next."""

# Statuses of a step.
ADVANCED, FAILED_CALL, NOT_FINITE, ERROR_STAYS, DIVERGES, NO_STEP, SINGULAR = range(7)

# The functions of an equation, f(context, from, to, 0, place) with addresses of vectors: f at time
# AT; J at that time; its product; I − STEP J/λ for both λ; solutions in place, real and complex;
# new coordinates about Y; ROOM of a vector; whether the step may be left unseen (status 0); poses
# at AT.
RATES, LINEARISE, PRODUCT, FACTORISE, SOLVE_REAL, SOLVE_PAIR, RENEW, TURN, LOOK, POSES = constants(
    range(10)
)
CONTEXT, FUNCTIONS = 10, 11

# Numbers that steps and functions share. ROUNDING: of coordinates, relative to the least ``atol``.
# ROOM: how many times as far coordinates may go before they become poor; below 1 they have.
AT, TIME, BEGIN, STEP, LENGTH, NEXT, ERROR, RATE, ETA, ROUNDING, ROOM = range(11)
RTOL, END, FIXED, COMPONENTS = range(11, 15)
NUMBERS = 15

STEPS, EVALUATIONS, JACOBIANS, SOLVES, LINEARISED, FACTORISED, FRESH, STAGED, PREDICTED = range(9)
SAMPLED, COUNTS = 9, 10

# Vectors: three stages Z_i, f(Z_i), the change of Z, and the last step in the present coordinates;
# f(t_n, 0), zero, the coordinates reached, the error of a step, ``atol`` and a right-hand side.
STAGES, SLOPES, CHANGE, PAST = constants(range(0, 12, 3))
SLOPE, STILL, Y, DEFECT, SCALE, REAL_SIDE = constants(range(12, 18))
# where a function takes no vector
UNUSED = STILL
VECTORS = 18


@part
def _call(functions, which, vectors, source, target):
    """Call a function of the equation with two vectors; returns its status."""
    begin, row = address_of(vectors), 8 * vectors.shape[1]
    return call(
        functions[which], functions[CONTEXT], begin + row * source, begin + row * target, 0, which
    )


@part
def _norm(vector, scale, components):
    """√mean((v/scale)²) over the components that can change."""
    total = 0.0
    for m in range(vector.shape[0]):
        total += (vector[m] / scale[m]) ** 2
    return math.sqrt(total / components)


@part
def _is_finite(vectors, first, last):
    """Whether every number in these rows is finite."""
    total = 0.0
    for i in range(first, last):
        for m in range(vectors.shape[1]):
            total += 0.0 * vectors[i, m]
    return total == 0.0


@part
def _rates(functions, numbers, counts, vectors, time, source, target):
    counts[EVALUATIONS] += 1
    numbers[AT] = time
    return _call(functions, RATES, vectors, source, target)


@kernel(alone=True)
def interpolate(numbers, counts, vectors, time, out):
    """out = y within the last step, on its collocation polynomial."""
    if not counts[STAGED]:
        for m in range(out.shape[0]):
            out[m] = vectors[Y, m]
        return
    x = (time - numbers[BEGIN]) / numbers[LENGTH]
    out[:] = 0.0
    for i in range(3):
        weight = WITHIN[i, 0] * x + WITHIN[i, 1] * x**2 + WITHIN[i, 2] * x**3
        for m in range(out.shape[0]):
            out[m] += weight * vectors[STAGES + i, m]


@part
def _first_length(functions, numbers, vectors):
    """h with ω³‖f‖ h⁴ = 1 for the rate ω = ‖Jf‖/‖f‖: what the error estimate should be."""
    if _call(functions, PRODUCT, vectors, SLOPE, DEFECT):
        return -1.0
    speed = _norm(vectors[SLOPE], vectors[SCALE], numbers[COMPONENTS])
    if speed == 0.0:
        return numbers[END]
    rate = _norm(vectors[DEFECT], vectors[SCALE], numbers[COMPONENTS]) / speed
    return SAFETY / max((speed * rate**3) ** 0.25, SAFETY / numbers[END])


@part
def _predict(functions, numbers, counts, vectors, step):
    """Z = the polynomial of the last step, continued, or 0 where it goes too far."""
    found = counts[PREDICTED]
    for i in range(3):
        vectors[STAGES + i] = 0.0
        if not found:
            continue
        x = NODES[i] * (step / numbers[LENGTH])
        for j in range(3):
            weight = BEYOND[j, 0] * x + BEYOND[j, 1] * x**2 + BEYOND[j, 2] * x**3
            for m in range(vectors.shape[1]):
                vectors[STAGES + i, m] += weight * vectors[PAST + j, m]
        _call(functions, TURN, vectors, STAGES + i, UNUSED)
        if numbers[ROOM] < 1.0:
            found = 0
    if not found:
        for i in range(3):
            vectors[STAGES + i] = 0.0


@part
def _newton_change(functions, numbers, counts, vectors, pair, step):
    """change = S ΔW, (I − h/λ J) ΔW = (h/λ) S⁻¹F − S⁻¹Z; returns a status."""
    for i in range(3):
        at = numbers[TIME] + NODES[i] * step
        if _rates(functions, numbers, counts, vectors, at, STAGES + i, SLOPES + i):
            return FAILED_CALL
    if not _is_finite(vectors, SLOPES, SLOPES + 3):
        return NOT_FINITE
    real_step, pair_step = step / REAL, step / COMPLEX
    for m in range(vectors.shape[1]):
        real, twin = 0.0, 0.0j
        for i in range(3):
            slope, stage = vectors[SLOPES + i, m], vectors[STAGES + i, m]
            real += TO_REAL[i] * (real_step * slope - stage)
            twin += TO_COMPLEX[i] * (pair_step * slope - stage)
        vectors[REAL_SIDE, m], pair[m] = real, twin
    counts[SOLVES] += 2
    if _call(functions, SOLVE_REAL, vectors, REAL_SIDE, REAL_SIDE):
        return FAILED_CALL
    if call(functions[SOLVE_PAIR], functions[CONTEXT], address_of(pair), 0, 0, SOLVE_PAIR):
        return FAILED_CALL
    for i in range(3):
        for m in range(vectors.shape[1]):
            twin = (FROM_COMPLEX[i] * pair[m]).real
            vectors[CHANGE + i, m] = FROM_REAL[i] * vectors[REAL_SIDE, m] + 2.0 * twin
    return ADVANCED if _is_finite(vectors, CHANGE, CHANGE + 3) else NOT_FINITE


@part
def _solve_stages(functions, numbers, counts, vectors, pair, step, patience):
    """Iterate until the error of Z is small enough; returns a status and the iterations.

    The error is η ‖ΔZ‖ with η = θ/(1 − θ), θ the rate of convergence. Before θ is known, the last
    η^0.8 is used, which grows with every step without a measured rate. Changes at the rounding of
    coordinates end the iteration.
    """
    if not counts[FACTORISED]:
        numbers[STEP] = step
        status = _call(functions, FACTORISE, vectors, UNUSED, UNUSED)
        if status:
            return (FAILED_CALL if status == FAILED_CALL else DIVERGES), patience
        counts[FACTORISED] = 1
    _predict(functions, numbers, counts, vectors, step)
    rounding = numbers[ROUNDING]
    tolerance = max(rounding, min(NEWTON_TOLERANCE, math.sqrt(numbers[RTOL])))
    last = 0.0
    numbers[ETA] = max(numbers[ETA], EPSILON) ** 0.8
    for iteration in range(1, patience + 1):
        status = _newton_change(functions, numbers, counts, vectors, pair, step)
        if status == FAILED_CALL:
            return status, iteration
        if status != ADVANCED:
            break
        total = 0.0
        for i in range(3):
            size = _norm(vectors[CHANGE + i], vectors[SCALE], numbers[COMPONENTS])
            total += size * size
        size = math.sqrt(total / 3.0)
        if iteration > 1:
            rate = size / last
            numbers[RATE] = rate
            numbers[ETA] = rate / (1.0 - rate) if rate < 1.0 else np.inf
            left = patience - iteration
            expected = min(rate, 1.0) ** left * (1.0 + numbers[ETA]) * size
            if expected > tolerance and size > rounding:
                break
        for i in range(3):
            for m in range(vectors.shape[1]):
                vectors[STAGES + i, m] += vectors[CHANGE + i, m]
        if size <= rounding or numbers[ETA] * size <= tolerance:
            return ADVANCED, iteration
        last = size
    numbers[RATE], numbers[ETA] = 1.0, np.inf
    return DIVERGES, patience


@part
def _error_size(functions, numbers, counts, vectors, step, rejected):
    """The error of the step in units of the tolerance, and a status.

    The error is (I − h γ_0 J)⁻¹ (h γ_0 f + Σ e_i Z_i), of order h⁴. Where it is first above 1, f
    is taken at y_n + error: the estimate then tends to 0 as hλ → ∞, at one further evaluation.
    """
    slope, size = SLOPE, 0.0
    for _ in range(2):
        for m in range(vectors.shape[1]):
            defect = step / REAL * vectors[slope, m]
            for i in range(3):
                defect += ESTIMATE[i] * vectors[STAGES + i, m]
            vectors[DEFECT, m] = defect
        counts[SOLVES] += 1
        if _call(functions, SOLVE_REAL, vectors, DEFECT, DEFECT):
            return 0.0, FAILED_CALL
        total = 0.0
        for m in range(vectors.shape[1]):
            scale = vectors[SCALE, m] + numbers[RTOL] * abs(vectors[STAGES + 2, m])
            total += (vectors[DEFECT, m] / scale) ** 2
        size = math.sqrt(total / numbers[COMPONENTS])
        if slope != SLOPE or size < 1.0 or not (rejected or numbers[ERROR] == 0.0):
            break
        slope = SLOPES
        if _rates(functions, numbers, counts, vectors, numbers[TIME], DEFECT, slope):
            return 0.0, FAILED_CALL
        if not _is_finite(vectors, slope, slope + 1):
            break
    return max(size, 1e-10), ADVANCED


@part
def growth(iterations, error):
    """The ratio of the next step to this one, from its error and Newton's iterations."""
    work = (2 * ITERATIONS + 1) / (2 * ITERATIONS + iterations)
    return SAFETY * work * error**-0.25


@kernel
def accept(numbers, counts, vectors, step, iterations, error, rejected):
    """Advance, and choose the next step by the predictive controller."""
    ratio = growth(iterations, error)
    if numbers[ERROR]:
        ratio *= min(1.0, step / numbers[LENGTH] * (numbers[ERROR] / error) ** 0.25)
    ratio = min(max(ratio, SLOWEST), FASTEST, SAFETY * numbers[ROOM])
    if rejected:
        ratio = min(ratio, 1.0)
    linearised = numbers[RATE] < FRESH_JACOBIAN
    if linearised and 1.0 <= ratio <= KEEP:
        ratio = 1.0
    if not (linearised and ratio == 1.0):
        counts[FACTORISED] = 0
    counts[LINEARISED] = 1 if linearised else 0
    numbers[ERROR] = max(error, SMALLEST_ERROR)
    numbers[LENGTH], numbers[NEXT] = step, ratio * step
    for m in range(vectors.shape[1]):
        vectors[Y, m] = vectors[STAGES + 2, m]
    numbers[TIME] += step
    counts[STAGED] = 1
    counts[STEPS] += 1


@part
def _take_step(functions, numbers, counts, vectors, pair):
    """One step from the coordinates reached, ROOM being that of its end; returns a status."""
    if _call(functions, RENEW, vectors, UNUSED, UNUSED):
        return FAILED_CALL
    counts[FRESH] = 0
    if _rates(functions, numbers, counts, vectors, numbers[TIME], STILL, SLOPE):
        return FAILED_CALL
    if not _is_finite(vectors, SLOPE, SLOPE + 1):
        return NOT_FINITE
    fixed = numbers[FIXED] > 0.0
    step, rejected, cause = numbers[FIXED] if fixed else numbers[NEXT], False, NO_STEP
    patience = PATIENCE if fixed else ITERATIONS
    while True:
        if not counts[LINEARISED]:
            counts[JACOBIANS] += 1
            counts[LINEARISED], counts[FRESH], counts[FACTORISED] = 1, 1, 0
            numbers[AT] = numbers[TIME]
            if _call(functions, LINEARISE, vectors, STILL, UNUSED):
                return FAILED_CALL
            if step == 0.0:
                step = _first_length(functions, numbers, vectors)
                if step < 0.0:
                    return FAILED_CALL
        if not step > 10.0 * np.spacing(abs(numbers[TIME])):
            return cause
        status, iterations = _solve_stages(
            functions, numbers, counts, vectors, pair, step, patience
        )
        if status == DIVERGES and not counts[FRESH]:
            counts[LINEARISED] = 0
            continue
        if status == FAILED_CALL:
            return status
        if status == ADVANCED:
            error, status = _error_size(functions, numbers, counts, vectors, step, rejected)
            if status == FAILED_CALL:
                return status
            _call(functions, TURN, vectors, STAGES + 2, UNUSED)
            room = SAFETY * numbers[ROOM]
            if fixed or (error < 1.0 and room >= SAFETY):
                accept(numbers, counts, vectors, step, iterations, error, rejected)
                return ADVANCED
            factor = max(SLOWEST, min(growth(iterations, error), room))
            cause = ERROR_STAYS
        else:
            if fixed:
                return DIVERGES
            factor, cause = 0.5, DIVERGES
        step *= factor
        rejected = True
        counts[FACTORISED] = 0


@kernel(nogil=True)
def advance(functions, numbers, counts, vectors, pair, most, times, counted, positions, frames):
    """Steps up to the first that has to be looked at; returns a status and their number.

    These are the last of ``most``, the one that passes the last of ``times`` (T,), and any that
    LOOK does not pass. Of all others the poses at ``times`` are sampled, to arrays at the addresses
    ``positions`` and ``frames``, with the steps and the evaluations ``counted`` (T, 2) by then;
    counts[SAMPLED] is their number.
    """
    taken, sampled, sphere = 0, 0, 8 * (vectors.shape[1] // 6)
    counts[SAMPLED] = 0
    while taken < most:
        status = _take_step(functions, numbers, counts, vectors, pair)
        if status != ADVANCED:
            return status, taken
        taken += 1
        if taken == most or not times.shape[0] or times[-1] <= numbers[TIME]:
            break
        if call(functions[LOOK], functions[CONTEXT], 0, 0, 0, LOOK):
            break
        while sampled < times.shape[0] and times[sampled] <= numbers[TIME]:
            numbers[AT] = times[sampled]
            counted[sampled, 0], counted[sampled, 1] = counts[STEPS], counts[EVALUATIONS]
            to = positions + 3 * sphere * sampled, frames + 9 * sphere * sampled
            call(functions[POSES], functions[CONTEXT], to[0], to[1], 0, POSES)
            sampled += 1
            counts[SAMPLED] = sampled
    return ADVANCED, taken


def start(numbers: np.ndarray, counts: np.ndarray, time: float) -> None:
    """Forget all steps: start at ``time``, at the coordinates Y."""
    numbers[[TIME, BEGIN, AT]] = time
    numbers[[STEP, LENGTH, NEXT, ERROR]] = 0.0
    numbers[RATE], numbers[ETA] = 1.0, np.inf
    counts[[LINEARISED, FACTORISED, FRESH, STAGED, PREDICTED]] = 0
