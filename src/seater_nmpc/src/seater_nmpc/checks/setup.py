"""Checks across the files of config/ at start-up: what each file allows may not fit together."""

from __future__ import annotations

from collections.abc import Mapping

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError
from seater_nmpc.checks.bay import check_bay, check_markers
from seater_nmpc.checks.findings import Findings, Given
from seater_nmpc.checks.motion import check_limits, check_times, check_tolerance
from seater_nmpc.checks.sight import check_sight
from seater_nmpc.parameters import NmpcParameters


def check_setup(
    chair: Chair,
    dock: Dock,
    parameters: NmpcParameters,
    camera: CameraModel | None = None,
    files: Mapping[str, object] | None = None,
) -> tuple[NmpcParameters, list[str]]:
    """The parameters to dock with, and warnings about what was adjusted or is doubtful.

    In a narrow bay `control/margin`, `planner/extra_margin` and the corridor shrink together, the margin down to 2 cm.

    Args:
        chair: as it drives forward into the dock (Vehicle.chair).
        camera: of the raw or of the rectified images, whichever perception is given; None: not known.
        files: names of the files behind `chair`, `dock`, `controller` and `camera`, for the messages.

    Raises:
        ParameterError: they do not fit together; names the keys of both sides, their values, and what would fit.
    """
    given, findings = Given(chair, dock, parameters, camera), Findings()
    adjusted = parameters
    if parameters.control.walls:
        adjusted = check_bay(given, findings)
        check_sight(given, findings)
        check_markers(given, findings)
    check_limits(given, findings)
    check_times(given, findings)
    check_tolerance(given, findings)
    if findings.errors:
        where = "".join(f"\n  {name}: {path}" for name, path in (files or {}).items())
        raise ParameterError(
            "chair, dock, camera and controller do not fit together:\n  " + "\n  ".join(findings.errors) + where
        )
    return adjusted, findings.warnings
