"""What a goal concludes from what it has found of the installation: where a docked chair stands, and how surely."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_nmpc.parameters import ObserverParameters, PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Contradiction, Kind
from seater_nmpc.plausibility.installation.installation import Installation
from seater_nmpc.plausibility.installation.knowledge import KEYS, NAMES, PLACES, Knowledge, without_turns

Array = NDArray[np.float64]

_SUSPECT = 0.5  # of the certainty that ends a docking: none of 50 chairs without a fault, 17 of 49 that stood far off
# Standard deviations: with nothing wrong 1.1 at most in six dockings; with depths 10 % wrong 3.7, straight ahead.
_STANDS_OUT = 2.0
# [m, m, rad] by which the walls may be elsewhere than the images have them, for a chair that drives in between them: it
# keeps 5 cm, and 2 of them are what it strays by. The heading moves a corner of the mouth, half a bay's width aside.
_WALLS = np.array([0.03, 0.03, 0.06])
# Times the certainty, for the likeliest filter: of three chairs that touched, one did before the mildest was certain
# (the likeliest was by 6.4 standard deviations); of 40 with nothing wrong it was by 3.4 at most.
_LIKELIEST = 1.2


class InstallationWatch:
    """Tell `seen` what each image shows; ask for what follows from it, and `learn` at the end of a docking."""

    def __init__(
        self, chair: Chair, dock: Dock, observer: ObserverParameters, parameters: PlausibilityParameters
    ) -> None:
        self._parameters = parameters
        self._at_the_mouth = np.array([chair.length_front - dock.bay.entrance_x, 0.0, 0.0])  # the dock in base_link
        self.seen = Installation(chair.camera, dock, observer)

    def final(self) -> Contradiction | None:
        """Of a chair that stands docked by its images: whether the installation is surely so wrong that it does not."""
        error, p = self.seen.error(), self._parameters
        if error is None:
            return None
        if not error.is_wrong(self._limits, p.final_certainty):
            return None
        x, y, heading = error.final.tolist()
        off = f"{1e3 * math.hypot(x, y):.0f} mm and {math.degrees(abs(heading)):.1f} deg"
        before = f" (with {error.dockings} dockings before)" if error.dockings else ""
        text = f"images and odometry{before} fit together only if the chair is {off} off: check {NAMES[error.suspect]}"
        return Contradiction(Kind.INCONSISTENT, f"{text} (chair.yaml, camera_info, the dock's file)")

    def walls(self) -> Contradiction | None:
        """Of a chair ahead of the bay: whether its walls surely are so far from where the images have them that the
        chair may touch them on its way in. By a focal length that is 4.5 % too long it did, three of 12 times."""
        found, certainty = self.seen, self._parameters.final_certainty
        error, likeliest = found.error(self._at_the_mouth), found.likeliest(self._at_the_mouth)
        if error is None or likeliest is None or not found.has_seen_enough:
            return None
        if not error.is_wrong(_WALLS, certainty):
            # Places of the camera show in turns, and slip looks like one: by 6.1 and 41 mm once, with nothing wrong.
            if likeliest.suspect in PLACES or not likeliest.is_wrong(_WALLS, _LIKELIEST * certainty):
                return None
            error = likeliest
        text = f"images and odometry fit together only if the bay is {1e3 * math.hypot(*error.final[:2]):.0f} mm from"
        check = f"where the images have it: check {NAMES[error.suspect]} (chair.yaml, camera_info, the dock's file)"
        return Contradiction(Kind.INCONSISTENT, f"{text} {check}")

    def suspected(self) -> str:
        """What a chair that stands docked by its images should have checked all the same; empty: nothing."""
        error, p = self.seen.error(), self._parameters
        if error is None or not error.is_wrong(self._limits, _SUSPECT * p.final_certainty):
            return ""
        off = f"{1e3 * math.hypot(error.final[0], error.final[1]):.0f} mm"
        return f"the way here suggests that it is {off} off: check {NAMES[error.suspect]} (./seater doctor --move)"

    def hint(self) -> str:
        """What to check first of a chair that stands docked by its images, and at no dock by its contact: then
        something is wrong, and little says what. Empty: nothing stands out."""
        error = self.seen.error()
        if error is None or error.certainty < _STANDS_OUT:
            return ""
        off = 1e3 * math.hypot(*error.final[:2])
        return f"images and the way here hint at {NAMES[error.suspect]}, {off:.0f} mm off: check that first"

    def unsure(self, position_sd: float, *, checked: bool) -> str:
        """Why a chair that stands docked by its images may stand elsewhere all the same; empty: it is sure enough.
        `checked`: the installation is checked where it is not known."""
        p = self._parameters
        if position_sd <= (p.final_unsure_checked if checked else p.final_unsure):
            return ""
        found = f"where it stands is known to {1e3 * position_sd:.0f} mm only (one standard deviation)"
        return f"{found}: calibrate the camera's mount, fit a contact, or dock again, which shows more of the mount"

    @property
    def found(self) -> dict[str, tuple[float, float]]:
        """By how much mount (x, y [m], yaw [rad]) and depths (share) seem to be off by this goal so far, and the
        standard deviation of that where nothing is; empty: it says nothing."""
        error = self.seen.error()
        if error is None:
            return {}
        sds = np.sqrt(np.diag(error.noise))
        return {name: (float(v), float(sd)) for name, v, sd in zip(KEYS, error.values, sds, strict=True)}

    def final_error(self, *, turned: bool) -> tuple[Array, Array]:
        """(3,) by which the docked chair seems to be off because of the installation: x, y [m], heading [rad], and the
        covariance (3, 3) of that. `turned`: in this goal, which shows it; else dockings before may have."""
        error = self.seen.error()
        off, spread = (np.zeros(3), self.seen.unknown) if error is None else (error.final, error.spread)
        return off, spread if turned or self.knowledge.turned else without_turns(spread)

    def doubt(self, *, turned: bool) -> float:
        """Standard deviation [m] of where the docked chair stands, by what seems wrong and what is unknown of the
        installation. `turned`: in this goal, which shows it; else dockings before may have shown it."""
        off, spread = self.final_error(turned=turned)
        known = self.knowledge
        remembered = self.seen.likeliest() if known.turned and known.dockings and not turned else None
        if remembered is not None:
            off, spread = remembered.final, remembered.spread
        return math.sqrt(float(np.linalg.eigvalsh((np.outer(off, off) + spread)[:2, :2])[-1]))

    @property
    def begun(self) -> int:
        """How often what images show of the installation has begun anew: what was seen before does not count then."""
        return self.seen.begun

    def learn(self, *, turned: bool) -> None:
        """A docking has ended at the dock: remember what it has shown. `turned`: at two places, to see where the camera
        sits."""
        self.seen.learn(self._limits, self._parameters.final_certainty, turned=turned)

    @property
    def knowledge(self) -> Knowledge:
        """Of the installation, by the dockings so far."""
        return self.seen.known

    @knowledge.setter
    def knowledge(self, known: Knowledge) -> None:
        self.seen.known = known
        self.seen.restart()

    @property
    def _limits(self) -> Array:
        p = self._parameters
        return np.array([p.final_position, p.final_position, p.final_heading])
