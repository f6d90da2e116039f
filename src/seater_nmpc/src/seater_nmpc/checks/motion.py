"""Limits, tolerances and times that one file fixes and another one relies on."""

from __future__ import annotations

from seater_nmpc.checks.findings import Findings, Given

SLOWEST_CAMERA = 3.0  # [Hz] images per second that a docking must do with


def check_limits(given: Given, findings: Findings) -> None:
    """Speeds of the chair against times of the sequence and the horizon."""
    limits, dock, p = given.chair.limits, given.dock, given.parameters
    fastest = max(limits.v_max, limits.v_reverse_max)
    findings.require(
        limits.v_bay_max <= fastest + 1e-9,
        "chair limits/v_bay_max, chair limits/v_max",
        f"the speed in the bay, {limits.v_bay_max} m/s, is larger than that outside, {fastest} m/s",
    )
    depth = max(0.0, -(dock.bay.entrance_x - given.chair.length_front))
    needed = depth / limits.v_bay_max
    findings.require(
        needed < p.sequence.timeouts.final,
        "chair limits/v_bay_max, controller sequence/timeouts/final",
        f"{depth:.2f} m in the bay at {limits.v_bay_max} m/s take {needed:.0f} s, and the final straight may take "
        f"{p.sequence.timeouts.final:.0f} s",
    )
    horizon, stopping = p.control.horizon * p.control.step, limits.v_max / limits.a_max
    findings.expect(
        p.control.last_step > 0.0 or horizon >= stopping,
        "controller control/horizon, controller control/step, chair limits/v_max, chair limits/a_max",
        f"a plan of {horizon:.2f} s does not reach the end of braking, which takes {stopping:.2f} s",
    )
    findings.require(
        p.planner.reach >= 0.5 - dock.predock_x,
        "controller planner/reach, dock predock_x",
        f"the search begins {p.planner.reach:.1f} m ahead of the dock, and must begin 0.5 m ahead of the predock point "
        f"at {dock.predock_x:.2f} m",
    )


def check_times(given: Given, findings: Findings) -> None:
    """Periods against steps, waiting times against rates."""
    control, sequence = given.parameters.control, given.parameters.sequence
    findings.require(
        control.control_period <= control.step + 1e-9,
        "controller control/control_period, controller control/step",
        f"a command holds for {control.control_period} s, longer than the plan's first step of {control.step} s",
    )
    findings.require(
        sequence.odometry_timeout >= 2.0 * control.control_period - 1e-9,
        "controller sequence/odometry_timeout, controller control/control_period",
        f"odometry counts as lost after {sequence.odometry_timeout} s, less than two cycles of "
        f"{control.control_period} s",
    )
    findings.require(
        control.stop_margin <= control.margin + 1e-9,
        "controller control/stop_margin, controller control/margin",
        f"plans keep {control.margin} m, and the chair brakes at {control.stop_margin} m: it would stop on its "
        f"own plan",
    )
    rate = sequence.verify_measurements / sequence.timeouts.verify
    findings.expect(
        rate <= SLOWEST_CAMERA,
        "controller sequence/verify_measurements, controller sequence/timeouts/verify",
        f"the camera must find the dock {rate:.1f} times per second, or verification times out",
    )


def check_tolerance(given: Given, findings: Findings) -> None:
    """The dock's tolerance against the zones in which the chair is stopped, and against the chair's deadband."""
    tolerance, sequence = given.dock.tolerance, given.parameters.sequence
    prediction = given.parameters.control.prediction
    latency = given.parameters.control.control_period + prediction.motor_lag
    for name, unit, axis, limit in (
        ("position", "m", "v", given.chair.limits.v_bay_max),
        ("heading", "rad", "omega", given.chair.limits.omega_max),
    ):
        allowed = getattr(tolerance, name)
        hold, release = getattr(sequence, f"hold_{name}"), getattr(sequence, f"release_{name}")
        findings.require(
            hold <= allowed,
            f"dock tolerance/{name}, controller sequence/hold_{name}",
            f"the chair is stopped within {hold} {unit}, which is more than the {allowed} {unit} that count as docked",
        )
        findings.expect(
            release <= allowed,
            f"dock tolerance/{name}, controller sequence/release_{name}",
            f"the stopped chair stays up to {release} {unit} away, though more than {allowed} {unit} is not docked",
        )
        findings.require(
            hold < release,
            f"controller sequence/hold_{name}, controller sequence/release_{name}",
            f"the chair is stopped within {hold} {unit} and must be released farther away, not at {release} {unit}",
        )
        deadband = float(getattr(prediction, f"deadband_{axis}", 0.0))
        findings.require(
            deadband < limit,
            f"controller control/prediction/deadband_{axis}, chair limits",
            f"commands up to {deadband} {unit}/s do not move the chair, and it may be asked for at most "
            f"{limit} {unit}/s",
        )
        findings.expect(
            deadband * latency <= allowed,
            f"controller control/prediction/deadband_{axis}, dock tolerance/{name}",
            f"the smallest move, {deadband} {unit}/s for {latency:.2f} s, is larger than the {allowed} {unit} that "
            f"count as docked",
        )
