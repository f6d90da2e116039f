"""What a user would tell the controller of a simulated chair: the scripted drive on it, then the values that
`./seater identify` writes into its copy of controller.yaml."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping

import yaml

from seater_common.geometry import Chair
from seater_common.params import as_mapping, load
from seater_identify.report.files import controller_values, edited
from seater_identify.result.identify import identify
from seater_identify.settings import IdentifySettings
from seater_identify.trial.simulation import Camera, simulate
from seater_nmpc.parameters import NmpcParameters
from seater_sim.settings import KINEMATIC, SimulatorSettings

_OTHER_DAY = 1_000_003  # added to the seed: other patches of floor, castors and noise than in what comes afterwards


def identified_parameters(
    parameters: NmpcParameters, simulator: SimulatorSettings, chair: Chair, seed: int
) -> NmpcParameters:
    """`parameters` with what an identification of this plant finds; what it refuses stays as it is.

    `chair`: the simulated one. `seed`: that of the run for which the chair is identified. Same arguments, same result.

    Raises:
        AreaError: the chair does not fit into the default area.
        RecordingError: the drive was stopped before anything was recorded.
        ParameterError: a value is out of the range that the controller takes.
    """
    values = identified_values(plain_text(simulator), chair, seed)
    text = edited(yaml.safe_dump(as_mapping(parameters)), values, "controller")
    return load(NmpcParameters, yaml.safe_load(text), "controller, identified")


@functools.lru_cache(maxsize=16)
def identified_values(simulator: str, chair: Chair, seed: int) -> Mapping[str, float]:
    """Key path in controller.yaml to value. `simulator`: its plain_text. One chair is driven only once."""
    settings = load(SimulatorSettings, json.loads(simulator), "simulator")
    camera = Camera(rate=settings.camera.rate)
    drive = simulate(IdentifySettings(), chair, settings, _seed_of_drive(settings, seed), camera)
    return controller_values(identify(drive.recording))  # a drive that was stopped: of its part


def plain_text(simulator: SimulatorSettings) -> str:
    """The settings as JSON, which can be compared and hashed."""
    return json.dumps(as_mapping(simulator))


def _seed_of_drive(simulator: SimulatorSettings, seed: int) -> int:
    """The ideal chair draws its odometry's constant errors from the seed: with another one it is another chair."""
    return seed if simulator.plant.kind == KINEMATIC else seed + _OTHER_DAY
