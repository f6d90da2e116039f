"""acados beside the controller: steps on the controller's own instances, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from multiprocessing import Pipe
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_eval.acados.stage import docking_stage, from_stages, to_stages
from seater_eval.acados.worker import Answer
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import ProblemData

Array = NDArray[np.float64]


class AcadosError(Exception):
    """acados cannot be used; the text says why and what to do."""


class AcadosPeer:
    """One real-time iteration of acados for each instance of the docking problem, from its own last plan.

    A context manager: its end ends the process.
    """

    def __init__(self, chair: Chair, dock: Dock, parameters: ControlParameters, folder: Path) -> None:
        """`folder`: what tools/make_acados.sh made.

        Raises:
            AcadosError: acados is not there, or does not build.
            ValueError: the parameters ask for a problem that it is not set up for.
        """
        self._stage, self._horizon = docking_stage(chair, dock, parameters), parameters.horizon
        self._count = self._stage.lines.stop - self._stage.lines.start
        self._pipe, theirs = Pipe()
        self._process = _start(folder, theirs.fileno())
        theirs.close()
        fault = self._ask((chair, dock, parameters))
        if fault:
            self.close()
            raise AcadosError(f"acados in {folder} does not build: {fault}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.wait(timeout=10.0)

    def begin(self, x: Array) -> None:
        """Start from these variables (DockingProblem's order), a converged solution say."""
        self._ask(("begin", to_stages(x, self._stage, self._horizon)))

    def step(self, data: ProblemData) -> tuple[Array, Answer]:
        """One step on this instance: variables in DockingProblem's order, and acados' own answer."""
        lines = data.p[self._stage.lines.start :].reshape(self._horizon, self._count)
        answer: Answer = self._ask(("step", (data.lbx[:5], lines)))
        return from_stages(answer.states, answer.inputs), answer

    def _ask(self, question: Any) -> Any:
        try:
            self._pipe.send(question)
            return self._pipe.recv()
        except (EOFError, OSError) as error:
            raise AcadosError(f"acados' process ended (code {self._process.poll()})") from error


def _start(folder: Path, descriptor: int) -> subprocess.Popen[bytes]:
    """The worker, with this interpreter and its CasADi; of acados' package only its interface is on the path."""
    package = folder.resolve() / "acados"
    install, interface = package / "install", package / "acados_template"
    for path in (install / "lib" / "libacados.so", install / "bin" / "t_renderer", interface / "__init__.py"):
        if not path.exists():
            raise AcadosError(f"{path} is missing: make the folder by tools/make_acados.sh {folder}")
    environment = {
        **os.environ,
        "ACADOS_SOURCE_DIR": str(install),
        "ACADOS_PYTHON_INTERFACE_PATH": str(interface),
        "TERA_PATH": str(install / "bin" / "t_renderer"),
        "LD_LIBRARY_PATH": f"{install / 'lib'}:{os.environ.get('LD_LIBRARY_PATH', '')}",
        "PYTHONPATH": os.pathsep.join([*(path for path in sys.path if path), str(package)]),
        "OMP_NUM_THREADS": "1",
    }
    serve = f"from seater_eval.acados.worker import main; main({descriptor})"  # not -m: the answers' class has a home
    command = [sys.executable, "-c", serve]
    return subprocess.Popen(command, env=environment, pass_fds=[descriptor], stdout=subprocess.DEVNULL)
