"""Faults of an installation, each as what it does to a scene, and the check that must name it.

A fault is named rightly when the first cross is of that check and its text holds the word.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from seater_tools.doctor.trial import edits, rows
from seater_tools.doctor.trial.edits import Edit


@dataclass(frozen=True)
class Fault:
    """`edit` makes a good scene a faulty one; `drive`: only --move can find it."""

    family: str
    name: str
    check: str
    word: str
    edit: Edit
    drive: bool = False


def _files() -> list[Fault]:
    family = "files"
    overlapping = edits.file("dock", ("markers", 1, "position"), [0.9, 0.1, 0.7])
    behind = edits.file("dock", ("markers", 2, "position"), [1.0, -0.35, 0.7])
    broken = edits.broken_file
    return [
        Fault(
            family, "chair.yaml: misspelt key", "chair file", "v_maks", edits.file("chair", ("limits", "v_maks"), 0.6)
        ),
        Fault(family, "dock file: tab, no YAML", "dock file", "cannot read", broken("dock")),
        Fault(
            family,
            "perception.yaml: string for a number",
            "perception file",
            "must",
            edits.rewritten("perception", "1", "one"),
        ),
        Fault(
            family,
            "safety.yaml: a_stop 0.01",
            "safety file",
            "a_stop",
            edits.rewritten("safety", "a_stop: 1.5", "a_stop: 0.01"),
        ),
        Fault(
            family, "bay narrower than the chair", "files together", "width", edits.file("dock", ("bay", "width"), 0.6)
        ),
        Fault(
            family,
            "mount looks at the ceiling",
            "files together",
            "view",
            edits.file("chair", ("camera", "pitch"), -1.2),
        ),
        Fault(family, "two markers overlap", "dock geometry", "overlap", overlapping),
        Fault(family, "marker behind the wall", "dock geometry", "behind", behind),
        Fault(
            family,
            "id beyond the family",
            "dock geometry",
            "no marker 60",
            edits.file("dock", ("markers", 0, "id"), 60),
        ),
        Fault(family, "calibration of half the size", "calibration", "another size", edits.lens_of_half_size),
        Fault(
            family,
            "edited after the start",
            "files in use",
            "tolerance",
            edits.told("dock", ("tolerance", "position"), 0.02),
        ),
    ]


def _computer() -> list[Fault]:
    family = "computer"
    return [
        Fault(family, "a package is missing", "packages", "seater_safety", edits.machine(missing=("seater_safety",))),
        Fault(family, "disk full", "disk", "0.2 GB", edits.machine(free=2e8)),
        Fault(family, "processor at its limit", "processor", "97 %", edits.machine(busy=0.97)),
        Fault(family, "simulated time left", "clock", "use_sim_time", edits.live(simulated_time=True)),
    ]


def _topics() -> list[Fault]:
    family = "topics and clocks"
    two = edits.traffic("cmd_vel", publishers=("/safety_gate", "/teleop"))
    return [
        Fault(family, "no base driver listens", "nodes", "motors", edits.traffic("cmd_vel", listeners=())),
        Fault(family, "perception not started", "nodes", "detections", edits.traffic("detections", publishers=())),
        Fault(family, "two senders of cmd_vel", "senders", "/teleop", two),
        Fault(
            family,
            "one message of ten of the odometry",
            "odom rate",
            "are needed",
            edits.tamper(odometry=rows.every(10)),
        ),
        Fault(family, "no images", "image rate", "nothing", edits.tamper(image=lambda image: None)),
        Fault(family, "odometry with stamps 0", "odom stamps", "are 0", edits.tamper(odometry=rows.zero_stamp)),
        Fault(family, "camera's clock 2 s behind", "image stamps", "old", edits.tamper(image_stamp=lambda t: t - 2.0)),
        Fault(
            family, "camera's clock 1 s ahead", "image stamps", "future", edits.tamper(image_stamp=lambda t: t + 1.0)
        ),
        Fault(family, "gyro drifts at rest", "odometry at rest", "rad/s", edits.tamper(odometry=rows.drifting)),
    ]


def _camera() -> list[Fault]:
    family = "camera"
    return [
        Fault(family, "camera_info not calibrated", "camera_info", "no calibration", edits.no_calibration),
        Fault(family, "camera_info of another size", "camera_info", "640 x 480", edits.info_of_half_size),
        Fault(family, "over-exposed", "exposure", "cut off", edits.light(gain=1.6)),
        Fault(family, "far too dark", "exposure", "contrast", edits.light(gain=0.12)),
        Fault(family, "TF 50 mm from chair.yaml", "camera in TF", "50 mm", edits.tf(x=0.05)),
        Fault(family, "TF 2 deg from chair.yaml", "camera in TF", "2.0 deg", edits.tf(yaw=math.radians(2.0))),
        Fault(family, "pitch 2.5 deg off", "camera tilt and height", "tilted", edits.camera(pitch=math.radians(2.5))),
        Fault(family, "60 mm lower than the file", "camera tilt and height", "mm too high", edits.camera(z=-0.06)),
    ]


def _markers() -> list[Fault]:
    family = "markers"
    return [
        Fault(family, "other family printed", "markers in view", "DICT_5X5", edits.other_family),
        Fault(family, "other ids printed", "markers in view", "10, 11, 12", edits.other_ids),
        Fault(family, "one covered", "markers in view", "marker 2", edits.covered),
        Fault(family, "marker 1 10 % too small", "marker sizes", "marker 1 is", edits.printed(1, 0.9)),
        Fault(family, "marker 0 6 % too large", "marker sizes", "marker 0 is", edits.printed(0, 1.06)),
        Fault(family, "all on letter paper: 6 % too small", "marker sizes", "marker 2 is", edits.all_printed(0.94)),
        Fault(family, "marker 1 40 mm aside", "marker places", "marker 1", edits.printed(1, shift=(0.0, 0.04, 0.0))),
        Fault(family, "marker 2 30 mm lower", "marker places", "marker 2", edits.printed(2, shift=(0.0, 0.0, -0.03))),
    ]


def _inputs() -> list[Fault]:
    family = "inputs"
    pressed = edits.tamper(gate=lambda gate, now: gate.emergency_stop(now, True))
    leans = edits.tamper(joystick=lambda rng: (0.04 + 0.005 * rng.standard_normal(), 0.0))
    return [
        Fault(family, "emergency stop pressed", "emergency stop", "pressed", pressed),
        Fault(family, "joystick off its middle", "joystick", "at rest", leans),
        Fault(family, "contact always closed", "charging contact", "closed", edits.closed_contact),
        Fault(family, "contact wanted, none there", "charging contact", "nobody", edits.no_charger),
    ]


def _motion() -> list[Fault]:
    family = "motion"

    def backward(v: float, omega: float) -> tuple[float, float]:
        return -v, omega

    wheels = "odometry against images"
    drives = [
        ("motors reversed", "command path", "went -", edits.tamper(command=backward)),
        ("motors without power", "command path", "does not move", edits.tamper(command=lambda v, omega: (0.0, 0.0))),
        ("odometry frozen", wheels, "+0.000", edits.tamper(odometry=rows.frozen)),
        ("odometry counts backward", wheels, "way: -", edits.tamper(odometry=rows.reversed_way)),
        ("odometry turns the other way", wheels, "turn: ", edits.tamper(odometry=rows.turned_about)),
        ("wheels 25 % too large", wheels, "times", edits.tamper(odometry=rows.scaled(0.75))),
        ("camera 50 mm ahead", "camera mount", "x of", edits.camera(x=0.05)),
        ("camera 96 mm back", "camera mount", "x of", edits.camera(x=-0.096)),
        ("camera 40 mm aside", "camera mount", "y of", edits.camera(y=0.04)),
        ("camera 96 mm aside", "camera mount", "y of", edits.camera(y=-0.096)),
        ("camera turned 3 deg", "camera mount", "yaw of", edits.camera(yaw=math.radians(3.0))),
        ("images stamped 80 ms late", "image delay", "taken -", edits.stamped_at_arrival),
    ]
    return [Fault(family, name, check, word, edit, drive=True) for name, check, word, edit in drives]


FAULTS: tuple[Fault, ...] = (*_files(), *_computer(), *_topics(), *_camera(), *_markers(), *_inputs(), *_motion())
