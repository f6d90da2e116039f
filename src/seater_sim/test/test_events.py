"""Events: when they come, what they do, what is refused."""

import math

import pytest

from seater_common.params import ParameterError
from seater_sim.world.events import Event, Schedule, WorldState, load_events


def test_each_event_comes_once_at_its_time_or_distance() -> None:
    schedule = Schedule(load_events([{"at": 3, "do": "cover"}, {"distance_below": 1.2, "do": "uncover"}], "e", [0]))
    assert schedule.take_due(2.99, 1.2) == []
    assert [e.do for e in schedule.take_due(3.0, 1.3)] == ["cover"]
    assert schedule.take_due(3.1, 1.3) == []
    assert [e.do for e in schedule.take_due(3.2, 1.19)] == ["uncover"]
    assert schedule.take_due(99.0, 0.0) == []


def test_what_events_do() -> None:
    world = WorldState(frozenset({0, 1, 2}))
    world.apply(Event("cover", ids=(1,)))
    assert world.covered == {1}
    world.apply(Event("cover"))
    assert world.covered == {0, 1, 2}
    world.apply(Event("uncover", ids=(0,)))
    assert world.covered == {1, 2}
    for action, mode in [("nan_images", "nan"), ("camera_off", "off"), ("good_images", "good")]:
        world.apply(Event(action))
        assert world.images == mode
    world.apply(Event("odometry_off"))
    assert world.odometry is False
    world.apply(Event("odometry_on"))
    assert world.odometry is True


@pytest.mark.parametrize(
    ("event", "message"),
    [
        ({"at": 1.0, "do": "explode"}, r"e\[0\]/do: is 'explode', must be one of cover"),
        ({"do": "cover"}, r"e\[0\]: has 0 of the keys at"),
        ({"at": 1.0, "distance_below": 1.0, "do": "cover"}, r"e\[0\]: has 2 of the keys at"),
        ({"at": math.nan, "do": "cover"}, r"e\[0\]/at: is nan, must be a number >= 0"),
        ({"at": True, "do": "cover"}, r"e\[0\]/at: is True"),
        ({"at": 1.0, "do": "cover", "ids": [9]}, r"e\[0\]/ids: is \[9\], must list markers of the dock: \[0\]"),
        ({"at": 1.0, "do": "cover", "when": 2}, r"e\[0\]/when: unknown key"),
        ("cover", r"e\[0\]: is 'cover', must be a mapping"),
    ],
)
def test_wrong_events_are_named(event: object, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        load_events([event], "e", [0])
