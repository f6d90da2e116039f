"""The service `docking_resume`: a person has a goal go on that a stop by a person has paused."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from typing import Any

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

PATIENCE = 5.0  # [s] of wall time for the answer
FRESH = 2.0  # [s] that a call may wait for the worker: later, the chair would drive off by surprise


class Call:
    """One call, on its way from the service's thread to the worker and back."""

    def __init__(self) -> None:
        self._asked = time.monotonic()
        self._answers: queue.Queue[str] = queue.Queue()

    def wait(self) -> str:
        """The worker's answer; empty: the goal goes on."""
        try:
            return self._answers.get(timeout=PATIENCE)
        except queue.Empty:
            return "the docking node does not answer in time"

    def work(self, resume: Callable[[], str]) -> None:
        """In the worker's thread: `resume`, unless the call is old."""
        old = time.monotonic() - self._asked > FRESH
        self._answers.put("the docking node was busy for too long" if old else resume())


class ResumeService:
    """Calls only hand over to `enqueue("resume", call)`."""

    def __init__(self, enqueue: Callable[[str, Any], None]) -> None:
        self._enqueue = enqueue
        self._service = rospy.Service("docking_resume", Trigger, self._on_call)

    def _on_call(self, _: TriggerRequest) -> TriggerResponse:
        call = Call()
        self._enqueue("resume", call)
        refusal = call.wait()
        return TriggerResponse(success=not refusal, message=refusal)
