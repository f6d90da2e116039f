"""An installation whose truth is hidden from the commands: lens, mount, prints, chair, and what a person reads off."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock, Tolerance
from seater_common.params import load, read_yaml
from seater_sim.chair.plant_ranges import load_plant_ranges
from seater_sim.settings import SimulatorSettings
from seater_tools.correct.scale import READING
from seater_tools.mount.prior import PRINT_SD, TAPE
from seater_tools.sheets.layout.paper import PAPERS
from seater_tools.trial.truth import Errors, draw_installation

Array = NDArray[np.float64]

PLANTS = ("indoor_chair", "worn_chair")
FOCAL = 0.1  # largest relative error of the nominal focal length
MIDDLE = 12.0  # [px] of the principal point
DISTORTION = ((-0.08, 0.05), (0.0, 0.03), (-0.001, 0.001), (-0.001, 0.001), (0.0, 0.0))  # k1 k2 p1 p2 k3
PRINTER = 0.02  # of all prints of one printer
PLACE = (0.01, 0.01)  # [m] ahead of and beside the planned place, where the person wants the docked chair
PAPER = PAPERS["a4"]
READINGS = 3  # of the printed bars, when the program asks to read them again
# No contact is wired: nothing but the camera says that the chair is docked.
NO_CONTACT = Tolerance(0.0005, 0.0001)


@dataclass(frozen=True)
class Hidden:
    """What is there, and what the person who installs it reads off ruler and tape.

    bars: of the print, across and upright [mm], as they are read the first time, the second ...; empty: nobody
        measured them, and each print is off by itself
    tape: ids of the two markers farthest apart, and their distance as it was read [m]
    place: (x, y) [m] of base_link in the true dock frame, where the person wants the docked chair, about
    """

    seed: int
    plant: str
    simulator: SimulatorSettings
    lens: CameraModel
    chair: Chair
    dock: Dock
    bars: tuple[tuple[float, ...], ...]
    tape: tuple[int, int, float]
    place: tuple[float, float]


def draw_hidden(config: Path, seed: int) -> Hidden:
    """Markers up to 20 mm and 3 deg off, sizes 2 %, the mount 30 mm and 3 deg, focal length 10 %; a chair of the ranges
    in `config`/plants. Same seed, same installation. Raises ParameterError: a file is not in order.
    """
    rng = np.random.default_rng([seed, 41])
    plant = PLANTS[int(rng.integers(len(PLANTS)))]
    base = load(SimulatorSettings, read_yaml(config / "simulator.yaml"), "simulator.yaml")
    simulator = load_plant_ranges(config / "plants" / f"{plant}.yaml").draw_simulator(rng, base)
    chair = load(Chair, read_yaml(config / "chair.yaml"), "chair.yaml")
    plan = load(Dock, read_yaml(config / "docks" / "default.yaml"), "default.yaml")
    lens = draw_lens(CameraModel.load(config / "cameras" / "d455.yaml"), rng)
    measured = bool(rng.integers(2))
    truth = draw_installation(chair.camera, plan, Errors(size=0.0 if measured else PRINTER), rng)
    dock, bars = _printed(truth.dock, rng, seed) if measured else (truth.dock, ())
    wall = max(marker.position[0] for marker in dock.markers)
    dock = dataclasses.replace(dock, bay=dataclasses.replace(dock.bay, back_wall_x=wall), contact_tolerance=NO_CONTACT)
    pairs = [(math.dist(a.position, b.position), a.id, b.id) for a in dock.markers for b in dock.markers if a.id < b.id]
    distance, first, second = max(pairs)
    return Hidden(
        seed=seed,
        plant=plant,
        simulator=simulator,
        lens=lens,
        chair=dataclasses.replace(chair, camera=truth.mount),
        dock=dock,
        bars=bars,
        tape=(first, second, distance + TAPE * float(rng.standard_normal())),
        place=(float(rng.uniform(-1, 1) * PLACE[0]), float(rng.uniform(-1, 1) * PLACE[1])),
    )


def draw_lens(nominal: CameraModel, rng: np.random.Generator) -> CameraModel:
    """Another lens of this kind; every pixel has one direction."""
    size = np.array([nominal.width - 1.0, nominal.height - 1.0])
    corners = size * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    while True:
        K, D = nominal.K.copy(), np.array([rng.uniform(low, high) for low, high in DISTORTION])
        K[0, 0] *= 1.0 + FOCAL * rng.uniform(-1, 1)
        K[1, 1] = K[0, 0] * (1.0 + 0.002 * rng.uniform(-1, 1))
        K[:2, 2] += MIDDLE * rng.uniform(-1, 1, 2)
        lens = CameraModel(nominal.width, nominal.height, "plumb_bob", D, K, np.eye(3), np.zeros((3, 4)))
        if np.all(np.isfinite(lens.ray(corners))):
            return lens


def _printed(dock: Dock, rng: np.random.Generator, seed: int) -> tuple[Dock, tuple[tuple[float, ...], ...]]:
    """All by one printer, and its bars as they are read, each time with the errors of a ruler."""
    scale = 1.0 + PRINTER * float(rng.uniform(-1, 1))
    sizes = [m.size * scale * (1.0 + PRINT_SD * float(rng.standard_normal())) for m in dock.markers]
    markers = [dataclasses.replace(m, size=size) for m, size in zip(dock.markers, sizes, strict=True)]
    again = np.random.default_rng([seed, 42])  # whose draws change nothing else of the seed
    errors = [rng.standard_normal(2), *again.standard_normal((READINGS - 1, 2))]
    bars = tuple(tuple((PAPER.bar * scale + READING * error).round(1).tolist()) for error in errors)
    return dataclasses.replace(dock, markers=markers), bars
