"""Find where the camera sits on the chair and how the markers hang, from a drive in front of the dock.

Drive by hand: straight towards the dock and back, and on the spot 25 deg to both sides, near and far, twice
(docs/how-to/calibrate_the_mount.md). Record it by `roslaunch seater_bringup record.launch bag:=FILE`. Written
are copies of the chair's and the dock's file, of the camera's where that says how certain it is, a picture and all
values as JSON; the files given stay as they are.
Exit status: 0 done, 1 a file could not be written, 2 wrong input, 3 the drive does not constrain the mount.
"""

from __future__ import annotations

import argparse
import datetime
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import yaml

from seater_common.camera_model import CameraModel
from seater_common.command.ending import results_folder
from seater_common.files import installation
from seater_common.files.whole import write_whole
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load, load_file, read_yaml
from seater_sim.settings import SimulatorSettings
from seater_tools.adjust.robust import NoMinimumError
from seater_tools.correct.known import bar_sd
from seater_tools.drive.bag import Topics, read_bag
from seater_tools.drive.drive import Drive, DriveError
from seater_tools.mount.copies import camera_text, chair_text, dock_text
from seater_tools.mount.picture import draw
from seater_tools.mount.prior import Lengths
from seater_tools.mount.result import camera_of, judge
from seater_tools.mount.solve import solve
from seater_tools.mount.table import as_json, describe
from seater_tools.trial.seen import simulate_drive
from seater_tools.trial.truth import Errors, describe_truth, draw_installation

NOT_CONSTRAINED = 3
RECORDS = ("mount.png", "mount.json")
ROLES = {role: role for role in ("dock", "chair", "camera")}  # of an installation, which it reads
SIDE, DISTANCE = (0.005, 2.0), (0.05, 20.0)  # [m] what a person may have measured


def add_options(parser: argparse.ArgumentParser, config: Path) -> None:
    """`config`: folder of the default files."""
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--bag", type=Path, help="a recorded drive")
    source.add_argument("--drive", type=Path, help="a drive that --save-drive has written (.npz)")
    source.add_argument("--simulate", type=int, metavar="SEED", help="a simulated drive at a dock hung up carelessly")
    parser.add_argument("--dock", type=Path, default=config / "docks" / "default.yaml", help="the dock as planned")
    parser.add_argument("--chair", type=Path, default=config / "chair.yaml", help="the chair as measured by a rule")
    parser.add_argument("--camera", type=Path, help="the camera's calibration (bag: its camera_info; else d455.yaml)")
    parser.add_argument("--measured-distance", nargs=3, action="append", default=[], metavar=("ID", "ID", "MM"),
                        help="between the centres of two markers, by a tape; fixes the scale best")  # fmt: skip
    parser.add_argument("--measured-side", nargs=2, action="append", default=[], metavar=("ID", "MM"),
                        help="of a marker's black square, by a ruler")  # fmt: skip
    parser.add_argument("--detections-topic", default=Topics.detections, help="in the bag (detections)")
    parser.add_argument("--odometry-topic", default=Topics.odometry, help="in the bag (odom)")
    parser.add_argument("--camera-info-topic", default=Topics.camera_info, help="in the bag, without --camera")
    parser.add_argument("--save-drive", type=Path, metavar="FILE", help="keep what was read of the drive (.npz)")
    parser.add_argument("--force", action="store_true", help="overwrite earlier results")
    parser.add_argument("--results", type=results_folder, default="results/calibrate_mount", metavar="DIR")


def run(options: argparse.Namespace, config: Path) -> int:
    """Raises ParameterError, DriveError (wrong input) and OSError (not written)."""
    if options.installation is not None and options.simulate is not None:
        raise ParameterError("--installation: goes with a real drive, --bag or --drive, not with --simulate")
    dock = load_file(Dock, options.dock)
    chair = load_file(Chair, options.chair)
    lengths = _lengths(options, dock)
    _targets([options.chair.name, options.dock.name, *RECORDS], options)  # refused before the work, not after it
    drive, camera, source = _drive(options, config, chair, dock)
    if options.save_drive is not None:
        drive.save(options.save_drive)
    try:
        solution = solve(drive, camera, chair.camera, dock, lengths)
    except NoMinimumError as error:
        raise DriveError(
            f"nothing like the two files explains this drive ({error}): are ids and places those of the dock file, is "
            "this the camera's calibration, does x of the odometry point ahead?"
        ) from error
    calibration = judge(solution, dock, lengths)
    print(describe(calibration))
    if calibration.missing:
        print("\nThis drive does not constrain where the camera sits; nothing is written. Drive again, and also:")
        print("\n".join(f"  {movement}" for movement in calibration.missing))
        return NOT_CONSTRAINED
    note = f"{datetime.date.today()}, from {source}, {calibration.images} images"
    texts = {
        options.chair.name: chair_text(options.chair.read_text(), str(options.chair), calibration, note),
        options.dock.name: dock_text(options.dock.read_text(), str(options.dock), dock, calibration, note),
    }
    load(Chair, yaml.safe_load(texts[options.chair.name]), options.chair.name)  # all values are in their ranges
    load(Dock, yaml.safe_load(texts[options.dock.name]), options.dock.name)
    roles = ["chair", "dock"]
    if camera.covariance is not None and options.camera is not None:
        name = str(read_yaml(options.camera).get("camera_name", "camera"))
        texts[options.camera.name] = camera_text(options.camera.read_text(), camera_of(solution), name, note)
        roles.append("camera")
    files = {name: text.encode() for name, text in texts.items()}
    files |= dict(zip(RECORDS, (draw(solution, calibration), as_json(calibration)), strict=True))
    _write(files, options)
    installation.conclude(options, {role: options.results / getattr(options, role).name for role in roles})
    if "camera" in roles:
        print(f"Give {options.camera.name} to the camera's driver, too: the mount goes with its lens.")
    return 0


def _write(files: dict[str, bytes], options: argparse.Namespace) -> None:
    """All or none, as far as names go: an earlier result stops it before the first is written."""
    for target, content in zip(_targets(files, options), files.values(), strict=True):
        write_whole(target, content, overwrite=True)
        print(target)


def _targets(names: Iterable[str], options: argparse.Namespace) -> list[Path]:
    """Where files of these names may be written. Raises ParameterError, FileExistsError."""
    targets = [options.results / name for name in names]
    given = {file.resolve() for file in (options.chair, options.dock, options.camera) if file is not None}
    for target in targets:
        if target.resolve() in given:
            raise ParameterError(f"--results: {options.results} holds {target.name} itself; choose another folder")
        if target.exists() and not options.force:
            raise FileExistsError(f"{target} exists already; --force overwrites it")
    return targets


def _drive(options: argparse.Namespace, config: Path, chair: Chair, dock: Dock) -> tuple[Drive, CameraModel, str]:
    """The drive, the camera it was seen with, and where it comes from."""
    camera = CameraModel.load(options.camera) if options.camera is not None else None
    if options.bag is not None:
        topics = (options.detections_topic, options.odometry_topic, options.camera_info_topic)
        drive, camera = read_bag(options.bag, Topics(*(topic.lstrip("/") for topic in topics)), camera)
        return drive, camera, options.bag.name
    camera = camera or CameraModel.load(config / "cameras" / "d455.yaml")
    if options.drive is not None:
        return Drive.load(options.drive), camera, options.drive.name
    seed = options.simulate
    if seed < 0:
        raise ParameterError(f"--simulate: is {seed}, must be >= 0")
    simulator = load(SimulatorSettings, read_yaml(config / "simulator.yaml"), "simulator.yaml")
    truth = draw_installation(chair.camera, dock, Errors(), np.random.default_rng(seed))
    print(describe_truth(truth))
    return simulate_drive(truth, camera, simulator, chair.limits, seed), camera, f"simulation {seed}"


def _lengths(options: argparse.Namespace, dock: Dock) -> Lengths:
    sides = {
        _marker("--measured-side", id, dock): _length("--measured-side", length, SIDE)
        for id, length in options.measured_side
    }
    distances = []
    for a, b, length in options.measured_distance:
        first, second = (_marker("--measured-distance", id, dock) for id in (a, b))
        if first == second:
            raise ParameterError(f"--measured-distance: marker {first} is named twice")
        distances.append((first, second, _length("--measured-distance", length, DISTANCE)))
    return Lengths(bar_sd(options.dock.read_text()), sides, tuple(distances))


def _marker(option: str, text: str, dock: Dock) -> int:
    ids = [marker.id for marker in dock.markers]
    if not text.isdecimal() or int(text) not in ids:
        raise ParameterError(f"{option}: marker is {text!r}, must be one of {', '.join(map(str, ids))}")
    return int(text)


def _length(option: str, text: str, allowed: tuple[float, float]) -> float:
    low, high = allowed
    try:
        length = 0.001 * float(text)
    except ValueError:
        length = float("nan")
    if not low <= length <= high:
        raise ParameterError(f"{option}: is {text!r} mm, must be {1000 * low:g} to {1000 * high:g} mm")
    return length
