"""The safety gate as the docking node sees it: it is asked for consent once per goal, and says when that has ended."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import rospy

from seater_msgs.msg import GateState, MotorFault
from seater_msgs.srv import GateArm, GateArmResponse
from seater_nmpc.ros.goal_checks import RefusedError
from seater_nmpc.sequence.goal.results import Result, ResultCode

SETTLED = 0.2  # [s] of message time: in lock-step the state of so long ago has arrived, whoever is faster
MISSED = 0.35  # [s] of wall time: of ten states a second it has left out some
PATIENCE = 1.0  # [s] of wall time: longest silence of the gate, and longest wait for its answer

CODES = {
    GateState.USER: ResultCode.STOPPED_BY_USER,
    GateState.EMERGENCY_STOP: ResultCode.EMERGENCY_STOP,
    GateState.RUNAWAY: ResultCode.RUNAWAY,
    GateState.WRONG_DIRECTION: ResultCode.WRONG_DIRECTION,
    GateState.OBSTACLE: ResultCode.BLOCKED,
    GateState.CHARGING: ResultCode.CHARGING,
}
BY_A_PERSON = (ResultCode.STOPPED_BY_USER, ResultCode.EMERGENCY_STOP)
MOTOR_FAULTS = {CODES[state]: state for state in (GateState.RUNAWAY, GateState.WRONG_DIRECTION)}


@dataclass(frozen=True)
class Loss:
    """Why the goal has to end."""

    code: ResultCode
    text: str


class Gate:
    """Consent for the goal that is being worked on. `on_state` runs in the worker's thread, `silence` in any."""

    def __init__(self, enqueue: Callable[[str, Any], None], *, lock_step: bool) -> None:
        """`enqueue("gate", message)` hands over to the worker. `lock_step`: silence in wall time means nothing, as the
        simulator waits for the slowest."""
        self._lock_step = lock_step
        self._consent, self._confirmed, self._heard = 0, False, 0.0
        self._arrived = 0.0  # of the last state, whether it has been worked through or not
        self._stood = (-1e9, 0.0)  # when this process went on after it stood still, and for how long [s]
        self.held_by = ""  # why the gate stopped the chair last for something in the way
        self._held: deque[tuple[float, bool]] = deque([(0.0, False)], maxlen=100)  # stamp [s], see `holds`
        self._motor_fault = rospy.Publisher("motor_fault", MotorFault, queue_size=10, tcp_nodelay=True)
        self._service = rospy.ServiceProxy("gate_arm", GateArm)

        def on_arrival(message: GateState) -> None:
            self._arrived = time.monotonic()
            enqueue("gate", message)

        rospy.Subscriber("gate_state", GateState, on_arrival, queue_size=10, tcp_nodelay=True)

    def arm(self, *, undock: bool = False) -> None:
        """Ask that the requests of this goal pass; `undock`: it leaves the dock.

        Raises:
            RefusedError: the gate refuses, with its reason, or does not answer.
        """
        answer = self._ask(undock=undock)
        if answer is None:
            raise RefusedError(ResultCode.GATE_LOST, f"the safety gate does not answer ({self._service.resolved_name})")
        if not answer.granted:
            raise RefusedError(_code(answer.state), answer.reason)
        self._consent, self._confirmed, self._heard = answer.consent, False, time.monotonic()

    def release(self, result: Result | None = None) -> None:
        """The goal has ended or is paused. Motors that do not obey are told to stop in vain: the gate takes their
        power."""
        self._consent = 0
        if result is not None and result.code in MOTOR_FAULTS:
            self._motor_fault.publish(MotorFault(state=MOTOR_FAULTS[result.code], reason=result.text))

    def on_state(self, message: GateState) -> Loss | None:
        """Whether the consent of this goal has ended with what the gate says."""
        held = message.state == GateState.OBSTACLE
        self._held.append((message.header.stamp.to_sec(), held))
        self.held_by = message.reason if held else self.held_by
        if not self._consent:
            return None
        if message.consent == self._consent:
            self._confirmed, self._heard = True, time.monotonic()
            return None if message.motion_allowed else Loss(_code(message.stopped_by), message.stop_reason)
        if not self._confirmed:  # sent before the consent was given
            return None
        return Loss(ResultCode.GATE_LOST, "the safety gate was started anew, or another node drives")

    def holds(self, now: float) -> bool:
        """Whether the gate stops the chair for something in the way, at message time `now` [s]."""
        if not self._lock_step:
            return self._held[-1][1]
        return next((held for stamp, held in reversed(self._held) if stamp <= now - SETTLED), False)

    def silence(self) -> Loss | None:
        """Whether the gate has been silent for too long during this goal."""
        if self._lock_step or not self._consent or time.monotonic() - self._heard <= PATIENCE:
            return None
        return Loss(ResultCode.GATE_LOST, f"the safety gate has been silent for {PATIENCE:.0f} s")

    def named(self, result: Result) -> Result:
        """A chair that stands as nobody passes its requests on is not blocked: the gate is named before it has been
        silent for long enough to say so by itself."""
        now, (went_on, stood) = time.monotonic(), self._stood
        if self._lock_step or result.code is not ResultCode.BLOCKED:
            return result
        if now - went_on <= PATIENCE:
            text = f"the docking node stood still for {stood:.1f} s (loaded computer?), and the safety gate braked"
        elif now - self._arrived > MISSED:
            text = f"the safety gate has been silent for {now - self._arrived:.1f} s"
        else:
            return result
        return replace(result, code=ResultCode.GATE_LOST, text=text)

    def stood_still(self, seconds: float) -> None:
        """This process has stood still, and the gate braked: what it works through now is of that time."""
        self._stood = (time.monotonic(), seconds)

    def _ask(self, *, undock: bool) -> GateArmResponse | None:
        """The gate's answer; None when there is none in time. In a thread of its own: a call has no time-out."""
        answers: list[GateArmResponse] = []

        def call() -> None:
            try:
                self._service.wait_for_service(PATIENCE)
                answers.append(self._service(undock))
            except (rospy.ROSException, rospy.ServiceException) as error:
                rospy.logwarn("%s: %s", self._service.resolved_name, error)

        thread = threading.Thread(target=call, daemon=True)
        thread.start()
        thread.join(PATIENCE + 0.5)
        return answers[0] if answers else None


def _code(state: int) -> ResultCode:
    return CODES.get(state, ResultCode.GATE_LOST)
