"""What the checks across files find."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_nmpc.parameters import NmpcParameters


@dataclass(frozen=True)
class Given:
    """What is checked against each other. The chair drives forward into the dock (see sequence.vehicle)."""

    chair: Chair
    dock: Dock
    parameters: NmpcParameters
    camera: CameraModel | None


@dataclass
class Findings:
    """Errors stop start-up; warnings are said once. Each text begins with the keys it is about, each after its file:
    `dock bay/width, chair width: ...`."""

    errors: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def require(self, holds: bool, keys: str, text: str) -> None:
        """An error unless it holds."""
        if not holds:
            self.errors.append(f"{keys}: {text}")

    def expect(self, holds: bool, keys: str, text: str) -> None:
        """A warning unless it holds."""
        if not holds:
            self.warnings.append(f"{keys}: {text}")
