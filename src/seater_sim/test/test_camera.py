"""Images against projection: where the renderer puts the markers, to hundredths of a pixel."""

import dataclasses
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.geometry import Bay, Chair, Dock, Marker
from seater_sim.camera.camera import Camera
from seater_sim.settings import CameraSettings, Obstacle

IDEAL = CameraSettings(blur_sd=0.0, noise_sd=0.0, vignetting=0.0, exposure=0.0)
DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)


# An estimator of edges that is independent of the renderer: the part of a column of pixels that is white, summed from
# inside the sheet's white margin to inside the print's black border, is exactly where the edge is (on average over the
# pixel's width), if a pixel is the mean of the light over its square.


def edge_points(image: np.ndarray, corners: np.ndarray, side: int, reach: float) -> np.ndarray:
    """Points (n, 2) [px] on one side of the printed square, whose outer border is white and inner one black.

    `side` 0: top, 1: right, 2: bottom, 3: left, of a print that stands upright in the image. `corners`: (4, 2) [px],
    roughly, top-left first; `reach`: how far a scan goes to both sides of the edge [px].
    """
    a, b = corners[side], corners[(side + 1) % 4]
    along = 0 if side in (0, 2) else 1
    across = 1 - along
    outwards = -1 if side in (0, 3) else 1
    low, high = sorted((a[along], b[along]))
    points = []
    for at in range(int(np.ceil(low + reach)), int(np.floor(high - reach)) + 1):
        middle = a[across] + (b[across] - a[across]) * (at - a[along]) / (b[along] - a[along])
        inner, outer = sorted((round(middle - reach), round(middle + reach)))
        scan = image[inner : outer + 1, at] if along == 0 else image[at, inner : outer + 1]
        light = scan.astype(float)
        if outwards > 0:  # black comes first: count it from the inner end
            black, white = light[0], light[-1]
            position = inner - 0.5 + np.sum((white - light) / (white - black))
        else:
            white, black = light[0], light[-1]
            position = inner - 0.5 + np.sum((light - black) / (white - black))
        points.append((at, position) if along == 0 else (position, at))
    return np.array(points)


def corners_by_edges(image: np.ndarray, corners: np.ndarray, reach: float) -> np.ndarray:
    """Corners (4, 2) [px] as crossings of straight lines through the edges' points."""
    lines = []
    for side in range(4):
        points = edge_points(image, corners, side, reach)
        dx, dy, x, y = cv2.fitLine(points.astype(np.float32), cv2.DIST_L2, 0, 1e-6, 1e-6).reshape(-1)
        lines.append(np.cross([x, y, 1.0], [x + dx, y + dy, 1.0]))
    crossings = np.array([np.cross(lines[(side - 1) % 4], lines[side]) for side in range(4)])
    return crossings[:, :2] / crossings[:, 2:]


def found(image: np.ndarray) -> dict[int, np.ndarray]:
    """Corners (4, 2) by OpenCV's detector with its usual sub-pixel refinement."""
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    parameters = cv2.aruco.DetectorParameters_create()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.cornerRefinementWinSize = 3
    corners, ids, _ = cv2.aruco.detectMarkers(grey, DICTIONARY, parameters=parameters)
    return {} if ids is None else {int(i): c.reshape(4, 2) for i, c in zip(ids.ravel(), corners, strict=True)}


# Frontal views, where edges run along the pixel rows and sampling errors would add up, at places that put the edges at
# different parts of a pixel; then oblique ones.
POSES = [(x, y, 0.0) for x in (-2.2, -1.503, -0.8, -0.301, 0.0) for y in (0.0, 0.0317)]
POSES += [(-1.5, 0.7, -0.35), (-0.8, -0.25, 0.2), (-2.0, 1.0, -0.45)]


@pytest.mark.parametrize("pose", POSES)
def test_corners_are_where_projection_says(ideal_camera: Camera, pose: tuple[float, float, float]) -> None:
    image = ideal_camera.render(pose)
    truth = ideal_camera.marker_corners(pose)
    errors = []
    for number in found(image):  # the others are cut off or hidden by a side wall
        corners = truth[number]
        side = np.linalg.norm(corners[0] - corners[1])
        # A scan must reach into paper and ink on both sides of a slanting edge, but not beyond the border of one cell.
        measured = corners_by_edges(image, corners, max(2.0, 0.09 * float(side)))
        errors.append(np.abs(measured - corners).max())
    assert errors
    # Measured 0.002 .. 0.02 px; what is left is the rounding to grey levels, amplified by extrapolation to the corner.
    assert max(errors) < 0.05


def projected(lens: str, model: CameraModel, points: np.ndarray, T: np.ndarray) -> np.ndarray:
    """Pixels (n, 2) of points (n, 3) [m], by OpenCV."""
    rvec, tvec = cv2.Rodrigues(T[:3, :3])[0], T[:3, 3]
    if lens == "equidistant":
        return np.asarray(cv2.fisheye.projectPoints(points[:, None], rvec, tvec, model.K, model.D)[0].reshape(-1, 2))
    return np.asarray(cv2.projectPoints(points, rvec, tvec, model.K, model.D)[0].reshape(-1, 2))


@pytest.mark.parametrize("lens", ["plumb_bob", "rational_polynomial", "equidistant"])
def test_edges_follow_the_lens(with_lens: Callable[[str], CameraModel], lens: str) -> None:
    model = with_lens(lens)
    mount = Chair().camera
    camera = Camera(model, mount, Dock(), IDEAL)
    pose = (-0.5, 0.03, 0.02)
    image = camera.render(pose)
    T_optical_dock = np.linalg.inv(camera.T_dock_optical(pose))
    for sheet in camera.scene.sheets:
        t = np.linspace(0.0, 1.0, 200)[:, None]
        for side in range(4):
            a, b = sheet.outline[side], sheet.outline[(side + 1) % 4]
            curve = projected(lens, model, a + t * (b - a), T_optical_dock)
            points = edge_points(image, camera.marker_corners(pose)[sheet.marker.id], side, 5.0)
            along = 0 if side in (0, 2) else 1
            order = np.argsort(curve[:, along])
            expected = np.interp(points[:, along], curve[order, along], curve[order, 1 - along])
            errors = points[:, 1 - along] - expected
            assert len(errors) > 30
            assert abs(errors.mean()) < 0.02
            assert np.abs(errors).max() < 0.06


def test_distortion_moves_the_corners_by_pixels(with_lens: Callable[[str], CameraModel], ideal_camera: Camera) -> None:
    # Otherwise the test above could pass with a lens that does nothing.
    camera = Camera(with_lens("plumb_bob"), Chair().camera, Dock(), IDEAL)
    difference = camera.marker_corners((-0.3, 0, 0))[1] - ideal_camera.marker_corners((-0.3, 0, 0))[1]
    assert np.abs(difference).max() > 2.0


@pytest.mark.parametrize("distance", [0.45, 0.6, 0.9, 1.25, 1.7, 2.2, 2.6])
def test_opencv_finds_all_markers(camera: Camera, distance: float) -> None:
    pose = (0.45 - distance, 0.0, 0.0)
    markers, truth = found(camera.render(pose, index=3)), camera.marker_corners(pose)
    assert set(markers) == {0, 1, 2}
    for number, corners in markers.items():
        # Wide enough for OpenCV's refinement; half a pixel of convention or a mirrored print would not pass.
        assert np.abs(corners - truth[number]).max() < 0.45


def test_opencv_finds_the_large_markers_at_three_metres(camera: Camera) -> None:
    assert {1, 2} <= set(found(camera.render((-2.55, 0.0, 0.0), index=1)))


def test_pixel_convention_on_average(camera: Camera) -> None:
    differences = []
    for k in range(12):
        pose = (-0.9 - 0.05 * k, 0.013 * k, -0.01 * k)
        truth = camera.marker_corners(pose)
        for number, corners in found(camera.render(pose, index=k)).items():
            differences.append((corners - truth[number]).mean(axis=0))
    assert len(differences) > 24
    np.testing.assert_allclose(np.mean(differences, axis=0), 0.0, atol=0.05)


def test_covered_markers_are_not_seen(camera: Camera) -> None:
    assert set(found(camera.render((-1.0, 0.0, 0.0), covered={0}))) == {1, 2}
    assert found(camera.render((-1.0, 0.0, 0.0), covered={0, 1, 2})) == {}


def test_side_wall_hides_the_markers(camera: Camera) -> None:
    pose = (-0.4, 1.7, -0.9)
    corners = np.concatenate(list(camera.marker_corners(pose).values()))
    assert np.any(np.all((corners > 0) & (corners < [1279, 719]), axis=1))  # in the field of view
    assert found(camera.render(pose)) == {}


def test_nothing_hides_the_markers_of_an_open_dock(model: CameraModel) -> None:
    dock = dataclasses.replace(Dock(), bay=Bay(side_wall_length=0.0))
    assert set(found(Camera(model, Chair().camera, dock).render((-0.4, 1.7, -0.9)))) >= {0, 1}


def test_obstacle_is_drawn_in_front(model: CameraModel) -> None:
    obstacle = Obstacle([-0.6, -0.06, -0.5, -0.06, -0.5, 0.06, -0.6, 0.06], 1.1)
    camera = Camera(model, Chair().camera, Dock(), obstacles=[obstacle])
    assert set(found(camera.render((-2.0, 0.0, 0.0)))) == {1, 2}  # the one in the middle is behind it


def test_markers_are_not_seen_from_behind(model: CameraModel) -> None:
    dock = dataclasses.replace(Dock(), markers=[Marker(0, 0.1, [0.0, 0.0, 0.7], 0.0)])  # faces away from the camera
    camera = Camera(model, Chair().camera, dock)
    assert found(camera.render((-1.5, 0.0, 0.0))) == {}
    assert set(found(Camera(model, Chair().camera, Dock()).render((-1.5, 0.0, 0.0)))) == {0, 1, 2}


def test_rgb_is_the_coloured_mono(model: CameraModel) -> None:
    grey = Camera(model, Chair().camera, Dock(), IDEAL).render((-1.5, 0.3, -0.2))
    colour = Camera(model, Chair().camera, Dock(), dataclasses.replace(IDEAL, encoding="rgb8")).render(
        (-1.5, 0.3, -0.2)
    )
    assert grey.shape == (720, 1280) and colour.shape == (720, 1280, 3) and colour.dtype == np.uint8
    assert np.abs(cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY).astype(int) - grey).max() <= 2
    assert np.ptp(colour[600, 640].astype(int)) > 5  # the mat is blue
    assert set(found(colour)) == {0, 1, 2}


def test_a_marker_that_is_not_in_the_dictionary_is_refused(model: CameraModel) -> None:
    with pytest.raises(ValueError, match=r"markers: id 77 is not in DICT_4X4_50 \(0\.\.49\)"):
        Camera(model, Chair().camera, dataclasses.replace(Dock(), markers=[Marker(77)]))
    with pytest.raises(ValueError, match="dictionary: is 'DICT_9X9'"):
        Camera(model, Chair().camera, dataclasses.replace(Dock(), dictionary="DICT_9X9"))


def test_every_view_of_the_room_can_be_drawn(camera: Camera) -> None:
    for k in range(24):
        image = camera.render((-1.5, 0.5, 0.2618 * k), index=k)
        assert image.shape == (720, 1280) and image.std() > 3.0


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.2, 3.0, 4.0, 5.3])
def test_faces_towards_the_camera_are_in_front(model: CameraModel, heading: float) -> None:
    obstacle = Obstacle([-4.3, -0.3, -3.7, -0.3, -3.7, 0.3, -4.3, 0.3], 1.0)
    camera = Camera(model, Chair().camera, Dock(), IDEAL, obstacles=[obstacle])
    pose = (-4.0 - 2.0 * np.cos(heading), -2.0 * np.sin(heading), heading)  # looks at its middle
    image = camera.render(pose)
    T = camera.T_dock_optical(pose)
    seen = 0
    for face in camera.scene.blocks[2].faces:
        centre = face.points.mean(axis=0)
        if face.normal @ (T[:3, 3] - centre) > 0.0:
            u, v = model.project((np.linalg.inv(T) @ [*centre, 1.0])[None, :3])[0]
            if v < 719 and face.normal[2] == 0.0:
                r, g, b = face.colour
                assert image[round(v), round(u)] == pytest.approx(0.299 * r + 0.587 * g + 0.114 * b, abs=1.0)
                seen += 1
    assert seen >= 1
