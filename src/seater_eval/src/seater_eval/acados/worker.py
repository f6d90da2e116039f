"""The process in which acados runs: takes instances of the problem over a pipe, steps, and answers with times."""

from __future__ import annotations

import pickle
import tempfile
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_eval.acados.ocp import make_solver
from seater_eval.acados.stage import docking_stage
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What one step of acados gives back."""

    states: Array  # (N + 1, 5)
    inputs: Array  # (N + 1, 7)
    status: int  # acados' own; 0: fine
    iterations: int  # of the quadratic programme
    wall: float  # [s] setting the instance, solving, reading the plan
    cpu: float  # [s] the same on the processor, in this thread


class Worker:
    """acados' solver for one chair, dock and set of parameters."""

    def __init__(self, chair: Chair, dock: Dock, parameters: ControlParameters, folder: Path) -> None:
        self._stage, self._horizon = docking_stage(chair, dock, parameters), parameters.horizon
        self._solver = make_solver(self._stage, parameters, folder)
        self._lines = np.arange(self._stage.lines.start, self._stage.lines.stop, dtype=np.int64)

    def begin(self, states: Array, inputs: Array) -> None:
        """The plan that the next step linearises at."""
        self._solver.reset()
        for k, values in enumerate(inputs):
            self._solver.set(k, "x", states[k])
            self._solver.set(k, "u", values)
        self._solver.set(self._horizon + 1, "x", states[-1])

    def step(self, state: Array, lines: Array) -> Answer:
        """One real-time iteration from the last plan, for the initial state (5,) and the lines (N, slots * 7)."""
        solver, N, where = self._solver, self._horizon, self._lines
        wall, cpu = time.perf_counter(), time.thread_time()
        if where.size:
            for k in range(N):
                solver.set_params_sparse(k + 1, where, lines[k])
        solver.constraints_set(0, "lbx", state)
        solver.constraints_set(0, "ubx", state)
        status = solver.solve()
        states = np.array([solver.get(k, "x") for k in range(N + 1)])
        cpu, wall = time.thread_time() - cpu, time.perf_counter() - wall
        inputs = np.array([solver.get(k, "u") for k in range(N + 1)])
        iterations = int(np.ravel(solver.get_stats("qp_iter"))[-1])
        return Answer(states=states, inputs=inputs, status=status, iterations=iterations, wall=wall, cpu=cpu)


def main(descriptor: int) -> None:
    """Serve the pipe with this file descriptor until the other side closes it."""
    with Connection(descriptor) as pipe, tempfile.TemporaryDirectory() as folder:
        try:
            chair, dock, parameters = pipe.recv()
            worker = Worker(chair, dock, parameters, Path(folder))
        except Exception as error:  # told to whoever waits, in whose process it is raised
            pipe.send(f"{type(error).__name__}: {error}")
            return
        pipe.send("")
        while True:
            try:
                name, arguments = pipe.recv()
            except (EOFError, pickle.UnpicklingError):
                return
            answer: Any = getattr(worker, name)(*arguments)
            pipe.send(answer)
