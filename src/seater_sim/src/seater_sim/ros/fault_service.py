"""The service by which a node takes faults."""

from __future__ import annotations

from collections.abc import Callable

import rospy

from seater_msgs.srv import Fail, FailRequest, FailResponse
from seater_sim.faults import kinds


def offer_faults(set_fault: Callable[[str, str, tuple[float, ...]], None]) -> rospy.Service:
    """The service ~fail: begins or ends a fault by `set_fault(component, kind, values)`."""

    def fail(request: FailRequest) -> FailResponse:
        try:
            values = kinds.read(request.component, request.kind, request.values)
        except ValueError as error:
            return FailResponse(success=False, message=str(error))
        set_fault(request.component, request.kind, values)
        rospy.logwarn("Fault: %s %s %s", request.component, request.kind, list(values) or "")
        return FailResponse(success=True, message="")

    return rospy.Service("~fail", Fail, fail)
