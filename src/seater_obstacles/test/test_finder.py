"""From scans to what has to be kept clear of."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import box, covers, disc, placed, scan

from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose, transform_points
from seater_obstacles.finder import Found, ObstacleFinder
from seater_obstacles.settings import ObstacleSettings

CHAIR, DOCK = Chair(), Dock()
ORIGIN = np.zeros(3)
PERIOD = 0.1  # [s]


def finder() -> ObstacleFinder:
    return ObstacleFinder(ObstacleSettings(), CHAIR, DOCK)


def test_a_box_is_outlined_where_it_stands_whatever_the_place_of_the_chair() -> None:
    for base in ([0.0, 0.0, 0.0], [3.0, -1.5, 2.5], [-2.0, 1.0, -1.0]):
        (inside,) = placed(base, [box(2.0, 0.3)])
        found = finder().update(10.0, scan(base, [inside]), base, None)
        (outline,) = found.outlines
        front = transform_points(base, [[1.85, 0.2], [1.85, 0.4]])
        assert covers([outline], front)
        assert abs(np.linalg.norm(outline.mean(axis=0) - inside.mean(axis=0))) < 0.16  # its near face is seen only
        assert np.all(np.abs(found.points - [1.9, 0.3]) < [0.25, 0.2])


def test_the_hull_of_a_corner_of_walls_leaves_the_room_free() -> None:
    walls = [box(3.0, 0.0, 0.1, 3.0), box(2.0, 1.5, 2.0, 0.1)]
    found = finder().update(10.0, scan(ORIGIN, walls), ORIGIN, None)
    assert len(found.outlines) >= 4
    assert not any(covers([outline], [[2.4, 0.9]]) for outline in found.outlines)


def test_dock_and_chair_are_no_obstacles_and_a_box_in_the_bay_is_one() -> None:
    dock = np.array([2.5, 0.2, 0.1])
    walls = placed(dock, DOCK.bay.outlines())
    wheel = box(0.72, 0.25, 0.02, 0.05)  # of the chair
    inside = placed(dock, [box(0.2, 0.1, 0.2, 0.2)])
    assert len(finder().update(10.0, scan(ORIGIN, [wheel]), ORIGIN, None).points) == 0
    assert len(finder().update(10.0, scan(ORIGIN, walls), ORIGIN, None).points) > 20
    assert len(finder().update(10.0, scan(ORIGIN, walls), ORIGIN, dock).points) == 0
    found = finder().update(10.0, scan(ORIGIN, walls + inside), ORIGIN, dock)
    middle = inside[0].mean(axis=0)
    assert len(found.points) > 3 and np.all(np.hypot(*(found.points - middle).T) < 0.25)


def test_single_points_are_noise() -> None:
    assert not finder().update(10.0, scan(ORIGIN, [box(3.5, 0.0, 0.01, 0.03)]), ORIGIN, None).outlines


def walk(start: float, speed: float, duration: float, base: np.ndarray = ORIGIN) -> tuple[Found, np.ndarray]:
    """Somebody walks across, 1.8 m ahead; what is found in the end, and where he is then."""
    f, n = finder(), round(duration / PERIOD)
    for i in range(n + 1):
        at = np.array([1.8, start + speed * i * PERIOD])
        found = f.update(10.0 + i * PERIOD, scan(base, [disc(*at), box(3.5, 0.0, 0.1, 4.0)]), base, None)
    return found, at


@pytest.mark.parametrize("speed", [1.2, -1.2, 0.8])
def test_a_walking_person_is_expected_ahead_of_where_he_is(speed: float) -> None:
    found, at = walk(-1.2 * np.sign(speed), speed, 0.8)
    assert found.moving == 1
    assert not covers(found.outlines, [at + [-0.17, 0.0]])  # the controller plans round nobody who walks
    ahead = found.points[np.abs(found.points[:, 0] - 1.7) < 0.2]
    assert np.max(np.sign(speed) * (ahead[:, 1] - at[1])) > 0.8 * abs(speed)
    assert np.min(np.sign(speed) * (ahead[:, 1] - at[1])) > -0.35  # and not where he has been


def test_who_walks_out_of_view_is_expected_where_he_was_last_for_a_while() -> None:
    f, narrow, lost = finder(), 0.5, ObstacleSettings().track.lost
    for i in range(12):
        at = np.array([1.8, -0.55 + 0.1 * i])
        found = f.update(10.0 + i * PERIOD, scan(ORIGIN, [disc(*at)], narrow), ORIGIN, None)
    stamp = 10.0 + 11 * PERIOD
    for after, expected in ((0.5, True), (lost - 0.5, True), (lost + 0.5, False)):
        found = f.update(stamp + after, scan(ORIGIN, [], narrow), ORIGIN, None)
        assert bool(len(found.points)) is expected and not found.outlines


def test_who_stands_does_not_move_nor_does_the_wall_behind_him() -> None:
    found, _ = walk(0.4, 0.0, 2.0)
    assert found.moving == 0


def test_standing_things_do_not_move_while_the_chair_drives_past() -> None:
    """The visible part of each changes all the time."""
    f, base = finder(), np.array([-1.5, 0.0, 0.0])
    world = [box(1.5, 0.9, 0.4, 0.4), disc(2.2, -0.8, 0.1), box(3.8, 0.2, 0.1, 3.0), box(1.0, -1.4, 0.6, 0.1)]
    for i in range(40):
        found = f.update(10.0 + i * PERIOD, scan(base, world), base, None)
        assert found.moving == 0, i
        base = compose(base, [0.06, 0.0, 0.02 * math.sin(0.3 * i)])


def test_what_was_seen_is_remembered_in_the_blind_area_and_forgotten_when_seen_through() -> None:
    f, thing = finder(), [box(0.9, 0.6)]
    narrow = 0.7  # [rad] to both sides, as of a depth camera
    ahead = np.array([-1.0, 0.0, 0.0])
    assert f.update(10.0, scan(ahead, thing, narrow), ahead, None).remembered == 0
    found = f.update(12.0, scan(ORIGIN, thing, narrow), ORIGIN, None)  # beside the front, out of view
    assert found.remembered > 0 and covers(found.outlines, [[0.76, 0.6]])
    f.update(13.0, scan(ahead, [], narrow), ahead, None)  # taken away, seen from where it had been seen
    assert not f.update(14.0, scan(ORIGIN, [], narrow), ORIGIN, None).outlines


def test_memory_does_not_grow_with_each_sight_of_the_same_room() -> None:
    """Of two things at one bearing the farther one is in a blind area, though it is seen."""
    f, world = finder(), [box(2.0, 0.2), disc(2.6, 0.4, 0.3), box(3.6, 0.0, 0.1, 3.0)]
    counts = [len(f.update(10.0 + i * PERIOD, scan(ORIGIN, world), ORIGIN, None).points) for i in range(40)]
    assert counts[-1] <= counts[0] + 10


def test_nothing_is_remembered_for_ever_nor_across_a_jump_of_time() -> None:
    thing, ahead = [box(0.9, 0.6)], np.array([-1.0, 0.0, 0.0])
    for stamp in (10.0 + ObstacleSettings().track.memory + 0.1, 9.0):
        f = finder()
        f.update(10.0, scan(ahead, thing, 0.7), ahead, None)
        assert f.update(stamp, scan(ORIGIN, thing, 0.7), ORIGIN, None).remembered == 0


def test_another_dock_can_be_exempted_instead() -> None:
    dock, wide = np.array([2.5, 0.2, 0.1]), replace(DOCK, bay=replace(DOCK.bay, width=1.6))
    walls = placed(dock, wide.bay.outlines())
    f = finder()
    assert len(f.update(10.0, scan(ORIGIN, walls), ORIGIN, dock).points) > 0
    f.use_dock(wide)
    assert len(f.update(10.1, scan(ORIGIN, walls), ORIGIN, dock).points) == 0


def test_what_turns_out_to_be_the_dock_is_not_remembered() -> None:
    f, dock = finder(), np.array([1.4, 0.0, 0.0])
    walls = placed(dock, DOCK.bay.outlines())
    f.update(10.0, scan([-1.0, 0.0, 0.0], walls, 0.7), [-1.0, 0.0, 0.0], None)
    assert len(f.update(10.1, scan(ORIGIN, walls, 0.3), ORIGIN, dock).points) == 0


def test_only_the_nearest_outlines_are_told() -> None:
    posts = [disc(1.5 + 0.3 * i, 0.7 * (-1) ** i * (1 + i / 8), 0.05) for i in range(8)]
    settings = ObstacleSettings()
    few = ObstacleFinder(ObstacleSettings(cluster=type(settings.cluster)(max_outlines=2)), CHAIR, DOCK).update(
        10.0, scan(ORIGIN, posts), ORIGIN, None
    )
    assert len(few.outlines) == 2 and covers(few.outlines, [posts[0].mean(axis=0) - [0.04, 0.0]])
