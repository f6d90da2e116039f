"""The texts of the new chair.yaml, dock and camera file; comments and everything else stay."""

from __future__ import annotations

import itertools

from seater_common.camera_model import CameraModel
from seater_common.files.installation import MOUNT
from seater_common.files.scalars import with_note, with_values
from seater_common.geometry import Dock
from seater_tools.correct.sizes import CORRECTED
from seater_tools.correct.wall import wall_values
from seater_tools.lens.file import calibration_text, with_projection
from seater_tools.mount.result import Calibration, Value
from seater_tools.teach.dock import without_teaching

PLACED = "# Markers calibrated: "
REFINED = "With the mount: "


def chair_text(text: str, name: str, calibration: Calibration, note: str) -> str:
    """With the camera's pose. Raises ParameterError naming the key that cannot be replaced."""
    values: dict[tuple[str | int, ...], float] = {("camera", v.name): v.used for v in calibration.mount}
    return with_note(with_values(text, values, name), MOUNT, note)


def dock_text(text: str, name: str, dock: Dock, calibration: Calibration, note: str) -> str:
    """With the markers' places and sizes, and the back wall where no print hangs behind it. It counts as a file with
    corrected sizes, which is never printed from, and as one that has not been taught: the docked pose was measured with
    the camera and the markers where they were before.

    Raises ParameterError naming the key that cannot be replaced.
    """
    values: dict[tuple[str | int, ...], float] = {}
    for i, marker in enumerate(dock.markers):
        found = _of(calibration, marker.id)
        if found["x"].kept:
            continue
        for axis, place in enumerate(("x", "y", "z")):
            values["markers", i, "position", axis] = found[place].used
        values["markers", i, "normal_yaw"] = found["yaw"].used
        values["markers", i, "size"] = found["size"].used
    places = [m.position[0] if (v := _of(calibration, m.id)["x"]).kept else v.used for m in dock.markers]
    values |= wall_values(dock.bay, dock.bay.back_wall_x, places)
    first, rest = f"{CORRECTED}by the drive that places them", text
    if text.startswith(CORRECTED):
        first, _, rest = text.partition("\n")
    edited = with_note(without_teaching(with_values(rest, values, name)), PLACED, note)
    return f"{first}\n{edited}"


def camera_text(text: str, camera: CameraModel, name: str, note: str) -> str:
    """`camera`: as the drive has it. `text`: of the file before, whose first lines, that say how it was made, stay."""
    comments = [line[1:].strip() for line in itertools.takewhile(lambda line: line.startswith("#"), text.splitlines())]
    comments = [comment for comment in comments if not comment.startswith(REFINED)]
    return calibration_text(with_projection(camera), name, [*comments, f"{REFINED}{note}"])


def _of(calibration: Calibration, marker: int) -> dict[str, Value]:
    return {value.name: value for value in calibration.markers[marker]}
