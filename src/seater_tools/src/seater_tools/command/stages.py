"""`seater doctor --stages`: the first stage of the docking that fails."""

from __future__ import annotations

import argparse
from pathlib import Path

from seater_common.params import ParameterError
from seater_tools.ros.master import require_master
from seater_tools.stages.report import as_json, describe
from seater_tools.stages.tree import first_failing, read_stages, sort

SHORTEST = 1.5  # [s] to listen: nodes report once a second


def run(options: argparse.Namespace, file: Path) -> int:
    """Exit status. `file`: config/diagnostics.yaml. Raises ParameterError: wrong input, or no ROS master."""
    if options.seconds < SHORTEST:
        raise ParameterError(f"--seconds: is {options.seconds:g}, must be {SHORTEST:g} or more with --stages")
    stages = read_stages(file)
    require_master("wheelchair.launch")
    from seater_tools.ros.stages import listen

    heard = sort(stages, listen("doctor_stages", options.seconds))
    print(as_json(heard) if options.json else describe(heard, values=options.values))
    failing = first_failing(heard)
    return 1 if failing is not None and failing.fails else 0
