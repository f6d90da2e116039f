"""White residuals of corners, odometry and prior, and which unknown each depends on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, lil_matrix

from seater_common.geometry import CameraMount, Dock
from seater_tools.drive.drive import Drive
from seater_tools.mount.layout import FIRST_LENS, MARKER, MOUNT, Layout, marker_rotations
from seater_tools.mount.lens import Lens
from seater_tools.mount.path import Path, steps
from seater_tools.mount.prior import Prior

Array = NDArray[np.float64]

# Of the odometry between two images: [m] per sqrt(m) along and across, [rad] per sqrt(m), per sqrt(rad); the smallest.
WAY, SIDE, DRIFT, TURN = 0.002, 0.0005, 0.002, 0.004
LEAST = (1e-4, 5e-5, 1e-4)  # [m], [m], [rad]
GROUPS = ("corners", "way", "side", "turn")  # each with a factor on its standard deviations, which the fit estimates
NEAREST = 0.01  # [m] in front of the lens: a start that is far off must not divide by zero


@dataclass(frozen=True, eq=False)
class Problem:
    """`factors`: (4,) on the standard deviations of GROUPS."""

    drive: Drive
    lens: Lens
    dock: Dock
    layout: Layout
    path: Path
    prior: Prior
    marker: NDArray[np.intp]  # (n,) row in layout.ids of each marker seen
    whiten: Array  # (n, 8, 8)
    factors: Array

    def corners(self, state: Array) -> Array:
        """(n, 4, 2) [px] where the corners should be."""
        layout, rows = self.layout, self.layout.markers(state)
        files = {marker.id: marker.corners() for marker in self.dock.markers}
        squares = np.array([files[id] for id in layout.ids]) * np.exp(rows[:, 6])[:, None, None]
        in_dock = np.einsum("mij,mcj->mci", marker_rotations(rows), squares) + rows[:, None, :3]
        poses = layout.poses(state)[self.drive.image]
        d = in_dock[self.marker]
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        x, y = d[..., 0] - poses[:, 0, None], d[..., 1] - poses[:, 1, None]
        in_base = np.stack([c * x + s * y, -s * x + c * y, d[..., 2]], axis=-1)
        T = CameraMount(*layout.mount(state)).T_base_optical()
        points = (in_base - T[:3, 3]) @ T[:3, :3]
        points[..., 2] = np.maximum(points[..., 2], NEAREST)
        camera = self.lens.at(layout.lens_off(state))
        return camera.project(points.reshape(-1, 3)).reshape(-1, 4, 2)

    def corner_residuals(self, state: Array) -> Array:
        """(n, 8), white."""
        off = (self.drive.corners - self.corners(state)).reshape(-1, 8)
        return np.einsum("nij,nj->ni", self.whiten, off) / self.factors[0]

    def odometry_residuals(self, state: Array) -> Array:
        """(3, images - 1): along, across, turn; white."""
        measured = steps(self.path.poses(self.layout.odometry(state)))
        off = steps(self.layout.poses(state)) - measured
        way, turn = self.path.effort.T
        sd = [WAY * np.sqrt(way), SIDE * np.sqrt(way), np.sqrt(DRIFT**2 * way + TURN**2 * turn)]
        return np.asarray(off.T / (np.hypot(sd, np.array(LEAST)[:, None]) * self.factors[1:, None]))

    def residuals(self, state: Array) -> Array:
        """All, in the order of GROUPS, the prior last."""
        corners, odometry = self.corner_residuals(state), self.odometry_residuals(state)
        return np.concatenate([corners.ravel(), odometry.ravel(), self.prior.residuals(state)])

    def groups(self) -> list[slice]:
        """Rows of each of GROUPS."""
        corners, between = 8 * len(self.drive.ids), self.layout.images - 1
        return [slice(0, corners), *(slice(corners + i * between, corners + (i + 1) * between) for i in range(3))]

    def sparsity(self) -> csr_matrix:
        """(residuals, unknowns), 1 where the one depends on the other."""
        layout, drive = self.layout, self.drive
        rows = 8 * len(drive.ids) + 3 * (layout.images - 1)
        S = lil_matrix((rows + self.prior.count, layout.size), dtype=np.int8)
        for n, (image, marker) in enumerate(zip(drive.image, self.marker, strict=True)):
            mine = slice(8 * n, 8 * n + 8)
            S[mine, : len(MOUNT)] = 1
            S[mine, FIRST_LENS : layout.first_marker] = 1
            first = layout.first_marker + len(MARKER) * marker
            S[mine, first : first + len(MARKER)] = 1
            S[mine, layout.first_pose + 3 * image : layout.first_pose + 3 * image + 3] = 1
        for group in self.groups()[1:]:
            S[group, len(MOUNT) : FIRST_LENS] = 1
            for k in range(layout.images - 1):
                S[group.start + k, layout.first_pose + 3 * k : layout.first_pose + 3 * k + 6] = 1
        S[rows:, : layout.first_pose] = 1
        return csr_matrix(S)


def without(problem: Problem, sightings: NDArray[np.bool_]) -> Problem:
    """These sightings of markers (n,) left out."""
    kept = ~sightings
    drive = problem.drive.without(sightings)
    return replace(problem, drive=drive, marker=problem.marker[kept], whiten=problem.whiten[kept])


def whitening(covariance: Array) -> Array:
    """(n, 8, 8) W with W C W^T = 1 of (n, 8, 8)."""
    return np.linalg.inv(np.linalg.cholesky(covariance))
