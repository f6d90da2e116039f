"""Identified values against the truth, over random chairs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from tabulate import tabulate

from seater_common.geometry import Chair
from seater_identify.result.identify import identify
from seater_identify.settings import IdentifySettings
from seater_identify.trial.simulation import Camera, simulate
from seater_identify.trial.truth import true_values
from seater_sim.chair.plant_ranges import PlantRanges
from seater_sim.settings import SimulatorSettings

# Largest error that is allowed (issue 11); of deadbands a share, but not less than the smallest that matters.
BARS = {"delay": 0.015, "lag_v": 0.030, "lag_omega": 0.030, "gain_v": 0.02, "gain_omega": 0.02}
DEADBAND_SHARE = 0.2
DEADBAND_LEAST = {"deadband_v": 0.002, "deadband_omega": 0.004}


@dataclass(frozen=True)
class Trial:
    """One chair: name to (identified, standard deviation, truth); refused: NaN."""

    seed: int
    state: str
    values: dict[str, tuple[float, float, float]]


def run_trial(ranges: PlantRanges, seed: int, settings: IdentifySettings, chair: Chair) -> Trial:
    """A chair drawn from the ranges by the seed is driven and identified."""
    simulator = ranges.draw_simulator(np.random.default_rng(seed), SimulatorSettings())
    drive = simulate(settings, chair, simulator, seed, Camera())
    result, truth = identify(drive.recording), true_values(simulator, chair.limits)
    values = {name: (e.value, e.sd, truth[name]) for name, e in result.estimates.items() if not name.startswith("ramp")}
    return Trial(seed, drive.state.value, values)


def allowed(name: str, truth: float) -> float:
    """The bar for one value; infinite where there is none."""
    if name in DEADBAND_LEAST:
        return max(DEADBAND_SHARE * truth, DEADBAND_LEAST[name])
    return BARS.get(name, math.inf)


def shares(trials: Sequence[Trial], name: str) -> dict[str, float]:
    """Over all chairs: refused; of the others: inside the bar, inside its own 95 % interval, rms error."""
    rows = np.array([trial.values[name] for trial in trials])
    said = rows[np.isfinite(rows[:, 1])]
    error = np.abs(said[:, 0] - said[:, 2])
    bars = np.array([allowed(name, truth) for truth in said[:, 2]])
    return {
        "refused": 1.0 - len(said) / len(rows),
        "in_bar": float(np.mean(error <= bars)) if len(said) else math.nan,
        "in_interval": float(np.mean(error <= 1.96 * said[:, 1])) if len(said) else math.nan,
        "rms": float(np.sqrt(np.mean(error**2))) if len(said) else math.nan,
    }


def describe_trials(trials: Sequence[Trial]) -> str:
    """The table."""
    rows = []
    for name in trials[0].values:
        s = shares(trials, name)
        rows.append([name, *(f"{s[key]:.2f}" for key in ("refused", "in_bar", "in_interval")), f"{s['rms']:.4f}"])
    head = ["what", "refused", "inside the bar", "inside its 95 % interval", "rms error"]
    return str(tabulate(rows, head, tablefmt="simple", disable_numparse=True))
