"""The computer and the files of configuration: what can be said before anything runs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from seater_common.geometry import Dock, Marker, polygon_distance
from seater_common.marker_family import marker_family
from seater_common.params import ParameterError
from seater_nmpc.checks.setup import check_setup
from seater_nmpc.sequence.vehicle import Vehicle
from seater_tools.doctor.observations import Observations
from seater_tools.doctor.setup import parsed
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong
from seater_tools.teach.dock import teaching_of

LEAST_FREE = 1e9  # [byte] a docking's bag without images takes some MB, with images 100 MB and more
BUSY = 0.9  # share of the processors beyond which control cycles come late
# The principal point of a lens lies within so much of the middle, of the image's width: 3 % is usual, and a calibration
# of another resolution (or of a cropped image) is off by 17 % and more.
OFF_CENTRE = 0.12
VIEWS = (20.0, 130.0)  # [deg] horizontal angle of view of lenses in use
BEHIND = 0.02  # [m] behind the back wall that a print may hang by the file: walls are measured to a centimetre
REBUILD = "beside the sources: setup, then build; the Debian package: apt install --reinstall seater"
QUIET = 1.0 / 6.0  # of the side: the white margin of one cell round a print of 4 x 4 cells


def packages(observations: Observations) -> Verdict:
    """Everything that the launch files start is there."""
    missing = observations.machine.missing
    if missing:
        return wrong("packages", f"not found: {', '.join(missing)}", REBUILD)
    return good("packages", "all found")


def disk(observations: Observations) -> Verdict:
    """Room for logs and bags."""
    machine = observations.machine
    text = f"{machine.free / 1e9:.1f} GB free in {machine.folder}"
    if machine.free < LEAST_FREE:
        return wrong("disk", text, f"delete old logs and bags (rosclean check); {LEAST_FREE / 1e9:.0f} GB are needed")
    return good("disk", text)


def processor(observations: Observations) -> Verdict:
    """Time for control cycles."""
    busy = observations.machine.busy
    if busy is None:
        return unknown("processor", "was not watched")
    text = f"{100 * busy:.0f} % of the processors' time is taken"
    if busy > BUSY:
        return wrong(
            "processor", text, "end other programs, lower the camera's rate or size, or take a faster computer"
        )
    return good("processor", text)


def file_of(role: str) -> Callable[[Observations], Verdict]:
    """The check of one file by itself: as the program that reads it checks it."""
    name = f"{role} file"

    def check(observations: Observations) -> Verdict:
        file = observations.files.get(role)
        if file is None:
            return unknown(name, "none is named")
        problem = parsed(file, role)[1]
        if problem:
            return wrong(name, _one_line(problem), f"correct {file.path}; keys: docs/reference/parameters.md")
        return good(name, file.path)

    return check


def fit(observations: Observations) -> Verdict:
    """The files against each other, by the checks that the docking node starts with."""
    name, setup = "files together", observations.setup
    if setup.chair is None or setup.dock is None or setup.controller is None:
        return unknown(name, "a file is not in order")
    camera = setup.camera
    if camera is None and observations.live is not None:
        camera = observations.live.pictures.info
    try:
        vehicle = Vehicle(setup.chair, setup.dock)
        warnings = check_setup(vehicle.chair, setup.dock, setup.controller, camera)[1]
    except ValueError as error:
        return wrong(name, _one_line(str(error)), "correct the keys named")
    return good(name, "; ".join(map(_one_line, warnings)) or "they fit")


def calibration(observations: Observations) -> Verdict:
    """Whether the calibration is one of images of its own size."""
    name, camera = "calibration", observations.setup.camera
    if camera is None and observations.live is not None:
        camera = observations.live.pictures.info
    if camera is None:
        return unknown(name, "no calibration file is named, and no camera_info arrives")
    size, middle = np.array([camera.width, camera.height]), camera.K[:2, 2]
    off = (middle - 0.5 * (size - 1)) / camera.width
    view = math.degrees(2.0 * math.atan(0.5 * camera.width / camera.K[0, 0]))
    text = f"{camera.width} x {camera.height}, {view:.0f} deg wide"
    remedy = "./seater calibrate camera with images of the size that the camera sends"
    if float(np.abs(off).max()) > OFF_CENTRE:
        place = f"principal point at ({middle[0]:.0f}, {middle[1]:.0f})"
        return wrong(name, f"{text}: {place}, far from the middle: made of images of another size?", remedy)
    if camera.distortion_model != "equidistant" and not VIEWS[0] < view < VIEWS[1]:
        return wrong(name, f"{text}: no usual lens; made of images of another size?", remedy)
    if abs(camera.K[1, 1] / camera.K[0, 0] - 1.0) > 0.1:
        return wrong(
            name, f"{text}: its pixels are {camera.K[1, 1] / camera.K[0, 0]:.2f} times as high as wide", remedy
        )
    return good(name, text)


def dock_geometry(observations: Observations) -> Verdict:
    """Whether such a dock can be hung up: markers beside each other, before the wall, of the family."""
    name, dock = "dock geometry", observations.setup.dock
    if dock is None:
        return unknown(name, "the dock's file is not in order")
    problems = [*_unknown_codes(dock), *_overlapping(dock), *_misplaced(dock)]
    if problems:
        return wrong(name, "; ".join(problems), "measure sizes and places, and correct the dock's file")
    sizes = ", ".join(f"{m.id}: {1000 * m.size:g} mm" for m in dock.markers)
    return good(name, f"markers {sizes}")


def teaching(observations: Observations) -> Verdict:
    """What the dock's file says of how the docked pose was found. None at all is no fault: a fresh dock has none."""
    name, file = "teaching", observations.files.get("dock")
    if file is None or observations.setup.dock is None:
        return unknown(name, "the dock's file is not in order")
    taught = teaching_of(file.text)
    if taught is None:
        return unknown(name, "the docked pose was never taught: it is as exact as the places in the file")
    return good(name, f"taught on {taught.date:%Y-%m-%d}, {taught.count} measurements")


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _unknown_codes(dock: Dock) -> list[str]:
    try:
        known = len(marker_family(dock.dictionary))
    except ParameterError as error:
        return [_one_line(str(error))]
    return [f"{dock.dictionary} has no marker {m.id}" for m in dock.markers if not 0 <= m.id < known]


def _overlapping(dock: Dock) -> list[str]:
    """Prints whose white margins would lie on each other; seen from the front, of those that face alike."""
    found = []
    for a, b in itertools.combinations(dock.markers, 2):
        normal = np.array([math.cos(a.normal_yaw), math.sin(a.normal_yaw)])
        away = np.array(b.position) - a.position
        if math.cos(a.normal_yaw - b.normal_yaw) < 0.7 or abs(float(normal @ away[:2])) > 0.1:
            continue
        aside = float(normal[0] * away[1] - normal[1] * away[0])
        if polygon_distance(_square(a, 0.0, 0.0), _square(b, aside, float(away[2]))) < 0.0:
            found.append(f"markers {a.id} and {b.id} overlap")
    return found


def _square(marker: Marker, x: float, y: float) -> np.ndarray:
    half = (0.5 + QUIET) * marker.size
    return np.array([[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]])


def _misplaced(dock: Dock) -> list[str]:
    found = []
    for m in dock.markers:
        x, _, z = m.position
        if x > dock.bay.back_wall_x + BEHIND:
            found.append(f"marker {m.id} hangs {1000 * (x - dock.bay.back_wall_x):.0f} mm behind the back wall")
        if z < 0.5 * m.size:
            found.append(f"marker {m.id} reaches into the floor")
    if not any(math.cos(m.normal_yaw) < 0.0 for m in dock.markers):
        found.append("no marker faces the arriving chair (normal_yaw near pi)")
    return found
