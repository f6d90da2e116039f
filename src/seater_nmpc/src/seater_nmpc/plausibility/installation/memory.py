"""What dockings have shown of the installation, kept in a file between two starts.

It holds for the mount, markers and calibration that it was made with: where one of them is corrected, or the file is
damaged, the dockings begin anew.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from seater_common.camera_model import CameraModel
from seater_common.files.whole import write_whole
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, read_yaml
from seater_nmpc.plausibility.installation.knowledge import PRIOR, Knowledge, nothing_known

_HEAD = b"# Written by the docking node: what its dockings have shown of the installation. Delete it to begin anew.\n"
_LARGEST = 1.0  # [m, rad, share] of a value
_ROUNDING = 1e-9  # of a covariance


def mark_of(chair: Chair, dock: Dock, camera: CameraModel | None) -> str:
    """Differs where mount, markers or calibration do."""
    markers = [(m.id, m.size, *m.position, m.normal_yaw) for m in dock.markers]
    lens = None
    if camera is not None:
        size, model = (camera.width, camera.height), camera.distortion_model
        lens = (size, model, *(np.asarray(values, float).tolist() for values in (camera.K, camera.D)))
    return hashlib.sha256(repr((chair.camera, markers, lens)).encode()).hexdigest()[:16]


class Memory:
    """By the docks' names."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def recall(self, dock: str, mark: str) -> Knowledge:
        """Nothing known: not there, of another installation, or of no use."""
        entry = self._read().get(dock)
        if not isinstance(entry, dict) or entry.get("mark") != mark:
            return nothing_known()
        try:
            known = Knowledge(
                int(entry["dockings"]),
                np.array(entry["values"], float),
                np.array(entry["covariances"], float),
                entry.get("turned") is True,  # not in files of before
            )
        except (KeyError, TypeError, ValueError, OverflowError):
            return nothing_known()
        return known if _is_of_use(known) else nothing_known()

    def keep(self, dock: str, mark: str, known: Knowledge) -> None:
        """Raises OSError."""
        docks = self._read()
        docks[dock] = {
            "mark": mark,
            "dockings": known.dockings,
            "values": known.values.tolist(),
            "covariances": known.covariances.tolist(),
            "turned": known.turned,
        }
        write_whole(self._path, _HEAD + yaml.safe_dump(docks, default_flow_style=None).encode(), overwrite=True)

    def _read(self) -> dict[str, Any]:
        try:
            content = read_yaml(self._path)
        except ParameterError:
            return {}
        return content if isinstance(content, dict) else {}


def _is_of_use(known: Knowledge) -> bool:
    """Finite, of the right shapes, and nowhere less sure than before the first docking."""
    start = nothing_known()
    if known.values.shape != start.values.shape or known.covariances.shape != start.covariances.shape:
        return False
    if not (np.all(np.isfinite(known.covariances)) and np.all(np.abs(known.values) <= _LARGEST)):
        return False
    symmetric = np.allclose(known.covariances, known.covariances.transpose(0, 2, 1), rtol=0.0, atol=_ROUNDING)
    positive = bool(np.all(np.linalg.eigvalsh(known.covariances) > 0.0))
    below = bool(np.all(known.covariances.diagonal(axis1=1, axis2=2) <= 1.1 * np.square(PRIOR)))
    return symmetric and positive and below and known.dockings > 0
