"""What the tests share: the files of config/ and cameras made from them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_sim.camera.camera import Camera
from seater_sim.settings import CameraSettings

CONFIG = Path(__file__).resolve().parents[3] / "config"

# Distortion coefficients of real size.
LENSES = {
    "plumb_bob": [-0.055, 0.065, 0.0006, -0.0004, -0.021],
    "rational_polynomial": [0.4, -0.1, 0.0005, -0.0003, 0.02, 0.45, -0.05, 0.01],
    "equidistant": [-0.02, 0.008, -0.006, 0.001],
}


@pytest.fixture(scope="session")
def camera_values() -> dict[str, Any]:
    """config/cameras/d455.yaml."""
    return dict(yaml.safe_load((CONFIG / "cameras" / "d455.yaml").read_text()))


@pytest.fixture(scope="session")
def simulator_values() -> dict[str, Any]:
    """config/simulator.yaml."""
    return dict(yaml.safe_load((CONFIG / "simulator.yaml").read_text()))


@pytest.fixture(scope="session")
def with_lens(camera_values: dict[str, Any]) -> Callable[[str], CameraModel]:
    """Makes the camera with one of LENSES."""

    def make(name: str) -> CameraModel:
        lens = {"rows": 1, "cols": len(LENSES[name]), "data": LENSES[name]}
        return CameraModel.from_mapping(camera_values | {"distortion_model": name, "distortion_coefficients": lens})

    return make


@pytest.fixture(scope="session")
def model(camera_values: dict[str, Any]) -> CameraModel:
    return CameraModel.from_mapping(camera_values)


@pytest.fixture(scope="session")
def camera(model: CameraModel) -> Camera:
    """With all default effects."""
    return Camera(model, Chair().camera, Dock())


@pytest.fixture(scope="session")
def ideal_camera(model: CameraModel) -> Camera:
    """Area sampling only."""
    return Camera(
        model, Chair().camera, Dock(), CameraSettings(blur_sd=0.0, noise_sd=0.0, vignetting=0.0, exposure=0.0)
    )
