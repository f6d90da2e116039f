"""What is to be judged, made from the files of config/ once in each process."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from pathlib import Path

import yaml

from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load
from seater_eval.run.config_files import load_chair, load_dock
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import ControlParameters, NmpcParameters
from seater_nmpc.plan.navigator import Navigator


@dataclass(frozen=True)
class Files:
    """Chair, dock and controller of a folder like config/."""

    chair: Chair
    dock: Dock
    parameters: NmpcParameters


@functools.lru_cache(maxsize=2)
def load_files(config: str) -> Files:
    """Raises ParameterError, naming file and key; only a dock that is entered forward is judged."""
    folder = Path(config)
    dock = load_dock(folder / "docks" / "default.yaml")
    if dock.direction != "forward":
        raise ParameterError(f"{config}/docks/default.yaml: direction: is {dock.direction!r}, must be 'forward' here")
    try:
        values = yaml.safe_load((folder / "controller.yaml").read_text())
    except (OSError, yaml.YAMLError) as error:
        raise ParameterError(f"cannot read {folder / 'controller.yaml'}: {error}") from error
    return Files(load_chair(folder / "chair.yaml"), dock, load(NmpcParameters, values, "controller"))


@functools.lru_cache(maxsize=4)
def _controller(config: str, control: ControlParameters) -> DockingController:
    files = load_files(config)
    controller = DockingController(files.chair, files.dock, control, deterministic=True)
    controller.warm_up()
    return controller


def fresh_controller(config: str, control: ControlParameters) -> DockingController:
    """The controller with these parameters, as at the start of a program. Building one takes a second; it is kept."""
    controller = _controller(config, control)
    controller.reset()
    controller.reset_commands()
    controller.set_obstacles([])
    return controller


def shared_navigator(config: str, parameters: NmpcParameters) -> Navigator:
    """One search for all runs: it does not depend on the prediction."""
    control = dataclasses.replace(parameters.control, prediction=type(parameters.control.prediction)())
    return _navigator(config, dataclasses.replace(parameters, control=control))


@functools.lru_cache(maxsize=2)
def _navigator(config: str, parameters: NmpcParameters) -> Navigator:
    files = load_files(config)
    navigator = Navigator(files.chair, files.dock, parameters.control, parameters.planner)
    navigator.prepare()
    return navigator
