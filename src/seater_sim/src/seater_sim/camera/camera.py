"""Images of the scene from the true pose of the camera."""

from __future__ import annotations

import math
from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock, pose_matrix
from seater_common.se2 import arc_step
from seater_sim.camera.ink import InkRenderer, marker_cells
from seater_sim.camera.sensor import Sensor
from seater_sim.camera.view import FaceSet, Frustum
from seater_sim.settings import CameraSettings, Obstacle, SceneSettings
from seater_sim.world.scene import Scene, Sheet, make_scene

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

# Motion within the exposure: so many pixels of it are covered by one rendering of the world, and of the prints.
BACKDROP_PX = 3.0
PRINT_PX = 1.0  # an area-sampled edge is a ramp of 1 px, so their mean has no steps
MAX_SUBFRAMES = 8


class Camera:
    """Renders what the camera on the chair sees. One instance serves one run or many; it keeps no state of a run."""

    def __init__(
        self,
        model: CameraModel,
        mount: CameraMount,
        dock: Dock,
        settings: CameraSettings | None = None,
        scene_settings: SceneSettings | None = None,
        obstacles: list[Obstacle] | None = None,
    ) -> None:
        """Raises ValueError when the dock's dictionary does not have its markers."""
        self.model = model
        self.settings = settings or CameraSettings()
        self._ink_reflectance = (scene_settings or SceneSettings()).ink
        self.scene: Scene = make_scene(dock, scene_settings or SceneSettings(), obstacles or [])
        self._T_base_optical = mount.T_base_optical()
        self._backdrop = FaceSet(self.scene.backdrop)
        self._blocks = [(block.centre, FaceSet(block.faces)) for block in self.scene.blocks]
        self._sheets = [(sheet, FaceSet([sheet.paper]), FaceSet([sheet.cover])) for sheet in self.scene.sheets]
        for marker in dock.markers:
            marker_cells(dock.dictionary, marker.id)
        self._frustum = Frustum(model)
        self._ink = InkRenderer(self._frustum, dock.dictionary)
        self._sensor = Sensor(self.settings, model.width, model.height)

    def T_dock_optical(self, T_dock_base: ArrayLike) -> Array:
        """4x4 pose of the optical frame in the dock frame, for a planar pose (x, y, heading) of the chair."""
        return pose_matrix(T_dock_base) @ self._T_base_optical

    def marker_corners(self, T_dock_base: ArrayLike) -> dict[int, Array]:
        """True corners (4, 2) [px] of every marker that is wholly in front of the camera, wherever they fall."""
        T = np.linalg.inv(self.T_dock_optical(T_dock_base))
        corners = {}
        for sheet in self.scene.sheets:
            points = sheet.outline @ T[:3, :3].T + T[:3, 3]
            if np.all(points[:, 2] > 0.0):
                corners[sheet.marker.id] = self.model.project(points)
        return corners

    def render(
        self,
        T_dock_base: ArrayLike,
        v: float = 0.0,
        omega: float = 0.0,
        *,
        covered: Collection[int] = (),
        seed: int = 0,
        index: int = 0,
    ) -> Image:
        """The image (height, width), or (height, width, 3) for rgb8.

        Args:
            T_dock_base: pose (x [m], y [m], heading [rad]) of the chair in the middle of the exposure.
            v: speed [m/s] during the exposure.
            omega: turning rate [rad/s] during the exposure.
            covered: ids of the markers that something hides.
            seed: of the noise.
            index: number of the image; the noise depends on seed and index only.
        """
        light = self.light(T_dock_base, v, omega, covered)
        return self._sensor.expose(light, seed, index)

    def light(self, T_dock_base: ArrayLike, v: float, omega: float, covered: Collection[int]) -> Image:
        """The image before PSF, vignetting, gain and noise; shape as for `render`."""
        motion = self._motion(T_dock_base, v, omega)
        whole = min(MAX_SUBFRAMES, max(1, math.ceil(motion / BACKDROP_PX)))
        prints = min(3, max(1, math.ceil(motion / (whole * PRINT_PX))))
        times = ((np.arange(whole * prints) + 0.5) / (whole * prints) - 0.5) * self.settings.exposure
        poses = [arc_step(T_dock_base, v, omega, float(t)) for t in times]
        views = [np.linalg.inv(self.T_dock_optical(pose)) for pose in poses]
        frames = [self._draw(views[k * prints : (k + 1) * prints], covered) for k in range(whole)]
        if whole == 1:
            return frames[0]
        total = np.zeros(frames[0].shape, np.float32)
        for frame in frames:
            cv2.accumulate(frame, total)
        return np.asarray(cv2.convertScaleAbs(total, alpha=1.0 / whole), dtype=np.uint8)

    def _motion(self, pose: ArrayLike, v: float, omega: float) -> float:
        """How far things at the dock move in the image during the exposure, at most about [px]."""
        exposure = self.settings.exposure
        if exposure == 0.0 or (v == 0.0 and omega == 0.0):
            return 0.0
        focal = float(self.model.K[0, 0])
        camera = self.T_dock_optical(pose)[:2, 3]
        distance = min((float(np.linalg.norm(s.outline[0, :2] - camera)) for s in self.scene.sheets), default=1.0)
        # A thing half an image off the axis moves outwards by that half times way / distance.
        outwards = 0.5 * self.model.width * abs(v) / max(distance, 0.2)
        lever = float(np.linalg.norm(self._T_base_optical[:2, 3]))
        sideways = focal * abs(omega) * (1.0 + lever / max(distance, 0.2))
        return (outwards + sideways) * exposure

    def _draw(self, views: list[Array], covered: Collection[int]) -> Image:
        """One sub-frame: the world from the middle one of `views` (T_optical_dock, 4x4), prints averaged over all."""
        colour = self.settings.encoding == "rgb8"
        shape = (self.model.height, self.model.width, 3) if colour else (self.model.height, self.model.width)
        image = np.full(shape, 140, np.uint8)
        T = views[len(views) // 2]
        camera = -T[:3, :3].T @ T[:3, 3]
        self._backdrop.draw(image, self._frustum, T)
        self._draw_sheets(image, True, views, camera, covered)
        order = sorted(self._blocks, key=lambda b: -float(np.sum((b[0] - camera[:2]) ** 2)))
        for _, faces in order:
            faces.draw(image, self._frustum, T)
        self._draw_sheets(image, False, views, camera, covered)
        return image

    def _draw_sheets(
        self, image: Image, on_back_wall: bool, views: list[Array], camera: Array, covered: Collection[int]
    ) -> None:
        T = views[len(views) // 2]
        for sheet, paper, cover in self._sheets:
            if sheet.hangs_on_back_wall != on_back_wall:
                continue
            if float(sheet.paper.normal @ (camera - sheet.paper.points[0])) <= 0.0:
                continue  # seen from behind
            if sheet.marker.id in covered:
                cover.draw(image, self._frustum, T)
            else:
                paper.draw(image, self._frustum, T)
                self._print(image, sheet, views)

    def _print(self, image: Image, sheet: Sheet, views: list[Array]) -> None:
        """Darken the image where there is ink."""
        outlines = [sheet.outline @ T[:3, :3].T + T[:3, 3] for T in views]
        if any(np.any(outline[:, 2] < 0.1) for outline in outlines):
            return  # partly behind the lens
        boxes = [box for box in map(self._ink.box, outlines) if box is not None]
        if not boxes:
            return
        x0, y0 = min(b[0] for b in boxes), min(b[1] for b in boxes)
        x1, y1 = max(b[2] for b in boxes), max(b[3] for b in boxes)
        total = np.zeros((y1 - y0, x1 - x0), np.uint16)
        for outline in outlines:
            total += self._ink.coverage(sheet, outline, (x0, y0, x1, y1))
        loss = (1.0 - self._ink_reflectance) / len(views)
        kept = cv2.convertScaleAbs(total.astype(np.float32), alpha=-loss, beta=255.0)
        patch = image[y0:y1, x0:x1]
        patch[:] = cv2.multiply(patch, kept if patch.ndim == 2 else cv2.merge([kept] * 3), scale=1.0 / 255.0)
