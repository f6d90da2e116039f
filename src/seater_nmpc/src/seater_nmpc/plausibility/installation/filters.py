"""Extended Kalman filters of the installation, one for each of SLIPS: how much the tyres slip is not known.

The state (11,) is that of drift.py, seven, and what mount and focal length are off by (effect.py), four. Turning the
chair shows dx and dy, driving shows dyaw, driving with a known scale of the odometry shows k.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_nmpc.observe.measurement import Measurement, difference
from seater_nmpc.observe.odometry.drift import SIZE as DRIFT
from seater_nmpc.observe.odometry.drift import Drift, transitions
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters
from seater_nmpc.plausibility.installation.castors import Castors
from seater_nmpc.plausibility.installation.effect import ALL, Effect
from seater_nmpc.plausibility.installation.knowledge import SLIPS

Array = NDArray[np.float64]
Found = tuple[Array, Array]  # values (4,) of NAMES and their covariance (4, 4)

# Standard deviations of constant errors of the odometry (scale, turning scale, turn per metre), whatever is configured:
# what is not told of it must not look like a wrong installation.
_CONSTANT = (0.04, 0.04, 0.04)
# [m] as if a wheel stood so far from the middle of the axle, about twice what it does: a slippery place lasts for much
# of a turn, and slip from one image to the next is taken as independent. Beside it, [m/sqrt(rad)], a place that is
# found slippery by none of the levels of slip: the camera's y by 48 checks was off by 6 mm, and told to 5.4 mm with it.
_HALF_TRACK, _ONE_WHEEL = 0.6, 0.006
_DRIFTS = 0.015  # [rad/s] of a gyro's bias, beyond which values of millimetres are not to be had from its heading
_GATE = 16.3  # chi-square, 99.9 %
_LOG_OUTLIER = math.log(0.03)
# Of so many images from the first one on, so many that contradict it by the filter of the least slip: then it was wrong
# (the mirror image of the first marker that came into view). Between so few no wheel can have slipped by as much.
_SETTLES, _CONTRADICT = 4, 2


def stacked(found: list[Found]) -> tuple[Array, Array]:
    """Values (k, 4) and covariances (k, 4, 4) by k filters."""
    return np.stack([values for values, _ in found]), np.stack([P for _, P in found])


class SlipFilters:
    """`restart` them, `begin` at an image, `add` those that follow; then ask what each has `found`."""

    def __init__(self, effect: Effect, parameters: ObserverParameters) -> None:
        self._effect = effect
        self._constant = np.diag(np.square([*_CONSTANT, parameters.gyro_bias_sd]))
        self._slip_turn_noise = parameters.slip_turn_noise
        self._drifts = [Drift(parameters, slip, both=True) for slip in SLIPS]

    def restart(self, values: Array, covariances: Array) -> None:
        """At the next image, each with its values (k, 4) of NAMES and covariances (k, 4, 4); none is favoured."""
        self.evidence = np.zeros(len(SLIPS))  # log likelihood of the images so far, by each
        self._follow_anew(values, covariances)

    def interrupt(self) -> None:
        """Keep what was found, and the evidence; where the dock is in odom comes from the next image."""
        self._follow_anew(*stacked(self.found))

    def _follow_anew(self, values: Array, covariances: Array) -> None:
        self._from = values, covariances
        self._evidence_before = self.evidence.copy()
        self._followed = self._contradicted = 0  # images since the first one, and of those, how many did not fit it
        self.last: Instant | None = None  # the chair at the last image that was used; None: not begun
        self._mean: list[Array] = []
        self._covariance: list[Array] = []
        self._castors = Castors()

    @property
    def found(self) -> list[Found]:
        """By each filter, with what it was restarted with."""
        pairs = zip(self._mean, self._covariance, strict=True)
        return [(mean[DRIFT:], covariance[DRIFT:, DRIFT:]) for mean, covariance in pairs]

    @property
    def best(self) -> int | None:
        """The filter that explains the images best; None before they have begun, and where the odometry's heading
        drifts with time."""
        best = int(np.argmax(self.evidence))
        return None if self.last is None or abs(self._mean[best][DRIFT - 1]) > _DRIFTS else best

    def begin(self, chair: Instant, first: Measurement) -> None:
        """`first`: the dock in odom as the image shows it."""
        for drift, values, known in zip(self._drifts, *self._from, strict=True):
            errors, spread = drift.initial_errors()
            covariance = np.zeros((ALL, ALL))
            covariance[3:DRIFT, 3:DRIFT] = spread + self._constant
            covariance[DRIFT:, DRIFT:] = known
            # The first image shows the dock with the installation's errors: it is certain together with them only.
            H = self._effect.jacobian(chair, first.pose)[:, DRIFT:]
            covariance[:3, :3] = first.covariance + H @ known @ H.T
            covariance[:3, DRIFT:] = -H @ known
            covariance[DRIFT:, :3] = covariance[:3, DRIFT:].T
            self._mean.append(np.concatenate([first.pose - H @ values, errors, values]))
            self._covariance.append(covariance)
        self.last = chair

    def add(self, chair: Instant, offered: list[Measurement], dock: Array) -> None:
        """The poses of the dock in odom that an image leaves open; `dock` (3,): where the observer has it."""
        last = self.last
        assert last is not None  # begun
        castors = self._castors.noise(last, chair, dock)
        docks = np.array([mean[:3] for mean in self._mean])
        for i, (moved, noise) in enumerate(zip(*transitions(self._drifts, docks, last, chair), strict=True)):
            F, Q = np.eye(ALL), np.zeros((ALL, ALL))
            F[:DRIFT, :DRIFT], Q[:DRIFT, :DRIFT] = moved, noise
            Q[:3, :3] += castors
            Q[:2, :2] += self._by_one_wheel(self._drifts[i].slip, last, chair)
            mean = F @ self._mean[i]
            # The step is along the tangent of the dock's circle round the chair; steps of a gyro's bias add up.
            lengthened = math.hypot(1.0, float(mean[2] - self._mean[i][2]))
            mean[:2] = chair.pose[:2] + (mean[:2] - chair.pose[:2]) / lengthened
            self._update(i, chair, offered, mean, F @ self._covariance[i] @ F.T + Q)
        self.last = chair
        self._followed += 1
        if self._followed <= _SETTLES and self._contradicted >= _CONTRADICT:  # from before that image
            self.evidence = self._evidence_before
            self._follow_anew(*self._from)

    def _by_one_wheel(self, slip: float, last: Instant, chair: Instant) -> Array:
        """Covariance (2, 2) of the way that one wheel's slip takes as the chair turns on the spot, of which drift.py
        knows none."""
        along = np.array([math.cos(chair.pose[2]), math.sin(chair.pose[2])])
        variance = (_HALF_TRACK * slip * self._slip_turn_noise) ** 2 + _ONE_WHEEL**2
        on_the_spot = chair.turned - last.turned - (chair.driven - last.driven) / _HALF_TRACK
        variance *= max(0.0, on_the_spot)
        return np.asarray(variance * np.outer(along, along))

    def _update(self, i: int, chair: Instant, offered: list[Measurement], mean: Array, P: Array) -> None:
        """Of filter i, from `mean` (11,) and P (11, 11), by the poses that are no outliers. Where two fit, they count
        as one, each as far as it is likely, that is as uncertain as they are apart: of those that fit best, several in
        a row were the mirror image, and drew the filter away from what is right."""
        H = self._effect.jacobian(chair, mean[:3])
        expected = mean[:3] + H[:, DRIFT:] @ mean[DRIFT:]
        likelihoods, values, fits = [], [], []
        for measurement in offered:
            S = H @ P @ H.T + measurement.covariance
            value = difference(measurement.pose, expected)
            nis = float(value @ np.linalg.solve(S, value))
            likelihoods.append(-0.5 * (nis + float(np.linalg.slogdet(S)[1]) + 3.0 * math.log(2.0 * math.pi)))
            values.append(value)
            fits.append(nis <= _GATE)
        self.evidence[i] += max(*likelihoods, _LOG_OUTLIER)
        self._contradicted += i == 0 and not any(fits)
        if any(fits):
            likely = np.where(fits, likelihoods, -np.inf)
            shares = np.exp(likely - likely.max())
            shares /= shares.sum()
            value = shares @ np.array(values)
            apart = np.array(values) - value
            R = np.einsum("k,kij->ij", shares, [one.covariance for one in offered]) + (shares * apart.T) @ apart
            gain = np.linalg.solve(H @ P @ H.T + R, H @ P).T
            mean = mean + gain @ value
            keep = np.eye(ALL) - gain @ H
            P = keep @ P @ keep.T + gain @ R @ gain.T
        mean[2] = wrap_angle(float(mean[2]))
        self._mean[i], self._covariance[i] = mean, P
