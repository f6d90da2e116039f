"""The bundle adjustment: robust least squares, with the noise of each kind of measurement estimated on the way.

Factors of the noise are estimated by Foerstner's method: s^2 = v^T v / r for each group, where r is its redundancy, the
number of its residuals less the trace of their part in the hat matrix. Standard deviations are those of the inverse of
J^T J, of the residuals as weighted at the end.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock
from seater_tools.adjust.jacobian import Jacobian
from seater_tools.adjust.noise import noise_factors
from seater_tools.adjust.robust import Minimum, minimise
from seater_tools.drive.drive import Drive
from seater_tools.mount.begin import first_poses, known_part, spread_images
from seater_tools.mount.layout import Layout
from seater_tools.mount.lens import Lens
from seater_tools.mount.path import Path
from seater_tools.mount.prior import Lengths, Prior
from seater_tools.mount.problem import Problem, whitening, without

Array = NDArray[np.float64]

MOST_IMAGES = 900  # that are used
OUTLIER = 5.0  # times the median misfit of all sightings
ROUNDS = 2  # of estimating noise
LOW, HIGH = np.array([1.0, 0.1, 1.0, 0.1]), np.array([30.0, 30.0, 1.0, 30.0])


@dataclass(frozen=True, eq=False)
class Solution:
    """`start`: the files' values in the same order as `state`. `covariance`: of all but the poses."""

    problem: Problem
    start: Array
    state: Array
    covariance: Array


def solve(
    drive: Drive, camera: CameraModel, mount: CameraMount, dock: Dock, lengths: Lengths, most_images: int = MOST_IMAGES
) -> Solution:
    """`mount`, `dock`: what the files say. The lens is found, too, as far as the camera's covariance allows.

    Raises:
        DriveError: the drive shows too little.
        NoMinimumError: nothing like the files explains the drive.
    """
    used = spread_images(known_part(drive, dock), most_images)
    ids = tuple(marker.id for marker in dock.markers if marker.id in used.ids)
    lens = Lens.of(camera)
    layout = Layout(ids, len(used.stamps), lens.count)
    start = layout.start(mount, dock, first_poses(used, camera, mount, dock))
    row = {id: i for i, id in enumerate(ids)}
    problem = Problem(
        drive=used,
        lens=lens,
        dock=dock,
        layout=layout,
        path=Path(used),
        prior=Prior(layout, dock, lengths, start),
        marker=np.array([row[int(id)] for id in used.ids]),
        whiten=whitening(used.covariance),
        factors=np.array([10.0, 1.0, 1.0, 1.0]),  # wide at first: the places in the file are centimetres off
    )
    first = minimise(problem.residuals, Jacobian(problem.sparsity()), start, layout.first_pose)
    problem = without(problem, _outliers(problem, first.state))
    jacobian = Jacobian(problem.sparsity())
    minimum = minimise(problem.residuals, jacobian, first.state, layout.first_pose)
    for _ in range(ROUNDS):
        problem = dataclasses.replace(problem, factors=_factors(problem, minimum))
        minimum = minimise(problem.residuals, jacobian, minimum.state, layout.first_pose)
    return Solution(problem, start, minimum.state, minimum.covariance)


def _outliers(problem: Problem, state: Array) -> NDArray[np.bool_]:
    """(n,) sightings whose corners are not where the others say: a reflection, a hidden corner."""
    misfit = np.sqrt(np.mean(problem.corner_residuals(state) ** 2, axis=1))
    return np.asarray(misfit > OUTLIER * np.median(misfit))


def _factors(problem: Problem, minimum: Minimum) -> Array:
    """(4,) new factors of the groups."""
    white = problem.residuals(minimum.state)
    low, high = LOW / problem.factors, HIGH / problem.factors
    return problem.factors * noise_factors(minimum.jacobian, white, minimum.weights, problem.groups(), low, high)
