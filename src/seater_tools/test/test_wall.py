"""The back wall among measured markers."""

from __future__ import annotations

import dataclasses

import pytest

from seater_common.geometry import Bay
from seater_tools.correct.wall import MOST, wall_values

BAY = Bay()


def test_a_wall_behind_all_prints_stays() -> None:
    assert wall_values(BAY, 0.9, [0.89, 0.9]) == {("bay", "back_wall_x"): 0.9}
    assert wall_values(BAY, 0.9, []) == {("bay", "back_wall_x"): 0.9}


def test_no_print_hangs_behind_it_and_the_entrance_stays() -> None:
    values = wall_values(BAY, 0.9, [0.88, 0.931])
    assert values["bay", "back_wall_x"] == pytest.approx(0.931)
    moved = Bay(back_wall_x=values["bay", "back_wall_x"], side_wall_length=values["bay", "side_wall_length"])
    assert moved.entrance_x == pytest.approx(0.9 - BAY.side_wall_length)
    open_dock = dataclasses.replace(BAY, side_wall_length=0.0)
    assert wall_values(open_dock, 0.9, [0.931]) == {("bay", "back_wall_x"): pytest.approx(0.931)}


def test_another_mistake_is_left_to_the_doctor() -> None:
    assert wall_values(BAY, 0.9, [0.9 + MOST + 0.001])["bay", "back_wall_x"] == 0.9
