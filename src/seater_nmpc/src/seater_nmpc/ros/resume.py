"""The service `docking_resume`: a person has a goal go on that a stop by a person has paused."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

PATIENCE = 5.0  # [s] of wall time for the answer
FRESH = 2.0  # [s] that a call may wait for the worker: later, the chair would drive off by surprise


class Call:
    """One call, on its way from the service's thread to the worker and back."""

    def __init__(self, work: Callable[[], str]) -> None:
        """`work` returns why what is asked for is not done; empty: it is."""
        self._work, self._asked = work, time.monotonic()
        self._answers: queue.Queue[str] = queue.Queue()

    def wait(self) -> str:
        """The worker's answer."""
        try:
            return self._answers.get(timeout=PATIENCE)
        except queue.Empty:
            return "the docking node does not answer in time"

    def work(self) -> None:
        """In the worker's thread, unless the call is old."""
        old = time.monotonic() - self._asked > FRESH
        self._answers.put("the docking node was busy for too long" if old else self._work())


class ResumeService:
    """Calls only hand over to the worker."""

    def __init__(self, ask: Callable[[Callable[[], str]], str], go_on: Callable[[], str]) -> None:
        """`ask(work)`: the answer of `work`, from the worker; `go_on`: empty, or why the goal does not go on."""
        self._ask, self._go_on = ask, go_on
        self._service = rospy.Service("docking_resume", Trigger, self._on_call)

    def _on_call(self, _: TriggerRequest) -> TriggerResponse:
        refusal = self._ask(self._go_on)
        return TriggerResponse(success=not refusal, message=refusal)
