"""The markers where they hang, to scale, with heights above the floor and distances from each other."""

from __future__ import annotations

from dataclasses import dataclass

from seater_common.geometry import Bay
from seater_tools.sheets.draw.dimensions import chain_across, dimension_up
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.rect import Rect
from seater_tools.sheets.layout.views import View

SCALES = (1, 2, 2.5, 4, 5, 6, 8, 10, 12.5, 15, 20, 25, 30, 40, 50, 100, 200)
STEP = 7.0  # [mm] from one dimension line to the next
SAME = 0.05  # [mm] heights and places closer than this are one


@dataclass(frozen=True)
class Frame:
    """From the dock [mm] to the paper [mm]."""

    scale: float  # 5 of 1 : 5
    x: float  # of the view's origin on the page
    y: float
    lowest: float  # what the drawing reaches down to, on the page

    def at(self, x: float, height: float) -> tuple[float, float]:
        return self.x + x / self.scale, self.y + height / self.scale


def draw_elevation(pen: Pen, view: View, pieces: dict[int, Piece], bay: Bay, room: Rect) -> Frame:
    """From the top of `room` downwards. `pieces`: by the marker's id."""
    heights = _distinct([place.height for place in view.places])
    drawn = _extent(view, pieces, bay)
    left, below = STEP * len(heights) + 3.0, 2 * STEP + 4.0
    width, height = room.width - left - 2.0, room.height - below - 6.0
    scale = next((s for s in SCALES if drawn.width / s <= width and drawn.height / s <= height), SCALES[-1])
    x, y = room.x0 + left - drawn.x0 / scale, room.y1 - 6.0 - drawn.y1 / scale
    frame = Frame(scale, x, y, y + drawn.y0 / scale - below)
    _draw_surroundings(pen, view, bay, frame, drawn)
    for place in view.places:
        _draw_print(pen, pieces[place.marker.id], place.marker.id, frame.at(place.x, place.height), scale)
    _draw_heights(pen, view, heights, frame, drawn)
    _draw_distances(pen, view, frame, drawn)
    return frame


def _distinct(values: list[float]) -> list[float]:
    """In rising order, without those that are the same within SAME."""
    found: list[float] = []
    for value in sorted(values):
        if not found or value - found[-1] > SAME:
            found.append(value)
    return found


def _extent(view: View, pieces: dict[int, Piece], bay: Bay) -> Rect:
    """What is drawn [mm of the dock]: from the floor to above the prints, and the bay from wall to wall."""
    halves = [0.5 * pieces[place.marker.id].quiet.width for place in view.places]
    prints = list(zip(view.places, halves, strict=True))
    half = 1000.0 * (0.5 * bay.width + bay.wall_thickness) if view.turn == 0.0 else 0.0
    ends = [-half, half] if view.reference else []
    left = min([*ends, *(place.x - reach for place, reach in prints)])
    right = max([*ends, *(place.x + reach for place, reach in prints)])
    low = min([0.0, *(place.height - reach for place, reach in prints)])
    return Rect(left - 20.0, low, right + 20.0, max(place.height + reach for place, reach in prints) + 60.0)


def _draw_surroundings(pen: Pen, view: View, bay: Bay, frame: Frame, drawn: Rect) -> None:
    """Floor, walls of the bay, and the line that distances are measured from."""
    top = min(drawn.y1, 1000.0 * bay.wall_height)
    if view.turn == 0.0:
        inner = 500.0 * bay.width
        outer = inner + 1000.0 * bay.wall_thickness
        for a, b in ((-outer, -inner), (inner, outer)) if bay.side_wall_length > 0.0 else ():
            (x0, y0), (x1, y1) = frame.at(a, 0.0), frame.at(b, top)
            pen.fill([Rect(x0, y0, x1, y1)], grey=0.85)
    floor = [frame.at(x, 0.0) for x in (drawn.x0, drawn.x1)]
    pen.line(floor[0], floor[1], width=0.5)
    pen.text(floor[1][0], floor[1][1] - 3.5, "floor", 7.0, "right")
    if view.reference:
        low, high = frame.at(0.0, drawn.y0), frame.at(0.0, drawn.y1)
        pen.line((low[0], low[1] - STEP), high, width=0.15, dash=(4.0, 1.0, 0.7, 1.0))
        pen.text(high[0], high[1] + 1.0, view.reference, 7.0, "middle")


def _draw_print(pen: Pen, piece: Piece, marker_id: int, at: tuple[float, float], scale: float) -> None:
    """The marker itself, small, so that one sees which it is; a cross in its middle."""

    def small(rect: Rect) -> Rect:
        return Rect(*(at[i % 2] + value / scale for i, value in enumerate((rect.x0, rect.y0, rect.x1, rect.y1))))

    quiet = small(piece.quiet)
    pen.fill([quiet], grey=1.0)
    pen.fill([small(rect) for rect in piece.black()], grey=0.35)
    pen.frame(quiet, width=0.1)
    for dx, dy in ((1.0, 0.0), (0.0, 1.0)):
        pen.line((at[0] - 2 * dx, at[1] - 2 * dy), (at[0] + 2 * dx, at[1] + 2 * dy), width=0.5, grey=1.0)
        pen.line((at[0] - 2 * dx, at[1] - 2 * dy), (at[0] + 2 * dx, at[1] + 2 * dy), width=0.2)
    pen.text(at[0], quiet.y1 + 1.0, f"id {marker_id}", 8.0, "middle", bold=True, clear=True)


def _draw_heights(pen: Pen, view: View, heights: list[float], frame: Frame, drawn: Rect) -> None:
    """Of the centres above the floor, left of the drawing."""
    edge = frame.at(drawn.x0, 0.0)[0]
    for i, height in enumerate(heights):
        x = edge - 3.0 - STEP * i
        y0, y1 = frame.at(0.0, 0.0)[1], frame.at(0.0, height)[1]
        last = max(place.x for place in view.places if abs(place.height - height) <= SAME)
        _extend(pen, (x - 1.0, y1), frame.at(last, height))
        _extend(pen, (x - 1.0, y0), (edge, y0))
        dimension_up(pen, x, y0, y1, height)


def _draw_distances(pen: Pen, view: View, frame: Frame, drawn: Rect) -> None:
    """From centre to centre by way of the reference, and from the first to the last, below the floor."""
    places = [place.x for place in view.places]
    stations = [(frame.at(x, 0.0)[0], x) for x in _distinct([*places, 0.0] if view.reference else places)]
    y = frame.at(0.0, drawn.y0)[1] - STEP
    for place in view.places:
        x, centre = frame.at(place.x, place.height)
        _extend(pen, (x, y - STEP - 1.0), (x, centre))
    chain_across(pen, stations, y)
    ends = [(frame.at(x, 0.0)[0], x) for x in (min(places), max(places))]
    if len(stations) > 2 and ends[1][1] - ends[0][1] > SAME:
        chain_across(pen, ends, y - STEP)


def _extend(pen: Pen, start: tuple[float, float], end: tuple[float, float]) -> None:
    """The thin line from a dimension line to what it measures."""
    pen.line(start, end, width=0.1, grey=0.5)
