"""What takes long to make and keeps nothing of a run: made once for each configuration in each process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_eval.baselines.minimum_time import MinimumTime
from seater_eval.campaign.setup.configuration import Configuration
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.navigator import Navigator
from seater_sim.camera.camera import Camera

T = TypeVar("T")

KEPT = 6  # of each kind: a campaign mixes chairs and docks at random, and a camera's tables take megabytes
_kept: dict[str, dict[str, Any]] = {}


def controller(chair: Chair, dock: Dock, parameters: NmpcParameters, camera: CameraModel) -> DockingController:
    """Ready for the first cycle of a run; no wall-time limit, so that a loaded machine decides the same. `camera`: told
    as camera_info tells the node."""

    def make() -> DockingController:
        made = DockingController(chair, dock, parameters.control, deterministic=True, camera=camera)
        made.warm_up()
        return made

    kept = _keep("controller", (chair, dock, parameters.control, _numbers(camera)), make)
    kept.forget_chair()
    kept.pace.limit()
    return kept


def navigator(chair: Chair, dock: Dock, parameters: NmpcParameters, camera: CameraModel) -> Navigator:
    """With its search ahead of the bay done. `camera`: as the controller's."""

    def make() -> Navigator:
        made = Navigator(chair, dock, parameters.control, parameters.planner, camera)
        made.prepare()
        return made

    key = (chair, dock, parameters.control, parameters.planner, _numbers(camera))
    return _keep("navigator", key, make)


def minimum_time(chair: Chair, dock: Dock) -> MinimumTime:
    """The solver for the shortest docking that the chair's limits allow."""
    return _keep("minimum_time", (chair, dock), lambda: MinimumTime(chair, dock, dock.tolerance))


def camera(c: Configuration) -> Camera:
    """The simulated camera of the true chair at the true dock."""
    s = c.simulator
    key = (_numbers(c.simulated_camera), c.simulated_chair.camera, c.simulated_dock, s.camera, s.scene, s.obstacles)

    def make() -> Camera:
        return Camera(c.simulated_camera, c.simulated_chair.camera, c.simulated_dock, s.camera, s.scene, s.obstacles)

    return _keep("camera", key, make)


def _numbers(model: CameraModel) -> tuple[Any, ...]:
    """A camera's geometry without arrays, whose text is not exact."""
    arrays = (model.D, model.K, model.R, model.P)
    return model.width, model.height, model.distortion_model, *(array.tolist() for array in arrays)


def _keep(kind: str, key: Any, make: Callable[[], T]) -> T:
    """The one made for the same key, if it is among the last KEPT. Dataclasses and numbers have exact texts."""
    kept = _kept.setdefault(kind, {})
    text = repr(key)
    found = kept.pop(text, None)
    kept[text] = make() if found is None else found  # the last used is the last to go
    if len(kept) > KEPT:
        del kept[next(iter(kept))]
    return kept[text]
