import numpy as np
import pytest

from seater_common.geometry import Chair, polygon_distance
from seater_common.separation import convex_outline, edge_distances, footprints, nearest, separating_lines

CHAIR = Chair()


@pytest.fixture
def scene():
    rng = np.random.default_rng(0)
    poses = rng.uniform([-2.0, -2.0, -3.1], [2.0, 2.0, 3.1], (400, 3))
    return footprints(CHAIR.corners(), poses), poses, convex_outline(0.3 * rng.normal(size=(8, 2)))


def test_footprints_are_the_chairs(scene) -> None:
    shapes, poses, _ = scene
    for shape, pose in zip(shapes[:20], poses, strict=False):
        assert shape == pytest.approx(CHAIR.corners_at(pose), abs=1e-12)


def test_lines_part_with_the_largest_gap(scene) -> None:
    """The gap is the signed distance, and both shapes lie on their sides of the line."""
    shapes, _, polygon = scene
    lines = separating_lines(shapes, [polygon])
    distances = [polygon_distance(shape, polygon) for shape in shapes]
    assert lines.distances[:, 0] == pytest.approx(distances, abs=1e-12)
    for shape, normal, offset, gap in zip(
        shapes, lines.normals[:, 0], lines.offsets[:, 0], lines.distances[:, 0], strict=True
    ):
        assert np.hypot(*normal) == pytest.approx(1.0)
        assert np.max(polygon @ normal) <= offset + 1e-12
        assert np.min(shape @ normal) - offset == pytest.approx(gap, abs=1e-12)


def test_edge_distances_never_exceed_the_distance(scene) -> None:
    shapes, _, polygon = scene
    distances = np.array([polygon_distance(shape, polygon) for shape in shapes])
    gaps = edge_distances(shapes, polygon)
    assert np.all(gaps <= distances + 1e-12)
    overlapping = distances < 0.0
    assert gaps[overlapping] == pytest.approx(distances[overlapping], abs=1e-12)


def test_the_nearest_lines_are_kept(scene) -> None:
    shapes, _, polygon = scene
    lines = nearest(separating_lines(shapes, [polygon + [3.0, 0.0], polygon, polygon - [0.0, 4.0]]), 2)
    assert lines.distances.shape == (400, 2) and np.all(lines.distances[:, 0] <= lines.distances[:, 1])
    assert separating_lines(shapes, []).distances.shape == (400, 0)


def test_outline_of_points_in_any_order() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for points in (square, square[::-1], np.vstack([square, [[0.5, 0.5], [0.5, 0.0]]])):
        outline = convex_outline(points)
        assert sorted(map(tuple, outline)) == sorted(map(tuple, square))
        x, y = outline.T
        assert 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) == pytest.approx(1.0)  # anticlockwise


@pytest.mark.parametrize(
    "points", [[[0, 0], [1, 1]], [[0, 0], [1, 1], [2, 2]], [[0, 0], [1, 0], [np.nan, 1]], [[0, 0, 0]] * 3, []]
)
def test_what_is_no_polygon_is_refused(points) -> None:
    with pytest.raises(ValueError, match="an obstacle must"):
        convex_outline(points)
