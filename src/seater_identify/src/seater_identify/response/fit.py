"""Fits both axes: each by itself for the kind of its deadband and for a ramp, then both with one delay.

Standard deviations are robust against residuals that last longer than one message (Newey and West, "A simple, positive
semi-definite, heteroskedasticity and autocorrelation consistent covariance matrix", 1987).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from seater_identify.response.data import AxisData
from seater_identify.response.model import NO_RAMP, AxisModel
from seater_identify.response.problem import HUBER, AxisProblem

Array = NDArray[np.float64]

# The coarse grid from whose best points a fit begins: delays [s], deadbands (of the typical speed).
STARTS = (0.05, 0.15, 0.25, 0.35, 0.5)
EDGES = (0.005, 0.02, 0.04, 0.06, 0.08, 0.11, 0.15)
BEST = 2
CORRELATED = 1.0  # [s] over which residuals are taken as correlated
PLAIN = ("delay", "lag", "deadband_plus", "deadband_minus")
ALIKE = 0.95  # ratio of the costs above which both kinds of deadband are possible
BETTER = 0.95  # share of the cost below which a ramp is believed
STEEP = 0.9  # of the steepest command: a ramp as steep as the commands themselves cannot be told from none


@dataclass(frozen=True)
class AxisFit:
    """One axis. `sd`: name to standard deviation, of the fitted parameters and of `gain`."""

    model: AxisModel
    gain: float
    sd: dict[str, float]
    predicted: Array  # (n,) mean speeds [1/s]
    other_kind: float  # [1/s] how far the deadband would be off if it is of the other kind; 0: certainly not


def fit_axes(data: Sequence[AxisData]) -> list[AxisFit]:
    """The fits of the axes (one or two), with a delay in common."""
    chosen = [_best(axis) for axis in data]
    problems = [problem for problem, _, _ in chosen]
    begin = np.concatenate([[np.mean([p[0] for _, p, _ in chosen])], *(p[1:] for _, p, _ in chosen)])
    splits = np.cumsum([len(problem.free) - 1 for problem in problems])[:-1]

    def parts(parameters: Array) -> list[Array]:
        return [np.concatenate([parameters[:1], part]) for part in np.split(parameters[1:], splits)]

    def residuals(parameters: Array) -> Array:
        return np.concatenate([p.residuals(part) for p, part in zip(problems, parts(parameters), strict=True)])

    bounds = [_bounds(problem) for problem in problems]
    low, high, scale = (np.concatenate([bounds[0][i][:1], *(b[i][1:] for b in bounds)]) for i in range(3))

    def steps(parameters: Array) -> Array:
        each = [p.steps(part) for p, part in zip(problems, parts(parameters), strict=True)]
        return np.concatenate([each[0][:1], *(e[1:] for e in each)])

    for _ in range(3):
        begin = _minimise(residuals, steps, begin, (low, high, scale), 12)[0]
        for problem, part in zip(problems, parts(begin), strict=True):
            problem.reweight(part)
    return _results(problems, parts(begin), [apart for _, _, apart in chosen])


def _best(data: AxisData) -> tuple[AxisProblem, Array, float]:
    """Problem and parameters of the best kind of deadband, with a ramp if the data ask for one; and `other_kind`."""
    jump, offset = (_fit(AxisProblem(data, PLAIN, kind), None) for kind in (False, True))
    for problem, _, _ in (jump, offset):
        problem.sd, problem.huber = jump[0].sd, jump[0].huber
    costs = [_cost(problem, parameters) for problem, parameters, _ in (jump, offset)]
    best = (jump, offset)[int(np.argmin(costs))]
    apart = abs(float(np.mean(jump[1][2:4]) - np.mean(offset[1][2:4]))) if max(costs) * ALIKE < min(costs) else 0.0
    if data.trails and not best[0].offset:
        best = _fit(AxisProblem(data, PLAIN, False, trailing=True), best[1])
        costs = [_cost(best[0], best[1])]
    ramped = AxisProblem(data, (*PLAIN, "ramp"), best[0].offset, best[0].trailing)
    ramped.sd = best[0].sd
    steepest = data.commands.steepest()
    parameters = _fit(ramped, np.append(best[1], 0.7 * max(steepest, 0.1 * data.unit)))[1]
    ramped.sd, ramped.huber = best[0].sd, best[0].huber
    if parameters[-1] < STEEP * steepest and _cost(ramped, parameters) < BETTER * min(costs):
        return ramped, parameters, apart
    return best[0], best[1], apart


def _fit(problem: AxisProblem, begin: Array | None) -> tuple[AxisProblem, Array, float]:
    """Problem, parameters, cost; without `begin` from the best of a grid."""
    bounds = _bounds(problem)
    if begin is None:
        unit = problem.data.unit
        grid = [np.array([delay, 0.18, edge * unit, edge * unit]) for delay in STARTS for edge in EDGES]
        grid.sort(key=lambda point: float(np.sum(problem.residuals(point) ** 2)))
        tried = [_minimise(problem.residuals, problem.steps, point, bounds, 6) for point in grid[:BEST]]
        begin = min(tried, key=lambda result: result[1])[0]
    for _ in range(2):
        problem.reweight(begin)
        begin, cost = _minimise(problem.residuals, problem.steps, begin, bounds, 12)
    return problem, begin, cost


def _minimise(
    residuals: Callable[[Array], Array],
    steps: Callable[[Array], Array],
    begin: Array,
    bounds: tuple[Array, Array, Array],
    evaluations: int,
) -> tuple[Array, float]:
    low, high, scale = bounds
    answer = least_squares(
        residuals, np.clip(begin, low + 1e-6, high - 1e-6), bounds=(low, high), x_scale=scale,
        jac=lambda x: _derivative(residuals, x, steps(x)), max_nfev=evaluations, ftol=1e-6, xtol=1e-5,
    )  # fmt: skip
    return answer.x, float(answer.cost)


def _derivative(residuals: Callable[[Array], Array], at: Array, steps: Array) -> Array:
    columns = []
    for index, step in enumerate(steps):
        up, down = at.copy(), at.copy()
        up[index], down[index] = at[index] + step, max(at[index] - step, 0.0)
        columns.append((residuals(up) - residuals(down)) / (up[index] - down[index]))
    return np.column_stack(columns)


def _bounds(problem: AxisProblem) -> tuple[Array, Array, Array]:
    unit = problem.data.unit
    low = {"ramp": 0.05 * unit}
    high = {"delay": 0.8, "lag": 1.0, "ramp": NO_RAMP}
    scale = {"delay": 0.1, "lag": 0.1, "ramp": unit}
    defaults = ((low, 0.0), (high, 0.4 * unit), (scale, 0.05 * unit))
    a, b, c = (np.array([table.get(name, default) for name in problem.free]) for table, default in defaults)
    return a, b, c


def _cost(problem: AxisProblem, parameters: Array) -> float:
    """Huber's loss of the residuals by the problem's standard deviations."""
    z = np.abs(problem.data.measured - problem.solve(problem.model(parameters))[1]) / problem.sd
    return float(np.sum(np.where(z <= HUBER, z**2, HUBER * (2.0 * z - HUBER))[problem.huber > 0.0]))


def _results(problems: Sequence[AxisProblem], parameters: Sequence[Array], apart: Sequence[float]) -> list[AxisFit]:
    """Sandwich covariance over all parameters: delay, then those of each axis with its linear ones."""
    blocks, scores, priors = [], [], []
    for problem, part in zip(problems, parameters, strict=True):
        coefficients, predicted = problem.solve(problem.model(part))
        root = np.sqrt(problem.huber) / problem.sd
        J = problem.jacobian(part) * root[:, None]
        blocks.append(J)
        scores.append(J * ((problem.data.measured - predicted) * root)[:, None])
        priors.append(np.concatenate([np.zeros(len(part)), 1.0 / problem.prior**2]))
    J, S = _stacked(blocks), _stacked(scores, together=True)
    prior = np.concatenate([[0.0], *(p for p in priors)])
    data = problems[0].data
    lags = max(1, round(CORRELATED / float(np.median(data.end - data.begin))))
    bread = np.linalg.pinv(J.T @ J + np.diag(prior))
    variance = np.maximum(np.diag(bread @ (newey_west(S, lags) + np.diag(prior)) @ bread), 0.0)
    results, at = [], 1
    for problem, part, other in zip(problems, parameters, apart, strict=True):
        names = [*problem.free[1:], "gain"]
        sd = {"delay": float(np.sqrt(variance[0]))}
        sd |= {name: float(np.sqrt(variance[at + i])) for i, name in enumerate(names)}
        model = problem.model(part)
        coefficients, predicted = problem.solve(model)
        results.append(AxisFit(model, float(coefficients[0]), sd, predicted, other))
        at += len(part) + len(problem.prior)
    return results


def _stacked(blocks: Sequence[Array], together: bool = False) -> Array:
    """One matrix with the first column (the delay) in common: rows below each other, or added (`together`)."""
    widths = [block.shape[1] - 1 for block in blocks]
    rows, at = [], 1
    for block, width in zip(blocks, widths, strict=True):
        row = np.zeros((len(block), 1 + sum(widths)))
        row[:, 0], row[:, at : at + width] = block[:, 0], block[:, 1:]
        rows.append(row)
        at += width
    return np.asarray(sum(rows)) if together else np.vstack(rows)


def newey_west(scores: Array, lags: int) -> Array:
    """Covariance of the sum of scores (n, p) that are correlated over `lags` rows (Bartlett kernel)."""
    total = scores.T @ scores
    for lag in range(1, min(lags, len(scores) - 1) + 1):
        product = scores[lag:].T @ scores[:-lag]
        total += (1.0 - lag / (lags + 1.0)) * (product + product.T)
    return np.asarray(total)
