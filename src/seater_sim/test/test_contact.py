"""What the chair touches."""

import numpy as np
import pytest

from seater_common.geometry import Bay, Chair, Dock, clearance
from seater_sim.settings import ContactSettings
from seater_sim.world.contact import ChargingContact, Walls


@pytest.fixture
def contact() -> ChargingContact:
    return ChargingContact(ContactSettings(max_speed=0.02, max_omega=0.05), Dock())


def test_contact_closes_only_in_place_and_slow(contact: ChargingContact) -> None:
    assert not contact.update([0.021, 0.0, 0.0], 0.0, 0.0)  # 20 mm are allowed
    assert not contact.update([0.015, -0.015, 0.0], 0.0, 0.0)  # 21 mm together
    assert not contact.update([0.0, 0.0, 0.036], 0.0, 0.0)  # 35 mrad are allowed
    assert not contact.update([0.0, 0.0, 0.0], 0.021, 0.0)
    assert not contact.update([0.0, 0.0, 0.0], 0.0, -0.051)
    assert contact.update([0.010, -0.010, -0.034], -0.019, 0.049)


def test_contact_opens_when_the_chair_leaves(contact: ChargingContact) -> None:
    assert contact.update([0.0, 0.0, 0.0], 0.0, 0.0)
    assert contact.update([-0.019, 0.0, 0.0], -0.1, 0.0)  # still touching while it moves
    assert not contact.update([-0.021, 0.0, 0.0], -0.1, 0.0)
    assert not contact.update([-0.019, 0.0, 0.0], 0.1, 0.0)  # coming back fast
    assert contact.update([-0.010, 0.0, 0.0], 0.0, 0.0)


def test_contact_opens_when_the_heading_leaves(contact: ChargingContact) -> None:
    assert contact.update([0.0, 0.0, 0.0], 0.0, 0.0)
    assert not contact.update([0.0, 0.0, -0.036], 0.0, 0.0)


@pytest.mark.parametrize("length", [0.9, 0.0])
def test_fast_clearance_is_the_exact_one(length: float) -> None:
    chair, bay = Chair(), Bay(side_wall_length=length)
    walls = Walls(chair, bay, [])
    rng = np.random.default_rng(1)
    compared = 0
    for _ in range(300):
        pose = rng.uniform([-2.0, -1.0, -1.0], [0.2, 1.0, 1.0])
        exact = clearance(chair, bay, pose)
        if exact > 0.0:
            compared += 1
            assert walls.distance_if_free(pose) == pytest.approx(exact, abs=1e-12)
    assert compared > 100


def test_obstacles_count_too() -> None:
    square = np.array([[-1.0, 0.5], [-0.5, 0.5], [-0.5, 1.0], [-1.0, 1.0]])
    walls = Walls(Chair(), Bay(), [square])
    assert walls.distance_if_free(np.array([-0.75, 0.0, 0.0])) == pytest.approx(0.175)
    assert walls.distance(np.array([-0.75, 0.0, 0.0])) == pytest.approx(0.175)


def test_contact_of_a_backward_dock_closes_with_the_back_to_the_wall() -> None:
    contact = ChargingContact(ContactSettings(max_speed=0.02, max_omega=0.05), Dock(direction="backward"))
    assert not contact.update([0.0, 0.0, 0.0], 0.0, 0.0)
    assert contact.update([0.010, -0.010, np.pi - 0.034], 0.0, 0.0)
    assert contact.update([0.010, -0.010, -np.pi + 0.034], 0.0, 0.0)
    assert not contact.update([0.0, 0.0, -np.pi + 0.036], 0.0, 0.0)
