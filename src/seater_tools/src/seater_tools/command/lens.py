"""Find a camera's focal length, principal point and distortion from images of a board.

The board: `./seater sheets --board charuco`, glued on something flat. Hold it, or the camera, in 15 or more places: at
every edge and corner of the image, near, and tilted to all four sides; sharp and still. Images come from a folder, or
(--topic) live: kept is each view that is new, and the terminal says which are missing
(docs/how-to/calibrate_the_lens.md).
Exit status: 0 done, 1 a file could not be written, 2 wrong input, 3 the views do not constrain the lens.
"""

from __future__ import annotations

import argparse
import datetime
import re
from collections.abc import Sequence
from pathlib import Path

import cv2

from seater_common.command.ending import results_folder
from seater_common.files import installation
from seater_common.files.whole import write_whole
from seater_common.params import ParameterError
from seater_tools.board.board import CHARUCO, CHESSBOARD, SQUARES, Board
from seater_tools.lens.find import View, find_board
from seater_tools.lens.model import COEFFICIENTS, LensError
from seater_tools.lens.output import camera_yaml, draw
from seater_tools.lens.result import calibrate, describe

NOT_CONSTRAINED = 3
ROLES: dict[str, str] = {}  # of an installation, which it reads
SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm")
FEWEST_VIEWS = 5  # below, nothing can be fitted and held out
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")  # camera_info_manager takes no other


def add_options(parser: argparse.ArgumentParser, config: Path) -> None:
    """`config` is not used: a lens has no default file."""
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--images", type=Path, metavar="DIR", help="folder of images, all of one size")
    source.add_argument("--topic", help="sensor_msgs/Image to collect views from, into DIR/images of --results")
    parser.add_argument("--board", choices=(CHARUCO, CHESSBOARD), default=CHARUCO, help="(charuco)")
    parser.add_argument("--squares", type=int, nargs=2, default=(7, 10), metavar=("ACROSS", "DOWN"),
                        help="of the board (7 10; a chessboard has one inner corner less each way)")  # fmt: skip
    parser.add_argument("--model", choices=COEFFICIENTS, default="plumb_bob", help="lens model (plumb_bob)")
    parser.add_argument("--name", default="camera", help="camera_name, and the file's (camera)")
    parser.add_argument("--force", action="store_true", help="overwrite earlier results")
    parser.add_argument("--results", type=results_folder, default="results/calibrate_camera", metavar="DIR")


def run(options: argparse.Namespace, config: Path) -> int:
    """Raises ParameterError, LensError (wrong input) and OSError (not written)."""
    board = _board(options)
    if not NAME.fullmatch(options.name):
        raise ParameterError(f"--name: is {options.name!r}, must be letters, digits and _, a letter first")
    targets = [options.results / f"{options.name}{suffix}" for suffix in (".yaml", ".png")]
    for target in targets:
        if target.exists() and not options.force:
            raise FileExistsError(f"{target} exists already; --force overwrites it")
    folder = options.images
    if folder is None:
        from seater_tools.ros.collect import collect_views

        folder = options.results / "images"
        collect_views(options.topic, board, folder)
    views, size = read_views(folder, board)
    result = calibrate(views, board, options.model, size)
    print(describe(result))
    squares = f"{board.columns} x {board.rows}"
    note = f"{installation.LENS[2:]}{datetime.date.today()}, {options.board} of {squares}, {folder.name}"
    write_whole(targets[1], draw(result, views), overwrite=True)
    print(targets[1])
    if result.refused:
        print("\nThese views do not constrain the lens; no calibration is written.\n  " + "\n  ".join(result.refused))
        return NOT_CONSTRAINED
    write_whole(targets[0], camera_yaml(result, options.name, note).encode(), overwrite=True)
    print(targets[0])
    installation.conclude(options, {installation.CAMERA: targets[0]})
    return 0


def read_views(folder: Path, board: Board) -> tuple[Sequence[View], tuple[int, int]]:
    """The views in a folder, and (width, height) of its images; says how many show the board.

    Raises:
        ParameterError: no folder, no images, several sizes, or too few that show the board.
    """
    if not folder.is_dir():
        raise ParameterError(f"--images: {folder} is no folder")
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    if not paths:
        raise ParameterError(f"--images: {folder} holds no images ({', '.join(SUFFIXES)})")
    views, sizes, without = [], dict[tuple[int, int], Path](), []
    for path in paths:
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        if image is None:
            raise ParameterError(f"{path}: cannot be read as an image")
        sizes.setdefault((image.shape[1], image.shape[0]), path)
        view = find_board(image, board, path.name)
        if view is None:
            without.append(path.name)
        else:
            views.append(view)
    if len(sizes) > 1:
        found = ", ".join(f"{path.name} {width} x {height}" for (width, height), path in sizes.items())
        raise ParameterError(f"{folder}: images of several sizes: {found}")
    if len(views) < FEWEST_VIEWS:
        raise ParameterError(
            f"{folder}: {len(views)} of {len(paths)} images show the board, at least {FEWEST_VIEWS} are needed "
            f"(is it a {board.kind} of {board.columns} x {board.rows} squares?)"
        )
    print(f"{len(views)} of {len(paths)} images show the board" + (f"; not {', '.join(without)}" if without else ""))
    return views, next(iter(sizes))


def _board(options: argparse.Namespace) -> Board:
    across, down = options.squares
    if not (4 <= across <= 30 and 4 <= down <= 30):
        raise ParameterError(f"--squares: is {across} x {down}, must be 4 to 30 each")
    board = Board(options.board, across, down, SQUARES["a4"])
    if len(board.markers()) > 100:
        raise ParameterError(f"--squares: {across} x {down} have more than 100 white ones, and no more markers exist")
    return board


__all__ = ["LensError", "add_options", "read_views", "run"]
