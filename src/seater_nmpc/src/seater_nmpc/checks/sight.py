"""Markers, camera and mount: are there markers in view from the predock point to the end."""

from __future__ import annotations

import numpy as np

from seater_common.field_of_view import FieldOfView
from seater_common.sight import Sight
from seater_nmpc.checks.findings import Findings, Given
from seater_nmpc.ocp.constraints.view import UNKNOWN_CAMERA, kept_field

# [px] side of a marker in the image at which it is found at last: the largest distances of the project's paper (table
# I: 50 mm at 1.50 m ... 150 mm at 3.75 m, with 640 px) give 21 to 26 px.
FOUND_PX = 21.0
_STEP = 0.02  # [m] between the places on the axis that are looked at


def check_sight(given: Given, findings: Findings) -> None:
    """Adds to the findings."""
    chair, dock, camera, control = given.chair, given.dock, given.camera, given.parameters.control
    if camera is not None:
        try:
            FieldOfView.of(camera)
        except ValueError as error:
            findings.errors.append(f"camera {error}")
            return
    sight = Sight(chair.camera, dock, kept_field(camera, control.view_half_angle))
    places = np.append(np.arange(dock.predock_x, 0.0, _STEP), 0.0)
    axis = np.column_stack([places, np.zeros((len(places), 2))])
    seen = sight.seen(axis)
    keys = f"dock markers, chair camera, {_camera_key(given)}"
    for row, where in ((0, f"the predock point ({dock.predock_x:.2f} m)"), (-1, "the docked pose")):
        findings.require(bool(np.any(seen[row])), keys, f"no marker is in view from {where}: {_why(given, axis[row])}")
    limit = given.parameters.sequence.max_blind_distance
    blind = _longest_gap(np.any(seen, axis=1)) * _STEP
    findings.require(
        findings.errors != [] or blind <= limit,
        f"{keys}, controller sequence/max_blind_distance",
        f"on the final straight no marker is in view for {blind:.2f} m, and the chair stops after {limit:.2f} m",
    )
    if camera is not None and np.any(seen[0]):
        largest = max(sight.pixels_across(axis[0], i, float(camera.K[0, 0])) for i in np.flatnonzero(seen[0]))
        findings.expect(
            largest >= FOUND_PX,
            "dock markers/size, dock predock_x, camera camera_matrix",
            f"from the predock point the largest marker is {largest:.0f} px wide; below {FOUND_PX:.0f} px it is seldom "
            f"found",
        )


def _camera_key(given: Given) -> str:
    return "camera camera_matrix" if given.camera is not None else "camera (none given)"


def _why(given: Given, pose: np.ndarray) -> str:
    """Which of the causes it is."""
    chair, dock, camera = given.chair, given.dock, given.camera
    half_angle = given.parameters.control.view_half_angle

    def any_seen(field: FieldOfView) -> bool:
        return bool(np.any(Sight(chair.camera, dock, field).seen(pose[None])))

    wide = kept_field(camera, 0.0)
    if half_angle > 0.0 and any_seen(wide):
        return f"controller control/view_half_angle is {half_angle:.2f} rad"
    if camera is None:
        return f"of an unknown camera {UNKNOWN_CAMERA} rad to both sides are reckoned with; give its calibration"
    if any_seen(FieldOfView(wide.left, wide.right, np.inf, np.inf)):
        return "they are above or below the image (camera z, pitch; markers' heights)"
    if any_seen(FieldOfView(np.inf, np.inf, wide.up, wide.down)):
        return "they are beside the image (camera x, y, yaw; markers' places)"
    if any_seen(FieldOfView(np.inf, np.inf, np.inf, np.inf)):
        return "they are outside the image (camera x, y, z, yaw, pitch; markers' places)"
    return "they are behind the camera, show their backs or hide behind the bay's walls"


def _longest_gap(seen: np.ndarray) -> int:
    """Largest number of False in a row."""
    longest = count = 0
    for value in seen.tolist():
        count = 0 if value else count + 1
        longest = max(longest, count)
    return longest
