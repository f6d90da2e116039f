"""Check an installation: files and computer; and, while wheelchair.launch runs, everything from lens to motors.

Let the chair face the dock, the camera 1 to 1.5 m before the markers, without a goal, and leave the joystick alone.
--move (while check.launch runs instead) asks on the terminal, then drives 0.3 m ahead, turns 20 deg to both sides and
comes back: it tells the signs of motors and odometry, and where the camera sits.
--stages, while anything runs, says which stage fails first (camera, detection, pose, observer, solver, sequence,
obstacles, gate, base), why, and what to do; it exits with 1 when one fails.
What each check says: docs/how-to/check_the_installation.md.
Exit status: 0 nothing is wrong, 1 something is, 2 wrong input.
"""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

import rosgraph

from seater_common.files.whole import write_whole
from seater_common.params import ParameterError
from seater_tools.doctor.checks import run as run_checks
from seater_tools.doctor.gather.drive import pieces
from seater_tools.doctor.gather.machine import ProcessorTime, look_at_files, look_at_machine
from seater_tools.doctor.gather.room import room_for
from seater_tools.doctor.observations import ROLES as OBSERVED
from seater_tools.doctor.observations import Live, Observations
from seater_tools.doctor.report import as_json, describe, support_zip
from seater_tools.doctor.setup import Setup

WRONG = 1
ROLES = ("chair", "dock", "camera", "controller")  # of an installation
SECONDS = (1.0, 60.0)
WAY, TURN = (0.05, 0.5), (0.0, 30.0)  # [m], [deg] that may be asked for


def add_options(parser: argparse.ArgumentParser, config: Path) -> None:
    """`config`: folder of the default files."""
    defaults = {"chair": "chair.yaml", "dock": "docks/default.yaml", "camera": None, "controller": "controller.yaml"}
    defaults |= {"perception": "perception.yaml", "safety": "safety.yaml", "obstacles": "obstacles.yaml"}
    for role, name in defaults.items():
        path = config / name if name is not None else None
        text = f"({name})" if name is not None else "the calibration (none: as camera_info says)"
        parser.add_argument(f"--{role}", type=Path, default=path, metavar="FILE", help=text)
    parser.add_argument("--image", default="camera/color/image_raw", help="topic (camera/color/image_raw)")
    parser.add_argument("--compressed", action="store_true", help="images come on TOPIC/compressed")
    parser.add_argument("--odom", default="odom", help="topic (odom)")
    parser.add_argument("--cmd-vel", default="cmd_vel", help="topic of the motors (cmd_vel)")
    parser.add_argument("--seconds", type=float, default=4.0, help="for which topics are watched (4)")
    parser.add_argument("--move", action="store_true", help="drive a little as well, after asking")
    parser.add_argument("--way", type=float, default=0.3, metavar="M", help="of --move, ahead and back (0.3)")
    parser.add_argument("--turn", type=float, default=20.0, metavar="DEG", help="of --move, to both sides (20)")
    parser.add_argument("--stages", action="store_true", help="only name the first stage of the docking that fails")
    parser.add_argument("--values", action="store_true", help="of --stages: rates, ages and counts of each, too")
    parser.add_argument("--json", action="store_true", help="the results as JSON")
    parser.add_argument("--zip", type=Path, metavar="FILE", help="files, results and a short record, for support")


def run(options: argparse.Namespace) -> int:
    """Raises ParameterError (wrong input) and OSError (the zip file cannot be written)."""
    _check_numbers(options)
    files = look_at_files({role: getattr(options, role) for role in OBSERVED})
    processor = ProcessorTime()
    observations = Observations(files)
    live = _watch(options, observations.setup) if rosgraph.is_master_online() else None
    if live is None and options.move:
        raise ParameterError("--move: needs a running system (roslaunch seater_bringup check.launch)")
    folder = Path(os.environ.get("ROS_LOG_DIR") or Path.home() / ".ros" / "log")
    machine = look_at_machine(folder, processor.busy() if live is not None else None)
    observations = Observations(files, machine, live)
    verdicts = run_checks(observations)
    print(as_json(verdicts, observations) if options.json else describe(verdicts))
    if options.zip is not None:
        write_whole(options.zip, support_zip(verdicts, observations), overwrite=True)
    return WRONG if any(verdict.ok is False for verdict in verdicts) else 0


def _check_numbers(options: argparse.Namespace) -> None:
    for name, (low, high) in (("seconds", SECONDS), ("way", WAY), ("turn", TURN)):
        value = getattr(options, name)
        if not low <= value <= high:
            raise ParameterError(f"--{name}: is {value:g}, must be {low:g} to {high:g}")


def _watch(options: argparse.Namespace, setup: Setup) -> Live:
    from seater_tools.ros.doctor import Names, begin, wait

    watch = begin(Names(options.image, options.odom, options.cmd_vel, options.compressed))
    wait(options.seconds)
    live = replace(watch.live(setup.dock), asks_to_drive=options.move)
    if not options.move:
        return live
    if setup.chair is None or setup.dock is None:
        raise ParameterError("--move: chair and dock file must be in order first (try without it)")
    from seater_tools.ros.doctor_move import Mover

    turn = math.radians(options.turn)
    why_not = "the simulation runs in lock-step (lock_step:=false)" if live.lock_step else ""
    if live.topics["velocity_request"].publishers:
        why_not = "another node drives; end wheelchair.launch, and start: roslaunch seater_bringup check.launch"
    why_not = why_not or room_for(live, setup.chair, setup.dock, options.way, turn)
    if why_not:
        raise ParameterError(f"--move: {why_not}")
    if not _agreed(options):
        print("not driven", file=sys.stderr)
        return live
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(WRONG))  # through `finally`, which sends zero
    try:
        return replace(live, move=Mover(watch, setup.chair, pieces(options.way, turn)).run(live))
    except KeyboardInterrupt:  # zero has been sent
        return live
    finally:
        watch.end()


def _agreed(options: argparse.Namespace) -> bool:
    """Asked on the terminal, answered there with the word itself."""
    print(
        f"The chair will drive {options.way:g} m ahead (0.5 m at most), turn {options.turn:g} deg to both sides on the "
        "spot, and come back.\nIs 1 m free ahead and 1 m all round, is the passenger told, is the emergency stop at "
        "hand? Where docking needs\nhold-to-run, hold it now until the chair stands. Type yes to drive: ",
        end="",
        file=sys.stderr,
        flush=True,
    )
    return sys.stdin.readline().strip().lower() == "yes"
