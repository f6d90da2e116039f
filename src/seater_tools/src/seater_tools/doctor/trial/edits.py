"""What faults do to a scene: to things, to files, to messages."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from seater_tools.doctor.gather.machine import look_at_files
from seater_tools.doctor.observations import Traffic
from seater_tools.doctor.trial.scene import Scene, change_marker, move_camera

HALF_SIZE = [320.0, 0.0, 319.5, 0.0, 320.0, 239.5, 0.0, 0.0, 1.0]  # K of 640 x 480
Edit = Callable[[Scene], object]


def file(role: str, key: tuple[str | int, ...], value: Any) -> Edit:
    """A file with another value, which everybody is told."""

    def edit(scene: Scene) -> None:
        def change(values: Any) -> None:
            for part in key[:-1]:
                values = values[part]
            values[key[-1]] = value

        scene.edit(role, change)

    return edit


def told(role: str, key: tuple[str, ...], value: Any) -> Edit:
    """A file that was edited after the nodes had started."""

    def edit(scene: Scene) -> None:
        values = scene.told[role]
        for part in key[:-1]:
            values = values[part]
        values[key[-1]] = value

    return edit


def traffic(role: str, **changes: Any) -> Edit:
    def edit(scene: Scene) -> None:
        scene.traffic[role] = dataclasses.replace(scene.traffic.get(role, Traffic(role)), **changes)

    return edit


def tamper(**changes: Any) -> Edit:
    def edit(scene: Scene) -> None:
        scene.tamper = dataclasses.replace(scene.tamper, **changes)

    return edit


def machine(**changes: Any) -> Edit:
    return lambda scene: setattr(scene, "machine", dataclasses.replace(scene.machine, **changes))


def live(**changes: Any) -> Edit:
    return lambda scene: setattr(scene, "live", dataclasses.replace(scene.live, **changes))


def camera(**changes: float) -> Edit:
    return lambda scene: move_camera(scene, **changes)


def printed(id: int, scale: float = 1.0, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Edit:
    def edit(scene: Scene) -> None:
        marker = next(m for m in scene.dock.markers if m.id == id)
        place = [value + off for value, off in zip(marker.position, shift, strict=True)]
        change_marker(scene, id, size=marker.size * scale, position=place)

    return edit


def all_printed(scale: float) -> Edit:
    return lambda scene: [printed(m.id, scale)(scene) for m in scene.dock.markers]


def light(**changes: Any) -> Edit:
    def edit(scene: Scene) -> None:
        camera = dataclasses.replace(scene.simulator.camera, **changes)
        scene.simulator = dataclasses.replace(scene.simulator, camera=camera)

    return edit


def info_of_half_size(scene: Scene) -> None:
    """A calibration of 640 x 480 given to images of 1280 x 720."""
    scene.info |= {"camera_matrix": {"rows": 3, "cols": 3, "data": HALF_SIZE}, "image_width": 640, "image_height": 480}


def lens_of_half_size(scene: Scene) -> None:
    """Its lens in a file, and in camera_info, that say the full size."""
    for values in (scene.files["camera"].values, scene.told["camera"], scene.info):
        values["camera_matrix"]["data"] = HALF_SIZE


def no_calibration(scene: Scene) -> None:
    """As drivers send it that have none: all zero."""
    scene.info["camera_matrix"] = {"rows": 3, "cols": 3, "data": [0.0] * 9}


def broken_file(role: str) -> Edit:
    """A file that is no YAML any more; the nodes run as they were."""

    def edit(scene: Scene) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{role}.yaml"
            path.write_text(scene.files[role].text + "\n\tmarkers: [")
            scene.files |= look_at_files({role: path})

    return edit


def rewritten(role: str, old: str, new: str) -> Edit:
    """A file in which a piece of text is another, read anew."""

    def edit(scene: Scene) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{role}.yaml"
            path.write_text(scene.files[role].text.replace(old, new))
            chair = Path(scene.files["chair"].path)
            scene.files[role] = look_at_files({"chair": chair, role: path})[role]

    return edit


def stamped_at_arrival(scene: Scene) -> None:
    """A camera whose images need 120 ms, of which the driver leaves 80 ms out."""
    light(latency=0.12)(scene)
    scene.tamper.image_stamp = lambda stamp: stamp + 0.08


def closed_contact(scene: Scene) -> None:
    """A relay that sticks."""
    scene.tamper.contact = lambda closed: True


def no_charger(scene: Scene) -> None:
    """Dockings ask for a contact that nobody sends."""
    live(require_contact=True)(scene)
    traffic("charging_contact", publishers=())(scene)


def tf(**changes: float) -> Edit:
    """A robot description that has the camera elsewhere than chair.yaml."""

    def edit(scene: Scene) -> None:
        files, there = scene.chair, dataclasses.replace(scene)
        move_camera(there, **changes)
        off = there.chair.camera.T_base_optical() @ np.linalg.inv(files.camera.T_base_optical())
        scene.T_base_optical = off @ scene.T_base_optical

    return edit


def other_family(scene: Scene) -> None:
    scene.dock = dataclasses.replace(scene.dock, dictionary="DICT_5X5_50")


def other_ids(scene: Scene) -> None:
    markers = [dataclasses.replace(m, id=m.id + 10) for m in scene.dock.markers]
    scene.dock = dataclasses.replace(scene.dock, markers=markers)


def covered(scene: Scene) -> None:
    markers = [m for m in scene.dock.markers if m.id != 2]
    scene.dock = dataclasses.replace(scene.dock, markers=markers)
