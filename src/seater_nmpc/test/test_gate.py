"""A goal ends with the code that names what the gate stopped for; motors that do not obey are told to the gate."""

from typing import Any

import pytest

from seater_msgs.msg import GateState, MotorFault
from seater_msgs.srv import GateArmResponse
from seater_nmpc.ros import gate as module
from seater_nmpc.ros.gate import Gate
from seater_nmpc.ros.goal_checks import RefusedError
from seater_nmpc.sequence.goal.results import Result, ResultCode

CONSENT = 7
CODES = [
    (GateState.USER, ResultCode.STOPPED_BY_USER),
    (GateState.EMERGENCY_STOP, ResultCode.EMERGENCY_STOP),
    (GateState.RUNAWAY, ResultCode.RUNAWAY),
    (GateState.WRONG_DIRECTION, ResultCode.WRONG_DIRECTION),
    (GateState.OBSTACLE, ResultCode.BLOCKED),
    (GateState.CHARGING, ResultCode.CHARGING),
    (GateState.STALE, ResultCode.GATE_LOST),
    (GateState.FAULT, ResultCode.GATE_LOST),
]


class Service:
    """Gives `answer`."""

    resolved_name = "/gate_arm"
    answer = GateArmResponse(granted=True, consent=CONSENT)

    def wait_for_service(self, timeout: float) -> None:
        pass

    def __call__(self, undock: bool) -> GateArmResponse:
        self.undock = undock
        return self.answer


class Published(list[Any]):
    def publish(self, message: Any) -> None:
        self.append(message)


@pytest.fixture
def published() -> Published:
    return Published()


@pytest.fixture
def service() -> Service:
    return Service()


@pytest.fixture
def heard() -> list[Any]:
    """What is called when a state arrives."""
    return []


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch, published: Published, service: Service, heard: list[Any]) -> Gate:
    monkeypatch.setattr(module.rospy, "Publisher", lambda *_, **__: published)
    monkeypatch.setattr(module.rospy, "Subscriber", lambda _, __, callback, **___: heard.append(callback))
    monkeypatch.setattr(module.rospy, "ServiceProxy", lambda *_, **__: service)
    return Gate(lambda kind, message: None, lock_step=False)


@pytest.mark.parametrize(("state", "code"), CODES)
def test_the_code_names_what_the_gate_stopped_for(gate: Gate, state: int, code: ResultCode) -> None:
    gate.arm()
    assert gate.on_state(GateState(consent=CONSENT, motion_allowed=True)) is None
    loss = gate.on_state(GateState(consent=CONSENT, stopped_by=state, stop_reason="why"))
    assert loss is not None and (loss.code, loss.text) == (code, "why")


@pytest.mark.parametrize(("state", "code"), CODES)
def test_a_refused_goal_names_it_too(gate: Gate, service: Service, state: int, code: ResultCode) -> None:
    service.answer = GateArmResponse(granted=False, state=state, reason="why")
    with pytest.raises(RefusedError) as refused:
        gate.arm()
    assert (refused.value.code, refused.value.text) == (code, "why")


def test_motors_that_do_not_obey_are_told_to_the_gate(gate: Gate, published: Published) -> None:
    for code in ResultCode:
        gate.release(Result(code=code, text=code.name))
    told = [MotorFault(GateState.RUNAWAY, "RUNAWAY"), MotorFault(GateState.WRONG_DIRECTION, "WRONG_DIRECTION")]
    assert published == told


def test_what_is_in_the_way_holds_the_chair(gate: Gate) -> None:
    assert not gate.holds(10.0)
    gate.on_state(GateState(state=GateState.OBSTACLE))
    assert gate.holds(10.0)
    gate.on_state(GateState(state=GateState.REQUEST))
    assert not gate.holds(10.0)


def test_in_lock_step_the_state_counts_when_it_has_surely_arrived(gate: Gate) -> None:
    gate._lock_step = True
    for stamp, state in ((10.0, GateState.OBSTACLE), (10.5, GateState.REQUEST)):
        message = GateState(state=state)
        message.header.stamp = module.rospy.Time(stamp)
        gate.on_state(message)
    assert [gate.holds(now) for now in (10.1, 10.3, 10.6, 10.8)] == [False, True, True, False]


def test_after_the_end_of_the_goal_the_gate_ends_nothing(gate: Gate) -> None:
    gate.arm()
    gate.release(Result(code=ResultCode.SUCCESS, text=""))
    assert gate.on_state(GateState(consent=CONSENT, stopped_by=GateState.RUNAWAY)) is None


@pytest.mark.parametrize("undock", [False, True])
def test_the_gate_is_told_whether_the_goal_leaves_the_dock(gate: Gate, service: Service, undock: bool) -> None:
    gate.arm(undock=undock)
    assert service.undock is undock


def test_a_chair_that_stands_since_the_gate_is_silent_is_not_called_blocked(
    gate: Gate, heard: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked, lost = (Result(code=code, text="why") for code in (ResultCode.BLOCKED, ResultCode.MARKER_LOST))
    now = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    heard[0](GateState(state=GateState.REQUEST))
    now[0] += 0.3
    assert gate.named(blocked) == blocked
    now[0] += 0.3
    assert (gate.named(blocked).code, gate.named(blocked).text) == (
        ResultCode.GATE_LOST,
        "the safety gate has been silent for 0.6 s",
    )
    assert gate.named(lost) == lost
    gate._lock_step = True
    assert gate.named(blocked) == blocked


def test_a_chair_that_stood_since_the_docking_node_did_is_not_called_blocked(
    gate: Gate, heard: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stopped for 5 s: the odometry of that time, which it works through afterwards, shows a chair that stands."""
    blocked, now = Result(code=ResultCode.BLOCKED, text="why"), [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    gate.stood_still(5.0)
    now[0] += 0.5
    heard[0](GateState(state=GateState.STOPPED))
    named = gate.named(blocked)
    assert named.code is ResultCode.GATE_LOST and "the docking node stood still for 5.0 s" in named.text
    now[0] += 1.0
    heard[0](GateState(state=GateState.REQUEST))
    assert gate.named(blocked) == blocked
