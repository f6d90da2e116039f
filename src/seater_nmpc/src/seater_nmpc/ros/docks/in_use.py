"""Which dock the node works at, what it knows of standing docked there, and what the docks before it have left."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar

import rospy
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_nmpc.observe.observer import DockEstimate, DockObserver
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.left_bays import LeftBays
from seater_nmpc.ros.docks.library import Docks, Loaded
from seater_nmpc.ros.docks.services import DockServices
from seater_nmpc.ros.docks.states import DockStates
from seater_nmpc.sequence.docked import DockWatch
from seater_nmpc.sequence.docking_sequence import DockingSequence


class _AtOneDock(Protocol):
    @property
    def chair(self) -> Chair: ...

    dock: Dock
    parameters: NmpcParameters
    observer: DockObserver
    sequence: DockingSequence


C = TypeVar("C", bound=_AtOneDock)


class DockInUse(Generic[C]):
    """All of it belongs to the worker's thread, and no goal is active when the dock changes."""

    def __init__(
        self,
        docks: Docks[C],
        services: DockServices,
        follow: Callable[[C, DockEstimate | None], None],
        *,
        require_contact: bool,
    ) -> None:
        """`follow(core, left)`: another core is used from now on; `left`: where the dock was that is used no more."""
        self.docks, self._services, self._follow = docks, services, follow
        self.core = docks.core()
        self._bays, self._states = LeftBays(), DockStates()
        self.watch = DockWatch(require_contact=require_contact)
        self._tell(rospy.Time())

    def use(self, name: str, since: rospy.Time) -> None:
        """Look for this dock from the stamp `since` on."""
        core = self.docks.core(name)
        if core is self.core:
            return
        estimate = self.core.observer.estimate()
        if estimate is not None:
            self._bays.leave(self.core.dock, estimate.pose, estimate.blind_distance)
        self._bays.use(core.dock)
        core.observer.forget()
        self.core = core
        self._follow(core, estimate)
        self._tell(since)

    def take(self, loaded: Loaded[C], since: rospy.Time) -> str:
        """From now on these are the docks; empty, or why they are not."""
        name = self.core.dock.name
        if name not in loaded.cores:
            stands = self.watch.why_not_to(loaded.database.configured, search=False)
            if stands:
                return f"{name} is not among them, and {stands}"
        self.docks.take(loaded)
        if name in loaded.cores and loaded.cores[name] is self.core:
            self._services.tell_again()
        else:
            self.watch.forget()  # it is another place now, which contact and images have to show
            self.use(name if name in loaded.cores else loaded.database.configured, since)
        return ""

    def forget(self) -> None:
        """Time started anew."""
        self.core.observer.forget()
        self.watch.forget()
        self._bays.forget()

    def tell_docked(self, stamp: rospy.Time, contact: bool | None) -> None:
        """Once per control cycle."""
        state = self.watch.update(stamp.to_sec(), contact, goal=self.core.sequence.active)
        self._states.tell(stamp, state)

    def walls_left(self, T_odom_dock: NDArray[Any], T_odom_base: NDArray[Any]) -> list[NDArray[Any]]:
        """Of docks that were used before, near the chair, as outlines in the frame of this dock."""
        return self._bays.in_dock(self.core.dock.bay, T_odom_dock, T_odom_base)

    def _tell(self, since: rospy.Time) -> None:
        core = self.core
        self.watch.use(core.chair, core.dock, core.observer, core.parameters.sequence)
        self._services.use(core.dock.name, since)
