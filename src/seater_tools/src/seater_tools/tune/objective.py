"""What a good set of weights is: the score of a campaign's dockings, and what they must not break.

Of each docking i, with the times and jerks of the same dockings before, b:

    c_i = t_i / t_b,i + COMFORT / 2 * (j_i / J_b + w_i / W_b)

t: time from the goal to the result; j, w: rms of jerk and angular jerk while it moves; J_b, W_b: their medians before.
The score is median(c) + SPREAD * (90th percentile of c - median(c)): time and comfort of the usual docking, and of the
bad one. Lower is better; before, it is near 1 + COMFORT.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = Sequence[Mapping[str, Any]]

COMFORT, SPREAD = 0.5, 0.5  # weights, 1
LOST = 5.0  # c of a docking that failed: worse than any that docks
ERROR_SHARE = 0.5  # of the dock's tolerance: what the final error may come to in 95 of 100 dockings


@dataclass(frozen=True, kw_only=True)
class Measures:
    """Of a set of dockings, in their order."""

    docked: int
    touched: int
    time: Array  # [s] NaN: it failed
    jerk: Array  # [m/s^3] rms
    angular_jerk: Array  # [rad/s^3] rms
    position_p95: float  # [m] true final error of those that docked
    heading_p95: float  # [deg]
    reversals: float  # mean


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """`violations`: what is broken, by how much; all <= 0: allowed."""

    score: float
    violations: dict[str, float]

    @property
    def allowed(self) -> bool:
        """Whether nothing is broken."""
        return all(value <= 0.0 for value in self.violations.values())


def measure(rows: Rows) -> Measures:
    """Of the campaign's rows."""
    docked = [bool(row["docked"]) for row in rows]
    errors = [(row["position_error_m"], abs(row["heading_error_deg"])) for row in rows if row["docked"]]
    p95 = np.quantile(np.array(errors), 0.95, axis=0) if errors else (np.inf, np.inf)
    return Measures(
        docked=sum(docked),
        touched=sum(bool(row["touched"]) for row in rows),
        time=_column(rows, "docking_time_s"),
        jerk=_column(rows, "jerk_rms"),
        angular_jerk=_column(rows, "angular_jerk_rms"),
        position_p95=float(p95[0]),
        heading_p95=float(p95[1]),
        reversals=float(np.mean([row.get("reversals", 0.0) for row in rows])),
    )


def _column(rows: Rows, name: str) -> Array:
    return np.array([row[name] if row["docked"] else np.nan for row in rows], dtype=float)


def costs(found: Measures, before: Measures) -> Array:
    """c of each docking; where it failed before, its own time counts as the time before."""
    time = found.time / np.where(np.isfinite(before.time), before.time, found.time)
    jerk = found.jerk / np.nanmedian(before.jerk) + found.angular_jerk / np.nanmedian(before.angular_jerk)
    return np.asarray(np.nan_to_num(time + 0.5 * COMFORT * jerk, nan=LOST))


def score(cost: Array) -> float:
    """Of c, (n,)."""
    middle, high = np.quantile(cost, [0.5, 0.9])
    return float(middle + SPREAD * (high - middle))


def judge(found: Measures, before: Measures, tolerance: tuple[float, float]) -> Verdict:
    """`tolerance` of the dock: [m], [deg]. Allowed is what docks as often as before, touches nothing (or no more than
    before), and whose 95th percentiles of the final errors are below half the tolerance (or what they were)."""
    position, heading = (ERROR_SHARE * value for value in tolerance)
    violations = {
        "docked": float(before.docked - found.docked),
        "touched": float(found.touched - before.touched),
        "final position": found.position_p95 / max(position, before.position_p95) - 1.0,
        "final heading": found.heading_p95 / max(heading, before.heading_p95) - 1.0,
    }
    return Verdict(score=score(costs(found, before)), violations=violations)
