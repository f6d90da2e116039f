"""The docking node pauses a goal that a person stops, and goes on when the service is called and the gate agrees."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import pytest
from drive import Drive
from stand import Stand
from std_srvs.srv import TriggerResponse

from seater_msgs.msg import DockFeedback, DockGoal, DockResult, GateState
from seater_msgs.srv import GateArmResponse
from seater_nmpc.ros.inbox import call
from seater_nmpc.sequence.goal.results import ResultCode

RECOVERS = 4.0  # [s]
WHY = "the joystick was moved"


@pytest.fixture
def stand() -> Iterator[Stand]:
    with pytest.MonkeyPatch.context() as monkeypatch:
        stand = Stand(monkeypatch)
        sequence = stand.node._core.sequence
        sequence._parameters = dataclasses.replace(sequence._parameters, pause_time=30.0)
        yield stand


def stopped(stand: Stand, drive: Drive, by: int) -> None:
    """The gate says that the consent has ended so."""
    stand.deliver("gate_state", GateState(consent=stand.consent, stopped_by=by, stop_reason=WHY))
    drive.gate_state = lambda: GateState(consent=stand.consent, motion_allowed=True)  # type: ignore[method-assign]


@pytest.mark.parametrize("by", [GateState.USER, GateState.EMERGENCY_STOP])
def test_a_stop_by_a_person_pauses_until_resumed(stand: Stand, by: int) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stopped(stand, drive, by)
    consent = stand.consent
    drive.advance(3.0)
    assert stand.active and not stand.results and stand.consent == consent
    assert stand.sent["feedback"][-1].phase == DockFeedback.PAUSED
    requests = stand.sent["velocity_request"]
    assert requests[-1].twist.linear.x == 0.0 and requests[-1].header.stamp < drive.stamp  # and silence afterwards
    assert stand.call("docking_resume") == TriggerResponse(True, "") and stand.consent == consent + 1
    assert drive.docks(RECOVERS)


def test_a_gate_that_refuses_keeps_it_paused(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stopped(stand, drive, GateState.EMERGENCY_STOP)
    pressed = GateArmResponse(granted=False, state=GateState.EMERGENCY_STOP, reason="the emergency stop is pressed")
    with monkeypatch.context() as refusing:
        refusing.setattr(stand.node._gate._service, "_answer", lambda: pressed)
        assert stand.call("docking_resume") == TriggerResponse(False, "the emergency stop is pressed")
    drive.advance(1.0)
    assert stand.active and stand.sent["feedback"][-1].phase == DockFeedback.PAUSED
    assert stand.call("docking_resume").success and drive.docks(RECOVERS)


def test_an_old_call_resumes_nothing(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    assert stand.call("docking_resume") == TriggerResponse(False, "no goal is paused")
    stopped(stand, drive, GateState.USER)
    monkeypatch.setattr(call, "FRESH", -1.0)
    assert stand.call("docking_resume") == TriggerResponse(False, "the docking node was busy for too long")
    drive.advance(0.5)
    assert stand.sent["feedback"][-1].phase == DockFeedback.PAUSED


def test_other_stops_end_the_goal(stand: Stand) -> None:
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stopped(stand, drive, GateState.FAULT)
    assert not stand.active and stand.results[-1].result_code == DockResult.GATE_LOST


def test_a_new_goal_replaces_a_paused_one_and_listens_to_the_gate(stand: Stand) -> None:
    """Its consent was given before the first one's end: that must not release it."""
    drive = Drive(stand)
    assert drive.docks(RECOVERS)
    stopped(stand, drive, GateState.USER)
    stand.give("dock", DockGoal(use_dock_id=True))
    assert stand.results[-1].result_code == DockResult.CANCELED and drive.docks(RECOVERS)
    stopped(stand, drive, GateState.FAULT)
    assert not stand.active and stand.results[-1].result_code == ResultCode.GATE_LOST


def test_a_goal_ends_when_its_client_is_gone(stand: Stand) -> None:
    """As the watching thread says; a goal that has ended meanwhile has no client any more."""
    drive, watch = Drive(stand), stand.node._client
    watch._timeout = 60.0
    assert drive.docks(RECOVERS)
    stand.put("client lost", None)
    stand.work_off()
    assert stand.active, "it has answered"
    watch._answered -= 60.1
    stand.put("client lost", None)
    stand.work_off()
    assert not stand.active and stand.results[-1].result_code == DockResult.CLIENT_LOST
    assert stand.results[-1].result_text.startswith("/client, which gave the goal, has not answered for ")
    assert stand.sent["velocity_request"][-1].twist.linear.x == 0.0 and watch.lost() == ""
