"""The common options of the evaluation's commands, and where config/ is."""

from __future__ import annotations

import argparse
from pathlib import Path

from seater_common.command.ending import results_folder


def make_parser(command: str, description: str | None) -> argparse.ArgumentParser:
    """--config, --results and --quick; the caller adds its own."""
    parser = argparse.ArgumentParser(prog=command, description=description)
    parser.add_argument("--config", type=Path, help="folder like config/ (default: that of the package seater_config)")
    parser.add_argument(
        "--results", type=results_folder, default="results", help="folder for JSON and figure (results)"
    )
    parser.add_argument("--quick", action="store_true", help="a small version for tests; its numbers are no proof")
    return parser


def add_peers_option(parser: argparse.ArgumentParser) -> None:
    """--peers."""
    parser.add_argument(
        "--peers", type=Path, metavar="FOLDER", help="also beside detectors from PyPI (tools/make_peers.sh FOLDER)"
    )


def config_folder(options: argparse.Namespace) -> Path:
    """The folder asked for, else that of seater_config. Raises rospkg.ResourceNotFound without the package."""
    if options.config is not None:
        return Path(options.config)
    import rospkg

    return Path(rospkg.RosPack().get_path("seater_config"))
