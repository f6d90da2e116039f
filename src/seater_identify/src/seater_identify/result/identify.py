"""From a recording to all estimates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_identify.odometry.fit import OdometryFit, fit_odometry
from seater_identify.record.recording import Increments, Recording, increments
from seater_identify.response.data import AxisData
from seater_identify.response.fit import AxisFit, fit_axes
from seater_identify.response.model import Commands
from seater_identify.result.excitation import no_deadband, no_dynamics, no_steady
from seater_identify.result.values import Estimate, bound, judged, refused

Array = NDArray[np.float64]

UNITS = (0.4, 0.6)  # [m/s], [rad/s] typical speeds
AXES = ("v", "omega")
SETTLING = (0.6, 1.5)  # [m], [rad] until castors of the longest usual trail, 0.09 m, do not push any more
MOVED = (0.1, 0.3)  # [m], [rad] of motion without which an axis is not fitted
# Errors of the model itself, measured on random chairs (rosrun seater_identify identification_accuracy).
FLOOR = {"delay": 0.006, "lag": 0.012}
GAIN_FLOOR = (0.008, 0.018)  # a turn on the spot may stand on one slippery patch from its beginning to its end
DEADBAND_FLOOR = (0.0008, 0.0025)  # [m/s], [rad/s], and
DEADBAND_SHARE = 0.05  # of the deadband
ODOMETRY_FLOOR = np.array([0.004, 0.012, 0.006])  # patches of slip are not the mean of the way
# Without the dock the true way is not known: what odometry of chairs is off, as the observer's scale_sd.
UNKNOWN_SCALE = 0.02


@dataclass(frozen=True)
class Identification:
    """All estimates by name, and what the figures show."""

    estimates: dict[str, Estimate]
    axes: dict[int, tuple[AxisData, AxisFit]]  # 0: speed, 1: turning rate; those that moved
    odometry: OdometryFit | None

    def __getitem__(self, name: str) -> Estimate:
        return self.estimates[name]

    @property
    def found(self) -> bool:
        """Whether the recording shows anything at all."""
        return any(estimate.usable for estimate in self.estimates.values())


def identify(recording: Recording) -> Identification:
    """Every estimate is there; what was not excited is refused."""
    steps = increments(recording)
    data = axis_data(recording, steps)
    fits = dict(zip(data, fit_axes(list(data.values())), strict=True)) if data else {}
    wheels = fit_odometry(recording)
    found = [*_odometry(wheels), _delay(data, fits)]
    for axis in (0, 1):
        if axis in fits:
            found += _axis(axis, data[axis], fits[axis], wheels)
        else:
            names = [f"{name}_{AXES[axis]}" for name in ("lag", "gain", "deadband", "ramp")]
            found += [refused(name, f"not excited: the chair did not {('drive', 'turn')[axis]}") for name in names]
    return Identification({e.name: e for e in found}, {a: (data[a], fits[a]) for a in fits}, wheels)


def axis_data(recording: Recording, steps: Increments) -> dict[int, AxisData]:
    """Axis to its data, of the axes that moved and were commanded."""
    speeds = (steps.way / steps.duration, steps.turn / steps.duration)
    amounts = (steps.way, steps.turn)
    return {
        axis: AxisData(
            Commands(recording.commands[:, 0], recording.commands[:, 1 + axis]),
            speeds[1 - axis], steps.heading, steps.begin, steps.end, speeds[axis],
            UNITS[axis], SETTLING[axis], trails=axis == 1,
        )
        for axis in (0, 1)
        if float(np.sum(np.abs(amounts[axis]))) > MOVED[axis] and np.any(recording.commands[:, 1 + axis] != 0.0)
    }  # fmt: skip


def _delay(data: dict[int, AxisData], fits: dict[int, AxisFit]) -> Estimate:
    excited = [axis for axis in fits if not no_dynamics(data[axis], axis)]
    if not excited:
        return refused("delay", "not excited: start and stop at least twice")
    fit = fits[excited[0]]
    return judged("delay", fit.model.delay, math.hypot(fit.sd["delay"], FLOOR["delay"]), "start and stop more often")


def _axis(axis: int, data: AxisData, fit: AxisFit, wheels: OdometryFit | None) -> list[Estimate]:
    name = AXES[axis]
    why = no_dynamics(data, axis)
    lag = refused(f"lag_{name}", why) if why else judged(
        f"lag_{name}", fit.model.lag, math.hypot(fit.sd["lag"], FLOOR["lag"]), "start and stop more often"
    )  # fmt: skip
    why = no_steady(data, axis)
    gain = refused(f"gain_{name}", why) if why else _gain(axis, fit, wheels)
    return [lag, gain, _deadband(axis, data, fit), _ramp(axis, data, fit)]


def _gain(axis: int, fit: AxisFit, wheels: OdometryFit | None) -> Estimate:
    """Of the true speed: the odometry's scale is taken out where it is known."""
    scale, scale_sd = 0.0, UNKNOWN_SCALE
    if wheels is not None:
        scale, scale_sd = float(wheels.errors[axis]), float(odometry_sds(wheels)[axis])
    value = fit.gain / (1.0 + scale)
    sd = math.sqrt(fit.sd["gain"] ** 2 + GAIN_FLOOR[axis] ** 2 + (value * scale_sd) ** 2)
    return judged(f"gain_{AXES[axis]}", value, sd, "hold several speeds, with the dock in view")


def _deadband(axis: int, data: AxisData, fit: AxisFit) -> Estimate:
    """The mean of both directions."""
    name = f"deadband_{AXES[axis]}"
    why = no_deadband(data, axis, 1.0) or no_deadband(data, axis, -1.0)
    if why:
        return refused(name, why)
    both = np.array([fit.model.deadband_plus, fit.model.deadband_minus])
    value = float(both.mean())
    statistic = 0.5 * math.hypot(fit.sd["deadband_plus"], fit.sd["deadband_minus"])
    apart = 0.35 * float(abs(both[0] - both[1]))  # two draws of one truth: their difference tells their error
    parts = (statistic, DEADBAND_FLOOR[axis], DEADBAND_SHARE * value, apart, 0.5 * fit.other_kind)
    sd = math.hypot(*parts)
    estimate = judged(name, value, sd, "let the command grow slowly from zero, both ways")
    kind = "command - deadband moves it" if fit.model.offset else "all of the command moves it"
    text = f"{both[0]:.4f} and {both[1]:.4f}; beyond it {kind}"
    return Estimate(estimate.name, estimate.unit, estimate.value, estimate.sd, estimate.quality, estimate.text or text)


def _ramp(axis: int, data: AxisData, fit: AxisFit) -> Estimate:
    name = f"ramp_{AXES[axis]}"
    if "ramp" not in fit.sd:
        steepest = data.commands.steepest()
        if steepest == 0.0:
            return refused(name, "not excited: start and stop")
        return bound(name, steepest, "at least what was commanded")
    value = fit.model.ramp or math.nan
    return judged(name, value, math.hypot(fit.sd["ramp"], 0.05 * value), "start and stop as fast as allowed")


def _odometry(wheels: OdometryFit | None) -> list[Estimate]:
    names = ("odometry_scale", "odometry_heading_scale", "odometry_heading_drift")
    if wheels is None:
        return [refused(name, "the dock was not in view: begin ahead of it, facing it") for name in names]
    drives = ("drive to and fro with the dock in view", "turn whole turns, the dock in view before and after",
              "drive to and fro with the dock in view")  # fmt: skip
    sds = odometry_sds(wheels)
    return [judged(n, float(wheels.errors[i]), float(sds[i]), drives[i]) for i, n in enumerate(names)]


def odometry_sds(wheels: OdometryFit) -> Array:
    """(3,) standard deviations with the floor."""
    return np.asarray(np.sqrt(np.diag(wheels.covariance) + ODOMETRY_FLOOR**2))
