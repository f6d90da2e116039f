"""The campaign's camera sees exactly the markers that rendered images show."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from seater_common.geometry import polygon_distance
from seater_common.occlusion import Prism
from seater_eval.control.pose_noise import DockSensor, NoiseModel
from seater_eval.run.setup_files import Setup, load_setup
from seater_sim.camera.camera import Camera
from seater_sim.settings import CameraSettings, Obstacle

CONFIG = Path(__file__).resolve().parents[3] / "config"
BOX = Obstacle([-0.9, -0.25, -0.6, -0.25, -0.6, 0.05, -0.9, 0.05], 1.0)
# Of a marker's pixels. A whole print keeps at least 0.969 of them (its rim is anti-aliased; 155 prints); between these
# parts a print is neither whole nor clearly cut.
WHOLE, CUT = 0.98, 0.96


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_setup(CONFIG)


def shown(camera: Camera, pose: np.ndarray, index: int, corners: np.ndarray) -> float:
    """Part of a marker's pixels that covering it changes: what stands before it stays as it is."""
    marker = camera.scene.sheets[index].marker.id
    plain, covered = (camera.light(pose, 0.0, 0.0, ids).astype(int) for ids in ((), (marker,)))
    mask = np.zeros(plain.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.rint(corners * 16).astype(np.int32), 255, cv2.LINE_8, 4)
    return float(np.mean(np.abs(plain - covered)[mask > 0] > 2))


@pytest.mark.parametrize(
    "obstacles",
    [pytest.param([], marks=pytest.mark.extensive, id="walls"), pytest.param([BOX], id="walls and a box")],
)
def test_hidden_as_in_rendered_images(setup: Setup, obstacles: list[Obstacle]) -> None:
    """At random poses, of every marker that is wholly in the image; both kinds come often."""
    settings = CameraSettings(exposure=0.0)
    camera = Camera(setup.camera, setup.chair.camera, setup.dock, settings, obstacles=obstacles)
    prisms = [Prism(obstacle.polygon(), obstacle.height) for obstacle in obstacles]
    sensor = DockSensor(setup.chair, setup.dock, setup.camera, NoiseModel(), prisms)
    rng, counts, doubtful = np.random.default_rng(6), {True: 0, False: 0}, 0
    for _ in range(120):
        pose = rng.uniform([-2.5, -1.6, -0.9], [-0.7, 1.6, 0.9])
        outlines = [*setup.dock.bay.outlines(), *(prism.outline for prism in prisms)]
        if min(polygon_distance(setup.chair.corners_at(pose), outline) for outline in outlines) < 0.02:
            continue
        visible, corners = sensor.in_view(pose), camera.marker_corners(pose)
        for index, marker in enumerate(setup.dock.markers):
            inside = corners.get(marker.id, np.full((4, 2), -1.0))
            if np.any(inside < 3.0) or np.any(inside > [1276.0, 716.0]):
                assert index not in visible
                continue
            part = shown(camera, pose, index, inside)
            doubtful += CUT < part < WHOLE
            assert (index in visible) == (part >= WHOLE) or CUT < part < WHOLE, (pose, index, part)
            counts[index in visible] += 1
    assert counts[True] > 50 and counts[False] > 30 and doubtful < 0.2 * sum(counts.values())
