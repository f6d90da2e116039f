"""One folder with the files of one chair and its dock: the commands read them there, put the new versions in their
places (the old ones stay beside them, with the time in their names), and say which step comes next.

What has been done stands in the files themselves, in the line that each command writes at their beginning.
"""

from __future__ import annotations

import argparse
import datetime
import shlex
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from seater_common.command.typed import as_typed
from seater_common.files.whole import replace_kept, write_whole

# Role to the shipped file, below the folder of seater_config, that it begins as. The lens comes from its calibration.
SHIPPED = {"chair": "chair.yaml", "dock": "docks/default.yaml", "controller": "controller.yaml"}
CAMERA = "camera"
LENS, MOUNT, IDENTIFIED, TAUGHT = "# Lens calibrated: ", "# Camera calibrated: ", "# Identified: ", "# Taught: "


@dataclass(frozen=True)
class Step:
    """`file`, `mark`: done where a line of the file begins so. `how`: what to type, with the folder in place of {}."""

    name: str
    file: str
    mark: str
    how: str


STEPS = (
    Step("markers printed", "sheets/dock_*.pdf", "", "./seater sheets --installation {}, print, and hang the markers"),
    Step(
        "lens calibrated",
        "camera.yaml",
        LENS,
        "./seater sheets --board charuco, then: ./seater calibrate camera --installation {} --topic "
        "camera/color/image_raw, and give camera.yaml to the camera's driver. A camera that brings its own calibration "
        "needs none: go on with ./seater calibrate mount",
    ),
    Step(
        "mount calibrated",
        "chair.yaml",
        MOUNT,
        "record a drive in front of the dock (docs/how-to/calibrate_the_mount.md), then: ./seater calibrate mount "
        "--installation {} --bag FILE --measured-distance ID ID MM",
    ),
    Step(
        "chair identified",
        "controller.yaml",
        IDENTIFIED,
        "./seater run roslaunch seater_bringup identify.launch installation:={} (docs/how-to/identify_the_chair.md)",
    ),
    Step(
        "dock taught",
        "dock.yaml",
        TAUGHT,
        "./seater run roslaunch seater_bringup teach.launch installation:={} (docs/how-to/teach_the_dock.md)",
    ),
)
DONE = (
    "./seater doctor --installation {}, then dock: ./seater run roslaunch seater_bringup wheelchair.launch "
    "installation:={}"
)


class Installation:
    """The folder; it need not be there yet."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def file(self, role: str) -> Path:
        """Where the file of a role is, or will be."""
        return self.folder / f"{role}.yaml"

    @property
    def missing(self) -> list[str]:
        """Roles whose files should be there and are not."""
        return [role for role in SHIPPED if not self.file(role).is_file()]

    def create(self, sources: Mapping[str, Path]) -> list[Path]:
        """The files that are missing, as copies of the `sources` of their roles. Raises OSError."""
        roles = self.missing
        for role in roles:
            write_whole(self.file(role), sources[role].read_bytes(), overwrite=False)
        return [self.file(role) for role in roles]

    def take(self, new: Mapping[str, Path]) -> list[str]:
        """Copies of these files, by role, take the places of the old ones, which stay; a line for each. Raises
        OSError."""
        lines = []
        for role, path in new.items():
            written, *old = _replace(path.read_text(), self.file(role))
            lines.append(f"{written} is new" + (f"; the one before is kept as {old[0].name}" if old else ""))
        if CAMERA in new and "chair" not in new and self._forget("chair", MOUNT):
            lines.append(f"{self.file('chair')} was calibrated with another lens: calibrate the mount again")
        return lines

    def done(self) -> dict[str, bool]:
        """Step to whether it has been done, in their order."""
        return {step.name: self._is_done(step) for step in STEPS}

    def next(self) -> str:
        """What to type next. A lens counts as calibrated where the mount is: the camera brought its calibration."""
        done = self.done()
        done["lens calibrated"] |= done["mount calibrated"]
        how = next((step.how for step in STEPS if not done[step.name]), DONE)
        return as_typed(how).replace("{}", shlex.quote(str(self.folder.resolve())))  # for nodes, which run elsewhere

    def _forget(self, role: str, mark: str) -> bool:
        """Take the line with this mark out of the file; False: there was none."""
        lines = self.file(role).read_text().splitlines(keepends=True)
        kept = [line for line in lines if not line.startswith(mark)]
        if len(kept) < len(lines):
            write_whole(self.file(role), "".join(kept).encode(), overwrite=True)
        return len(kept) < len(lines)

    def _is_done(self, step: Step) -> bool:
        return any(
            not step.mark or any(line.startswith(step.mark) for line in path.read_text().splitlines())
            for path in self.folder.glob(step.file)
        )


def _replace(text: str, target: Path) -> list[Path]:
    """As replace_kept, now. Where a command before has kept a file in this second, which names it, in the next one."""
    try:
        return replace_kept(text, target, datetime.datetime.now(datetime.UTC))
    except FileExistsError:
        time.sleep(1.0)
        return replace_kept(text, target, datetime.datetime.now(datetime.UTC))


def add_option(parser: argparse.ArgumentParser) -> None:
    """--installation."""
    parser.add_argument(
        "--installation", type=Path, metavar="DIR", help="read the files there, and put the new ones in their places"
    )


def use(options: argparse.Namespace, parser: argparse.ArgumentParser, roles: Mapping[str, str], work: str) -> None:
    """With --installation: options named in `roles` that were not given are its files of these roles, and results (if
    there is such an option) go into its folder `work`, over earlier ones. Ends the program (2) when a file is missing.
    """
    if options.installation is None:
        return
    installation = Installation(options.installation)
    if installation.missing:
        parser.error(
            f"--installation: {options.installation} has no {installation.missing[0]}.yaml; "
            + as_typed(f"./seater installation {options.installation} makes what is missing")
        )
    values: dict[str, Any] = {"results": options.installation / work, "force": True}
    for name, role in roles.items():
        path = installation.file(role)
        if role != CAMERA or path.is_file():
            values[name] = [path] if isinstance(parser.get_default(name), list) else path
    for name, value in values.items():
        if hasattr(options, name) and str(getattr(options, name)) == str(parser.get_default(name)):
            setattr(options, name, value)


def conclude(options: argparse.Namespace, new: Mapping[str, Path]) -> None:
    """With --installation: put the new files, by role, in their places, and say what comes next. Raises OSError."""
    if options.installation is None:
        return
    installation = Installation(options.installation)
    for line in installation.take(new):
        print(line)
    print(f"\nNext: {installation.next()}")
