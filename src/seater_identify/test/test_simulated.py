"""What the controller is told of a simulated chair after an identification."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from seater_common.geometry import Chair
from seater_common.params import load_file
from seater_identify import simulated
from seater_identify.report.files import write_copy
from seater_identify.simulated import identified_parameters, identified_values
from seater_nmpc.parameters import NmpcParameters
from seater_sim.chair.odometry import Odometry
from seater_sim.settings import KINEMATIC, WHEELCHAIR, OdometrySettings, PlantSettings, SimulatorSettings
from seater_sim.settings.wheelchair import CommandSettings, WheelchairSettings

CONTROLLER = Path(__file__).resolve().parents[3] / "config" / "controller.yaml"
SLUGGISH = CommandSettings(delay=0.24, gain_v=0.9, deadband_v=0.025, deadband_omega=0.05)
CHAIR = SimulatorSettings(plant=PlantSettings(kind=WHEELCHAIR, wheelchair=WheelchairSettings(command=SLUGGISH)))


def test_the_controller_is_told_the_chair_as_the_copy_of_its_file_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = load_file(NmpcParameters, CONTROLLER)
    told = identified_parameters(before, CHAIR, Chair(), 5)
    prediction = told.control.prediction
    assert prediction.command_delay == pytest.approx(SLUGGISH.delay + 0.5 * SLUGGISH.delay_jitter, abs=0.015)
    assert prediction.deadband_v == pytest.approx(SLUGGISH.deadband_v, rel=0.2)
    assert prediction.gain_v < 0.95
    assert told.observer.scale_sd != before.observer.scale_sd
    assert told.planner == before.planner and told.control.weights == before.control.weights

    monkeypatch.setattr(simulated, "simulate", None)  # the same chair is not driven again
    again = identified_parameters(dataclasses.replace(before), CHAIR, Chair(), 5)
    assert again == told
    values = identified_values(simulated.plain_text(CHAIR), Chair(), 5)
    assert load_file(NmpcParameters, write_copy(CONTROLLER, tmp_path / "controller.yaml", values)) == told


def test_what_is_refused_stays_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulated, "Camera", lambda rate: None)  # no dock in view: nothing about odometry
    observer = dataclasses.replace(NmpcParameters().observer, odometry_scale=0.123, scale_sd=0.0456)
    told = identified_parameters(dataclasses.replace(NmpcParameters(), observer=observer), CHAIR, Chair(), 6)
    assert told.observer == observer
    assert told.control.prediction.command_delay != NmpcParameters().control.prediction.command_delay


@pytest.mark.extensive  # another chair is told as its file has it always
def test_the_ideal_chair_keeps_the_odometry_of_its_seed() -> None:
    odometry = OdometrySettings(scale_sd=0.05)
    ideal = dataclasses.replace(CHAIR, plant=PlantSettings(kind=KINEMATIC), odometry=odometry)
    told = identified_parameters(NmpcParameters(), ideal, Chair(), 7)
    assert told.observer.odometry_scale == pytest.approx(Odometry(odometry, 7).scale, abs=0.01)
    assert told.observer.odometry_scale != pytest.approx(Odometry(odometry, 8).scale, abs=0.02)


def test_another_drive_of_the_same_chair_has_other_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    seeds: list[int] = []
    monkeypatch.setattr(simulated, "simulate", lambda *arguments: seeds.append(arguments[3]) or 1 / 0)
    for seed in (11, 12):
        with pytest.raises(ZeroDivisionError):
            identified_parameters(NmpcParameters(), CHAIR, Chair(), seed)
    assert len({*seeds, 11, 12}) == 4
