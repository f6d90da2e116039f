"""The chair in the bay: does it fit, and which margins can be kept."""

from __future__ import annotations

import math
from dataclasses import replace

from seater_common.geometry import Chair, Dock
from seater_nmpc.checks.findings import Findings, Given
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.free_space import final_straight_x

SMALLEST_MARGIN = 0.02  # [m] kept from every wall, however narrow the bay
_PLAN_PLAY = 0.005  # [m] beside the planner's margin on the dock's axis, so that rounding does not close the bay

_SAME = 1e-6  # [m] rounding


def play_aside(chair: Chair, dock: Dock) -> float:
    """How far a chair that counts as docked may be off to the side at its farther end [m]."""
    t = dock.tolerance
    return t.position + t.heading * max(chair.length_front, chair.length_rear)


def play_ahead(chair: Chair, dock: Dock) -> float:
    """How far its front may be too near to the back wall [m]."""
    return dock.tolerance.position + 0.5 * chair.width * dock.tolerance.heading


def check_bay(given: Given, findings: Findings) -> NmpcParameters:
    """Whether the chair fits; the parameters with margins and corridor that leave a way in."""
    chair, dock, parameters = given.chair, given.dock, given.parameters
    bay, wanted = dock.bay, parameters.control.margin
    aside = 0.5 * (bay.width - chair.width) if bay.side_wall_length > 0.0 else math.inf
    ahead = bay.back_wall_x - chair.length_front
    least_aside, least_ahead = SMALLEST_MARGIN + play_aside(chair, dock), SMALLEST_MARGIN + play_ahead(chair, dock)
    findings.require(
        aside >= least_aside - 1e-9,
        "dock bay/width, chair width",
        f"a bay of {bay.width:.3f} m leaves {aside:.3f} m on each side of a chair of {chair.width:.3f} m; needed are "
        f"{least_aside:.3f} m ({SMALLEST_MARGIN} m and what dock tolerance allows). A bay of at least "
        f"{chair.width + 2.0 * least_aside:.3f} m would fit, or a chair of at most "
        f"{max(0.0, bay.width - 2.0 * least_aside):.3f} m",
    )
    findings.require(
        ahead >= least_ahead - 1e-9,
        "dock bay/back_wall_x, chair length_front",
        f"the docked chair's front, {chair.length_front:.3f} m ahead of its axle, leaves {ahead:.3f} m to the back "
        f"wall; needed are {least_ahead:.3f} m: back_wall_x of at least {chair.length_front + least_ahead:.3f} m",
    )
    gate = final_straight_x(chair, dock) - parameters.sequence.gate_distance
    findings.require(
        dock.predock_x <= gate + 1e-9,
        "dock predock_x, dock bay/side_wall_length, chair length_front, controller sequence/gate_distance",
        f"at {dock.predock_x:.2f} m the chair reaches into the bay or has no straight left; it must be at most "
        f"{gate:.2f} m",
    )
    if findings.errors:
        return parameters
    margin = min(wanted, max(SMALLEST_MARGIN, min(0.5 * aside, aside - play_aside(chair, dock))))
    margin = min(margin, ahead - play_ahead(chair, dock))
    return _with_margin(given, findings, margin, aside)


def check_markers(given: Given, findings: Findings) -> None:
    """Warns of markers that would stand in a side wall: the camera sees them from nowhere, or only from afar."""
    bay = given.dock.bay
    for marker in given.dock.markers if bay.side_wall_length > 0.0 else []:
        x, y, _ = marker.position
        half = 0.5 * marker.size * abs(math.cos(marker.normal_yaw))
        findings.expect(
            abs(y) + half <= 0.5 * bay.width + _SAME or not bay.entrance_x < x <= bay.back_wall_x + _SAME,
            "dock markers, dock bay/width",
            f"marker {marker.id} reaches {abs(y) + half:.3f} m to the side, and the side wall begins at "
            f"{0.5 * bay.width:.3f} m: the wall hides it; without it the dock is less well known",
        )


def _with_margin(given: Given, findings: Findings, margin: float, aside: float) -> NmpcParameters:
    """Margin, planner's margin and corridor together: half of a narrow gap is kept, the other half is room to steer."""
    parameters, chair, bay = given.parameters, given.chair, given.dock.bay
    control, planner, sequence = parameters.control, parameters.planner, parameters.sequence
    extra = min(planner.extra_margin, max(0.0, aside - _PLAN_PLAY - margin))
    room = aside - margin
    # At the gate the front end must already fit between the walls.
    half_width = min(sequence.corridor_half_width, 0.8 * room)
    heading = min(sequence.corridor_heading, room / max(chair.length_front, 0.1))
    findings.expect(
        margin > control.margin - _SAME and extra > planner.extra_margin - _SAME,
        "controller control/margin, controller planner/extra_margin, dock bay/width, chair width",
        f"used are margin {margin:.3f} m (instead of {control.margin:.3f}) and extra_margin {extra:.3f} m (instead of "
        f"{planner.extra_margin:.3f}), as a bay of {bay.width:.3f} m and its back wall leave the chair no more",
    )
    return replace(
        parameters,
        control=replace(control, margin=margin, stop_margin=min(control.stop_margin, margin)),
        planner=replace(planner, extra_margin=extra),
        sequence=replace(sequence, corridor_half_width=half_width, corridor_heading=heading),
    )
