"""Where a chair ends that could not dock: where it is, or backed out to the predock point."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import seldom

from seater_common.geometry import Dock, Tolerance
from seater_nmpc.sequence.goal.results import Phase, ResultCode

CLOSE = (-0.05, 0.0, 0.0)


def start(make_world, end: str, **options):
    sequence = {"failed_end": end, "max_retries": 0, "pause_time": 20.0}
    world = make_world(CLOSE, require_contact=True, sequence=sequence, **options)
    world.tick()
    world.sequence.start_dock(world.now)
    return world


def no_contact(world) -> bool:
    return False


def test_as_shipped_it_stays(make_world) -> None:
    world = make_world(CLOSE, require_contact=True, contact=no_contact)
    world.tick()
    world.sequence.start_dock(world.now)
    assert world.run(30.0).result.code is ResultCode.FAILED_TO_CHARGE
    assert abs(world.truth[0]) < 0.03 and "RETRY" not in world.phases


def test_without_contact_it_backs_out_and_then_says_why(make_world) -> None:
    world = start(make_world, "predock", contact=no_contact)
    step = world.run(30.0, lambda step: step.phase is Phase.RETRY)
    assert not step.done
    step = world.run(40.0)
    result = step.result
    assert result.code is ResultCode.FAILED_TO_CHARGE and (step.command.v, step.command.omega) == (0.0, 0.0)
    assert result.text == "the charging contact does not close; backed out to the predock point"
    assert result.retries == 0 and world.phases.count("FINAL") == 1
    assert np.hypot(world.truth[0] - world.dock.predock_x, world.truth[1]) < 0.09  # predock_position
    assert abs(world.v) < 0.003 and world.smallest_clearance > 0.05


def test_outside_the_tolerance_after_all_retries(make_world) -> None:
    tight = replace(Dock(), tolerance=Tolerance(position=0.0005, heading=0.0001))  # which noise cannot meet
    world = start(make_world, "predock", dock=tight, contact=lambda w: w.truth[0] > -0.02)
    result = world.run(60.0).result
    assert result.code is ResultCode.NOT_WITHIN_TOLERANCE
    assert result.text.endswith("after 0 retries; backed out to the predock point")
    assert np.hypot(world.truth[0] - world.dock.predock_x, world.truth[1]) < 0.09


def test_what_ends_the_backing_out_names_the_failure_too(make_world) -> None:
    world = start(make_world, "predock", contact=no_contact)
    world.run(30.0, lambda step: step.phase is Phase.RETRY)
    result = world.sequence.abort(world.now, ResultCode.STOPPED_BY_USER, "the joystick was moved").result
    assert result.code is ResultCode.STOPPED_BY_USER
    assert result.text.startswith("the joystick was moved, backing out after FAILED_TO_CHARGE")


def test_a_person_who_resumes_has_it_try_again(make_world) -> None:
    closes = []
    world = start(make_world, "predock", contact=lambda w: bool(closes) and w.truth[0] > -0.02)
    world.run(30.0, lambda step: step.phase is Phase.RETRY)
    world.sequence.pause(world.now, ResultCode.STOPPED_BY_USER, "let go")
    closes.append(True)
    world.sequence.resume(world.now)
    result = world.run(60.0).result
    assert (result.code, result.text) == (ResultCode.SUCCESS, "docked")


def test_a_success_that_is_doubted_says_so_and_its_deviation_too(make_world) -> None:
    """The camera stands 29 mm beside where it is told, which one docking does not show for sure."""
    results = []
    for aside in (0.0, 0.029):
        world, T = make_world((-2.0, 0.5, -10.0)), np.eye(4)
        T[0, 3] = aside
        world.shows = lambda _, found, T=T: [replace(seen, T_optical_dock=T @ seen.T_optical_dock) for seen in found]
        world.tick()
        world.sequence.start_dock(world.now)
        results.append(world.run(60.0).result)
        assert results[-1].code is ResultCode.SUCCESS and world.sequence.knowledge.dockings == 1
        assert abs(abs(world.truth[1]) - aside) < 0.005 and results[-1].position_sd > 0.003
    assert results[0].text == "docked"
    assert results[1].text.startswith("docked, but the way here suggests") and "camera's y" in results[1].text
    assert results[1].position_sd > max(0.02, results[0].position_sd)


@pytest.mark.parametrize(
    ("contact", "code"), [(None, ResultCode.NOT_CERTAIN), (False, ResultCode.NOT_CERTAIN), (True, ResultCode.SUCCESS)]
)
def test_no_success_is_claimed_where_the_chair_may_stand_elsewhere(make_world, contact, code) -> None:
    world = make_world(CLOSE, contact=lambda w: contact, plausibility={"final_unsure": 0.005})
    world.tick()
    world.sequence.start_dock(world.now)
    step = world.run(30.0)
    result = step.result
    assert result.code is code and result.position_sd > 0.005
    assert (step.command.v, step.command.omega) == (0.0, 0.0) and abs(world.truth[0]) < 0.03
    assert code is ResultCode.SUCCESS or "calibrate the camera's mount, fit a contact" in result.text


@pytest.mark.extensive  # two dockings; a resumed one knows nothing of it, either
def test_the_next_goal_knows_nothing_of_it(make_world) -> None:
    world = start(make_world, "predock", contact=no_contact)
    world.run(60.0)
    world.contact = lambda w: w.truth[0] > -0.02
    world.sequence.start_dock(world.now)
    assert world.run(60.0).result.code is ResultCode.SUCCESS


@pytest.mark.parametrize("retries", [seldom(0), 2])
def test_a_camera_that_was_turned_is_named_where_the_docking_fails(make_world, retries) -> None:
    """It ended with NOT_WITHIN_TOLERANCE, "stands beside the dock", after two retries; no other attempt would help."""
    c, s = math.cos(0.05), math.sin(0.05)
    turn = np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])  # about the optical frame's y
    world = make_world((-1.6, 0.0, 5.0), sequence={"max_retries": retries})
    world.shows = lambda _, found: [replace(seen, T_optical_dock=turn @ seen.T_optical_dock) for seen in found]
    world.tick()
    world.sequence.start_dock(world.now)
    result = world.run(60.0).result
    assert result.code is ResultCode.INCONSISTENT and result.retries == 0, result
    assert result.text.startswith("stands beside the dock") and "check the camera's yaw" in result.text
