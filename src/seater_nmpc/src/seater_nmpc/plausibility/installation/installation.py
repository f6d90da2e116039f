"""How far camera mount and focal length are off, by what the images make of the way that the odometry measures.

What they do to an image is in effect.py, how it is measured in filters.py. How much the tyres slip is not known, so
several filters run; see `error` for which one answers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Dock
from seater_common.se2 import wrap_angle
from seater_nmpc.observe.measurement import Measurement, difference
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import ObserverParameters
from seater_nmpc.plausibility.installation.effect import Effect
from seater_nmpc.plausibility.installation.filters import Found, SlipFilters, stacked
from seater_nmpc.plausibility.installation.knowledge import (
    PLACES,
    PRIOR,
    SERIES,
    InstallationError,
    Knowledge,
    nothing_known,
)
from seater_nmpc.plausibility.installation.steadiness import Steadiness

Array = NDArray[np.float64]

_STEP = (0.015, 0.015)  # [m, rad] driven or turned from one image that is used to the next
_FIRST = 0.1  # [m, rad] that the first image may be off the observer's dock
# [m, rad] by which the observer's dock is another one from one image to the next: the mirror image of one marker, which
# is metres away beside it. No wrong installation moves it by so much at once.
_ANOTHER = (0.3, 0.3)
# [m, rad] from one image that is used to the next, beyond which the dock is followed anew. After 22 s without an image
# a wrong one, 55 mm off, was within what the wheels may have slipped, and all right ones after it beyond the gate.
_BLIND = (0.5, 1.0)
_LASTS = 5  # images that have it there: for one or two, turned to the edge of the view, it was the mirror image once
# What no length of driving makes surer: floors and castors are not quite what drift.py says. In two attempts on patchy
# floor 22 mm were seen where nothing was wrong, at 6.7 standard deviations without this.
_MODEL = np.array([0.004, 0.004, 0.0005, 0.001])
# In log likelihood, summed over a docking. Floors are dry here and wet there, so no one level of slip explains all:
# 16 in favour of little slip were seen where that found 41 mm (5.8 standard deviations) and more slip 28 mm (2.5).
_AS_WELL = 30.0
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
        self._effect = Effect(mount, dock)
        self._filters = SlipFilters(self._effect, parameters)
        self.known = nothing_known()
        self.begun = 0  # how often it has begun anew
        self.restart()

    def restart(self) -> None:
        """Begin anew, with what is known of dockings before."""
        self.begun += 1
        self._used = 0
        self._floor_changed = False
        self._headings = (0.0, 0.0)  # [rad] least and most, from the first image on
        self._filters.restart(self.known.values, self.known.covariances)
        self._begin_images()

    def interrupt(self) -> None:
        """The chair may have been moved anyhow: keep what was found, and follow the dock anew."""
        if self._filters.last is not None:
            self._filters.interrupt()
            self._begin_images()

    def _begin_images(self) -> None:
        self._elsewhere = 0  # images in a row that the observer's dock is another one
        self._dock: Array | None = None  # where the observer has had it at the last image
        self._steadiness = Steadiness()
        self._turned_to = 0.0  # [rad] now

    def add(self, chair: Instant, offered: list[Measurement], known: Array) -> None:
        """The poses of the dock in odom that an image leaves open; `known` (3,): where the observer has it.

        Late images and those of a chair that stands are left out. Where `known` is another place and stays so, all
        begins anew; after a blind way the dock is followed anew, from an image that shows it where the observer has it.
        """
        filters = self._filters
        if filters.last is not None and _is_blind(filters.last, chair):
            self.interrupt()
        if self._dock is not None and _is_another(known, self._dock):
            self._elsewhere += 1
            if self._elsewhere < _LASTS:
                return
            self.restart()
        self._dock, self._elsewhere = np.array(known), 0
        if filters.last is None:
            near = [one for one in offered if float(np.abs(difference(one.pose, known)).max()) <= _FIRST]
            if near:
                filters.begin(chair, near[0])
        elif _has_moved(filters.last, chair):
            self._used += 1
            turned_to = self._turned_to + wrap_angle(float(chair.pose[2] - filters.last.pose[2]))
            self._turned_to, (least, most) = turned_to, self._headings
            self._headings = min(least, turned_to), max(most, turned_to)
            filters.add(chair, offered, known)
            self._notice_another_floor()

    def _notice_another_floor(self) -> None:
        """Where what was found changes as no installation does, go back to what was known before, with no level of slip
        favoured, once: what comes again is no floor."""
        filters = self._filters
        if filters.best is None or self._floor_changed:
            return
        found = filters.found
        before = self._steadiness.unlikely(filters.best, found[filters.best], _MODEL)
        self._steadiness.add(found)
        if before is not None:
            self._floor_changed = True
            filters.restart(*stacked(before))
            self._begin_images()

    def learn(self, limits: Array, certainty: float, *, turned: bool = False) -> None:
        """Remember what this docking has shown, for the next ones, unless it is certain by itself: it may have been a
        fault of this docking alone. Where it contradicts those before it, the installation has changed, and only this
        one counts. Limits and certainty: as of `InstallationError.is_wrong`. `turned`: it has turned at two places to
        see; what such a docking has shown no other one wears away."""
        best = self._filters.best
        if self._used < _FEWEST or best is None:
            return
        found, dockings = self._alone(), 1
        if self._mildest(found, 0).is_wrong(limits, certainty):
            return
        if not self._contradicts(found[best], best):
            if self.known.turned and not turned:
                self.known = replace(self.known, covariances=self.known.covariances + np.diag(_FADES**2))
                return
            found, dockings = self._filters.found, self.known.dockings + 1
        values, covariances = stacked(found)
        self.known = Knowledge(dockings, values, covariances + np.diag(_FADES**2), turned)

    def error(self, dock: Array = _DOCKED) -> InstallationError | None:
        """By the filter that accuses least, of those that explain the images about as well as the likeliest one; None
        before there is one, and where the odometry's heading drifts with time. Effects: on a dock (3,) that is there in
        base_link."""
        if self._filters.best is None:
            return None
        return self._mildest(self._filters.found, self.known.dockings, dock)

    def likeliest(self, dock: Array = _DOCKED) -> InstallationError | None:
        """By the filter that explains the images best: before a goal has driven far, all explain them, and the mildest
        is one that believes nothing. None, and effects: as of `error`."""
        best = self._filters.best
        return None if best is None else self._error_by(*self._filters.found[best], self.known.dockings, dock)

    @property
    def has_seen_enough(self) -> bool:
        """Whether enough images were used to conclude from them."""
        return self._used >= _FEWEST

    @property
    def unknown(self) -> Array:
        """(3, 3) covariance of where the docked chair stands, where this docking has said nothing."""
        B = self._effect.on(np.zeros(3))
        return np.asarray(B @ self.known.covariances[0] @ B.T)

    def _alone(self) -> list[Found]:
        """By each filter, by this docking alone: the information of those before it taken away again."""
        alone = []
        for (values, P), known, P_known in zip(
            self._filters.found, self.known.values, self.known.covariances, strict=True
        ):
            after, before = np.linalg.inv(P), np.linalg.inv(P_known)
            covariance = np.linalg.inv(np.diag(PRIOR**-2) + after - before)
            alone.append((covariance @ (after @ values - before @ known), 0.5 * (covariance + covariance.T)))
        return alone

    def _contradicts(self, alone: Found, best: int) -> bool:
        """Whether this docking and those before it are farther apart than chance has it, by the likeliest filter."""
        (values, P), known = alone, self.known
        shift = values - known.values[best]
        return float(shift @ np.linalg.solve(known.covariances[best] + P + np.diag(_MODEL**2), shift)) > _CHANGED

    def _mildest(self, found: Sequence[Found], dockings: int, dock: Array = _DOCKED) -> InstallationError:
        """`found`: by each filter."""
        evidence = self._filters.evidence
        plausible = np.flatnonzero(evidence >= evidence.max() - _AS_WELL)
        errors = [self._error_by(*one, dockings, dock) for one in found]
        best = min(map(int, plausible), key=lambda i: errors[i].certainty)
        slipping = errors[min(best + 1, len(errors) - 1)]
        straight = self._headings[1] - self._headings[0] < _STRAIGHT and errors[best].suspect in PLACES
        stays = (_STAYS_STRAIGHT if straight else _STAYS) * errors[best].certainty
        vanishes = slipping.certainty < stays  # with more slip: then it may be slip
        return slipping if vanishes and dockings + 1 < SERIES else errors[best]

    def _error_by(self, values: Array, P: Array, dockings: int, dock: Array = _DOCKED) -> InstallationError:
        model, B = np.diag(np.square(_MODEL)), self._effect.on(dock)
        noise = P - P @ np.diag(PRIOR**-2) @ P + model
        return InstallationError(values, noise, B * values, B @ (P + model) @ B.T, dockings)


def _has_moved(last: Instant, chair: Instant) -> bool:
    """Whether an image at `chair` is not late, and shows something that the one at `last` did not."""
    driven, turned = chair.driven - last.driven, chair.turned - last.turned
    return chair.stamp > last.stamp and (driven >= _STEP[0] or turned >= _STEP[1])


def _is_blind(last: Instant, chair: Instant) -> bool:
    """Whether the way between two images that are used is one."""
    return chair.driven - last.driven > _BLIND[0] or chair.turned - last.turned > _BLIND[1]


def _is_another(dock: Array, before: Array) -> bool:
    x, y, turn = difference(dock, before)
    return math.hypot(x, y) > _ANOTHER[0] or abs(turn) > _ANOTHER[1]
