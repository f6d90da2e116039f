"""The bundle adjustment finds what is there, is right about how sure it is, and refuses what a drive cannot show."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from drive_by_hand import CAMERA, TRACK, TURNS, Truth, corners_of, make_drive
from scipy.stats import chi2

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock
from seater_tools.drive.drive import DriveError
from seater_tools.mount.gauge import held_still
from seater_tools.mount.prior import Lengths
from seater_tools.mount.result import camera_of, judge
from seater_tools.mount.solve import Solution, solve

IMAGES = 60  # enough for a test
TRUTH = Truth()
DISTANCE = math.dist(TRUTH.markers[1][2:5], TRUTH.markers[2][2:5])
TAPE = Lengths(distances=((1, 2, DISTANCE),))


@pytest.fixture(scope="module")
def solution() -> Solution:
    return solve(make_drive(TRUTH), CAMERA, CameraMount(), Dock(), TAPE, IMAGES)


def rows_of(dock: Dock) -> np.ndarray:
    return np.array([[*m.position, m.normal_yaw] for m in dock.markers])


def true_rows(truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    """Markers (x, y, z, yaw) moved as one to where the file's mean is, and that motion."""
    file, rows = rows_of(Dock()), rows_of(truth.dock)
    rows[:, 3] = file[:, 3] + np.remainder(rows[:, 3] - file[:, 3] + math.pi, 2.0 * math.pi) - math.pi
    return held_still(file, rows)


def test_the_camera_is_found_where_it_is(solution: Solution) -> None:
    layout, sd = solution.problem.layout, np.sqrt(np.diag(solution.covariance))
    true = np.array(TRUTH.mount)
    true[2] += true_rows(TRUTH)[1][2]  # height counts from the markers
    off = layout.mount(solution.state) - true
    assert np.all(np.abs(off[:3]) < 0.002), off
    assert np.all(np.abs(off[3:]) < 0.001), off
    assert np.all(np.abs(off) < 4.0 * layout.mount(sd)), off / layout.mount(sd)
    assert np.all(layout.mount(sd) < [0.0015, 0.0015, 0.0015, 0.001, 0.001, 0.001])


def test_markers_and_sizes_are_found(solution: Solution) -> None:
    layout = solution.problem.layout
    found, (rows, _) = layout.markers(solution.state), true_rows(TRUTH)
    assert np.abs(found[:, :3] - rows[:, :3]).max() < 0.001
    assert np.abs(found[:, 3] - rows[:, 3]).max() < 0.004
    sizes = [row[1] for row in TRUTH.markers]
    assert [0.1, 0.15, 0.15] * np.exp(found[:, 6]) == pytest.approx(sizes, rel=0.002)
    assert found[:, 4:6] == pytest.approx(np.array([row[6:8] for row in TRUTH.markers]), abs=0.003)


def test_odometry_errors_are_found(solution: Solution) -> None:
    scale, heading_scale, drift, *_ = solution.problem.layout.odometry(solution.state)
    assert scale == pytest.approx(TRUTH.scale, abs=0.002)
    assert heading_scale == pytest.approx(TRUTH.heading_scale, abs=0.003)
    assert drift == pytest.approx(TRUTH.heading_drift, abs=0.003)


def test_wheels_of_different_radii_are_no_camera_to_the_side() -> None:
    """1 % larger left, 1 % smaller right: the chair turns about a point 2.8 mm beside the middle."""
    truth = dataclasses.replace(TRUTH, radii=(0.01, -0.01), scale=0.0, heading_scale=0.0, heading_drift=0.0)
    found = solve(make_drive(truth), CAMERA, CameraMount(), Dock(), TAPE, 120)
    layout = found.problem.layout
    _, _, drift, way_per_turn, *_ = layout.odometry(found.state)
    assert drift == pytest.approx(0.02 / TRACK, abs=0.003)
    assert way_per_turn == pytest.approx(-0.02 * TRACK / 4.0, abs=0.001)
    assert layout.mount(found.state)[1] == pytest.approx(TRUTH.mount[1], abs=0.0015)


@pytest.mark.extensive  # of one drive: test_the_camera_is_found_where_it_is
def test_other_noise_gives_other_standard_deviations_and_they_are_right() -> None:
    """Six drives: normalised errors of the mount are about one. Odometry is exact here, so the corners decide."""
    normalised = []
    for seed in range(6):
        found = solve(make_drive(TRUTH, seed), CAMERA, CameraMount(), Dock(), TAPE, 40)
        sd = np.sqrt(np.diag(found.covariance))
        true = np.array(TRUTH.mount)
        true[2] += true_rows(TRUTH)[1][2]
        normalised.append((found.problem.layout.mount(found.state) - true) / found.problem.layout.mount(sd))
    rms = np.sqrt(np.mean(np.array(normalised) ** 2, axis=0))
    # x hangs on the tape, which is exact here; the others: chi with 6 degrees of freedom, 99.9 %.
    assert np.all(rms[1:] < 1.9), rms
    assert np.all(rms[3:] > 0.25), rms


def test_the_scale_comes_from_what_was_measured() -> None:
    """The same drive with a tape that is read 1 % long makes everything 1 % larger."""
    long = Lengths(distances=((1, 2, 1.01 * DISTANCE),))
    found = solve(make_drive(TRUTH), CAMERA, CameraMount(), Dock(), long, IMAGES)
    assert found.problem.layout.odometry(found.state)[0] == pytest.approx(1.012 / 1.01 - 1.0, abs=0.003)
    assert found.problem.layout.mount(found.state)[0] == pytest.approx(1.01 * TRUTH.mount[0], abs=0.002)
    nothing = Lengths()
    unknown = judge(solve(make_drive(TRUTH), CAMERA, CameraMount(), Dock(), nothing, IMAGES), Dock(), nothing)
    assert 0.005 < unknown.scale_sd < 0.02
    assert any("No length was measured by hand" in note for note in unknown.notes)


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ([(0.25, 0.0, 7.0), (-0.25, 0.0, 6.0)], "turn on the spot, 25 deg"),
        ([*TURNS, *TURNS], "drive straight, at least 1 m"),
    ],
)
def test_a_drive_that_does_not_constrain_the_mount_says_which_movement_is_missing(
    moves: list[tuple[float, float, float]], words: str
) -> None:
    truth = dataclasses.replace(TRUTH, moves=moves)
    found = judge(solve(make_drive(truth), CAMERA, CameraMount(), Dock(), TAPE, IMAGES), Dock(), TAPE)
    assert any(movement.startswith(words) for movement in found.missing), found.missing


def test_a_drive_that_constrains_misses_nothing(solution: Solution) -> None:
    assert judge(solution, Dock(), TAPE).missing == []


def test_one_marker_and_no_turn_ask_for_another_marker_too() -> None:
    truth = dataclasses.replace(TRUTH, markers=TRUTH.markers[:1], moves=[(0.25, 0.0, 7.0), (-0.25, 0.0, 6.0)])
    side = Lengths(sides={0: TRUTH.markers[0][1]})
    found = judge(solve(make_drive(truth), CAMERA, CameraMount(), Dock(), side, IMAGES), Dock(), side)
    assert found.missing[-1] == "hang at least two markers" and len(found.missing) > 1


def test_stamps_that_are_early_are_noticed() -> None:
    drive = make_drive(TRUTH)
    early = dataclasses.replace(drive, stamps=drive.stamps - 0.03).chosen(np.arange(1, len(drive.stamps)))
    found = solve(early, CAMERA, CameraMount(), Dock(), TAPE, IMAGES)
    assert found.problem.layout.odometry(found.state)[5] == pytest.approx(0.03, abs=0.004)
    assert found.problem.layout.mount(found.state)[0] == pytest.approx(TRUTH.mount[0], abs=0.002)


def test_a_standing_chair_and_foreign_markers_are_refused() -> None:
    standing = dataclasses.replace(TRUTH, moves=[(0.0, 0.0, 10.0)])
    with pytest.raises(DriveError, match="the chair hardly moves"):
        solve(make_drive(standing), CAMERA, CameraMount(), Dock(), TAPE, IMAGES)
    foreign = dataclasses.replace(TRUTH, markers=((9, *TRUTH.markers[0][1:]),))
    with pytest.raises(DriveError, match="shows markers 9, the dock file has none"):
        solve(make_drive(foreign), CAMERA, CameraMount(), Dock(), TAPE, IMAGES)


def test_a_marker_that_was_not_seen_keeps_its_place() -> None:
    truth = dataclasses.replace(TRUTH, markers=TRUTH.markers[1:])
    found = judge(solve(make_drive(truth), CAMERA, CameraMount(), Dock(), TAPE, IMAGES), Dock(), TAPE)
    assert {value.kept for value in found.markers[0]} == {"was not seen"}
    assert [value.used for value in found.markers[0]] == [0.9, 0.0, 0.7, pytest.approx(math.pi), 0.1]
    assert "Marker 0 keeps the file's place and size: was not seen." in found.notes


def test_wrong_corners_in_some_images_do_no_harm() -> None:
    drive = make_drive(TRUTH)
    corners = drive.corners.copy()
    corners[::40] += 40.0  # [px]: what a reflection or another print of the same number does
    wrong = dataclasses.replace(drive, corners=corners)
    found = solve(wrong, CAMERA, CameraMount(), Dock(), TAPE, IMAGES)
    off = found.problem.layout.mount(found.state) - TRUTH.mount
    assert np.all(np.abs(off[[0, 1]]) < 0.003) and np.all(np.abs(off[3:]) < 0.0015), off


def test_a_leaning_print_is_told() -> None:
    leaning = tuple((*row[:6], row[6] + 0.03 * (row[0] == 1), row[7]) for row in TRUTH.markers)
    truth = dataclasses.replace(TRUTH, markers=leaning)
    found = judge(solve(make_drive(truth), CAMERA, CameraMount(), Dock(), TAPE, IMAGES), Dock(), TAPE)
    assert any(note.startswith("Marker 1 leans by 1.4 deg: hang it upright") for note in found.notes), found.notes


def test_a_point_of_the_model_is_where_opencv_puts_it(solution: Solution) -> None:
    """With the truth for the state, model and OpenCV agree to the noise, marker by marker."""
    problem, layout = solution.problem, solution.problem.layout
    state = solution.state.copy()
    layout.mount(state)[:] = TRUTH.mount
    layout.markers(state)[:] = [
        (*r[2:8], np.log(r[1] / s)) for r, s in zip(TRUTH.markers, (0.1, 0.15, 0.15), strict=True)
    ]
    layout.poses(state)[:] = [-1.2, 0.1, 0.05]
    expected = {int(row[0]): corners_of(row, np.array([-1.2, 0.1, 0.05]), TRUTH.mount) for row in TRUTH.markers}
    for id, corners in zip(problem.drive.ids, problem.corners(state), strict=True):
        assert corners == pytest.approx(expected[int(id)], abs=1e-6)


# Of fx, fy, cx, cy, k1, k2, p1, p2, k3: what twenty views of a board leave, fx and fy nearly as one.
LENS_SD = np.array([0.25, 0.25, 0.4, 0.4, 4e-4, 8e-4, 5e-5, 6e-5, 5e-4])
_TOGETHER = np.eye(9)
_TOGETHER[0, 1] = _TOGETHER[1, 0] = 0.98
LENS_COVARIANCE = _TOGETHER * np.outer(LENS_SD, LENS_SD)


def calibrated(seed: int) -> CameraModel:
    """CAMERA as such views make it."""
    off = np.random.default_rng(seed).multivariate_normal(np.zeros(9), LENS_COVARIANCE)
    K = CAMERA.K + np.array([[off[0], 0.0, off[2]], [0.0, off[1], off[3]], [0.0, 0.0, 0.0]])
    return dataclasses.replace(CAMERA, K=K, D=CAMERA.D + off[4:], covariance=LENS_COVARIANCE)


@pytest.mark.parametrize("seeds", [range(1, 2), pytest.param(range(6), marks=pytest.mark.extensive)])
def test_a_lens_that_is_a_little_off_does_not_move_the_camera_unnoticed(seeds: range) -> None:
    """Taken for exact such calibrations put the camera elsewhere by many of its standard deviations."""
    normalised, exact, drive = [], [], make_drive(TRUTH)
    true = np.array(TRUTH.mount)
    true[2] += true_rows(TRUTH)[1][2]
    for seed in seeds:
        camera = calibrated(seed)
        for known, errors in ((dataclasses.replace(camera, covariance=None), exact), (camera, normalised)):
            found = solve(drive, known, CameraMount(), Dock(), TAPE, 40)
            layout, sd = found.problem.layout, np.sqrt(np.diag(found.covariance))
            errors.append((layout.mount(found.state) - true) / layout.mount(sd))
        lens = camera_of(found)
        assert lens.covariance is not None
        assert np.all(np.diag(lens.covariance) <= 1.001 * np.diag(LENS_COVARIANCE))
        assert abs(lens.K[0, 0] - CAMERA.K[0, 0]) < 4.0 * math.sqrt(lens.covariance[0, 0])
    limit = math.sqrt(chi2.ppf(0.999, len(seeds)) / len(seeds))
    assert np.all(np.sqrt(np.mean(np.square(normalised), axis=0)) < limit)
    assert np.max(np.abs(exact)) > 10.0 > 4.0 > np.max(np.abs(normalised))


def test_a_drive_that_contradicts_the_lens_says_so() -> None:
    other = dataclasses.replace(calibrated(1), K=CAMERA.K + np.diag([6.0, 6.0, 0.0]))  # 1 % of the focal length
    notes = judge(solve(make_drive(TRUTH), other, CameraMount(), Dock(), TAPE, IMAGES), Dock(), TAPE).notes
    assert any("does not go with the lens' calibration" in note for note in notes)
    right = judge(solve(make_drive(TRUTH), calibrated(1), CameraMount(), Dock(), TAPE, IMAGES), Dock(), TAPE)
    assert not any("lens" in note for note in right.notes)
    assert [value.name for value in right.lens] == ["fx", "fy", "cx", "cy"]
