"""Goes through the commands of docs/tutorials/from_the_box.md at a hidden installation, each with the files that the
one before has written. Knows of the truth only what eyes, ruler and tape say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.files.installation import Installation
from seater_common.geometry import Chair
from seater_common.params import load, read_yaml
from seater_identify.settings import IdentifySettings
from seater_tools.commissioning.hidden import PAPER, Hidden
from seater_tools.commissioning.live import live_crosses
from seater_tools.commissioning.photographs import Photographer
from seater_tools.commissioning.pilots import ByEye, Identification, Pilot
from seater_tools.commissioning.programs import run_program
from seater_tools.commissioning.record import record
from seater_tools.trial.drive import SCRIPT, START, Script, To
from seater_tools.trial.eyes import make_tracker

Array = NDArray[np.float64]

NOT_CONSTRAINED = 3  # exit status of calibrations
LONGEST = 180.0  # [s] of a drive
IDENTIFY_FROM = (-2.2, 0.0, 0.0)  # in the dock frame, as docs/how-to/identify_the_chair.md asks for
PARK_FROM, STANDS = -1.4, 5.0  # [m] where the drive in begins, [s] it stands at the end
TRIES = 3  # of a step that asks for more, or of a drive


class StepError(Exception):
    """A command refused; the message is what it said last."""


@dataclass
class Technician:
    """`installation`: the folder whose files each command reads and replaces. `seconds`: of driving in each step."""

    hidden: Hidden
    config: Path
    folder: Path  # of all that is recorded
    script: Script = SCRIPT  # of the drive for the mount
    seconds: dict[str, float] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    taught: Array | None = None  # (3,) true pose in which the chair stood when it was taught

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True)
        self._said = ""  # by the last command
        self.installation = Installation(self.folder / "installation")

    def sheets(self) -> None:
        """Prints, and says what the bars measure where somebody measured them."""
        self._run("seater_tools", "installation", self.installation.folder)
        words = (*self._here(), "--paper", PAPER.name)
        self._run("seater_tools", "sheets", *words)
        self._measure_bars(words)
        self._run("seater_tools", "sheets", "--board", "charuco", "--results", self.folder)

    def _measure_bars(self, words: Sequence[str]) -> None:
        """Reads them again where the program asks for it."""
        for attempt, bars in enumerate(self.hidden.bars, 1):
            try:
                self._run("seater_tools", "sheets", *words, "--measured-bar", *(f"{bar:g}" for bar in bars))
                return
            except StepError as error:
                if "Read both again" not in str(error) or attempt == len(self.hidden.bars):
                    raise

    def lens(self) -> None:
        """Takes views, and those that the guide asks for, until they are enough."""
        images = self.folder / "photographs"
        photographer = Photographer(self.hidden.lens, images, self.hidden.seed)
        for _ in range(TRIES):
            photographer.take(self._said)
            if self._run("seater_tools", "calibrate", "camera", *self._here(), "--images", images, more=True):
                return
        raise StepError("the lens is not constrained")

    def mount(self) -> None:
        """A drive in front of the dock, and a tape between two markers."""
        a, b, distance = self.hidden.tape
        bag, tape = self.folder / "mount.bag", ("--measured-distance", str(a), str(b), f"{1000 * distance:.1f}")
        for attempt in range(TRIES):
            self._record("mount", ByEye(self.script), START, bag, 10 + attempt)
            if self._run("seater_tools", "calibrate", "mount", *self._here(), "--bag", bag, *tape, more=True):
                return
        raise StepError("the mount is not constrained")

    def identify(self) -> None:
        """The scripted drive in front of the dock."""
        settings = load(IdentifySettings, read_yaml(self.config / "identify.yaml"), "identify.yaml")
        chair = load(Chair, read_yaml(self.installation.file("chair")), "chair.yaml")
        pilot = Identification(settings, chair, read_yaml(self.config / "safety.yaml"))
        bag = self.folder / "identify.bag"
        self._record("identify", pilot, IDENTIFY_FROM, bag, 20)
        if not pilot.done:
            self.notes["identify"] = f"the drive was stopped: {pilot.text}"
        self._run("seater_identify", "identify", *self._here(), "--bag", bag)

    def teach(self) -> None:
        """Drives in by hand, stands, and confirms."""
        x, y = self.hidden.place
        bag, start = self.folder / "teach.bag", (PARK_FROM, 0.3 * y, 0.0)
        self.taught = self._record("teach", ByEye((To(x, y),)), start, bag, 30, stands=STANDS)
        self._run("seater_tools", "teach", *self._here(), "--bag", bag)

    def doctor(self) -> None:
        """Before the launch file is started, and while it runs, with its drive."""
        self._run("seater_tools", "doctor", *self._here())
        crosses = live_crosses(self.hidden, self.installation, self.config)
        if crosses:
            self.notes["doctor"] = "; ".join(crosses)

    def _here(self) -> tuple[str, str]:
        return "--installation", str(self.installation.folder)

    def _record(self, step: str, pilot: Pilot, start: ArrayLike, bag: Path, drive: int, stands: float = 0.0) -> Array:
        """The true pose at the end. Perception is told the files as they are now."""
        file = self.installation.file
        camera, mount = CameraModel.load(file("camera")), read_yaml(file("chair"))["camera"]
        perception = read_yaml(self.config / "perception.yaml")
        tracker = make_tracker(camera, read_yaml(file("dock")), perception, mount)
        seconds, pose = record(
            self.hidden, tracker, camera, pilot, start, bag, drive=drive, longest=LONGEST, stands=stands
        )
        self.seconds[step] = self.seconds.get(step, 0.0) + seconds
        return pose

    def _run(self, package: str, program: str, *words: str | Path, more: bool = False) -> bool:
        """Whether it was done; False, with `more`: it asks for more views or another drive.

        Raises StepError: it refuses.
        """
        done = run_program(package, program, *words)
        self._said = done.output
        with (self.folder / "said.txt").open("a") as file:
            file.write(f"$ {program} {' '.join(map(str, words))}\n{done.output}\n[{done.code}]\n\n")
        if done.code == 0 or (more and done.code == NOT_CONSTRAINED):
            return done.code == 0
        raise StepError(f"{program}: {done.last} (exit status {done.code})")
