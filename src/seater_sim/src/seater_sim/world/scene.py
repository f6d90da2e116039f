"""The world that the camera sees, in the dock frame: room, floor, bay, sheets with markers, obstacles.

Everything is made of planar convex faces. They are drawn back to front (painter's order): room, floor, back wall and
what hangs on it, then the upright blocks (side walls, obstacles) from far to near. That is right for a camera in front
of the back wall, which is the only place where the dock matters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Bay, Dock, Marker
from seater_sim.settings import Obstacle, SceneSettings

Array = NDArray[np.float64]
Colour = tuple[float, float, float]

FLOOR = (122.0, 116.0, 108.0)
JOINT = (112.0, 106.0, 98.0)
MAT = (86.0, 98.0, 116.0)
ROOM = (150.0, 152.0, 156.0)
CEILING = (196.0, 196.0, 194.0)
SKIRTING = (96.0, 92.0, 88.0)
BACK_WALL = (196.0, 190.0, 178.0)
BLOCK = (112.0, 124.0, 144.0)
OBSTACLE = (170.0, 134.0, 96.0)
CARDBOARD = (146.0, 122.0, 92.0)
SUN = np.array([-0.55, 0.45, 0.70])  # towards the light, for the shading of upright faces
ROOM_HALF, ROOM_HEIGHT = 6.0, 2.8  # [m]
TILE = 0.6  # [m]


@dataclass(frozen=True, eq=False)
class Face:
    """A planar convex polygon (n, 3) [m], anticlockwise as seen from the side that can be seen; colour in rgb."""

    points: Array
    colour: Colour
    normal: Array = field(init=False)  # towards the side that can be seen; length is not one

    def __post_init__(self) -> None:
        normal = np.cross(self.points[1] - self.points[0], self.points[2] - self.points[1])
        object.__setattr__(self, "normal", normal)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A marker printed on a white sheet."""

    marker: Marker
    paper: Face
    cover: Face  # what is in front of it when the marker is covered
    outline: Array  # the printed square, (4, 3) [m], in the dock frame
    hangs_on_back_wall: bool


@dataclass(frozen=True, eq=False)
class Block:
    """An upright prism."""

    faces: list[Face]
    centre: Array  # (2,) [m]


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn, in this order: `backdrop`, sheets on the back wall, `blocks` far to near, other sheets."""

    backdrop: list[Face]
    sheets: list[Sheet]
    blocks: list[Block]


def make_scene(dock: Dock, settings: SceneSettings, obstacles: list[Obstacle]) -> Scene:
    """The world round this dock."""
    bay = dock.bay
    blocks = [_block(wall, bay.wall_height, BLOCK) for wall in bay.side_walls()]
    blocks += [_block(obstacle.polygon(), obstacle.height, OBSTACLE) for obstacle in obstacles]
    return Scene(
        backdrop=_room(bay) + _floor(bay) + _back_wall(bay),
        sheets=[_sheet(marker, bay, settings) for marker in dock.markers],
        blocks=blocks,
    )


def _quad(*corners: tuple[float, float, float]) -> Array:
    return np.array(corners, dtype=float)


def _shaded(points: Array, colour: Colour) -> Face:
    """An upright face, lighter where it faces the light."""
    face = Face(points, colour)
    light = float(face.normal @ SUN) / (float(np.linalg.norm(face.normal)) * float(np.linalg.norm(SUN)))
    shade = 0.80 + 0.25 * max(light, -0.5)
    return Face(points, (colour[0] * shade, colour[1] * shade, colour[2] * shade))


def _upright(a: tuple[float, float], b: tuple[float, float], low: float, high: float) -> Array:
    """A wall from a to b; seen from the side that has a on its left."""
    return _quad((*a, low), (*b, low), (*b, high), (*a, high))


def _room(bay: Bay) -> list[Face]:
    x, h = bay.back_wall_x, ROOM_HALF
    corners = [(x + 1.2, -h), (x + 1.2, h), (x - 2 * h, h), (x - 2 * h, -h)]
    faces = [Face(_quad(*((*c, ROOM_HEIGHT) for c in reversed(corners))), CEILING)]
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        # The room's walls are seen from inside.
        faces.append(_shaded(_upright(b, a, 0.0, ROOM_HEIGHT), ROOM))
        faces.append(_shaded(_upright(b, a, 0.0, 0.12), SKIRTING))
    return faces


def _floor(bay: Bay) -> list[Face]:
    x, h = bay.back_wall_x, ROOM_HALF
    near = x - 2 * h

    def on_floor(x0: float, x1: float, y0: float, y1: float, colour: Colour) -> Face:
        return Face(_quad((x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)), colour)

    half = 0.5 * bay.width
    faces = [on_floor(near, x + 1.2, -h, h, FLOOR)]
    width = 0.006
    for k in range(-5, 6):
        y = (k + 0.5) * TILE
        faces.append(on_floor(x - 5.0, x, y - width, y + width, JOINT))
    for k in range(1, 9):
        faces.append(on_floor(x - k * TILE - width, x - k * TILE + width, -3.3, 3.3, JOINT))
    if bay.side_wall_length > 0.0:
        faces.append(on_floor(bay.entrance_x, x, -half, half, MAT))
    return faces


def _back_wall(bay: Bay) -> list[Face]:
    x, half = bay.back_wall_x, 0.5 * bay.width + bay.wall_thickness
    left, right = (x, half), (x, -half)
    top = _upright(left, right, 0.0, bay.wall_height)
    return [_shaded(top, BACK_WALL), _shaded(_upright(left, right, 0.0, 0.08), SKIRTING)]


def _block(polygon: Array, height: float, colour: Colour) -> Block:
    """A prism over an anticlockwise polygon (n, 2)."""
    points = [(float(x), float(y)) for x, y in polygon]
    faces = [_shaded(_upright(a, b, 0.0, height), colour) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    faces.append(Face(_quad(*((*p, height) for p in points)), colour))
    return Block(faces, np.asarray(polygon, dtype=float).mean(axis=0))


def _sheet(marker: Marker, bay: Bay, settings: SceneSettings) -> Sheet:
    T = marker.T_dock_marker()

    def square(half: float) -> Array:
        corners = np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])
        return corners @ T[:3, :3].T + T[:3, 3]

    half = marker.size * (0.5 + settings.quiet_zone)
    white = (settings.white,) * 3
    return Sheet(
        marker,
        Face(square(half), white),
        Face(square(1.05 * half), CARDBOARD),
        marker.corners() @ T[:3, :3].T + T[:3, 3],
        hangs_on_back_wall=abs(marker.position[0] - bay.back_wall_x) < 0.05
        and abs(math.cos(marker.normal_yaw) + 1.0) < 0.05,
    )
