"""The computer and the files, as they are now."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform
import shutil
from collections.abc import Mapping
from pathlib import Path

import rospkg
import yaml

from seater_common.camera_model import read_calibration
from seater_common.params import ParameterError, read_yaml
from seater_tools.doctor.observations import Machine
from seater_tools.doctor.setup import FileSeen

# What wheelchair.launch starts, and what its Python nodes import beside Debian's own.
PACKAGES = (
    "seater_bringup", "seater_common", "seater_config", "seater_msgs", "seater_nmpc", "seater_obstacles",
    "seater_perception", "seater_safety", "seater_tools",
)  # fmt: skip
MODULES = ("casadi", "piqp", "numpy", "scipy", "cv2", "rospy", "tf2_ros", "seater_perception", "seater_safety")


def look_at_machine(folder: Path, busy: float | None) -> Machine:
    """`folder`: where logs go; `busy`: as ProcessorTime says."""
    known = set(rospkg.RosPack().list())
    missing = [name for name in PACKAGES if name not in known]
    missing += [f"Python module {name}" for name in MODULES if importlib.util.find_spec(name) is None]
    there = next(path for path in (folder, *folder.parents) if path.exists())
    return Machine(tuple(missing), str(folder), float(shutil.disk_usage(there).free), busy, _versions())


def _versions() -> dict[str, str]:
    found = {"system": platform.platform(), "python": platform.python_version()}
    for name in ("casadi", "piqp", "numpy", "scipy", "opencv"):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    for name in ("seater_tools", "roscpp"):
        try:
            found[name] = rospkg.RosPack().get_manifest(name).version
        except rospkg.ResourceNotFound:
            continue
    return found


class ProcessorTime:
    """Share of the processors' time that is taken between two looks at /proc/stat (Linux)."""

    def __init__(self) -> None:
        self._before = _ticks()

    def busy(self) -> float | None:
        """Since the begin; None: too short a time."""
        total, idle = (b - a for a, b in zip(self._before, _ticks(), strict=True))
        return 1.0 - idle / total if total > 0 else None


def _ticks() -> tuple[int, int]:
    """All and idle ticks: user, nice, system, idle, iowait, ..."""
    values = [int(value) for value in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
    return sum(values), values[3] + values[4]


def look_at_files(paths: Mapping[str, Path | None]) -> dict[str, FileSeen]:
    """By role; None: not named, and not looked at."""
    seen = {role: _look(role, path) for role, path in paths.items() if path is not None}
    return {role: _refused(role, file, seen) for role, file in seen.items()}


def _look(role: str, path: Path) -> FileSeen:
    try:
        text = path.read_text()
        values = read_calibration(path) if role == "camera" else read_yaml(path)
    except (OSError, UnicodeDecodeError, ParameterError, yaml.YAMLError) as error:
        return FileSeen(str(path), error=str(error))
    return FileSeen(str(path), text, values)


def _refused(role: str, file: FileSeen, seen: Mapping[str, FileSeen]) -> FileSeen:
    """perception.yaml and safety.yaml by the compiled code that reads them."""
    checks = {"perception": _perception_refuses, "safety": _safety_refuses}
    if file.error or role not in checks:
        return file
    try:
        checks[role](file, seen)
    except ImportError:  # not built: the check of the packages says so
        return file
    except (TypeError, ValueError) as error:
        return FileSeen(file.path, file.text, file.values, refused=f"{file.path}: {error}")
    return file


def _safety_refuses(file: FileSeen, seen: Mapping[str, FileSeen]) -> None:
    """Raises ValueError, TypeError."""
    import seater_safety

    if not isinstance(file.values, dict):
        raise ValueError("must be a mapping")
    described = seater_safety.describe_parameters()
    wanted = {entry["key"] for entry in described if entry["file"] == "safety"}
    wrong = [f"{key}: is missing" for key in sorted(wanted - set(file.values))]
    wrong += [f"{key}: unknown key" for key in sorted(set(file.values) - wanted)]
    if wrong:
        raise ValueError("; ".join(wrong))
    chair = seen["chair"].values if "chair" in seen and isinstance(seen["chair"].values, dict) else None
    if chair is None:
        return
    values = {key: float(value) for key, value in file.values.items()}
    for entry in described:
        part = {"chair": chair, "chair/limits": chair.get("limits") or {}}.get(entry["file"])
        if part is not None and entry["key"] in part:
            values[entry["key"]] = float(part[entry["key"]])
    seater_safety.VelocityGate(**values)


def _perception_refuses(file: FileSeen, seen: Mapping[str, FileSeen]) -> None:
    """Raises ValueError, TypeError. The dock's and the mount's own mistakes are told with their files."""
    import seater_perception as sp

    size, lens = (1280, 720), [640.0, 0.0, 639.5, 0.0, 640.0, 359.5, 0.0, 0.0, 1.0]
    camera = sp.CameraModel.raw(sp.Calibration(*size, lens, [0.0] * 5, "plumb_bob", [0.0] * 12))
    mount = {"x": 0.0, "y": 0.0, "z": 0.7, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}
    sp.DockDetector(camera, sp.layout_of_equal_markers("DICT_4X4_50", 0.1), file.values, mount)
