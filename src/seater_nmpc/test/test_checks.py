"""Checks across the files of config/: each names the keys of both sides, and the shipped files pass without a word."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from seater_common.camera_model import CameraModel
from seater_common.geometry import Bay, CameraMount, Chair, Dock, Limits, Marker, Tolerance
from seater_common.params import ParameterError, load
from seater_nmpc.checks.bay import SMALLEST_MARGIN
from seater_nmpc.checks.findings import Findings, Given
from seater_nmpc.checks.motion import check_tolerance
from seater_nmpc.checks.setup import check_setup
from seater_nmpc.parameters import NmpcParameters, SequenceParameters, Timeouts
from seater_nmpc.sequence.vehicle import turned_about

ROOT = Path(__file__).resolve().parents[3]


def read(path: str) -> object:
    return yaml.safe_load((ROOT / path).read_text())


CHAIR, DOCK = load(Chair, read("config/chair.yaml"), "chair"), load(Dock, read("config/docks/default.yaml"), "dock")
PARAMETERS = load(NmpcParameters, read("config/controller.yaml"), "controller")
CAMERA = CameraModel.from_mapping(read("config/cameras/d455.yaml"))


def test_the_shipped_files_fit_together_and_nothing_is_changed() -> None:
    assert check_setup(CHAIR, DOCK, PARAMETERS, CAMERA) == (PARAMETERS, [])
    assert check_setup(CHAIR, DOCK, PARAMETERS, None) == (PARAMETERS, [])
    chair = turned_about(load(Chair, read("test/config/chair_backward.yaml"), "chair"))
    dock = load(Dock, read("test/config/dock_backward.yaml"), "dock")
    assert check_setup(chair, dock, PARAMETERS, CAMERA) == (PARAMETERS, [])


@pytest.mark.parametrize("width", [0.85, 0.80, 0.74])
def test_margins_and_corridor_shrink_together_in_a_narrow_bay(width: float) -> None:
    markers = [replace(marker, position=[0.9, 0.7 * marker.position[1], 0.7]) for marker in DOCK.markers]
    gap, dock = 0.5 * (width - CHAIR.width), replace(DOCK, bay=Bay(width=width), markers=markers)
    adjusted, warnings = check_setup(CHAIR, dock, PARAMETERS, CAMERA)
    margin, extra = adjusted.control.margin, adjusted.planner.extra_margin
    assert SMALLEST_MARGIN <= margin <= PARAMETERS.control.margin and margin + extra < gap
    assert adjusted.sequence.corridor_half_width < gap - margin
    assert adjusted.sequence.corridor_heading * CHAIR.length_front <= gap - margin + 1e-12
    if width < 0.85:
        (warning,) = warnings
        for words in ("control/margin", "planner/extra_margin", "dock bay/width", "chair width", f"{margin:.3f} m"):
            assert words in warning


def test_without_walls_the_bay_is_not_looked_at() -> None:
    parameters = replace(PARAMETERS, control=replace(PARAMETERS.control, walls=False))
    assert check_setup(CHAIR, replace(DOCK, bay=Bay(width=0.5)), parameters, CAMERA) == (parameters, [])


def with_control(**changes: object) -> NmpcParameters:
    return replace(PARAMETERS, control=replace(PARAMETERS.control, **changes))


def with_sequence(**changes: object) -> NmpcParameters:
    return replace(PARAMETERS, sequence=replace(SequenceParameters(), **changes))


def with_limits(**changes: float) -> Chair:
    return replace(CHAIR, limits=replace(Limits(), **changes))


def with_markers(*markers: Marker) -> Dock:
    return replace(DOCK, markers=list(markers))


MARKER_ASIDE = Marker(0, 0.1, [0.9, 0.2, 0.7], math.pi)
ERRORS = [
    ({"dock": replace(DOCK, bay=Bay(width=0.7))}, ("dock bay/width", "chair width", "0.700", "0.650", "0.736")),
    ({"dock": replace(DOCK, bay=Bay(back_wall_x=0.77))}, ("dock bay/back_wall_x", "chair length_front", "0.020 m")),
    ({"dock": replace(DOCK, predock_x=-0.8)}, ("dock predock_x", "chair length_front", "bay/side_wall_length")),
    ({"dock": with_markers(Marker(0, 0.1, [0.9, 0.0, 1.1], math.pi))}, ("dock markers", "chair camera", "above")),
    ({"dock": with_markers(Marker(0, 0.1, [0.9, 0.0, 0.7], 0.0))}, ("dock markers", "show their backs")),
    ({"chair": replace(CHAIR, camera=CameraMount(yaw=1.0))}, ("chair camera", "camera camera_matrix", "beside")),
    (
        {"dock": with_markers(Marker(0, 0.1, [0.9, 0.4, 0.7], math.pi)), "camera": None},
        ("dock markers", "camera (none given)", "unknown camera"),
    ),
    (
        {
            "dock": with_markers(Marker(0, 0.1, [0.9, 0.2, 0.7], math.pi)),
            "parameters": with_control(view_half_angle=0.2),
        },
        ("dock markers", "control/view_half_angle is 0.20"),
    ),
    ({"chair": with_limits(v_bay_max=0.7)}, ("chair limits/v_bay_max", "chair limits/v_max")),
    ({"chair": with_limits(v_bay_max=0.01)}, ("chair limits/v_bay_max", "sequence/timeouts/final")),
    ({"dock": replace(DOCK, tolerance=Tolerance(0.002, 0.02))}, ("dock tolerance/position", "sequence/hold_position")),
    ({"dock": replace(DOCK, tolerance=Tolerance(0.01, 0.004))}, ("dock tolerance/heading", "sequence/hold_heading")),
    ({"parameters": with_sequence(release_position=0.003)}, ("sequence/hold_position", "sequence/release_position")),
    ({"parameters": with_control(stop_margin=0.1)}, ("control/stop_margin", "control/margin")),
    ({"parameters": with_control(control_period=0.2)}, ("control/control_period", "control/step")),
    ({"parameters": with_sequence(odometry_timeout=0.05)}, ("sequence/odometry_timeout", "control/control_period")),
    (
        {
            "dock": replace(DOCK, predock_x=-1.8),
            "parameters": replace(PARAMETERS, planner=replace(PARAMETERS.planner, reach=2.0)),
        },
        ("controller planner/reach", "dock predock_x"),
    ),
]


@pytest.mark.parametrize(("changes", "words"), ERRORS, ids=[words[0] for _, words in ERRORS])
def test_what_does_not_fit_is_refused_with_the_keys_of_both_sides(changes: dict, words: tuple[str, ...]) -> None:
    given = {"chair": CHAIR, "dock": DOCK, "parameters": PARAMETERS, "camera": CAMERA} | changes
    with pytest.raises(ParameterError) as caught:
        check_setup(**given, files={"dock": "some/dock.yaml"})
    for word in (*words, "some/dock.yaml"):
        assert word in str(caught.value)


WARNINGS = [
    ({"dock": replace(DOCK, tolerance=Tolerance(0.005, 0.02))}, ("dock tolerance/position", "release_position")),
    ({"parameters": with_sequence(timeouts=Timeouts(verify=2.0))}, ("verify_measurements", "timeouts/verify", "5.0")),
    ({"parameters": with_control(horizon=5)}, ("control/horizon", "chair limits/a_max")),
    ({"dock": with_markers(Marker(0, 0.05, [0.9, 0.0, 0.7], math.pi))}, ("dock markers/size", "19 px")),
    (
        {"dock": with_markers(Marker(0, 0.1, [0.9, 0.0, 0.7], math.pi), Marker(1, 0.1, [0.9, 0.46, 0.7], math.pi))},
        ("dock bay/width", "marker 1", "0.510 m", "0.500 m"),
    ),
]


@pytest.mark.parametrize(("changes", "words"), WARNINGS, ids=[words[0] for _, words in WARNINGS])
def test_what_is_doubtful_is_said(changes: dict, words: tuple[str, ...]) -> None:
    given = {"chair": CHAIR, "dock": DOCK, "parameters": PARAMETERS, "camera": CAMERA} | changes
    _, (warning,) = check_setup(**given)
    for word in words:
        assert word in warning


def test_markers_that_leave_the_image_on_the_way_are_noticed() -> None:
    """The camera looks to the left; one marker is on the right, and one shows its front to the docked chair only."""
    far, near = Marker(0, 0.1, [0.9, -0.45, 0.7], math.pi), Marker(1, 0.05, [0.85, 0.45, 0.7], -0.25 * math.pi)
    chair = replace(CHAIR, camera=replace(CHAIR.camera, yaw=0.3))
    with pytest.raises(ParameterError, match="controller sequence/max_blind_distance: on the final straight no marker"):
        check_setup(chair, with_markers(far, near), PARAMETERS, CAMERA)
    patient = with_sequence(max_blind_distance=1.0)
    assert check_setup(chair, with_markers(far, near), patient, CAMERA) == (patient, [])


def test_a_deadband_larger_than_the_tolerance_is_said_and_one_beyond_the_limits_refused() -> None:
    """Deadbands are read where the prediction has them."""

    def findings(**deadbands: float) -> Findings:
        prediction = SimpleNamespace(motor_lag=0.2, **deadbands)
        parameters = SimpleNamespace(control=SimpleNamespace(prediction=prediction, control_period=0.05))
        parameters.sequence = PARAMETERS.sequence
        found = Findings()
        check_tolerance(Given(CHAIR, DOCK, parameters, CAMERA), found)  # type: ignore[arg-type]
        return found

    assert findings(deadband_v=0.02, deadband_omega=0.05) == Findings()
    assert "deadband_omega" in findings(deadband_v=0.0, deadband_omega=0.1).warnings[0]
    assert "deadband_v" in findings(deadband_v=0.2, deadband_omega=0.0).errors[0]
