"""What is known of whether the chair stands docked: by contact, images, goals and odometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.docked import Docked, DockWatch

LAB, HALL = replace(Dock(), name="lab"), replace(Dock(), name="hall")


class Idle:
    """A chair without a goal: `stand` for a while, `push` it."""

    def __init__(self, make_world, start, *, require_contact: bool = False, seen: bool = True, contact=None) -> None:
        self.world = make_world(start, seen=lambda world: self.seen, dock=LAB)
        self.watch = DockWatch(require_contact=require_contact)
        self.seen, self.contact, self.goal = seen, contact, False
        self.use(LAB)

    def use(self, dock: Dock) -> None:
        self.watch.use(Chair(), dock, self.world.sequence.observer, SequenceParameters())

    def stand(self, seconds: float = 1.0):
        for _ in range(round(seconds / 0.05)):
            for _ in range(2):
                self.world.tick()
            state = self.watch.update(self.world.now, self.contact, goal=self.goal)
        return state

    def push(self, way: float):
        """At 0.2 m/s."""
        self.world.v, self.world.obeys = np.copysign(0.2, way), False
        self.stand(abs(way) / 0.2)
        self.world.v = 0.0
        return self.stand(0.3)


def is_docked(state, dock: str) -> bool:
    return state.docked is Docked.DOCKED and state.dock == dock


def test_nothing_is_known_at_first(make_world) -> None:
    chair = Idle(make_world, (-2.0, 0.0, 0.0), seen=False)
    state = chair.stand()
    assert state.docked is Docked.UNKNOWN and state.contact is None and "neither contact nor images" in state.reason


def test_images_show_where_it_stands(make_world) -> None:
    """After a restart, say."""
    assert is_docked(Idle(make_world, (0.002, 0.001, 0.0)).stand(), "lab")
    assert Idle(make_world, (-1.2, 0.0, 0.0)).stand().docked is Docked.NOT_DOCKED
    assert Idle(make_world, (-0.025, 0.0, 0.0)).stand().docked is Docked.UNKNOWN  # neither in it nor away from it


def test_images_alone_do_not_say_docked_where_the_contact_is_required(make_world) -> None:
    chair = Idle(make_world, (0.002, 0.0, 0.0), require_contact=True, contact=False)
    assert chair.stand().docked is Docked.UNKNOWN
    chair.contact = True
    assert is_docked(chair.stand(), "lab")


def test_the_contact_says_docked_and_only_images_say_where(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0), seen=False, contact=True)
    before = chair.stand()
    assert is_docked(before, "")
    chair.seen = True
    state = chair.stand()
    assert is_docked(state, "lab") and state.since == before.since


def test_a_contact_elsewhere_is_not_the_dock_in_view(make_world) -> None:
    assert is_docked(Idle(make_world, (-1.5, 0.0, 0.0), contact=True).stand(), "")


def test_a_lost_charge_is_told_and_the_chair_still_stands_there(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0), contact=True)
    before = chair.stand()
    chair.contact = False
    state = chair.stand()
    assert is_docked(state, "lab") and state.contact is False and state.since == before.since


@pytest.mark.parametrize("seen", [True, False])
def test_a_chair_that_is_pushed_away_is_not_docked_any_more(make_world, seen) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0))
    assert is_docked(chair.stand(), "lab")
    chair.seen = seen
    chair.stand(1.5)
    since = chair.world.now
    state = chair.push(-0.1)
    assert state.docked is Docked.NOT_DOCKED and state.dock == "" and state.since > since


def test_noise_changes_nothing(make_world) -> None:
    chair = Idle(make_world, (0.0085, 0.0, 0.0))  # at the edge of the tolerance
    states = {chair.stand(0.05) for _ in range(200)}
    assert len({(state.docked, state.since) for state in states if state.docked is Docked.DOCKED}) <= 1


def test_a_chair_that_has_driven_far_is_not_docked(make_world) -> None:
    chair = Idle(make_world, (-3.0, 0.0, 0.0), seen=False)
    chair.stand()
    assert chair.push(-0.4).docked is Docked.UNKNOWN
    assert chair.push(-0.2).docked is Docked.NOT_DOCKED


def test_goals_tell_how_they_ended(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0), seen=False)
    chair.stand()
    chair.watch.reached(chair.world.now, docked=True)
    assert is_docked(chair.stand(), "lab") and chair.watch.state.reason == "a goal has docked it"
    chair.watch.reached(chair.world.now, docked=False)
    assert chair.stand().docked is Docked.NOT_DOCKED


def test_while_a_goal_drives_its_result_decides(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0))
    chair.goal = True
    assert chair.stand().docked is Docked.UNKNOWN


def test_what_was_known_can_be_void(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0))
    chair.stand()
    chair.seen = False
    chair.stand(2.0)
    chair.watch.forget()
    assert chair.stand().docked is Docked.UNKNOWN


def test_a_docked_chair_does_not_set_out_for_another_dock(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0))
    chair.stand()
    assert chair.watch.why_not_to("hall", search=False) == "the chair stands docked at lab: undock first"
    assert chair.watch.why_not_to("lab", search=True) == ""


def test_a_chair_that_charges_somewhere_does_not_search(make_world) -> None:
    chair = Idle(make_world, (0.0, 0.0, 0.0), seen=False, contact=True)
    chair.stand()
    assert "not known where: undock first" in chair.watch.why_not_to("lab", search=True)
    assert chair.watch.why_not_to("lab", search=False) == ""


def test_a_chair_in_a_bay_does_not_set_out_for_another_dock(make_world) -> None:
    """The way to the other one knows nothing of this bay's walls."""
    chair = Idle(make_world, (-0.4, 0.0, 0.0))
    assert chair.stand().docked is Docked.NOT_DOCKED
    assert chair.watch.why_not_to("hall", search=False) == "the chair stands in the bay of lab: undock first"
    assert chair.watch.why_not_to("lab", search=False) == ""


@pytest.mark.parametrize("start", [(-1.2, 0.0, 0.0), (0.0, 2.0, 0.0)])
def test_before_or_beside_the_bay_it_may_set_out(make_world, start) -> None:
    chair = Idle(make_world, start)
    chair.stand()
    assert chair.watch.why_not_to("hall", search=True) == ""
