"""A button counts as held only as long as its page has proved it, and each press ends once."""

import pytest
from panels import FakeChair

from seater_panel.hold.driver import GRACE, LEAD, REPEAT, Driver
from seater_panel.hold.hold import Hold

TIMEOUT = 0.2


@pytest.fixture
def hold() -> Hold:
    return Hold(TIMEOUT)


def test_held_until_the_timeout_after_the_newest_tick_that_was_answered(hold: Hold) -> None:
    assert hold.press("a", 1, "dock", proven=10.0, now=10.05) == ""
    hold.keep("a", 1, proven=10.1, now=10.15)
    assert hold.current(10.299) is not None
    assert hold.current(10.301) is None
    assert "slow or lost" in hold.ended


def test_old_answers_that_arrive_late_prolong_nothing(hold: Hold) -> None:
    """As from a connection that hangs and then delivers all at once, or one that is always late."""
    hold.press("a", 1, "dock", proven=0.0, now=0.0)
    for tick in range(1, 4):
        hold.keep("a", 1, proven=0.05 * tick, now=0.19)
    hold.keep("a", 1, proven=0.0, now=0.19)  # out of order
    assert hold.current(0.349) is not None
    assert hold.current(0.351) is None


def test_what_has_ended_is_not_revived(hold: Hold) -> None:
    hold.press("a", 1, "dock", proven=0.0, now=0.0)
    assert hold.current(0.3) is None
    hold.keep("a", 1, proven=0.3, now=0.3)
    assert hold.current(0.3) is None
    assert hold.press("a", 1, "dock", proven=0.3, now=0.3)  # the same press again
    assert hold.press("a", 2, "dock", proven=0.3, now=0.3) == ""


def test_an_answer_after_the_deadline_does_not_bridge_the_gap(hold: Hold) -> None:
    """Even when nobody has looked at the hold in between."""
    hold.press("a", 1, "dock", proven=0.0, now=0.0)
    hold.keep("a", 1, proven=0.24, now=0.25)
    assert hold.current(0.25) is None


def test_a_press_over_a_slow_connection_begins_nothing(hold: Hold) -> None:
    assert hold.press("a", 1, "dock", proven=0.0, now=0.21) == "the connection is too slow"
    assert hold.current(0.21) is None


def test_one_page_at_a_time(hold: Hold) -> None:
    hold.press("a", 1, "dock", proven=0.0, now=0.0)
    assert hold.press("b", 1, "undock", proven=0.0, now=0.0) == "somebody else holds a button"
    hold.keep("b", 1, proven=0.15, now=0.15)
    hold.release("b")
    assert hold.current(0.19).client == "a"
    assert hold.current(0.21) is None  # what b answered counts for b alone
    assert hold.press("b", 2, "undock", proven=0.21, now=0.21) == ""


def test_a_page_that_is_gone_holds_nothing(hold: Hold) -> None:
    hold.press("a", 1, "dock", proven=0.0, now=0.0)
    hold.forget("a")
    assert hold.current(0.0) is None


def test_an_unknown_action_is_refused(hold: Hold) -> None:
    assert "no action 'drive'" in hold.press("a", 1, "drive", proven=0.0, now=0.0)


@pytest.fixture
def chair() -> FakeChair:
    return FakeChair()


@pytest.fixture
def driver(hold: Hold, chair: FakeChair) -> Driver:
    return Driver(hold, chair)


def test_the_gate_hears_of_the_button_before_the_goal_is_given(driver: Driver, chair: FakeChair) -> None:
    driver.press("a", 1, "dock", 0.0, 0.0)
    driver.step(0.0)
    assert chair.words() == ["held"]
    driver.step(LEAD)
    driver.step(LEAD + 0.02)
    assert chair.words() == ["held", "dock"]


def test_let_go_before_the_goal_gives_none(driver: Driver, hold: Hold, chair: FakeChair) -> None:
    driver.press("a", 1, "dock", 0.0, 0.0)
    driver.step(0.0)
    hold.release("a")
    driver.step(LEAD)
    assert chair.words() == ["held", "let go"]


def drive(driver: Driver, hold: Hold) -> float:
    """A goal runs; the time then."""
    driver.press("a", 1, "dock", 0.0, 0.0)
    hold.keep("a", 1, 0.15, 0.15)
    for now in (0.0, LEAD, 0.15):
        driver.step(now)
    return 0.15


def test_let_go_is_told_at_once_and_the_goal_is_cancelled_if_the_gate_does_not_end_it(
    driver: Driver, hold: Hold, chair: FakeChair
) -> None:
    now = drive(driver, hold)
    hold.release("a")
    driver.step(now)
    assert chair.words()[-1] == "let go"
    driver.step(now + GRACE)
    assert chair.words()[-1] == "cancel"


def test_a_goal_that_does_not_end_is_cancelled_again(driver: Driver, hold: Hold, chair: FakeChair) -> None:
    now = drive(driver, hold)
    hold.release("a")
    for i in range(50):
        chair.goal = "dock"
        driver.step(now + 0.02 * i)
    assert chair.words().count("cancel") == pytest.approx((50 * 0.02 - GRACE) / REPEAT, abs=1.0)


def test_a_new_press_waits_until_the_goal_before_has_ended(driver: Driver, hold: Hold, chair: FakeChair) -> None:
    now = drive(driver, hold)
    hold.release("a")
    driver.step(now)
    assert driver.press("a", 2, "undock", now, now) == ""
    driver.step(now + GRACE)
    driver.step(now + GRACE + 0.02)
    assert chair.words() == ["held", "dock", "let go", "held", "cancel", "undock"]


def test_stop_waits_for_nothing_and_ends_goals_of_others(driver: Driver, hold: Hold, chair: FakeChair) -> None:
    now = drive(driver, hold)
    driver.stop(now)
    assert chair.words()[-2:] == ["let go", "cancel"]
    chair.said.clear()
    driver.stop(now + 1.0)  # nobody holds; a goal of somebody else may run
    assert chair.words() == ["cancel"]
    driver.step(now + 1.02)
    assert not chair.held


def test_when_the_goal_has_ended_the_finger_that_stays_runs_nothing_else(
    driver: Driver, hold: Hold, chair: FakeChair
) -> None:
    now = drive(driver, hold)
    chair.goal = ""  # docked
    driver.step(now)
    driver.step(now + 0.02)
    assert not chair.held
    hold.keep("a", 1, now + 0.02, now + 0.02)
    driver.step(now + 0.04)
    assert chair.words() == ["held", "dock", "let go"]


def test_a_chair_that_takes_no_goal_refuses_the_press(driver: Driver, hold: Hold, chair: FakeChair) -> None:
    chair.refused = "the docking node does not run"
    assert driver.press("a", 1, "dock", 0.0, 0.0) == "the docking node does not run"
    assert hold.current(0.0) is None
