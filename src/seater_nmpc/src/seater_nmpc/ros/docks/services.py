"""What others are told of the docks: the services `list_docks` and `reload_docks`, the topic `dock_in_use`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from seater_msgs.msg import DockInUse, MarkerDetectionArray
from seater_msgs.srv import ListDocks, ListDocksRequest, ListDocksResponse
from seater_nmpc.ros.docks.library import Docks, Loaded

_FOLLOWS = 1.0  # [s] by then perception looks for the dock that it was told


class DockServices:
    """What rospy's threads are asked, the worker decides."""

    def __init__(self, docks: Docks[Any], ask: Callable[[Callable[[], str]], str], *, speaks: bool = True) -> None:
        """`ask(work)`: the answer of `work` from the worker, empty or why not. `speaks` False: another node says which
        dock is in use."""
        self._docks, self._ask = docks, ask
        self._in_use, self._since = "", rospy.Time()
        self.loading = False  # no goal begins then
        self._publisher = rospy.Publisher("dock_in_use", DockInUse, queue_size=1, latch=True) if speaks else None

    def offer(self, refusal: Callable[[], str], take: Callable[[Loaded[Any]], str]) -> None:
        """Advertise both services. In the worker: `refusal` says why the docks may not be loaded anew now (empty: they
        may), `take` has them used, or says why not."""
        self._refusal, self._take = refusal, take
        self._services = [
            rospy.Service("list_docks", ListDocks, self._on_list),
            rospy.Service("reload_docks", Trigger, self._on_reload),
        ]

    def use(self, name: str, since: rospy.Time) -> None:
        """Tell everybody that this dock is looked for, from the stamp `since` on."""
        entry, self._in_use, self._since = self._docks.database.entry(name), name, since
        message = DockInUse(
            name=name,
            revision=self._docks.revision(name),
            source=entry.source,
            since=since,
            known=self._docks.database.names,
            content=entry.content,
        )
        if self._publisher is not None:
            self._publisher.publish(message)

    def tell_again(self) -> None:
        """The docks were loaded anew; the one in use is the same."""
        self.use(self._in_use, self._since)

    def about(self, message: MarkerDetectionArray) -> bool:
        """Whether detections are about the dock in use; an empty name says nothing."""
        name, revision = message.dock_name, message.dock_revision
        if not name or (name, revision) == (self._in_use, self._docks.revision(self._in_use)):
            return True
        if (message.header.stamp - self._since).to_sec() > _FOLLOWS:
            rospy.logwarn_throttle(10.0, "perception still looks for dock %s, not for %s", name, self._in_use)
        return False

    def _on_list(self, _: ListDocksRequest) -> ListDocksResponse:
        database = self._docks.database
        return ListDocksResponse(
            names=database.names,
            sources=[entry.source for entry in database],
            configured=database.configured,
            in_use=self._in_use,
        )

    def _on_reload(self, _: TriggerRequest) -> TriggerResponse:
        """Making a core takes a second, in which the worker has to go on."""
        why_not = self._ask(self._begin)
        if why_not:
            return TriggerResponse(False, why_not)
        try:
            loaded = self._docks.load()
            why_not = self._ask(lambda: self._take(loaded))
        except ValueError as error:
            why_not = f"the docks stay as they were: {error}"
        finally:
            self.loading = False
        return TriggerResponse(not why_not, why_not or f"docks: {', '.join(self._docks.database.names)}")

    def _begin(self) -> str:
        why_not = "they are being loaded already" if self.loading else self._refusal()
        self.loading = self.loading or not why_not
        return why_not
