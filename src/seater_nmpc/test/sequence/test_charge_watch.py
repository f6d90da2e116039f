"""A docked chair whose goal watches the contact for a while: it docks again when the contact opens, and only then."""

import pytest

from seater_nmpc.sequence.goal.results import Phase, ResultCode

CLOSE = (-0.05, 0.0, 0.0)


def start(make_world, watch: float = 5.0, sequence: dict | None = None, **options):
    world = make_world(CLOSE, require_contact=True, sequence={"charge_watch": watch} | (sequence or {}), **options)
    world.tick()
    world.sequence.start_dock(world.now)
    return world


def closes(world) -> bool:
    return world.truth[0] > -0.02


def test_the_goal_ends_when_the_contact_stayed_closed(make_world) -> None:
    world = start(make_world, contact=closes)
    world.run(10.0, lambda step: step.phase is Phase.HOLDING)
    held, truth = world.now, world.truth
    result = world.run(10.0).result
    assert result.code is ResultCode.SUCCESS and result.contact and result.retries == 0
    assert 5.0 <= world.now - held < 5.2 and (world.truth == truth).all()


def test_a_docking_whose_watch_is_ended_has_shown_the_installation_too(make_world) -> None:
    # From so far, that it is surely not the odometry that drifts.
    world = make_world((-2.2, 0.3, 0.0), require_contact=True, contact=closes, sequence={"charge_watch": 60.0})
    world.tick()
    world.sequence.start_dock(world.now)
    world.run(60.0, lambda step: step.phase is Phase.HOLDING)
    assert world.sequence.knowledge.dockings == 0
    assert world.sequence.abort(world.now, ResultCode.CHARGING, "it charges").result.code is ResultCode.SUCCESS
    assert world.sequence.knowledge.dockings == 1


def test_as_shipped_the_goal_ends_at_once(make_world) -> None:
    world = start(make_world, watch=0.0, contact=closes)
    assert world.run(10.0).result.code is ResultCode.SUCCESS
    assert "HOLDING" not in world.phases


def test_a_contact_that_opens_is_docked_again(make_world) -> None:
    world = start(make_world)
    lost = []

    def contact(w) -> bool:
        if w.sequence._goal.phase is Phase.HOLDING and not lost:
            lost.append(w.now)
        moved = any(t[0] < -0.5 for t in w.track)
        return closes(w) and (not lost or w.now < lost[0] + 1.0 or moved)

    world.contact = contact
    result = world.run(60.0).result
    assert result.code is ResultCode.SUCCESS and result.retries == 1 and result.contact
    assert world.phases.count("HOLDING") == 2 and "RETRY" in world.phases


def test_a_bounce_of_the_contact_moves_nothing(make_world) -> None:
    world = start(make_world, contact=lambda w: closes(w) and round(w.now * 100) % 300 > 40)
    assert world.run(15.0).result.code is ResultCode.SUCCESS
    assert "RETRY" not in world.phases


def test_a_contact_that_opens_at_the_very_end_is_no_success(make_world) -> None:
    world = start(make_world, contact=closes)
    world.run(10.0, lambda step: step.phase is Phase.HOLDING)
    end = world.now + 5.0
    world.contact = lambda w: closes(w) and w.now < end - 0.2
    assert world.run(10.0, lambda step: step.phase is Phase.RETRY).phase is Phase.RETRY


def test_a_contact_that_never_stays_ends_the_goal(make_world) -> None:
    world = start(make_world, sequence={"max_retries": 1})
    world.contact = lambda w: closes(w) and w.sequence._goal.phase is not Phase.HOLDING
    assert world.run(120.0).result.code is ResultCode.FAILED_TO_CHARGE


@pytest.mark.parametrize("code", [ResultCode.STOPPED_BY_USER, ResultCode.EMERGENCY_STOP, ResultCode.CANCELED])
def test_who_ends_the_watch_leaves_a_docked_chair_and_nothing_moves_it_any_more(make_world, code) -> None:
    world = start(make_world, contact=closes)
    step = world.run(10.0, lambda step: step.phase is Phase.HOLDING)
    assert not step.done and not world.sequence.can_pause
    result = world.sequence.abort(world.now, code, "let go").result
    assert result.code is ResultCode.SUCCESS and result.text.endswith("let go")
    with pytest.raises(ValueError, match="no goal"):
        world.sequence.update(world.now, False)


def test_a_fault_during_the_watch_is_told(make_world) -> None:
    world = start(make_world, contact=closes)
    world.run(10.0, lambda step: step.phase is Phase.HOLDING)
    assert world.sequence.abort(world.now, ResultCode.ODOMETRY_LOST, "gone").result.code is ResultCode.ODOMETRY_LOST
