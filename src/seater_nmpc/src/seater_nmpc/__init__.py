"""Docking by nonlinear model predictive control: model, optimal control problem, solver, observer, sequence. No ROS."""

import os

# One thread: threads of BLAS only disturb solves of this size. Read when the libraries are loaded, hence before CasADi.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
