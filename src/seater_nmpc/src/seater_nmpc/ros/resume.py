"""The service `docking_resume`: a person has a goal go on that a stop by a person has paused."""

from __future__ import annotations

from collections.abc import Callable

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse


class ResumeService:
    """Calls only hand over to the worker."""

    def __init__(self, ask: Callable[[Callable[[], str]], str], go_on: Callable[[], str]) -> None:
        """`ask(work)`: the answer of `work`, from the worker; `go_on`: empty, or why the goal does not go on."""
        self._ask, self._go_on = ask, go_on
        self._service = rospy.Service("docking_resume", Trigger, self._on_call)

    def _on_call(self, _: TriggerRequest) -> TriggerResponse:
        refusal = self._ask(self._go_on)
        return TriggerResponse(success=not refusal, message=refusal)
