"""How far camera mount and focal length are off, by what the images make of the way that the odometry measures.

An extended Kalman filter: the seven states of drift.py, and dx, dy [m], dyaw [rad] by which the mount is off, and k, by
which distances along the camera's axis are measured too long (a focal length that is too long by k, or prints that are
smaller). With c the camera and M the middle of the markers, q = D - c and r = M - c seen from base_link, a the camera's
axis and t the angle between it and the normal of the markers, an image shows the dock D off by

    position  -(dx, dy) + dyaw (q_y, -q_x) + k (a r) a + turn (D - M)_across,
    heading   -dyaw + turn,   turn = k sin t cos t.

Turning the chair shows dx and dy, driving shows dyaw, driving with a known scale of the odometry shows k. How much the
tyres slip is not known, so several filters run; see `error` for which one answers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Dock
from seater_common.se2 import relative, transform_points, wrap_angle
from seater_nmpc.observe.drift import SIZE, Drift, transitions
from seater_nmpc.observe.measurement import Measurement, difference
from seater_nmpc.observe.odometry import Instant
from seater_nmpc.parameters import ObserverParameters
from seater_nmpc.plausibility.installation.castors import Castors
from seater_nmpc.plausibility.installation.knowledge import (
    PLACES,
    PRIOR,
    SERIES,
    SLIPS,
    InstallationError,
    Knowledge,
    nothing_known,
)

Array = NDArray[np.float64]

# Standard deviations of constant errors of the odometry (scale, turning scale, turn per metre), whatever is configured:
# what is not told of it must not look like a wrong installation.
_CONSTANT = (0.04, 0.04, 0.04)
_STEP = (0.015, 0.015)  # [m, rad] driven or turned from one image that is used to the next
# [m] as if a wheel stood so far from the middle of the axle, about twice what it does: a slippery place lasts for much
# of a turn, and slip from one image to the next is taken as independent. Beside it, [m/sqrt(rad)], a place that is
# found slippery by none of the levels of slip: the camera's y by 48 checks was off by 6 mm, and told to 5.4 mm with it.
_HALF_TRACK, _ONE_WHEEL = 0.6, 0.006
_DRIFTS = 0.015  # [rad/s] of a gyro's bias, beyond which values of millimetres are not to be had from its heading
_FIRST = 0.1  # [m, rad] that the first image may be off the observer's dock
# [m, rad] by which the observer's dock is another one from one image to the next: the mirror image of one marker, which
# is metres away beside it. No wrong installation moves it by so much at once.
_ANOTHER = (0.3, 0.3)
# [m, rad] from one image that is used to the next, beyond which the dock is followed anew. After 22 s without an image a
# wrong one, 55 mm off, was within what the wheels may have slipped, and all right ones after it beyond the gate.
_BLIND = (0.5, 1.0)
_LASTS = 5  # images that have it there: for one or two, turned to the edge of the view, it was the mirror image once
# What no length of driving makes surer: floors and castors are not quite what drift.py says. In two attempts on patchy
# floor 22 mm were seen where nothing was wrong, at 6.7 standard deviations without this.
_MODEL = np.array([0.004, 0.004, 0.0005, 0.001])
# In log likelihood, summed over a docking. Floors are dry here and wet there, so no one level of slip explains all:
# 16 in favour of little slip were seen where that found 41 mm (5.8 standard deviations) and more slip 28 mm (2.5).
_AS_WELL = 30.0
_GATE = 16.3  # chi-square, 99.9 %
_LOG_OUTLIER = math.log(0.03)
_ALL = SIZE + 4
_CHANGED = 40.0  # chi-square with 4 degrees of freedom; floors are not quite what drift.py says, so not 18.5 (99.9 %)
_FEWEST = 20  # images that a docking has to have used to be remembered
# Standard deviations by which an installation may change from one docking to the next: so dockings long ago fade.
_FADES = np.array([0.001, 0.001, 0.0005, 0.002])
# What is wrong shows by the filter of the next larger slip, too, with 0.41 of the certainty at least (six made-up
# installations); a worn chair on one-sided patches, which stood right, with 0.35 of 5.1 (commissioning, seed 1027).
_STAYS = 0.38
# [rad] Where a docking has turned by less, places of the camera show in its wriggles alone, as does what the floor does
# aside: 60 mm were seen on a straight way from 3.9 m (5.4 standard deviations, 0.4 of it with more slip). What is wrong
# with yaw or focal length shows straight ahead.
_STRAIGHT, _STAYS_STRAIGHT = 0.3, 0.6
_DOCKED = np.zeros(3)  # the dock in base_link, of a docked chair


class Installation:
    """Of one goal after another: `restart`, `add` what each image shows, ask for the `error`, `learn`."""

    def __init__(self, mount: CameraMount, dock: Dock, parameters: ObserverParameters) -> None:
        self._camera = np.array([mount.x, mount.y, mount.yaw])
        self._middle = dock.front[:2]
        self._normal = float(np.mean([marker.normal_yaw for marker in dock.markers]))
        self._constant = np.diag(np.square([*_CONSTANT, parameters.gyro_bias_sd]))
        self._slip_turn_noise = parameters.slip_turn_noise
        self._drifts = [Drift(parameters, slip, both=True) for slip in SLIPS]
        self.known = nothing_known()
        self.begun = 0  # how often it has begun anew
        self.restart()

    def restart(self) -> None:
        """Begin anew, with what is known of dockings before."""
        self.begun += 1
        self._used = 0
        self._headings = (0.0, 0.0)  # [rad] least and most, from the first image on
        self._evidence = np.zeros(len(SLIPS))
        self._follow_anew(self.known.values, self.known.covariances)

    def interrupt(self) -> None:
        """The chair may have been moved anyhow: keep what was found, and follow the dock anew."""
        if self._last is not None:
            found = [self._found(i) for i in range(len(SLIPS))]
            self._follow_anew(np.stack([values for values, _ in found]), np.stack([P for _, P in found]))

    def _follow_anew(self, values: Array, covariances: Array) -> None:
        """With these (k, 4) and (k, 4, 4) of NAMES, from the next image on."""
        self._from = values, covariances
        self._elsewhere = 0  # images in a row that the observer's dock is another one
        self._last: Instant | None = None
        self._dock: Array | None = None  # where the observer has had it at the last image
        self._turned_to = 0.0  # [rad] now
        self._mean: list[Array] = []
        self._covariance: list[Array] = []
        self._castors = Castors()

    def add(self, chair: Instant, offered: list[Measurement], known: Array) -> None:
        """The poses of the dock in odom that an image leaves open; `known` (3,): where the observer has it. Late images
        and those of a chair that stands are left out. Where that is another place and stays so, all begins anew; after a
        blind way the dock is followed anew, from an image that shows it where the observer has it."""
        if self._last is not None and _is_blind(self._last, chair):
            self.interrupt()
        if self._dock is not None and _is_another(known, self._dock):
            self._elsewhere += 1
            if self._elsewhere < _LASTS:
                return
            self.restart()
        self._dock, self._elsewhere = np.array(known), 0
        if self._last is None:
            near = [one for one in offered if float(np.abs(difference(one.pose, known)).max()) <= _FIRST]
            if near:
                self._begin(chair, near[0])
            return
        driven, turned = chair.driven - self._last.driven, chair.turned - self._last.turned
        if chair.stamp <= self._last.stamp or (driven < _STEP[0] and turned < _STEP[1]):
            return
        self._used += 1
        turned_to = self._turned_to + wrap_angle(float(chair.pose[2] - self._last.pose[2]))
        self._turned_to, (least, most) = turned_to, self._headings
        self._headings = min(least, turned_to), max(most, turned_to)
        castors = self._castors.noise(self._last, chair, known)
        docks = np.array([mean[:3] for mean in self._mean])
        for i, (moved, noise) in enumerate(zip(*transitions(self._drifts, docks, self._last, chair), strict=True)):
            F, Q = np.eye(_ALL), np.zeros((_ALL, _ALL))
            F[:SIZE, :SIZE], Q[:SIZE, :SIZE] = moved, noise
            Q[:3, :3] += castors
            Q[:2, :2] += self._by_one_wheel(self._drifts[i].slip, chair)
            mean = F @ self._mean[i]
            # The step is along the tangent of the dock's circle round the chair; steps of a gyro's bias add up.
            lengthened = math.hypot(1.0, float(mean[2] - self._mean[i][2]))
            mean[:2] = chair.pose[:2] + (mean[:2] - chair.pose[:2]) / lengthened
            self._update(i, chair, offered, mean, F @ self._covariance[i] @ F.T + Q)
        self._last = chair

    def _by_one_wheel(self, slip: float, chair: Instant) -> Array:
        """Covariance (2, 2) of the way that one wheel's slip takes as the chair turns on the spot, of which drift.py
        knows none."""
        assert self._last is not None  # every caller has looked
        along = np.array([math.cos(chair.pose[2]), math.sin(chair.pose[2])])
        variance = (_HALF_TRACK * slip * self._slip_turn_noise) ** 2 + _ONE_WHEEL**2
        on_the_spot = chair.turned - self._last.turned - (chair.driven - self._last.driven) / _HALF_TRACK
        variance *= max(0.0, on_the_spot)
        return np.asarray(variance * np.outer(along, along))

    def learn(self, limits: Array, certainty: float, *, turned: bool = False) -> None:
        """Remember what this docking has shown, for the next ones, unless it is certain by itself: it may have been a
        fault of this docking alone. Where it contradicts those before it, the installation has changed, and only this
        one counts. Limits and certainty: as of `InstallationError.is_wrong`. `turned`: it has turned at two places to
        see; what such a docking has shown no other one wears away."""
        if self._used < _FEWEST or self.error() is None:
            return
        found, dockings = [self._alone(i) for i in range(len(SLIPS))], 1
        if self._mildest(found, 0).is_wrong(limits, certainty):
            return
        if not self._has_changed():
            if self.known.turned and not turned:
                self.known = replace(self.known, covariances=self.known.covariances + np.diag(_FADES**2))
                return
            found, dockings = [self._found(i) for i in range(len(SLIPS))], self.known.dockings + 1
        values: Array = np.stack([one for one, _ in found])
        self.known = Knowledge(dockings, values, np.stack([P for _, P in found]) + np.diag(_FADES**2), turned)

    def error(self, dock: Array = _DOCKED) -> InstallationError | None:
        """By the filter that accuses least, of those that explain the images about as well as the likeliest one; None
        before there is one, and where the odometry's heading drifts with time. Effects: on a dock (3,) that is there in
        base_link."""
        if self._best is None:
            return None
        return self._mildest([self._found(i) for i in range(len(SLIPS))], self.known.dockings, dock)

    def likeliest(self, dock: Array = _DOCKED) -> InstallationError | None:
        """By the filter that explains the images best: before a goal has driven far, all explain them, and the mildest
        is one that believes nothing. None, and effects: as of `error`."""
        best = self._best
        return None if best is None else self._error_by(*self._found(best), self.known.dockings, dock)

    @property
    def has_seen_enough(self) -> bool:
        """Whether enough images were used to conclude from them."""
        return self._used >= _FEWEST

    @property
    def _best(self) -> int | None:
        """The filter that explains the images best; None: as of `error`."""
        best = int(np.argmax(self._evidence))
        return None if self._last is None or abs(self._mean[best][SIZE - 1]) > _DRIFTS else best

    @property
    def unknown(self) -> Array:
        """(3, 3) covariance of where the docked chair stands, where this docking has said nothing."""
        B = self._effect(np.zeros(3))
        return np.asarray(B @ self.known.covariances[0] @ B.T)

    def _found(self, i: int) -> tuple[Array, Array]:
        """Values and covariance by filter i, with what is known."""
        return self._mean[i][SIZE:], self._covariance[i][SIZE:, SIZE:]

    def _alone(self, i: int) -> tuple[Array, Array]:
        """The same by this docking alone: the information of those before it taken away again."""
        (values, P), known = self._found(i), self.known
        after, before = np.linalg.inv(P), np.linalg.inv(known.covariances[i])
        covariance = np.linalg.inv(np.diag(PRIOR**-2) + after - before)
        return covariance @ (after @ values - before @ known.values[i]), 0.5 * (covariance + covariance.T)

    def _has_changed(self) -> bool:
        """Whether this docking and those before it are farther apart than chance has it, by the likeliest filter."""
        i = int(np.argmax(self._evidence))
        (values, P), known = self._alone(i), self.known
        shift = values - known.values[i]
        return float(shift @ np.linalg.solve(known.covariances[i] + P + np.diag(_MODEL**2), shift)) > _CHANGED

    def _mildest(self, found: Sequence[tuple[Array, Array]], dockings: int, dock: Array = _DOCKED) -> InstallationError:
        """`found`: values and covariance by each filter."""
        plausible = np.flatnonzero(self._evidence >= self._evidence.max() - _AS_WELL)
        errors = [self._error_by(*one, dockings, dock) for one in found]
        best = min(map(int, plausible), key=lambda i: errors[i].certainty)
        slipping = errors[min(best + 1, len(errors) - 1)]
        straight = self._headings[1] - self._headings[0] < _STRAIGHT and errors[best].suspect in PLACES
        stays = (_STAYS_STRAIGHT if straight else _STAYS) * errors[best].certainty
        vanishes = slipping.certainty < stays  # with more slip: then it may be slip
        return slipping if vanishes and dockings + 1 < SERIES else errors[best]

    def _error_by(self, values: Array, P: Array, dockings: int, dock: Array = _DOCKED) -> InstallationError:
        model, B = np.diag(np.square(_MODEL)), self._effect(dock)
        noise = P - P @ np.diag(PRIOR**-2) @ P + model
        return InstallationError(values, noise, B * values, B @ (P + model) @ B.T, dockings)

    def _begin(self, chair: Instant, first: Measurement) -> None:
        for drift, values, known in zip(self._drifts, *self._from, strict=True):
            errors, spread = drift.initial_errors()
            covariance = np.zeros((_ALL, _ALL))
            covariance[3:SIZE, 3:SIZE] = spread + self._constant
            covariance[SIZE:, SIZE:] = known
            # The first image shows the dock with the installation's errors: it is certain together with them only.
            H = self._jacobian(chair, first.pose)[:, SIZE:]
            covariance[:3, :3] = first.covariance + H @ known @ H.T
            covariance[:3, SIZE:] = -H @ known
            covariance[SIZE:, :3] = covariance[:3, SIZE:].T
            self._mean.append(np.concatenate([first.pose - H @ values, errors, values]))
            self._covariance.append(covariance)
        self._last = chair

    def _update(self, i: int, chair: Instant, offered: list[Measurement], mean: Array, P: Array) -> None:
        H = self._jacobian(chair, mean[:3])
        expected = mean[:3] + H[:, SIZE:] @ mean[SIZE:]
        scored = []
        for measurement in offered:
            S = H @ P @ H.T + measurement.covariance
            value = difference(measurement.pose, expected)
            scored.append((float(value @ np.linalg.solve(S, value)), measurement, value, S))
        nis, best, value, S = min(scored, key=lambda entry: entry[0])
        likelihood = -0.5 * (nis + float(np.linalg.slogdet(S)[1]) + 3.0 * math.log(2.0 * math.pi))
        self._evidence[i] += max(likelihood, _LOG_OUTLIER)
        if nis <= _GATE:
            gain = np.linalg.solve(S, H @ P).T
            mean = mean + gain @ value
            keep = np.eye(_ALL) - gain @ H
            P = keep @ P @ keep.T + gain @ best.covariance @ gain.T
        mean[2] = wrap_angle(float(mean[2]))
        self._mean[i], self._covariance[i] = mean, P

    def _jacobian(self, chair: Instant, dock: Array) -> Array:
        """(3, 11) of what an image shows in odom."""
        heading = float(chair.pose[2])
        R = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
        B = self._effect(relative(chair.pose, dock))
        H = np.zeros((3, _ALL))
        H[:, :3] = np.eye(3)
        H[:2, SIZE:], H[2, SIZE:] = R @ B[:2], B[2]
        return H

    def _effect(self, dock: Array) -> Array:
        """(3, 4): of (dx, dy, dyaw, k) on a dock at `dock` (3,) in base_link."""
        middle = transform_points(dock, self._middle[None, :])[0]
        q, r = dock[:2] - self._camera[:2], middle - self._camera[:2]
        yaw = float(self._camera[2])
        a = np.array([math.cos(yaw), math.sin(yaw)])
        t = math.remainder(float(dock[2]) + self._normal + math.pi - yaw, 2.0 * math.pi)
        turn = math.sin(t) * math.cos(t)
        arm = dock[:2] - middle
        B = np.zeros((3, 4))
        B[0, 0] = B[1, 1] = -1.0
        B[:2, 2], B[2, 2] = (q[1], -q[0]), -1.0
        B[:2, 3], B[2, 3] = float(a @ r) * a + turn * np.array([-arm[1], arm[0]]), turn
        return B


def _is_blind(last: Instant, chair: Instant) -> bool:
    """Whether the way between two images that are used is one."""
    return chair.driven - last.driven > _BLIND[0] or chair.turned - last.turned > _BLIND[1]


def _is_another(dock: Array, before: Array) -> bool:
    x, y, turn = difference(dock, before)
    return math.hypot(x, y) > _ANOTHER[0] or abs(turn) > _ANOTHER[1]
