"""What the camera sees of the dock, against the dock's file and the camera's mount."""

from __future__ import annotations

import numpy as np

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_nmpc.observe.measurement import MarkerSight
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.markers import Markers
from seater_tools.doctor.observations import NOT_RUNNING, Live, Observations
from seater_tools.doctor.prints import PrintFit, fit_prints, mean_corners
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong

SIZE_OFF = 0.03  # as plausibility/marker_scale: printers are off by up to 2 %, other paper sizes by 6 % and more
PLACE_OFF = 0.006  # [m] as plausibility/marker_place
CERTAIN = 4.0  # standard deviations
NOT_IN_VIEW = "no marker of the dock is in view: stand 1 to 2 m before the dock, facing it"
INSIDE = 10.0  # [px] from the image's edge: a print that is so far inside is in view


def in_view(observations: Observations) -> Verdict:
    """The dock's markers are found: all of those that the camera must see."""
    name, live, dock = "markers in view", observations.live, observations.setup.dock
    if live is None:
        return unknown(name, NOT_RUNNING)
    if dock is None or live.pictures.size is None:
        return unknown(name, "the dock's file is not in order" if dock is None else "no image arrives")
    if live.pictures.other is not None:
        family, ids = live.pictures.other
        text = f"the image shows markers {', '.join(map(str, ids))} of {family}; the dock's file has "
        text += f"{', '.join(str(m.id) for m in dock.markers)} of {dock.dictionary}"
        return wrong(name, text, "correct dictionary and ids in the dock's file, or print its sheets (./seater sheets)")
    seen = mean_corners(live.sights)
    if not seen:
        return unknown(name, NOT_IN_VIEW)
    hidden = _hidden(live, dock, set(seen))
    if hidden:
        text = f"marker {', '.join(map(str, hidden))} is not found where it must be in view"
        return wrong(name, text, "look at detections/image: covered, dirty, another id, hung elsewhere, in the shade?")
    return good(name, f"{', '.join(map(str, sorted(seen)))}")


def sizes(observations: Observations) -> Verdict:
    """Each print has the size that the file says, by the distances between the markers."""
    name, found = "marker sizes", _fit(observations)
    if isinstance(found, str):
        return unknown(name, found)
    off = {id: r for id, r in found.ratio.items() if abs(r - 1.0) > max(SIZE_OFF, CERTAIN * found.sd[id])}
    if not off or _misplaced(found):
        return good(name, ", ".join(f"{id}: {100 * r:.1f} %" for id, r in found.ratio.items()) + " of the file's")
    text = ", ".join(f"marker {id} is {100 * r:.1f} % of the file's size" for id, r in off.items())
    remedy = (
        "measure the black square, and correct size in the dock's file (./seater sheets corrects by a measured bar)"
    )
    if len(off) == len(found.ratio):
        remedy += "; where the sizes are right, measure the distances between the markers, or calibrate the camera"
    return wrong(name, text, remedy)


def places(observations: Observations) -> Verdict:
    """The markers hang where the file says, against each other."""
    name, found = "marker places", _fit(observations)
    if isinstance(found, str):
        return unknown(name, found)
    if _misplaced(found) and found.moved is not None:
        id, way = found.moved
        remedy = "measure its place and correct the dock's file, or ./seater calibrate mount, which finds all places"
        return wrong(name, f"marker {id} is {1000 * way:.0f} mm from where the file has it among the others", remedy)
    return good(name, "where the file has them, against each other")


def upright(observations: Observations) -> Verdict:
    """The dock stands on the floor: tilt and height of the camera. By the checks of a docking (plausibility)."""
    name, live, setup = "camera tilt and height", observations.live, observations.setup
    if live is None:
        return unknown(name, NOT_RUNNING)
    if setup.chair is None or setup.dock is None:
        return unknown(name, "a file is not in order")
    if not any(sight.docks for sight in live.sights):
        return unknown(name, NOT_IN_VIEW)
    found = _fit(observations)
    if isinstance(found, PrintFit) and (_misplaced(found) or sizes(observations).ok is False):
        return unknown(name, "sizes or places of the markers come first")
    parameters = setup.controller.plausibility if setup.controller else PlausibilityParameters()
    watch = Markers(setup.chair.camera, setup.dock, parameters)
    for sight in live.sights:
        watch.add(sight.docks, [MarkerSight(marker.id, marker.T) for marker in sight.markers])
    contradiction = watch.check()
    if contradiction is not None:
        return wrong(name, contradiction.text, "./seater calibrate mount, or measure the camera's height and tilt")
    return good(name, "the dock stands upright on the floor")


def _fit(observations: Observations) -> PrintFit | str:
    """Or why there is none."""
    live, dock = observations.live, observations.setup.dock
    if live is None:
        return NOT_RUNNING
    camera = _camera(observations)
    if dock is None or camera is None:
        return "the dock's file is not in order" if dock is None else "no calibration"
    if not mean_corners(live.sights):
        return NOT_IN_VIEW
    return fit_prints(live.sights, camera, dock) or "needs two markers in view"


def _camera(observations: Observations) -> CameraModel | None:
    live = observations.live
    return (live.pictures.info if live is not None else None) or observations.setup.camera


def _misplaced(found: PrintFit) -> bool:
    return found.moved is not None and found.moved[1] > PLACE_OFF


def _hidden(live: Live, dock: Dock, seen: set[int]) -> list[int]:
    """Markers that face the camera, wholly inside the image and not too small, by the pose of the others."""
    info, sight = live.pictures.info, next((s for s in reversed(live.sights) if s.docks), None)
    if info is None or sight is None:
        return []
    found = []
    for marker in dock.markers:
        T = sight.docks[0].T_optical_dock @ marker.T_dock_marker()
        points = marker.corners() @ T[:3, :3].T + T[:3, 3]
        if (
            marker.id in seen
            or np.any(points[:, 2] < 0.1)
            or float(T[:3, 2] @ T[:3, 3]) > -0.5 * np.linalg.norm(T[:3, 3])
        ):
            continue
        pixels = info.project(points)
        size = np.array([info.width, info.height])
        wide = float(np.linalg.norm(pixels[0] - pixels[1]))
        if np.all(pixels > INSIDE) and np.all(pixels < size - INSIDE) and wide > 40.0:
            found.append(marker.id)
    return found


def distance(live: Live, chair: Chair, dock: Dock) -> float | None:
    """[m] of base_link from the docked pose, by the images; None: the dock is not seen."""
    poses = [
        np.linalg.inv(chair.camera.T_base_optical() @ sight.docks[0].T_optical_dock)[:2, 3]
        for sight in live.sights
        if sight.docks
    ]
    return float(np.linalg.norm(np.median(poses, axis=0) - dock.docked_pose[:2])) if poses else None
