#!/usr/bin/env python3
"""Draw docs/images/architecture.svg from test/structure/rooms.yaml: the rooms, their arrows, and the way of one image.

Run it in the project's environment: `./seater run python3 tools/draw_architecture.py`. The rooms and what each uses
come from the file that test/structure compares with the code, so the figure stays true. A room stands above all rooms
that it uses; an arrow that follows from others is left out.
With --check nothing is drawn: exit status 1 when the figure shows other rooms or arrows than the file, or the way leads
through a room that is not there.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import yaml
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path as Path2D

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ROOT / "test" / "structure" / "rooms.yaml"
OUTPUT = ROOT / "docs" / "images" / "architecture.svg"

WALL, ROOM, INK, ARROW, WAY = "#f3f1ec", "#ffffff", "#222222", "#9a9a9a", "#d9541e"
ROW, HEIGHT, WIDEST = 1.0, 0.62, 3.1  # of a room, in units of the drawing
LETTER = 0.14  # width of a letter of a room's name, about, in the same units

Arrows = dict[str, set[str]]


@dataclass(frozen=True)
class Place:
    """Middle and width of a box."""

    x: float
    y: float
    width: float

    @property
    def left(self) -> tuple[float, float]:
        return self.x - 0.5 * self.width, self.y

    @property
    def right(self) -> tuple[float, float]:
        return self.x + 0.5 * self.width, self.y

    @property
    def top(self) -> tuple[float, float]:
        return self.x, self.y + 0.5 * HEIGHT

    @property
    def bottom(self) -> tuple[float, float]:
        return self.x, self.y - 0.5 * HEIGHT


Places = dict[str, Place]


@dataclass(frozen=True)
class House:
    """A package and its place in the figure (left upper corner, width)."""

    package: str
    text: str
    x: float
    y: float
    width: float


HOUSES = (
    House("seater_perception", "image to dock pose", 0.0, 0.0, 8.2),
    House("seater_nmpc", "dock pose to command", 11.0, 0.0, 7.6),
    House("seater_sim", "simulated chair, camera, world", 0.0, -13.3, 8.2),
    House("seater_eval", "campaigns, benchmarks, reports", 11.0, -14.3, 7.6),
)
CAPTIONS = {
    "seater_perception": {
        "ros": "nodelet, messages", "tools": "detect_image, drawing", "pipeline": "what calls what",
        "photometric": "intensities to pose", "photometric/kernel": "inner loops",
        "photometric/samples": "pixels to fit", "pose": "corners to pose", "search": "image to corners",
        "search/code": "bits", "search/outline": "edges", "image": "camera, encodings",
        "marker": "the print", "numerics": "small maths", "config": "what a user tunes",
    },
    "seater_nmpc": {
        "ros": "docking node", "sequence": "goal to result", "sequence/phases": "what it does in each",
        "sequence/goal": "results, time-outs",
        "control": "one command a cycle", "plan": "paths",
        "observe": "dock and chair", "observe/odometry": "wheels", "solve": "solvers", "ocp": "model, cost",
        "ocp/constraints": "walls, view, ...", "controller": "for other programs", "parameters": "what a user tunes",
        "programme": "NLP in stages", "plausibility": "do all agree?", "plausibility/installation": "camera mount",
    },
    "seater_sim": {
        "ros": "the node", "loop": "steps in lock-step", "camera": "rendered images", "chair": "plant, odometry",
        "world": "scene, contact, events", "settings": "parameters",
    },
    "seater_eval": {
        "ros": "runs with nodes", "docking": "one docking", "control": "controller", "perception": "detector",
        "perception/images": "renderer, bound",
        "baselines": "other methods", "report": "tables, bars", "run": "long runs",
    },
}  # fmt: skip
# The way of one image to one command: the numbers are those of docs/explanation/architecture.md.
STOPS = {
    "seater_perception": {2: "ros", 3: "pipeline", 4: "search", 5: "pose", 6: "photometric"},
    "seater_nmpc": {8: "observe", 9: "sequence", 10: "plan", 11: "control", 12: "solve", 13: "ocp"},
}


def levels(arrows: Arrows) -> dict[str, int]:
    """0 for a room that uses no other, else one more than the highest room that it uses."""
    result: dict[str, int] = {}

    def level(room: str) -> int:
        if room not in result:
            result[room] = max((1 + level(used) for used in arrows[room]), default=0)
        return result[room]

    for room in arrows:
        level(room)
    return result


def reduced(arrows: Arrows) -> Arrows:
    """Without the arrows that follow from others."""

    def below(room: str) -> set[str]:
        return arrows[room].union(*(below(used) for used in arrows[room]))

    return {room: uses - set().union(*(below(used) for used in uses)) for room, uses in arrows.items()}


def places(house: House, arrows: Arrows) -> Places:
    """Middle and width of each room: a row for each level, the rooms of a row side by side."""
    level, result = levels(arrows), {}
    highest = max(level.values())
    for row in range(highest + 1):
        rooms = sorted(room for room in arrows if level[room] == row)
        pitch = house.width / len(rooms)
        for i, room in enumerate(rooms):
            y = house.y - 0.95 - (highest - row) * ROW
            result[room] = Place(house.x + (i + 0.5) * pitch, y, min(WIDEST, pitch - 0.35))
    return result


def identity(package: str, room: str, used: str = "") -> str:
    """The name that a room or an arrow bears in the figure's source."""
    return f"{package}:{room}" + (f">{used}" if used else "")


def expected(packages: dict[str, Arrows]) -> set[str]:
    """The names of all rooms and arrows."""
    names = set()
    for house in HOUSES:
        arrows = packages[house.package]
        names |= {identity(house.package, room) for room in arrows}
        names |= {identity(house.package, room, used) for room, uses in reduced(arrows).items() for used in uses}
    return names


def draw_box(axes: Axes, place: Place, title: str, caption: str, name: str | None = None) -> None:
    x, y, width = place.x, place.y, place.width
    box = FancyBboxPatch((x - 0.5 * width, y - 0.5 * HEIGHT), width, HEIGHT, boxstyle="round,pad=0.03",
                         facecolor=ROOM, edgecolor=INK, linewidth=0.8, zorder=2)  # fmt: skip
    box.set_gid(name)
    axes.add_patch(box)
    if len(title) * LETTER > width:  # a room within a room, in a narrow box: two lines, no caption
        title, caption = title.replace("/", "/\n"), ""
    style: dict[str, Any] = {"ha": "center", "va": "center", "zorder": 3}
    axes.text(x, y + (0.12 if caption else 0.0), title, fontsize=9, color=INK, **style)
    axes.text(x, y - 0.17, caption, fontsize=7, color="#666666", **style)


def draw_house(axes: Axes, house: House, arrows: Arrows) -> Places:
    """The house with its rooms and arrows; returns the places of the rooms."""
    where = places(house, arrows)
    bottom = min(place.y for place in where.values()) - 0.6
    wall = FancyBboxPatch((house.x - 0.15, bottom), house.width + 0.3, house.y - bottom, boxstyle="round,pad=0.1",
                          facecolor=WALL, edgecolor="#c9c4b8", zorder=0)  # fmt: skip
    axes.add_patch(wall)
    axes.text(house.x, house.y - 0.2, house.package, va="center", weight="bold", fontsize=9, color=INK)
    axes.text(house.x + house.width, house.y - 0.2, house.text, ha="right", va="center", fontsize=8, color=INK)
    for room, uses in sorted(reduced(arrows).items()):
        for used in sorted(uses):
            arrow = FancyArrowPatch(where[room].bottom, where[used].top, arrowstyle="-|>", mutation_scale=7,
                                    color=ARROW, linewidth=0.8, zorder=1)  # fmt: skip
            arrow.set_gid(identity(house.package, room, used))
            axes.add_patch(arrow)
    for room, place in where.items():
        draw_box(axes, place, room, CAPTIONS[house.package].get(room, ""), identity(house.package, room))
    for number, room in STOPS.get(house.package, {}).items():
        draw_number(axes, number, where[room].left)
    return where


def draw_number(axes: Axes, number: int, at: tuple[float, float]) -> None:
    axes.text(*at, str(number), ha="center", va="center", fontsize=8, weight="bold", color="white", zorder=6,
              bbox={"boxstyle": "circle,pad=0.25", "facecolor": WAY, "edgecolor": "white"})  # fmt: skip


def draw_way(
    axes: Axes, points: list[tuple[float, float]], text: str, at: tuple[float, float], style: str = "-"
) -> None:
    """An arrow along the points, and in words what goes along it."""
    arrow = FancyArrowPatch(path=Path2D(points), arrowstyle="-|>", mutation_scale=13, color=WAY, linewidth=1.8,
                            linestyle=style, zorder=5, fill=False)  # fmt: skip
    axes.add_patch(arrow)
    axes.text(*at, text, ha="center", va="center", fontsize=8, color=WAY, zorder=6)


def draw_surroundings(axes: Axes, perception: Place, docking: Place, sim: Place) -> None:
    """Camera, wheels, safety gate, motors, and how the way goes on between the houses; each given by its room `ros`."""
    camera, wheels = Place(perception.x, 1.2, 2.0), Place(docking.x, 1.2, 2.0)
    gate, motors = Place(docking.x - 0.2, -12.5, 3.4), Place(9.5, -12.5, 1.7)
    user = Place(gate.x, -13.6, 4.0)
    for place, title, caption in (
        (camera, "camera", ""), (wheels, "wheels", ""), (motors, "motors", ""),
        (gate, "seater_safety", "limits, time-outs, priority"), (user, "joystick, emergency stop", ""),
    ):  # fmt: skip
        draw_box(axes, place, title, caption)
    aside, between = docking.x + 4.4, 0.5 * (perception.right[0] + docking.left[0])
    draw_way(axes, [camera.bottom, perception.top], "image, camera_info", (camera.x + 1.3, 0.5))
    draw_way(axes, [wheels.bottom, docking.top], "odom", (wheels.x + 0.5, 0.5))
    draw_way(axes, [perception.right, docking.left], "detections", (between, perception.y + 0.35))
    request = [docking.right, (aside, docking.y), (aside, gate.y), gate.right]
    draw_way(axes, request, "velocity_request", (0.5 * (gate.right[0] + aside), gate.y + 0.25))
    draw_way(axes, [gate.left, motors.right], "cmd_vel", (0.5 * (gate.left[0] + motors.right[0]), gate.y + 0.35))
    draw_way(axes, [user.top, gate.bottom], "", user.top)
    in_simulation = [motors.bottom, (motors.x, sim.y), sim.right]
    draw_way(axes, in_simulation, "in simulation", (motors.x - 1.8, sim.y + 0.22), "--")
    rendered = [sim.left, (-0.7, sim.y), (-0.7, camera.y), camera.left]
    draw_way(axes, rendered, "in simulation", (0.5 * (camera.left[0] - 0.7), camera.y + 0.25), "--")
    halfway = 0.5 * (camera.bottom[1] + perception.top[1])
    draw_number(axes, 1, (camera.x, halfway))
    draw_number(axes, 7, (between, perception.y))
    draw_number(axes, 14, (aside, 0.5 * (docking.y + gate.y)))
    draw_number(axes, 15, (0.5 * (gate.left[0] + motors.right[0]), gate.y))


def draw(packages: dict[str, Arrows], output: Path) -> None:
    matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "seater", "font.family": "sans-serif"})
    figure, axes = plt.subplots(figsize=(13.0, 14.0))
    rooms = {house.package: draw_house(axes, house, packages[house.package]) for house in HOUSES}
    draw_surroundings(axes, *(rooms[package]["ros"] for package in ("seater_perception", "seater_nmpc", "seater_sim")))
    base = Place(9.3, -19.8, 18.9)
    draw_box(
        axes, base, "seater_common: planar poses, typed parameters, chair, dock     seater_msgs: messages, actions", ""
    )
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")
    figure.savefig(output, bbox_inches="tight", metadata={"Date": None} if output.suffix == ".svg" else None, dpi=90)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="draw nothing; exit with 1 when the figure is not true")
    parser.add_argument("--rooms", type=Path, default=ROOMS, help="the file with the rooms (test/structure/rooms.yaml)")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="the file that is drawn (.svg, or .png to look at)")
    options = parser.parse_args()
    loaded = yaml.safe_load(options.rooms.read_text())
    packages = {name: {room: set(uses or []) for room, uses in rooms.items()} for name, rooms in loaded.items()}
    if not options.check:
        draw(packages, options.output)
        return 0
    source = options.output.read_text().replace("&gt;", ">")
    shown = set(re.findall(r'<g id="(seater_\w+:[^"]+)"', source))
    for name in sorted(expected(packages) ^ shown):
        print(f"{'missing' if name not in shown else 'not there any more'}: {name}")
    return 1 if shown != expected(packages) else 0


if __name__ == "__main__":
    sys.exit(main())
